//! The answer "no": which value, which limit.

use inhand_model::{
    Dictionary, DictionaryKind, Finger, Hand, Object, PerFinger, Pose, Position, Residual,
    VelocityBounds,
};
use inhand_planner::{
    AccelerationBounds, Ends, Holding, Method, PlanError, Planner, PlannerSettings, Target,
};
use nalgebra::{DMatrix, DVector, Isometry3};

use crate::support::{bounds, ends, residual, settings, smooth};

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
    settings
        .constraints
        .velocity
        .as_mut()
        .expect("settings have bounds")
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
    assert!(
        error
            .to_string()
            .contains("velocity bounds of little, axis 2")
    );
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
fn targets_that_contradict_themselves_are_refused() {
    let dictionary = smooth(DictionaryKind::Nmf, 6, 4);
    let planner = Planner::new(&dictionary, Method::Prior, &settings(bounds(1.0))).unwrap();
    let there = |x: f64| {
        let mut tips = PerFinger::from_fn(|_| None);
        tips[Finger::Ring] = Some([x, 0.0, 0.0]);
        tips
    };
    let last = || Target::new().last([0.0; 15]);
    let pose = Pose::<Hand, Object>::new(Isometry3::translation(0.1, 0.0, 0.0));
    let holding = |samples: usize, tau_m: f64| Holding {
        hand_from_object: vec![pose; samples],
        contacts: PerFinger::from_fn(|_| Some(Position::new(0.0, 0.02, 0.0))),
        tau_m,
    };
    let nobody = Holding {
        contacts: PerFinger::from_fn(|_| None),
        ..holding(6, 0.005)
    };
    for (target, expected) in [
        (Target::new(), "gives nothing"),
        (last().only(&[]), "gives nothing"),
        // 6 samples at 6 Hz end at 5/6 s.
        (
            last().waypoint(0.9, there(0.0)),
            "a waypoint lies at 0.9 s: expected a time from 0 to 0.833",
        ),
        (
            last().waypoint(-0.1, there(0.0)),
            "a waypoint lies at -0.1 s",
        ),
        (
            last().waypoint(f64::NAN, there(0.0)),
            "a waypoint lies at NaN s",
        ),
        (
            last()
                .waypoint(0.33, there(0.01))
                .waypoint(0.34, there(0.02)),
            "want ring at [0.01, 0.0, 0.0] and at [0.02, 0.0, 0.0] m at the same sample 2",
        ),
        (
            last().waypoint(0.83, there(0.01)),
            "last configuration and waypoint want ring at [0.0, 0.0, 0.0] and at [0.01, 0.0, 0.0]",
        ),
        (
            last().waypoint(0.3, there(f64::NAN)),
            "waypoint of ring, axis 0, is NaN",
        ),
        (
            last().first_velocity([250.0; 15]),
            "first velocity of thumb, axis 0, is 250: expected a number of at most 100",
        ),
        (
            last().object_first(pose),
            "object, which is not in these segments",
        ),
        (
            last().holding(holding(7, 0.005)),
            "number of the object's poses that fingers hold on to is 7, expected 6",
        ),
        (
            last().holding(holding(6, 0.0)),
            "tau_m of holding fingers is 0",
        ),
        (last().holding(nobody), "at least one finger"),
    ] {
        let message = planner.plan(&target).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
        assert!(planner.corridor(&target).is_err());
    }
    // Twice the same is no contradiction.
    let twice = last()
        .waypoint(0.33, there(0.01))
        .waypoint(0.34, there(0.01));
    assert!(planner.plan(&twice).is_ok());
}

#[test]
fn constraints_out_of_range_are_refused() {
    let acceleration = |min: f64, max: f64| AccelerationBounds {
        min_m_s2: [min; 15],
        max_m_s2: [max; 15],
    };
    let message = refused(|_, s| s.constraints.acceleration = Some(acceleration(1.0, -1.0)));
    assert_eq!(
        message.to_string(),
        "acceleration bounds of thumb, axis 0, run from 1 to -1 m/s²: \
         expected two numbers, the first not above the second"
    );
    let error = refused(|_, s| s.constraints.reachability_margin_m = Some(0.0));
    assert!(error.to_string().contains("that of thumb has no faces"));
    for value in [0.0, -0.01, f64::NAN] {
        let message = refused(|_, s| s.constraints.separation_m = Some(value)).to_string();
        assert!(message.contains(&format!("separation_m is {value}: expected a positive")));
        let message = refused(|_, s| s.velocity_sigma_m_s = value).to_string();
        assert!(message.contains("velocity_sigma_m_s"));
    }
    let error = refused(|_, s| s.constraints.reachability_margin_m = Some(f64::NAN));
    assert!(error.to_string().contains("reachability_margin_m is NaN"));
}

#[test]
fn residuals_that_do_not_fit_together_are_refused() {
    for (change, expected) in [
        (
            (|r| r.layout.samples = 11) as fn(&mut Residual),
            "rows of the primitives is 150, expected 165",
        ),
        (
            |r| r.layout.object = true,
            "rows of the primitives is 150, expected 210",
        ),
        (|r| r.layout.rate_hz = f64::NAN, "10 samples at NaN Hz"),
        (
            |r| r.ends_mean = DVector::zeros(59),
            "length of the mean end conditions is 59, expected 60",
        ),
        (
            |r| r.ends_mean[3] = f64::NAN,
            "mean end conditions to plan with hold NaN",
        ),
        (
            |r| r.covariance_m2 *= 0.0,
            "covariance of the 3 activations is not positive definite (smallest eigenvalue 0",
        ),
        (
            |r| r.ends_covariance[(7, 7)] = -1.0,
            "covariance of the 60 end conditions is not positive definite",
        ),
        (
            |r| r.primitives = r.primitives.columns(0, 2).into_owned(),
            "number of expected activations is 3, expected 2",
        ),
    ] {
        let mut residual = residual(10, 3, false);
        change(&mut residual);
        let error = Planner::residual(&residual, &settings(bounds(1.0))).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}
