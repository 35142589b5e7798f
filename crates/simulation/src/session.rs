//! A session: takes for learning and takes for testing, of one hand and one object.

use inhand_model::Shape;
use rayon::prelude::*;

use crate::error::SimulationError;
use crate::faults::{FaultSettings, simulate_faulty};
use crate::random::{Purpose, Random};
use crate::settings::{GapSettings, TakeSettings, in_range};
use crate::take::{SimulatedTake, simulate};

/// Most takes of one kind in a session: names have two digits.
const MAX_TAKES: usize = 99;

/// A session of takes; [`SessionSettings::new`] has the defaults of the demo.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionSettings {
    /// The object in the hand, as in [`TakeSettings::shape`].
    pub shape: Shape,
    /// Takes for learning, up to 99.
    pub train_takes: usize,
    /// Takes for testing, up to 99.
    pub test_takes: usize,
    /// Length of every take, seconds.
    pub duration_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Standard deviation of marker noise per coordinate, metres.
    pub noise_m: f64,
    /// Gaps in the fingertip markers of every take, if any.
    pub gaps: Option<GapSettings>,
    /// Faults planted into every take, if any; their gaps take the place of `gaps`.
    pub faults: Option<FaultSettings>,
    /// Whether the object is tracked in the takes for learning; in those for testing it is.
    pub track_object_in_training: bool,
}

impl SessionSettings {
    /// The session of the demo with this object: five takes for learning, one for testing, 120 s
    /// each, otherwise as [`TakeSettings::new`]; the object is tracked in the test take alone.
    pub const fn new(shape: Shape) -> Self {
        Self {
            shape,
            train_takes: 5,
            test_takes: 1,
            duration_s: 120.0,
            rate_hz: 100.0,
            noise_m: 1e-4,
            gaps: None,
            faults: None,
            track_object_in_training: false,
        }
    }

    fn take(&self, name: String, track_object: bool) -> TakeSettings {
        TakeSettings {
            shape: self.shape,
            duration_s: self.duration_s,
            rate_hz: self.rate_hz,
            noise_m: self.noise_m,
            gaps: self.gaps,
            track_object,
            name,
        }
    }
}

/// The takes of a simulated session.
#[derive(Clone, Debug)]
pub struct SimulatedSession {
    /// Takes for learning, named like `cube_train_01`.
    pub train: Vec<SimulatedTake>,
    /// Takes for testing, named like `cube_test_01`.
    pub test: Vec<SimulatedTake>,
}

/// Simulates the takes of a session in parallel on rayon's pool. Every take has a seed of its own,
/// derived from `seed`, its kind and its number: neither the number of threads nor that of the
/// other takes changes it.
///
/// # Errors
///
/// [`SimulationError`] as [`simulate`] returns it, of the first take that has one.
pub fn session(settings: &SessionSettings, seed: u64) -> Result<SimulatedSession, SimulationError> {
    for (setting, takes) in [
        ("train_takes", settings.train_takes),
        ("test_takes", settings.test_takes),
    ] {
        in_range(setting, takes as f64, 0.0, MAX_TAKES as f64)?;
    }
    let object = match settings.shape {
        Shape::Cuboid { edges_m: [x, y, z] } if x == y && y == z => "cube",
        Shape::Cuboid { .. } => "box",
        Shape::Cylinder { .. } => "cylinder",
    };
    let plan = |role: &'static str, takes: usize, first_stream: u64, track_object: bool| {
        (1..=takes).map(move |number| {
            let name = format!("{object}_{role}_{number:02}");
            let stream = Purpose::Take(first_stream + number as u64);
            let take_seed = Random::new(seed, stream).integer();
            (settings.take(name, track_object), take_seed)
        })
    };
    let track_in_training = settings.track_object_in_training;
    let takes: Vec<(TakeSettings, u64)> = plan("train", settings.train_takes, 0, track_in_training)
        .chain(plan("test", settings.test_takes, 1000, true))
        .collect();
    let simulated: Vec<_> = (takes.par_iter())
        .map(|(take, take_seed)| match &settings.faults {
            None => simulate(take, *take_seed),
            Some(faults) => Ok(simulate_faulty(take, faults, *take_seed)?.into_take()),
        })
        .collect();
    // In order, so that the first error is the same whatever the number of threads.
    let mut train = simulated.into_iter().collect::<Result<Vec<_>, _>>()?;
    let test = train.split_off(settings.train_takes);
    Ok(SimulatedSession { train, test })
}
