//! Cleaning of recordings: the steps that settings ask for, one after the other.

mod fill;
mod offset;
mod resample;

use inhand_model::{Change, PerFinger, Recording, Roles};
use inhand_motion::MotionError;

use crate::detect;
use crate::suspect::{Suspect, repair};

pub use fill::{FillMethod, FillSettings, fill};
pub use offset::to_pads;
pub use resample::resample;

/// Steps of cleaning; [`CleanSettings::default`] takes none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CleanSettings {
    /// Whether flipped bodies are turned back.
    pub flips: bool,
    /// Whether exchanged fingertips are exchanged back.
    pub swaps: bool,
    /// Whether spikes are removed.
    pub spikes: bool,
    /// Whether unlabelled pieces go to the fingertips that they are.
    pub stitch: bool,
    /// How gaps are filled, if at all.
    pub fill: Option<FillSettings>,
    /// From markers to pads, by finger: vectors with the axes of the hand's frame, metres.
    pub pads_m: PerFinger<Option<[f64; 3]>>,
    /// Rate of the result, Hz; that of the take where it is not given.
    pub resample_hz: Option<f64>,
}

/// A cleaned recording.
#[derive(Clone, Debug)]
pub struct Cleaned {
    /// The recording after all steps.
    pub recording: Recording,
    /// What each step changed, in the order of the steps. Samples are those of the measured recording: it
    /// is resampled last.
    pub changes: Vec<Change>,
}

type Detector = fn(&Recording, &Roles) -> Result<Vec<Suspect>, MotionError>;

/// Cleans a recording: flips, swaps, spikes, lost labels, gaps, pads, rate, in this order, the steps
/// that `settings` wish for. The recording given stays as it is.
///
/// What is looked for in a later step is looked for with everything before it out of the way, whether
/// that is repaired or not: a take whose swaps are not to be touched has its spikes found all the same.
///
/// # Errors
///
/// [`MotionError`].
pub fn clean(
    recording: &Recording,
    roles: &Roles,
    settings: &CleanSettings,
) -> Result<Cleaned, MotionError> {
    let mut cleaned = recording.clone();
    let mut changes = Vec::new();
    let repairs: [(bool, Detector); 4] = [
        (settings.flips, |recording, _| Ok(detect::flips(recording))),
        (settings.swaps, detect::swaps),
        (settings.spikes, |recording, roles| {
            detect::fingertips(recording, roles).map(|[_, spikes, _]| spikes)
        }),
        (settings.stitch, detect::unlabelled),
    ];
    for (_, detector) in repairs.into_iter().filter(|(wanted, _)| *wanted) {
        let found = detector(&cleaned, roles)?;
        changes.extend(repair(&mut cleaned, roles, &found)?);
    }
    if let Some(settings) = &settings.fill {
        changes.extend(fill(&mut cleaned, roles, settings)?);
    }
    changes.extend(to_pads(&mut cleaned, roles, &settings.pads_m)?);
    if let Some(rate_hz) = settings.resample_hz {
        let (resampled, change) = resample(&cleaned, rate_hz)?;
        cleaned = resampled;
        changes.push(change);
    }
    Ok(Cleaned {
        recording: cleaned,
        changes,
    })
}
