//! `vibro fit` of several records together.

use super::{COSINE, ROUNDED, said};

/// Rows of 10 mm cos(w t) for a start at `place` m, rounded to 0.1 µm.
fn cosine(place: f64, frequency: f64) -> String {
    let row = |k: i32| {
        let t = 0.05 * f64::from(k);
        format!("{t},{:.7}\n", place * (frequency * t).cos())
    };
    "time,m.s\n".to_owned() + &(0..20).map(row).collect::<String>()
}

/// Two masses on one spring, from two places: 1 kg from 10 mm, 4 kg from 6 mm. The stiffness is
/// shared, the places are unknown, and the second mass is set.
#[test]
fn closed_form_of_a_stiffness_that_two_records_share() {
    let tables = [("one.csv", cosine(0.01, 10.0)), ("two.csv", cosine(0.006, 5.0))];
    let tables: Vec<(&str, &str)> = tables.iter().map(|(name, text)| (*name, &text[..])).collect();
    let arguments =
        "--data one.csv,two.csv --free spring.k.stiffness --own body.m.start.s --set-in two:body.m.mass=4kg";
    let (out, told) = said("fit-together", COSINE, &tables, arguments);
    let text = std::fs::read_to_string(out.join("numbers.csv")).unwrap_or_else(|_| panic!("{told}"));
    let mut rows = text.lines();
    assert_eq!(rows.next(), Some("record,number,value,error"));
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split(',').collect()).collect();
    let expected = [
        ("one", "spring.k.stiffness", 100.0, ROUNDED),
        ("one", "body.m.start.s", 0.01, 1e-7),
        ("two", "spring.k.stiffness", 100.0, ROUNDED),
        ("two", "body.m.start.s", 0.006, 1e-7),
    ];
    for (row, (record, number, value, near)) in rows.iter().zip(expected) {
        assert_eq!(row[..2], [record, number]);
        assert!((row[2].parse::<f64>().unwrap() - value).abs() < near, "{row:?}");
        assert!(row[3].parse::<f64>().unwrap() < near, "{row:?}");
    }
    for (record, mass) in [("one", "mass = 1.0"), ("two", "mass = 4.0")] {
        let fitted = std::fs::read_to_string(out.join(record).join("fitted.toml")).unwrap();
        assert!(fitted.starts_with("# vibro fit: fits") && fitted.contains(mass), "{fitted}");
        for file in ["fit.json", "residuals.csv", "report.html", "fit.svg"] {
            assert!(out.join(record).join(file).exists(), "{record}/{file}");
        }
    }
}

/// A fit that replaces an earlier one leaves only its own files and the user's.
#[test]
fn invariant_files_of_an_earlier_fit_do_not_stay_beside_new_ones() {
    let contacts = "element,time\nwall,0.1\n";
    let tables = [("one.csv", cosine(0.01, 10.0)), ("two.csv", cosine(0.01, 10.0))];
    let tables = tables.iter().map(|(name, text)| (*name, &text[..])).chain([("met.csv", contacts)]);
    let tables: Vec<(&str, &str)> = tables.collect();
    let wall = "[stop.wall]\nbetween = [\"ground\", \"m\"]\ngap = 1.0\nrestitution = 0.5\n";
    let walled = format!("{COSINE}{wall}");
    let free = "--free spring.k.stiffness";
    let first = format!("--data one.csv --events met.csv --start m.s=0.01 {free}");
    let (out, told) = said("fit-earlier", &walled, &tables, &first);
    let run = |file: &str, arguments: &str| {
        let line = format!("fit {file} --out fit --replace {arguments}");
        let mut vibro = std::process::Command::new(env!("CARGO_BIN_EXE_vibro"));
        let output = vibro.args(line.split(' ')).current_dir(out.parent().unwrap()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let is_there = |name: &str| out.join(name).exists();
    let of_first = ["start.toml", "residuals-contacts.csv", "fit.json", "report.html"];
    assert!(of_first.into_iter().all(is_there), "{told}");
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    let of_both = ["numbers.csv", "numbers.manifest.toml", "one", "two"];
    run("m.toml", &format!("--data one.csv,two.csv {free}"));
    assert!(of_both.into_iter().all(is_there) && !of_first.into_iter().any(is_there));
    run("m.toml", &format!("--data one.csv {free}"));
    assert!(is_there("fit.json") && is_there("notes.txt"));
    assert!(!of_both.into_iter().chain(of_first.into_iter().take(2)).any(is_there));
    // The machine's file may be an earlier fit's.
    std::fs::write(out.join("fitted.toml"), format!("# my comment\n{walled}")).unwrap();
    run("fit/fitted.toml", &format!("--data one.csv {free}"));
    let fitted = std::fs::read_to_string(out.join("fitted.toml")).unwrap();
    assert!(fitted.contains("# my comment"), "{fitted}");
}

#[test]
fn refused_records_that_do_not_go_together() {
    let tables = [("one.csv", "time,m.s\n0,0\n0.1,0.05\n"), ("two.csv", "time,m.s\n0,0\n0.1,0.05\n")];
    let cases = [
        ("--data one.csv,one.csv --free spring.k.stiffness", "one: is the name of two records"),
        (
            "--data one.csv,two.csv --free spring.k.stiffness --set-in three:body.m.mass=4kg",
            "no record is named three; expected one of one, two",
        ),
        (
            "--data one.csv,two.csv --free spring.k.stiffness --set-in body.m.mass=4kg",
            "RECORD:NAME=VALUE, e.g. run2:load.shaker.frequency=11Hz",
        ),
        (
            "--data one.csv,two.csv --free spring.k.stiffness --set-in two:spring.k.stiffness=80",
            "spring.k.stiffness begins at 90 in record one and at 80 in record two",
        ),
        (
            "--data one.csv,two.csv --events one.csv --free spring.k.stiffness",
            "--events: has 1 tables where --data has 2",
        ),
    ];
    for (arguments, words) in cases {
        let (_, told) = said("fit-apart", COSINE, &tables, arguments);
        assert!(told.contains(words), "{arguments}: {told}");
    }
}

/// The folder of one record has the results of another fit: the fit is refused before work begins,
/// so that nothing is written.
#[test]
fn a_folder_of_a_record_with_other_results_is_refused_before_work_begins() {
    let tables = [("one.csv", cosine(0.01, 10.0)), ("two.csv", cosine(0.01, 10.0))];
    let tables: Vec<(&str, &str)> = tables.iter().map(|(name, text)| (*name, &text[..])).collect();
    let (out, told) =
        said("fit-occupied", COSINE, &tables, "--data one.csv --free spring.k.stiffness --out fit/two");
    assert!(out.join("two/fit.json").exists(), "{told}");
    let line = "fit m.toml --data one.csv,two.csv --free spring.k.stiffness --out fit";
    let mut vibro = std::process::Command::new(env!("CARGO_BIN_EXE_vibro"));
    let output = vibro.args(line.split(' ')).current_dir(out.parent().unwrap()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("holds the result `fit` of another run"), "{text}");
    assert!(!out.join("numbers.csv").exists() && !out.join("one").exists());
}
