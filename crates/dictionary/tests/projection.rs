//! Activations of a segment for a given dictionary.

use inhand_dictionary::{NmfSettings, activations, learn_nmf};
use inhand_model::{Dictionary, SegmentLayout};
use nalgebra::{DMatrix, DVector};

use crate::pca::{numbers, reference};
use crate::segments::{demonstrated, motion, segments};

fn learned() -> Dictionary {
    let settings = NmfSettings {
        rank: 12,
        ..NmfSettings::default()
    };
    learn_nmf(&segments(motion(8, 40)), demonstrated(), &settings).unwrap()
}

#[test]
fn agrees_with_scipys_non_negative_least_squares() {
    let r = reference("nnls");
    let primitives = DMatrix::from_vec(15, 6, numbers(&r["primitives"]));
    let dictionary = Dictionary {
        layout: SegmentLayout {
            samples: 1,
            rate_hz: 100.0,
            object: false,
        },
        offset_m: DVector::zeros(15),
        primitives,
        activation_mean_m: DVector::zeros(6),
        ..learned()
    };
    let segment = numbers(&r["segment"]);
    let found = activations(&dictionary, &segment).unwrap();
    let expected = numbers(&r["activations"]);
    assert!(expected.contains(&0.0), "a bound is active");
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-7, "{found} {expected}");
    }
    let residual = (&dictionary.primitives * &found - DVector::from_vec(segment)).norm();
    assert!((residual - r["residual"].as_f64().unwrap()).abs() < 1e-12);
}

#[test]
fn satisfies_the_conditions_of_optimality() {
    let dictionary = learned();
    for segment in motion(8, 47).column_iter().skip(40) {
        let h = activations(&dictionary, segment.clone_owned().as_slice()).unwrap();
        let residual = &dictionary.offset_m + &dictionary.primitives * &h - segment;
        let gradient = dictionary.primitives.transpose() * residual;
        for (h, gradient) in h.iter().zip(&gradient) {
            assert!(*h >= 0.0);
            // Metres, for segments of decimetres: a nanometre.
            assert!(
                *gradient > -1e-9 && (*h == 0.0 || gradient.abs() < 1e-9),
                "{h} {gradient}"
            );
        }
    }
}

#[test]
fn a_column_that_does_not_fit_is_refused() {
    let dictionary = learned();
    let error = activations(&dictionary, &[0.0; 119]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a segment of 119 numbers does not fit a dictionary of 120 rows"
    );
    let mut column = [0.1; 120];
    column[17] = f64::INFINITY;
    let error = activations(&dictionary, &column).unwrap_err().to_string();
    assert!(
        error.starts_with("number 17 of the segment is inf"),
        "{error}"
    );
}
