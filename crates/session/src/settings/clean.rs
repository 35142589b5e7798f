//! Cleaning settings: the table `[clean]`.

use std::collections::BTreeMap;

use inhand_inspection::{CleanSettings, FillMethod, FillSettings};
use inhand_model::PerFinger;
use serde::{Deserialize, Serialize};

use super::check::finger;
use super::fingers::by_finger;
use crate::error::SessionError;

section! {
    /// Which steps of cleaning are taken; by default none.
    pub struct CleanSection {
        /// Whether flipped bodies are turned back.
        pub flips: bool = false,
        /// Whether exchanged fingertips are exchanged back.
        pub swaps: bool = false,
        /// Whether spikes are taken away.
        pub spikes: bool = false,
        /// Whether unlabelled markers that go on where a fingertip is lost become that fingertip.
        pub stitch: bool = false,
        /// How gaps are filled in the recording. Processing fills what is left by its own setting.
        pub fill: FillMethod = FillMethod::None,
        /// Longest gap that is filled so, seconds.
        pub fill_limit_s: f64 = 0.1,
        /// New rate of the recording, Hz.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub resample_hz: Option<f64> = None,
        /// From marker to pad by finger name, in the axes of the hand's body, millimetres.
        #[serde(deserialize_with = "by_finger")]
        pub pad_mm: BTreeMap<String, [f64; 3]> = BTreeMap::new(),
    }
}

impl CleanSection {
    /// The steps asked for; `None` where there is none.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`].
    pub fn steps(&self) -> Result<Option<CleanSettings>, SessionError> {
        let mut pads_m = PerFinger::from_fn(|_| None);
        for (name, offset_mm) in &self.pad_mm {
            pads_m[finger(name, "clean.pad_mm")?] = Some(offset_mm.map(|mm| mm * 1e-3));
        }
        let steps = CleanSettings {
            flips: self.flips,
            swaps: self.swaps,
            spikes: self.spikes,
            stitch: self.stitch,
            fill: (self.fill != FillMethod::None).then_some(FillSettings {
                method: self.fill,
                limit_s: self.fill_limit_s,
            }),
            pads_m,
            resample_hz: self.resample_hz,
        };
        Ok((steps != CleanSettings::default()).then_some(steps))
    }
}
