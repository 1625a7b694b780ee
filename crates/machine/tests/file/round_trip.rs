//! A written machine reads back equal, to the last digit.

use crate::random::machine;
use proptest::prelude::*;
use vibro_machine::file::{no_records, parse};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn invariant_a_written_machine_reads_back_equal(machine in machine()) {
        let text = machine.to_toml();
        let read = parse(&text, "written.toml", &no_records);
        prop_assert!(read.is_ok(), "{}\n{text}", read.unwrap_err());
        prop_assert_eq!(read.unwrap(), machine, "{}", text);
    }
}
