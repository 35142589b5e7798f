//! A session: takes for learning and takes for testing, of one hand and one object.

use inhand_model::Shape;

use crate::error::SimulationError;
use crate::faults::{FaultSettings, simulate_faulty};
use crate::random::{Purpose, Random};
use crate::settings::{TakeSettings, in_range};
use crate::take::{SimulatedTake, simulate};

/// Most takes of one kind in a session: names have two digits.
const MAX_TAKES: usize = 99;

/// A session of takes; [`SessionSettings::new`] has the defaults of the demo.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionSettings {
    /// What all takes have in common. Each has a name of its own, and the object is tracked in those for
    /// testing and where `track_object_in_training` says so.
    pub take: TakeSettings,
    /// Takes for learning, up to 99.
    pub train_takes: usize,
    /// Takes for testing, up to 99.
    pub test_takes: usize,
    /// Faults planted into every take, if any; their gaps take the place of those of `take`.
    pub faults: Option<FaultSettings>,
    /// Whether the object is tracked in the takes for learning; in those for testing it is.
    pub track_object_in_training: bool,
}

impl SessionSettings {
    /// The session of the demo with this object: five takes for learning, one for testing, 120 s
    /// each, otherwise as [`TakeSettings::new`]; the object is tracked in the test take alone.
    pub fn new(shape: Shape) -> Self {
        Self {
            take: TakeSettings::new(shape, ""),
            train_takes: 5,
            test_takes: 1,
            faults: None,
            track_object_in_training: false,
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
    let object = match settings.take.shape {
        Shape::Cuboid { edges_m: [x, y, z] } if x == y && y == z => "cube",
        Shape::Cuboid { .. } => "box",
        Shape::Cylinder { .. } => "cylinder",
    };
    let plan = |role: &'static str, takes: usize, first_stream: u64, track_object: bool| {
        (1..=takes).map(move |number| {
            let take = TakeSettings {
                name: format!("{object}_{role}_{number:02}"),
                track_object,
                ..settings.take.clone()
            };
            let stream = Purpose::Take(first_stream + number as u64);
            let take_seed = Random::new(seed, stream).integer();
            (take, take_seed)
        })
    };
    let track_in_training = settings.track_object_in_training;
    let takes: Vec<(TakeSettings, u64)> = plan("train", settings.train_takes, 0, track_in_training)
        .chain(plan("test", settings.test_takes, 1000, true))
        .collect();
    let mut train = inhand_parallel::try_map(&takes, |(take, take_seed)| match &settings.faults {
        None => simulate(take, *take_seed),
        Some(faults) => Ok(simulate_faulty(take, faults, *take_seed)?.into_take()),
    })?;
    let test = train.split_off(settings.train_takes);
    Ok(SimulatedSession { train, test })
}
