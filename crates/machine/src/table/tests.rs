use super::*;

/// The columns of a record of `time` and `box.s`.
fn read(text: &str) -> Result<Vec<(String, Vec<f64>)>, String> {
    Table::read(text).columns(&|name| Some(if name == "time" { "s" } else { "m" }))
}

#[test]
fn closed_form_of_columns_by_the_units_of_their_heading() {
    let expected = vec![("time".to_owned(), vec![0.0, 0.5]), ("box.s".to_owned(), vec![0.001, -0.0025])];
    for text in [
        "time,box.s\n0,0.001\n0.5,-25e-4",
        "# made by hand\n\n time [s] , box.s [m]\n# begin\n0,0.001\n\n0.5,-0.0025\n",
        "\u{feff}time [ms];box.s (mm)\r\n0;1\r\n500;-2.5\r\n",
        "\"time/ms\",\"box.s/µm\"\n0,1e3\n\"500\",-2500",
    ] {
        assert_eq!(read(text), Ok(expected.clone()), "{text}");
    }
    let names = |text| Table::read(text).names();
    let unit = |name, unit| Heading { name, unit: Some(unit) };
    assert_eq!(names("c (N/(m/s)),F(t)/kN"), [unit("c", "N/(m/s)"), unit("F(t)", "kN")]);
    assert_eq!(
        names("in/out,\"t; since noon\""),
        ["in/out", "t; since noon"].map(|name| Heading { name, unit: None })
    );
}

#[test]
fn what_is_no_table_is_refused_by_its_line() {
    for (text, words) in [
        ("time [ms],box.s [kN]\n0,1\n", "line 1: `box.s` has the unit `kN`; expected one of m, cm, mm"),
        ("time [],box.s\n0,1\n", "line 1: `time` has the unit ``; expected one of s, ms"),
        ("time;box.s\n0;1\n# next\n0,5;1\n", "line 4: `0,5` has a decimal comma; expected a decimal point"),
        ("time,box.s\n0,1\n0,5,1,0\n", "line 3: `0,5,1,0` has 4 cells; expected 2 cells separated by commas"),
        (
            "time,box.s\n0;1\n",
            "line 2: `0;1` is separated by a semicolon; expected 2 cells separated by commas",
        ),
        (
            "time;box.s\n0,1\n",
            "line 2: `0,1` is separated by a comma; expected 2 cells separated by semicolons",
        ),
        ("time,box.s\n0 1\n", "line 2: `0 1` is separated by a blank; expected 2 cells"),
        ("time,box.s\n0,inf\n", "line 2: `inf` is not a number; expected a number"),
    ] {
        let found = read(text).unwrap_err();
        assert!(found.starts_with(words), "{text}: {found}");
    }
    // A row of numbers is not a heading, whatever its decimal separator.
    assert_eq!(Table::read("0,5;1\n").heading(), None);
}
