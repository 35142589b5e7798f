use super::*;

/// Two samples: 30 rows, with the object 42.
const LAYOUT: SegmentLayout = SegmentLayout {
    samples: 2,
    rate_hz: 2.0,
    object: false,
};

fn variables(list: &[(&str, DMatrix<f64>)]) -> Variables {
    (list.iter())
        .map(|(name, matrix)| ((*name).to_owned(), Variable::from(matrix.clone())))
        .collect()
}

fn import(list: &[(&str, DMatrix<f64>)], kind: DictionaryKind) -> Result<Given, String> {
    import_primitives(&variables(list), LAYOUT, kind).map_err(|error| error.to_string())
}

/// Of any lengths, above zero.
fn primitives() -> DMatrix<f64> {
    DMatrix::from_fn(30, 3, |i, j| 1.0 + (i * 3 + j) as f64)
}

#[test]
fn columns_get_unit_length_whatever_else_is_in_the_file() {
    let other = DMatrix::from_element(7, 5, 0.01);
    for list in [
        [("primitives", primitives()), ("activations", other.clone())],
        [("W", primitives()), ("H", other.clone())],
        [("components_", primitives().transpose()), ("x", other)],
    ] {
        let given = import(&list, DictionaryKind::Nmf).unwrap();
        for (column, from) in (given.primitives.column_iter()).zip(primitives().column_iter()) {
            assert!((column.norm() - 1.0).abs() < 1e-15);
            assert!((column * from.norm() - from).amax() < 1e-12);
        }
        assert_eq!(given.offset_m, None);
    }
}

#[test]
fn offsets_are_columns_rows_or_one_number() {
    let offset = |name: &'static str, matrix: DMatrix<f64>| {
        let list = [("W", primitives()), (name, matrix)];
        import(&list, DictionaryKind::Nmf).map(|given| given.offset_m.unwrap())
    };
    let numbers: Vec<f64> = (0..30).map(|n| -0.01 * f64::from(n)).collect();
    let expected = DVector::from_vec(numbers.clone());
    let column = DMatrix::from_vec(30, 1, numbers.clone());
    assert_eq!(offset("offset_m", column).unwrap(), expected);
    let row = DMatrix::from_vec(1, 30, numbers);
    assert_eq!(offset("mean_", row).unwrap(), expected);
    let one = offset("offset", DMatrix::from_element(1, 1, -0.2)).unwrap();
    assert_eq!(one, DVector::from_element(30, -0.2));
    let error = offset("offset", DMatrix::zeros(29, 1)).unwrap_err();
    assert!(
        error.contains("expected one number or 30, found 29 x 1"),
        "{error}"
    );
    let error = offset("offset", DMatrix::from_element(30, 1, -110.0)).unwrap_err();
    assert!(error.contains("divide it by 1000"), "{error}");
}

#[test]
fn what_does_not_fit_is_refused_with_what_to_do() {
    let check = |list: &[(&str, DMatrix<f64>)], expected: &[&str]| {
        let error = import(list, DictionaryKind::Nmf).unwrap_err();
        for part in expected {
            assert!(error.contains(part), "{error}");
        }
    };
    check(&[], &["no variable", "components_"]);
    check(&[("X", primitives())], &["found X"]);
    check(&[("H", primitives())], &["found H", "H is ambiguous"]);
    check(
        &[("W", primitives()), ("primitives", primitives())],
        &["found primitives and W"],
    );
    check(
        &[("W", primitives().transpose())],
        &["expected 30 x rank", "found 3 x 30", "looks transposed"],
    );
    check(
        &[("components_", primitives())],
        &["rank x 30", "looks transposed"],
    );
    check(
        &[("W", DMatrix::zeros(42, 3))],
        &["found 42 x 3", "looks like one for fingertips and object"],
    );
    check(
        &[("W", DMatrix::zeros(31, 3))],
        &["of this length and rate"],
    );
    check(
        &[("W", DMatrix::zeros(7, 3)), ("H", primitives().transpose())],
        &["segments are rows", "save H as components_"],
    );
    check(&[("W", DMatrix::zeros(30, 0))], &["found 30 x 0"]);
    let changed = |value: f64| {
        let mut matrix = primitives();
        matrix[(4, 1)] = value;
        matrix
    };
    check(
        &[("W", changed(f64::NAN))],
        &["finite", "NaN in row 4, column 1"],
    );
    check(&[("W", changed(-1e-9))], &["below zero", "row 4, column 1"]);
    let mut empty = primitives();
    empty.column_mut(2).fill(0.0);
    check(&[("W", empty)], &["primitive 2 of length 0"]);
    let given = import(&[("W", changed(-1.0))], DictionaryKind::Pca).unwrap();
    assert!(given.primitives[(4, 1)] < 0.0);
    let mut text = variables(&[]);
    text.insert("W".to_owned(), Variable::Other("text".to_owned()));
    let error = import_primitives(&text, LAYOUT, DictionaryKind::Nmf);
    assert!(error.unwrap_err().to_string().contains("found text"));
}
