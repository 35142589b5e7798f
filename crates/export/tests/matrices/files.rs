use inhand_export::matrices::{MatrixFormat, Variable, Variables, read, write};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

pub(crate) const STORED_NPZ: &[u8] = include_bytes!("reference/stored.npz");
pub(crate) const PACKED_NPZ: &[u8] = include_bytes!("reference/packed.npz");
pub(crate) const STORED_MAT: &[u8] = include_bytes!("reference/stored.mat");
pub(crate) const PACKED_MAT: &[u8] = include_bytes!("reference/packed.mat");
pub(crate) const BIG_ENDIAN_MAT: &[u8] = include_bytes!("reference/big_endian.mat");
/// Files that this crate wrote and that `make.py` has checked by NumPy and SciPy.
const WRITTEN: [(MatrixFormat, &[u8]); 2] = [
    (MatrixFormat::Npz, include_bytes!("reference/written.npz")),
    (MatrixFormat::Mat, include_bytes!("reference/written.mat")),
];

/// Set this to write the files anew; then run `make.py` on them.
const WRITE: &str = "INHAND_WRITE_MATRICES";

/// As in `make.py`.
fn w() -> DMatrix<f64> {
    DMatrix::from_row_slice(2, 3, &[0.0, 1.5, -2.25, 3.0, 1e-300, 65504.0])
}

fn check(variables: &Variables, name: &str, expected: &DMatrix<f64>) {
    match &variables[name] {
        Variable::Numbers(found) => assert_eq!(found, expected, "{name}"),
        Variable::Other(what) => panic!("{name} is {what}"),
    }
}

fn check_other(variables: &Variables, name: &str, expected: &str) {
    match &variables[name] {
        Variable::Other(what) => assert!(what.contains(expected), "{name} is {what}"),
        Variable::Numbers(found) => panic!("{name} is {found}"),
    }
}

/// What both forms have in common.
fn check_types(variables: &Variables) {
    // A float of four bytes knows no 1e-300.
    let single = w().map(|v| if v == 1e-300 { 0.0 } else { v });
    check(variables, "single", &single);
    check(
        variables,
        "int8",
        &DMatrix::from_row_slice(1, 2, &[-128.0, 127.0]),
    );
    check(
        variables,
        "uint16",
        &DMatrix::from_row_slice(1, 2, &[0.0, 65535.0]),
    );
    let most = 2f64.powi(53);
    check(
        variables,
        "int64",
        &DMatrix::from_row_slice(1, 2, &[-most, most]),
    );
    check(
        variables,
        "logical",
        &DMatrix::from_row_slice(1, 2, &[1.0, 0.0]),
    );
    check(variables, "number", &DMatrix::from_element(1, 1, 7.5));
    check(variables, "empty", &DMatrix::zeros(0, 3));
    check_other(variables, "cube", "3 dimensions");
    check_other(variables, "text", "text");
    check_other(variables, "complex", "complex");
}

#[test]
fn every_array_of_numpy_is_read() {
    for bytes in [STORED_NPZ, PACKED_NPZ] {
        let variables = read(bytes, "numpy.npz").unwrap();
        check_types(&variables);
        for name in ["c_order", "fortran_order", "big_endian"] {
            check(&variables, name, &w());
        }
        check(
            &variables,
            "half",
            &DMatrix::from_row_slice(1, 2, &[0.5, -1.0]),
        );
        check(
            &variables,
            "vector",
            &DMatrix::from_row_slice(3, 1, &[1.0, 2.0, 3.0]),
        );
        check_other(&variables, "structured", "structured");
        assert_eq!(variables.len(), 16);
    }
}

#[test]
fn every_variable_of_scipy_is_read() {
    for bytes in [STORED_MAT, PACKED_MAT] {
        let variables = read(bytes, "scipy.mat").unwrap();
        check_types(&variables);
        check(&variables, "w", &w());
        check(
            &variables,
            "vector",
            &DMatrix::from_row_slice(1, 3, &[1.0, 2.0, 3.0]),
        );
        check(
            &variables,
            "a_name_that_is_as_long_as_matlab_takes_one_x_x_x_x_x_x_x",
            &w(),
        );
        check_other(&variables, "sparse", "sparse");
        check_other(&variables, "cells", "cell");
        check_other(&variables, "structure", "structure");
        assert_eq!(variables.len(), 16);
    }
    let variables = read(BIG_ENDIAN_MAT, "old.mat").unwrap();
    check(&variables, "w", &w());
    check(
        &variables,
        "vector",
        &DMatrix::from_row_slice(3, 1, &[1.0, 2.0, 3.0]),
    );
}

/// Variables of the files that `make.py` checks.
fn written(form: MatrixFormat) -> Vec<u8> {
    let vector = DVector::from_vec(vec![1.0, 2.0, 3.0]);
    let variables = [
        ("w", Variable::from(w())),
        ("vector", Variable::from(&vector)),
        ("number", Variable::from(7.5)),
        ("empty", Variable::from(DMatrix::zeros(0, 3))),
        ("nan", Variable::from(f64::NAN)),
    ];
    write(form, "written", &variables).unwrap()
}

#[test]
fn what_is_written_is_what_numpy_and_scipy_have_read() {
    for (form, checked) in WRITTEN {
        let bytes = written(form);
        if std::env::var_os(WRITE).is_some() {
            let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/matrices/reference");
            std::fs::write(format!("{folder}/written.{}", form.extension()), &bytes).unwrap();
            continue;
        }
        assert!(
            bytes == checked,
            "{form:?}: written differently: set {WRITE}=1, then run make.py on the files"
        );
    }
}

#[test]
fn names_that_a_tool_would_not_take_are_refused() {
    let one = || Variable::from(1.0);
    for name in ["", "1st", "a-b", "_a", "ä", &"a".repeat(64)] {
        let error = write(MatrixFormat::Npz, "a.npz", &[(name, one())]).unwrap_err();
        assert!(
            error.to_string().contains("expected names of letters"),
            "{error}"
        );
    }
    let twice = [("a", one()), ("a", one())];
    assert!(write(MatrixFormat::Mat, "a.mat", &twice).is_err());
    let other = [("a", Variable::Other("text".to_owned()))];
    let error = write(MatrixFormat::Mat, "a.mat", &other)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("variable a") && error.contains("text"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn every_matrix_comes_back_bit_for_bit(
        rows in 0..7_usize,
        columns in 0..7_usize,
        bits in prop::collection::vec(any::<u64>(), 49),
        name in "[a-zA-Z][a-zA-Z0-9_]{0,62}",
    ) {
        let matrix = DMatrix::from_fn(rows, columns, |i, j| f64::from_bits(bits[7 * i + j]));
        for form in MatrixFormat::ALL {
            let bytes = write(form, "a", &[(&name, Variable::from(matrix.clone()))]).unwrap();
            let back = read(&bytes, "a").unwrap();
            let back = back[&name].numbers().unwrap();
            prop_assert_eq!(back.shape(), matrix.shape());
            prop_assert!(back.iter().zip(&matrix).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}
