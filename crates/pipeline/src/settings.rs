//! Every setting of a session: the content of `inhand.toml`, with the defaults of the method.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use inhand_capture::roles::{BodyChoice, RoleSettings};
use inhand_capture::{ReadSettings, parse_length_unit, parse_rotation_order, parse_up_axis};
use inhand_model::{Finger, PerFinger, Shape};
use inhand_motion::{Filter, GapFill, ProcessSettings};
use serde::{Deserialize, Serialize};

use crate::error::PipelineError;
use crate::methods::Method;

/// Settings of a session, as `inhand.toml` holds them. Lengths are metres unless the name says
/// otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Name of the session; the folder's name where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Whether one file may serve for training and testing over the same stretch of time.
    pub allow_shared_takes: bool,
    /// What source files leave open.
    pub source: SourceSettings,
    /// Which tracked thing is the hand, the object.
    pub roles: BodySettings,
    /// Which marker is on which finger, by finger name.
    pub fingers: BTreeMap<String, String>,
    /// The manipulated object.
    pub object: ObjectSettings,
    /// Gaps and filter.
    pub process: ProcessSection,
    /// How takes are cut.
    pub segments: SegmentSection,
    /// The dictionary.
    pub learn: LearnSection,
    /// Generation.
    pub plan: PlanSection,
    /// Thresholds of the evaluation.
    pub evaluate: EvaluateSection,
    /// Takes with their roles; empty for a folder with `train/` and `test/`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub takes: Vec<TakeEntry>,
}

/// A take and what it is for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TakeEntry {
    /// File, relative to the session's folder.
    pub path: PathBuf,
    /// Training or testing.
    pub role: Role,
    /// First instant used, seconds after the take's first sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// End of what is used, seconds after the take's first sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_s: Option<f64>,
}

/// What a take is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// The dictionary is learned from it.
    Train,
    /// Methods are judged on it.
    Test,
}

impl Role {
    /// Lower-case name, as in files.
    pub const fn name(self) -> &'static str {
        match self {
            Role::Train => "train",
            Role::Test => "test",
        }
    }
}

/// What source files leave open.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SourceSettings {
    /// Unit of length, where a file does not state it: m, cm, mm, in or ft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<String>,
    /// `quaternion` or the order of Euler angles such as `XYZ`, where a file does not state it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_order: Option<String>,
    /// Which axis points up, where a file does not state it: y or z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<String>,
}

/// Which tracked thing is the hand, the object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BodySettings {
    /// A rigid body, or three or more marker names separated by commas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand: Option<String>,
    /// A rigid body, or three or more marker names separated by commas; `none` ignores objects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
}

/// The manipulated object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectSettings {
    /// `cube:EDGE`, `box:XxYxZ` or `cylinder:DIAMETERxHEIGHT` in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// From the tracked body's origin to the object's centre, in the body's frame.
    pub offset_m: [f64; 3],
}

/// Gaps and filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ProcessSection {
    /// Longest gap that is filled, seconds.
    pub max_gap_s: f64,
    /// `cubic`, `linear` or `none`.
    pub fill: String,
    /// `median`, `savitzky-golay`, `butterworth` or `none`.
    pub filter: String,
    /// Window of the median and Savitzky-Golay filters, samples.
    pub window: usize,
    /// Order of the Savitzky-Golay and Butterworth filters.
    pub order: usize,
    /// Cut-off of the Butterworth filter after both passes, Hz.
    pub cutoff_hz: f64,
}

impl Default for ProcessSection {
    fn default() -> Self {
        Self {
            max_gap_s: 0.1,
            fill: "cubic".into(),
            filter: "median".into(),
            window: 50,
            order: 2,
            cutoff_hz: 6.0,
        }
    }
}

/// How takes are cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SegmentSection {
    /// Samples from one training segment to the next; 0 for no overlap. Test segments never
    /// overlap.
    pub stride: usize,
    /// Seconds kept free at both ends of a stretch; end velocities are taken over them.
    pub margin_s: f64,
}

impl Default for SegmentSection {
    fn default() -> Self {
        Self {
            stride: 0,
            margin_s: 0.04,
        }
    }
}

/// The dictionary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LearnSection {
    /// Number of primitives.
    pub rank: usize,
    /// Seed of the random start.
    pub seed: u64,
    /// Most iterations.
    pub max_iterations: usize,
    /// Sweeps over each factor in an iteration.
    pub sweeps: usize,
    /// Stop when a sweep lowers the objective by less than this share of it.
    pub relative_change: f64,
    /// Stop at this reconstruction error, millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_rms_mm: Option<f64>,
}

impl Default for LearnSection {
    fn default() -> Self {
        Self {
            rank: 200,
            seed: 0,
            max_iterations: 10,
            sweeps: 3,
            relative_change: 1e-4,
            stop_rms_mm: None,
        }
    }
}

/// Generation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanSection {
    /// Methods in the order of the report; the first is the default one.
    pub methods: Vec<Method>,
    /// How exactly start and goal are met: standard deviation, millimetres.
    pub sigma_mm: f64,
    /// Ridge that makes `paper` unique, in units of millimetres.
    pub ridge: f64,
    /// Velocity bounds: training extremes times this.
    pub velocity_factor: f64,
}

impl Default for PlanSection {
    fn default() -> Self {
        Self {
            methods: Method::ALL.to_vec(),
            sigma_mm: 0.1,
            ridge: 1e-4,
            velocity_factor: 1.1,
        }
    }
}

/// Thresholds of the evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EvaluateSection {
    /// Largest distance to the object's surface that counts as contact, millimetres.
    pub tau_mm: f64,
    /// Two fingertips nearer than this collide, millimetres.
    pub collision_mm: f64,
    /// Distance from marker to finger pad by finger name, millimetres; taken off the distance.
    pub pad_offset_mm: BTreeMap<String, f64>,
}

impl Default for EvaluateSection {
    fn default() -> Self {
        Self {
            tau_mm: 5.0,
            collision_mm: 10.0,
            pad_offset_mm: BTreeMap::new(),
        }
    }
}

impl Settings {
    /// Reads a settings file.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] with the place in the file, [`PipelineError::Io`].
    pub fn read(path: &Path) -> Result<Self, PipelineError> {
        let text = std::fs::read_to_string(path).map_err(PipelineError::io("read", path))?;
        toml::from_str(&text).map_err(|error| PipelineError::SettingsFile {
            path: path.to_owned(),
            message: error.to_string().trim_end().to_owned(),
        })
    }

    /// The settings as a TOML file that gives them again.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] for a number that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, PipelineError> {
        toml::to_string(self).map_err(|e| invalid("settings", "anything TOML can hold", &e))
    }

    /// What readers of source files need.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] for a word that is no unit, order or axis.
    pub fn read_settings(&self) -> Result<ReadSettings, PipelineError> {
        let source = &self.source;
        Ok(ReadSettings {
            length_unit: parsed(
                "units",
                &source.units,
                parse_length_unit,
                "m, cm, mm, in or ft",
            )?,
            rotation_order: parsed(
                "rotation-order",
                &source.rotation_order,
                parse_rotation_order,
                "quaternion or three axes such as XYZ",
            )?,
            up_axis: parsed("up", &source.up, parse_up_axis, "y or z")?,
        })
    }

    /// What the map from names to roles needs.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] for an unknown finger or a malformed body.
    pub fn role_settings(&self) -> Result<RoleSettings, PipelineError> {
        for name in self.fingers.keys() {
            finger(name, "fingers")?;
        }
        let body = |key: &'static str, text: &Option<String>| {
            text.as_deref()
                .map(|t| BodyChoice::from_str(t).map_err(|e| invalid(key, "a body or markers", &e)))
                .transpose()
        };
        let no_object = self.roles.object.as_deref() == Some("none");
        Ok(RoleSettings {
            hand: body("roles.hand", &self.roles.hand)?,
            object: if no_object {
                None
            } else {
                body("roles.object", &self.roles.object)?
            },
            fingers: PerFinger::from_fn(|finger| self.fingers.get(finger.name()).cloned()),
            no_object,
        })
    }

    /// The object's shape.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] for a word that is no shape.
    pub fn shape(&self) -> Result<Option<Shape>, PipelineError> {
        let parse = |text: &String| {
            text.parse()
                .map_err(|e| invalid("object.shape", "a shape such as cube:0.05", &e))
        };
        self.object.shape.as_ref().map(parse).transpose()
    }

    /// What processing needs.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] for an unknown fill or filter.
    pub fn process_settings(&self) -> Result<ProcessSettings, PipelineError> {
        let section = &self.process;
        let fill = match section.fill.as_str() {
            "cubic" => GapFill::Cubic,
            "linear" => GapFill::Linear,
            "none" => GapFill::None,
            other => return Err(invalid("process.fill", "cubic, linear or none", &other)),
        };
        let filter = match section.filter.as_str() {
            "median" => Filter::Median {
                window: section.window,
            },
            "savitzky-golay" => Filter::SavitzkyGolay {
                window: section.window,
                order: section.order,
            },
            "butterworth" => Filter::Butterworth {
                cutoff_hz: section.cutoff_hz,
                order: section.order,
            },
            "none" => Filter::None,
            other => {
                let expected = "median, savitzky-golay, butterworth or none";
                return Err(invalid("process.filter", expected, &other));
            }
        };
        positive_or_zero("process.max_gap_s", section.max_gap_s)?;
        Ok(ProcessSettings {
            max_gap_s: section.max_gap_s,
            fill,
            filter,
            object_offset_m: self.object.offset_m,
        })
    }

    /// Distance from marker to finger pad, metres.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] for an unknown finger.
    pub fn pad_offsets_m(&self) -> Result<PerFinger<f64>, PipelineError> {
        let mut offsets_m = PerFinger::new([0.0; Finger::COUNT]);
        for (name, offset_mm) in &self.evaluate.pad_offset_mm {
            offsets_m[finger(name, "evaluate.pad_offset_mm")?] = offset_mm / 1000.0;
        }
        Ok(offsets_m)
    }

    /// Checks every number and word, so that a run fails before its first long step.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Settings`] for the first one that cannot be used.
    pub fn validate(&self) -> Result<(), PipelineError> {
        self.read_settings()?;
        self.role_settings()?;
        self.shape()?;
        self.process_settings()?;
        self.pad_offsets_m()?;
        positive_or_zero("segments.margin_s", self.segments.margin_s)?;
        if self.learn.sweeps == 0 {
            return Err(invalid("learn.sweeps", "at least 1", &0));
        }
        positive_or_zero("learn.relative_change", self.learn.relative_change)?;
        for (key, value) in [
            ("plan.sigma_mm", self.plan.sigma_mm),
            ("plan.ridge", self.plan.ridge),
            ("plan.velocity_factor", self.plan.velocity_factor),
            ("evaluate.tau_mm", self.evaluate.tau_mm),
            ("evaluate.collision_mm", self.evaluate.collision_mm),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(invalid(key, "a positive number", &value));
            }
        }
        if self.learn.rank == 0 {
            return Err(invalid("learn.rank", "at least 1", &0));
        }
        let twice = |method: &&Method| {
            let same = self.plan.methods.iter().filter(|other| other == method);
            same.count() > 1
        };
        if let Some(method) = self.plan.methods.iter().find(twice) {
            return Err(invalid(
                "plan.methods",
                "each method once",
                &format!("{method} twice"),
            ));
        }
        if self.plan.methods.is_empty() {
            return Err(invalid("plan.methods", "at least one method", &"none"));
        }
        Ok(())
    }

    /// Settings that a dictionary depends on, the training takes' time ranges among them.
    pub(crate) fn learning_json(&self) -> String {
        serde_json::to_value(self).map_or_else(|e| e.to_string(), |v| v.to_string())
    }

    /// Settings that affect numbers, as one line of JSON with sorted keys, for provenance.
    pub fn provenance_json(&self) -> String {
        let without_takes = Settings {
            takes: Vec::new(),
            ..self.clone()
        };
        // Serialising plain structs of strings and finite numbers cannot fail.
        serde_json::to_value(&without_takes).map_or_else(|e| e.to_string(), |v| v.to_string())
    }
}

/// An error about one setting.
pub(crate) fn invalid(key: &str, expected: &str, found: &impl std::fmt::Display) -> PipelineError {
    PipelineError::Settings {
        key: key.to_owned(),
        expected: expected.to_owned(),
        found: found.to_string(),
    }
}

fn positive_or_zero(key: &str, value: f64) -> Result<(), PipelineError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(invalid(key, "a number not below zero", &value))
    }
}

fn finger(name: &str, key: &str) -> Result<Finger, PipelineError> {
    name.parse()
        .map_err(|_| invalid(key, "thumb, index, middle, ring or little", &name))
}

/// A setting that may be left out, as a reader of source files understands it.
fn parsed<T>(
    key: &str,
    text: &Option<String>,
    parse: fn(&str) -> Option<T>,
    expected: &str,
) -> Result<Option<T>, PipelineError> {
    text.as_ref()
        .map(|text| parse(text).ok_or_else(|| invalid(key, expected, text)))
        .transpose()
}
