//! The answer "no": which value, which limit.

use inhand_model::{Dictionary, DictionaryKind, VelocityBounds};
use inhand_planner::{Ends, Method, PlanError, Planner, PlannerSettings};
use nalgebra::{DMatrix, DVector};

use crate::support::{bounds, ends, settings, smooth};

fn refused(change: impl Fn(&mut Dictionary, &mut PlannerSettings)) -> PlanError {
    let mut dictionary = smooth(DictionaryKind::Nmf, 6, 4);
    let mut settings = settings(bounds(1.0));
    change(&mut dictionary, &mut settings);
    Planner::new(&dictionary, Method::Prior, &settings).expect_err("a change for the worse")
}

#[test]
fn dictionaries_that_cannot_plan_are_refused() {
    for (change, expected) in [
        (
            (|d| d.primitives[(3, 1)] = f64::NAN) as fn(&mut Dictionary),
            "the primitives holds a number that is not finite",
        ),
        (|d| d.primitives[(3, 1)] = -1.0, "negative"),
        (
            |d| d.layout.samples = 7,
            "rows of the primitives is 90, expected 105",
        ),
        (|d| d.layout.samples = 1, "1 samples at 6 Hz"),
        (|d| d.layout.rate_hz = 0.0, "6 samples at 0 Hz"),
        (
            |d| d.activation_covariance_m2[(2, 2)] = -1.0,
            "not positive definite (smallest eigenvalue -1.0",
        ),
        (
            |d| {
                d.primitives = DMatrix::zeros(90, 0);
                d.activation_mean_m = DVector::zeros(0);
                d.activation_covariance_m2 = DMatrix::zeros(0, 0);
            },
            "no primitives",
        ),
    ] {
        let message = refused(|dictionary, _| change(dictionary)).to_string();
        assert!(message.contains(expected), "{message}");
    }
}

fn velocity(settings: &mut PlannerSettings) -> &mut VelocityBounds {
    settings.constraints.velocity.as_mut().unwrap()
}

#[test]
fn settings_out_of_range_are_refused() {
    for value in [0.0, -1e-4, f64::NAN, f64::INFINITY] {
        let message = refused(|_, s| s.ends = Ends::Soft { sigma_m: value }).to_string();
        assert!(message.contains(&format!("sigma_m is {value}: expected a positive number")));
        assert!(
            refused(|_, s| s.ridge = value)
                .to_string()
                .contains("ridge")
        );
    }
    let error = refused(|_, s| velocity(s).min_m_s[4] = 2.0);
    assert_eq!(
        error.to_string(),
        "velocity bounds of index, axis 1, run from 2 to 1 m/s: \
         expected two numbers, the first not above the second"
    );
    let error = refused(|_, s| velocity(s).max_m_s[14] = f64::NAN);
    assert!(matches!(error, PlanError::VelocityBounds { axis: 2, .. }));
}

#[test]
fn targets_that_are_no_places_are_refused_where_the_method_looks_at_them() {
    let dictionary = smooth(DictionaryKind::Nmf, 6, 4);
    let good = ends(&dictionary, 0, 0.01);
    for (value, text) in [
        (f64::NAN, "first configuration of thumb, axis 2, is NaN"),
        (f64::INFINITY, "is inf"),
        (83.5, "is 83.5: expected a number of at most 10 in size"),
    ] {
        let mut ends = good;
        ends.first_m[2] = value;
        let settings = settings(bounds(1.0));
        let prior = Planner::new(&dictionary, Method::Prior, &settings).unwrap();
        let message = prior
            .plan(&Method::Prior.target(&ends))
            .unwrap_err()
            .to_string();
        assert!(message.contains(text), "{message}");
        // Only the last configuration counts for `paper`.
        let paper = Planner::new(&dictionary, Method::Paper, &settings).unwrap();
        assert!(paper.plan(&Method::Paper.target(&ends)).is_ok());
    }
}

#[test]
fn names_of_methods_are_read_and_others_refused() {
    for method in Method::ALL {
        assert_eq!(method.name().parse(), Ok(method));
    }
    let message = "papier".parse::<Method>().unwrap_err().to_string();
    assert_eq!(
        message,
        "unknown planning method \"papier\": expected one of paper, prior"
    );
}
