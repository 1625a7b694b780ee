//! Every format gives the same model; files that are cut off or hostile are refused with their
//! line.

use nalgebra::DMatrix;
use std::path::PathBuf;
use vibro_reduce::import::files::{self, Sources};
use vibro_reduce::import::{Matrix, abaqus, calculix, harwell, market, model, punch};
use vibro_reduce::model::Model;
use vibro_reduce::sparse::Symmetric;

fn dense(a: &Symmetric) -> DMatrix<f64> {
    a.times(&DMatrix::identity(a.count(), a.count()))
}

/// Stiffness and mass of all the files below; dofs 11.x, 12.x, 12.rz.
fn expected() -> [DMatrix<f64>; 2] {
    let k = DMatrix::from_row_slice(3, 3, &[300.0, -100.0, 0.0, -100.0, 100.0, 0.25, 0.0, 0.25, 2.0]);
    let m = DMatrix::from_diagonal(&vec![2.0, 1.5, 0.001].into());
    [k, m]
}

const MARKET: [&str; 2] = [
    "%%MatrixMarket matrix coordinate real symmetric\n% comment\n3 3 5\n1 1 300\n2 1 -100.0\n2 2 1e2\n3 2 0.25\n3 3 2\n",
    "%%MatrixMarket matrix array real general\n3 3\n2\n0\n0\n0\n1.5\n0\n0\n0\n1e-3\n",
];
const CALCULIX: [&str; 3] = [
    "1 1 300.0\n1 2 -100.\n2 2 1.000000000000000e+02\n2 3 0.25\n3 3 2.\n",
    "      1     1  2.\n 2 2 1.5E+00\n 3 3 1.e-3\n",
    "11.1\n12.1\n12.6\n",
];
const ABAQUS: [&str; 2] = [
    "** ASSEMBLED\n*MATRIX INPUT\n11,1, 11,1, 3.0e+02\n12,1, 11,1, -1.0e+02\n12,1, 12,1, 1.0e+02\n12,6, 12,1, 0.25\n12,6, 12,6, 2.0\n",
    "11,1, 11,1, 2.0\n12,1, 12,1, 1.5\n12,6, 12,6, 1e-3\n",
];
const PUNCH: &str = "$TITLE\n\
DMIG    KAAX           0       6       2       0                       3\n\
DMIG*   KAAX                          11               1\n\
*                     11               1 3.000000000D+02\n\
*                     12               1-1.000000000D+02\n\
DMIG*   KAAX                          12               1\n\
*                     12               1 1.000000000D+02\n\
*                     12               6 2.5-1\n\
DMIG*   KAAX                          12               6\n\
*                     12               6 2.0\n\
DMIG,MAAX,0,6,2,0\n\
DMIG,MAAX,11,1,,11,1,2.0\n\
DMIG    MAAX    12      1               12      1       1.5\n\
DMIG    MAAX    12      6               12      6       1.-3\n\
ENDDATA\n";
const HARWELL: [&str; 2] = [
    "Stiffness                                                               K\n\
             3             1             1             1             0\n\
RSA                        3             3             5             0\n\
(4I4)           (5I4)           (1P,5E12.4)\n   1   3   5   6\n   1   2   2   3   3\n  3.0000E+02 -1.0000E+02  1.0000E+02  2.5000E-01  2.0000E+00\n",
    "Mass                                                                    M\n\
             3             1             1             1             0\n\
RUA                        3             3             3             0\n\
(I4)            (3I4)           (3D12.4)\n   1\n   2\n   3\n   4\n   1   2   3\n  2.0000D+00  1.5000D+00  1.0000D-03\n",
];
const MAPPING: &str = "  Matrix Eqn   Node   DOF\n       1     11   UX\n   2   12 UX\n 3 12 ROTZ\n";

fn is_expected(model: &Model, names: bool) {
    let [k, m] = expected();
    assert_eq!(dense(&model.stiffness), k);
    assert_eq!(dense(&model.mass), m);
    if names {
        let own: Vec<String> = model.dofs.list().iter().map(ToString::to_string).collect();
        assert_eq!(own, ["11.x", "12.x", "12.rz"]);
    }
}

fn punched(text: &str) -> [Matrix; 2] {
    let found = punch::matrices(text, "p.pch").unwrap();
    let names: Vec<&str> = found.iter().map(|own| own.0.as_str()).collect();
    assert_eq!(names, ["KAAX", "MAAX"]);
    let mut found = found.into_iter().map(|own| own.1);
    [found.next().unwrap(), found.next().unwrap()]
}

#[test]
fn closed_form_every_format_is_read() {
    let dofs = || Some(("b.dof".to_owned(), calculix::dofs(CALCULIX[2], "b.dof").unwrap()));
    let [k, m] = MARKET.map(|text| market::matrix(text, "K.mtx").unwrap());
    is_expected(&model(k, m, None, None).unwrap(), false);
    let [k, m] = [CALCULIX[0], CALCULIX[1]].map(|text| calculix::matrix(text, "b.sti").unwrap());
    is_expected(&model(k, m, None, dofs()).unwrap(), true);
    let [k, m] = ABAQUS.map(|text| abaqus::matrix(text, "STIF1.mtx").unwrap());
    is_expected(&model(k, m, None, None).unwrap(), true);
    let coordinates = [CALCULIX[0], CALCULIX[1]].map(|text| abaqus::matrix(text, "STIF1.mtx").unwrap());
    let [k, m] = coordinates;
    is_expected(&model(k, m, None, dofs()).unwrap(), true);
    let [k, m] = punched(PUNCH);
    is_expected(&model(k, m, None, None).unwrap(), true);
    let [k, m] = HARWELL.map(|text| harwell::matrix(text, "k.rsa").unwrap());
    let mapped = Some(("k.mapping".to_owned(), harwell::mapping(MAPPING, "k.mapping").unwrap()));
    is_expected(&model(k, m, None, mapped).unwrap(), true);
}

/// A reader of a file.
type Reader = fn(&str) -> Option<String>;

#[test]
fn invariant_every_file_that_is_cut_off_is_refused_or_shorter() {
    let readers: [(&str, Reader); 7] = [
        (MARKET[0], |text| market::matrix(text, "f").err().map(|e| e.to_string())),
        (MARKET[1], |text| market::matrix(text, "f").err().map(|e| e.to_string())),
        (CALCULIX[0], |text| calculix::matrix(text, "f").err().map(|e| e.to_string())),
        (ABAQUS[0], |text| abaqus::matrix(text, "f").err().map(|e| e.to_string())),
        (PUNCH, |text| punch::matrices(text, "f").err().map(|e| e.to_string())),
        (HARWELL[0], |text| harwell::matrix(text, "f").err().map(|e| e.to_string())),
        (MAPPING, |text| harwell::mapping(text, "f").err().map(|e| e.to_string())),
    ];
    for (text, read) in readers {
        assert_eq!(read(text), None);
        for at in 0..text.len() {
            // Formats that state their size must notice; none may panic.
            let said = read(&text[..at]);
            assert!(said.is_none_or(|said| said.starts_with('f')), "{at}");
        }
    }
    let whole = |text: &'static str| text.trim_end();
    for cut in 1..whole(HARWELL[0]).len() {
        assert!(harwell::matrix(&whole(HARWELL[0])[..cut], "f").is_err(), "{cut}");
    }
    for text in [CALCULIX[0], ABAQUS[0]] {
        let cut = &whole(text)[..whole(text).len() - 1];
        assert!(calculix::matrix(cut, "f").is_err() && abaqus::matrix(cut, "f").is_err(), "{cut}");
    }
    // A last digit may be missing, but no entry.
    assert!(market::matrix(&whole(MARKET[0])[..whole(MARKET[0]).len() - 2], "f").is_err());
    let [k, m] = ["1 1 2.0\n", "1 1 1.0\n2 2 1.0\n"].map(|text| calculix::matrix(text, "f").unwrap());
    let dofs = ("d".to_owned(), calculix::dofs("7.x\n7.y\n", "d").unwrap());
    let text = model(k, m, None, Some(dofs)).unwrap_err().to_string();
    assert!(text.contains("its last row is 1, but d names 2 dofs"), "{text}");
}

#[test]
fn invariant_hostile_files_are_refused_with_their_line() {
    let huge = "999999999999999999";
    let cases: Vec<(Option<String>, &str)> = vec![
        (err(calculix::matrix("1 1 nan\n", "f")), "f:1: 1 1 nan: expected row"),
        (err(calculix::matrix("1 1 1.0\n0 1 2.0\n", "f")), "f:2"),
        (err(calculix::matrix("1 1\n", "f")), "f:1"),
        (err(calculix::matrix("1 1 1 1\n", "f")), "f:1"),
        (err(calculix::matrix("", "f")), "no entries"),
        (err(calculix::dofs("11.1\n12.0\n", "f")), "f:2: 12.0"),
        (err(calculix::dofs("11.1\n12.8\n", "f")), "pressures are not reduced"),
        (err(market::matrix("%%MatrixMarket matrix coordinate complex symmetric\n1 1 1\n", "f")), "f:1"),
        (
            err(market::matrix("%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 2 3.0\n", "f")),
            "f:3",
        ),
        (
            err(market::matrix(
                &format!("%%MatrixMarket matrix array real general\n{huge} {huge}\n1\n"),
                "f",
            )),
            "too few",
        ),
        (err(market::matrix("%%MatrixMarket matrix coordinate real symmetric\n2 3 1\n", "f")), "square"),
        (err(abaqus::matrix("1,1,1,1,2.0\n-3,1,1,1,2.0\n", "f")), "Lagrange"),
        (err(abaqus::matrix("1,8,1,8,2.0\n", "f")), "pressures"),
        (err(abaqus::matrix("1,1,1,1,2.0\n1,1,2.0\n", "f")), "f:2"),
        (err(abaqus::matrix("*MATRIX\n", "f")), "no entries"),
        (err(punch::matrices("DMIG*   KAAX                          11               1\n", "f")), "heading"),
        (err(punch::matrices("DMIG    KAAX           0       6       4       0\n", "f")), "real matrix"),
        (err(punch::matrices("DMIG    KAAX           0       9       2       0\n", "f")), "form 6 or 1"),
        (err(punch::matrices("DMIG,K,0,6,2,0\nDMIG,K,1,1,,1,9,3.0\n", "f")), "f:2"),
        (err(punch::matrices("DMIG,K,0,6,2,0\nDMIG,K,1,1,,1,1,3.0,1.0\n", "f")), "finite number"),
        (err(punch::matrices("DMIG,K,0,6,2,0\nDMIG,K,1,1\n", "f")), "at least one entry"),
        (err(punch::matrices("nothing\n", "f")), "no DMIG"),
        (err(harwell::matrix(&HARWELL[0].replace("RSA", "CSA"), "f")), "f:3"),
        (err(harwell::matrix(&HARWELL[0].replace("        5  ", "999999999  "), "f")), "f:3"),
        (err(harwell::matrix(&HARWELL[0].replace("(4I4)", "(4Q4)"), "f")), "formats"),
        (
            err(harwell::matrix(&HARWELL[0].replace("   1   3   5   6", "   1   5   3   6"), "f")),
            "rise from 1 to 6",
        ),
        (
            err(harwell::matrix(&HARWELL[0].replace("   1   2   2   3   3", "   1   2   2   3   4"), "f")),
            "f:6",
        ),
        (err(harwell::mapping("1 11 UX\n2 11 TEMP\n", "f")), "f:2"),
        (err(harwell::mapping("1 11 UX\n3 11 UY\n", "f")), "equation 2"),
        (err(harwell::mapping("Heading\n", "f")), "no equation"),
    ];
    for (k, (said, expected)) in cases.into_iter().enumerate() {
        let said = said.unwrap_or_else(|| panic!("case {k}, {expected}: was read"));
        assert!(said.contains(expected), "case {k}: {said}");
    }
}

fn err<T>(read: vibro_reduce::Result<T>) -> Option<String> {
    read.err().map(|e| e.to_string())
}

#[test]
fn invariant_matrices_that_do_not_fit_are_refused() {
    let matrix = |text: &str| calculix::matrix(text, "f").unwrap();
    let named = |text: &str| Some(("d".to_owned(), calculix::dofs(text, "d").unwrap()));
    let said = |k: &str, m: &str, dofs| err(model(matrix(k), matrix(m), None, dofs)).unwrap();
    let text = said("1 1 1\n999999999999 1 1\n", "1 1 1\n", None);
    assert!(text.contains("999999999999 rows, but only 3 entries"), "{text}");
    let text = said("1 1 1\n3 3 1\n", "1 1 1\n", named("1.x\n2.x\n"));
    assert!(text.contains("has a row 3, but d names 2 dofs"), "{text}");
    let text = said("1 1 1\n1 1 1\n", "1 1 1\n", None);
    assert!(text.contains("listed twice"), "{text}");
    let text = said("1 1 1\n1 2 1\n2 1 2\n2 2 1\n", "1 1 1\n2 2 1\n", named("7.x\n7.y\n"));
    assert!(text.contains("dof 7.x") && text.contains("not symmetric"), "{text}");
    let text = said("1 1 1\n2 2 1\n", "1 1 1\n2 2 1\n", named("7.x\n7.1\n"));
    assert!(text.contains("dof 7.x: rows 1 and 2"), "{text}");
}

#[test]
fn closed_form_dofs_with_a_penalty_are_clamped() {
    let k = "1,1,1,1,1.0e36\n2,1,1,1,-100.0\n2,1,2,1,300.0\n";
    let [k, m] = [k, "1,1,1,1,5.0\n2,1,2,1,2.0\n"].map(|text| abaqus::matrix(text, "f").unwrap());
    let model = model(k, m, None, None).unwrap();
    assert_eq!((model.dofs.len(), model.clamped.list()[0].to_string()), (1, "1.x".into()));
    assert_eq!(dense(&model.stiffness)[(0, 0)], 300.0);
    assert!(model.remarks[0].contains("1.x"), "{:?}", model.remarks);
}

#[test]
fn invariant_files_are_found_by_their_names_and_large_ones_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let sources = |files: Vec<PathBuf>| Sources { files, ..Sources::default() };
    let calculix =
        vec![write("b.sti", CALCULIX[0]), write("b.mas", CALCULIX[1]), write("b.dof", CALCULIX[2])];
    is_expected(&files::read(&sources(calculix)).unwrap(), true);
    is_expected(&files::read(&sources(vec![write("p.pch", PUNCH)])).unwrap(), true);
    let abaqus = vec![write("Job_STIF1.mtx", ABAQUS[0]), write("Job_MASS1.mtx", ABAQUS[1])];
    is_expected(&files::read(&sources(abaqus)).unwrap(), true);
    let ansys = vec![write("K.rsa", HARWELL[0]), write("M.rsa", HARWELL[1]), write("K.mapping", MAPPING)];
    is_expected(&files::read(&sources(ansys)).unwrap(), true);
    let odd = [write("one.mtx", MARKET[0]), write("two.mtx", MARKET[1])];
    let text = files::read(&sources(odd.to_vec())).unwrap_err().to_string();
    assert!(text.contains("--stiffness FILE"), "{text}");
    let [k, m] = odd;
    let named = Sources { stiffness: Some(k.clone()), mass: Some(m), ..Sources::default() };
    is_expected(&files::read(&named).unwrap(), false);
    let text = files::read(&sources(vec![write("K.mtx", MARKET[0])])).unwrap_err().to_string();
    assert!(text.contains("no mass matrix"), "{text}");
    let text = files::read(&sources(vec![write("b.op4", "x")])).unwrap_err().to_string();
    assert!(text.contains("expected .mtx"), "{text}");
    let binary = folder.path().join("x.sti");
    std::fs::write(&binary, [0xff, 0xfe, 0x00]).unwrap();
    let text = files::read(&sources(vec![binary])).unwrap_err().to_string();
    assert!(text.contains("not a text"), "{text}");
    // A file with a hole: it takes no room on disk.
    let large = folder.path().join("large.sti");
    std::fs::File::create(&large).unwrap().set_len(10_500_000_000).unwrap();
    let text = files::read(&sources(vec![large])).unwrap_err().to_string();
    assert!(text.contains("10.5 GB; expected at most 10 GB"), "{text}");
}
