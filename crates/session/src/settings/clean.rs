//! How takes are cleaned: the table `[clean]`.

use std::collections::BTreeMap;

use inhand_cleaning::{CleanSettings, FillMethod, FillSettings, PadOffset};
use inhand_model::{Finger, PerFinger};
use serde::{Deserialize, Serialize};

use super::invalid;
use crate::error::SessionError;

/// Which steps of cleaning are taken; by default none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CleanSection {
    /// Whether flipped bodies are turned back.
    pub flips: bool,
    /// Whether exchanged fingertips are exchanged back.
    pub swaps: bool,
    /// Whether spikes are taken away.
    pub spikes: bool,
    /// Whether unlabelled markers that go on where a fingertip is lost become that fingertip.
    pub stitch: bool,
    /// How gaps are filled in the recording: `none`, `linear`, `cubic`, `cluster` or `neighbours`.
    /// Processing fills what is left by its own setting.
    pub fill: String,
    /// Longest gap that is filled so, seconds.
    pub fill_limit_s: f64,
    /// New rate of the recording, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resample_hz: Option<f64>,
    /// From marker to pad by finger name, in the axes of the hand's body, millimetres.
    pub pad_mm: BTreeMap<String, [f64; 3]>,
}

impl Default for CleanSection {
    fn default() -> Self {
        Self {
            flips: false,
            swaps: false,
            spikes: false,
            stitch: false,
            fill: "none".to_owned(),
            fill_limit_s: 0.1,
            resample_hz: None,
            pad_mm: BTreeMap::new(),
        }
    }
}

impl CleanSection {
    /// The steps asked for; `None` where there is none.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`].
    pub fn steps(&self) -> Result<Option<CleanSettings>, SessionError> {
        let method = match self.fill.as_str() {
            "none" => None,
            "linear" => Some(FillMethod::Linear),
            "cubic" => Some(FillMethod::Cubic),
            "cluster" => Some(FillMethod::Cluster),
            "neighbours" => Some(FillMethod::Neighbours),
            other => {
                let words = "none, linear, cubic, cluster or neighbours";
                return Err(invalid("clean.fill", words, &other));
            }
        };
        let mut pads = PerFinger::from_fn(|_| None);
        for (name, offset_mm) in &self.pad_mm {
            let finger: Finger = (name.parse()).map_err(|_| {
                let words = "thumb, index, middle, ring or little";
                invalid("clean.pad_mm", words, name)
            })?;
            pads[finger] = Some(PadOffset::InHand {
                offset_m: offset_mm.map(|mm| mm * 1e-3),
            });
        }
        let steps = CleanSettings {
            flips: self.flips,
            swaps: self.swaps,
            spikes: self.spikes,
            stitch: self.stitch,
            fill: method.map(|method| FillSettings {
                method,
                limit_s: self.fill_limit_s,
            }),
            pads,
            resample_hz: self.resample_hz,
        };
        Ok((steps != CleanSettings::default()).then_some(steps))
    }
}
