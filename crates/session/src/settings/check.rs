//! Checks of settings, and the settings of each step.

use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// The ends of a 95 % interval of fewer draws are single ones; of more they only take time.
const DRAWS: std::ops::RangeInclusive<usize> = 100..=1_000_000;

use inhand_capture::roles::{BodyChoice, RoleSettings, is_fingertip_name};
use inhand_capture::{ReadSettings, parse_length_unit, parse_rotation_order, parse_up_axis};
use inhand_dictionary::LearnError;
use inhand_import::ImportSettings;
use inhand_model::{DictionaryKind, Finger, PerFinger, Selection, Shape};
use inhand_motion::{Filter, ProcessSettings};
use serde_json::Value;

use super::{FilterKind, LearnSection, Settings};
use crate::error::{SessionError, invalid};
use crate::methods::Method;

impl Settings {
    /// Reads a settings file.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] with the place in the file, [`SessionError::Io`].
    pub fn read(path: &Path) -> Result<Self, SessionError> {
        let text = std::fs::read_to_string(path).map_err(SessionError::io("read", path))?;
        toml::from_str(&text).map_err(|error: toml::de::Error| {
            SessionError::usage(path, error.to_string().trim_end())
        })
    }

    /// The settings as a TOML file that gives them again.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for a number that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, SessionError> {
        toml::to_string(self).map_err(|e| invalid("settings", "anything TOML can hold", &e))
    }

    /// What readers of source files need.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for a word that is no unit, order or axis.
    pub fn read_settings(&self) -> Result<ReadSettings, SessionError> {
        let source = &self.source;
        Ok(ReadSettings {
            length_unit: parsed(
                "source.units",
                &source.units,
                parse_length_unit,
                "m, cm, mm, in or ft",
            )?,
            rotation_order: parsed(
                "source.rotation_order",
                &source.rotation_order,
                parse_rotation_order,
                "quaternion or three axes such as XYZ",
            )?,
            up_axis: parsed("source.up", &source.up, parse_up_axis, "y or z")?,
        })
    }

    /// Settings of the import of third-party MCAP recordings.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for a word that says nothing about a topic, and as
    /// [`Settings::read_settings`].
    pub fn import_settings(&self) -> Result<ImportSettings, SessionError> {
        let ReadSettings {
            length_unit,
            up_axis,
            ..
        } = self.read_settings()?;
        positive("source.rate_hz", self.source.rate_hz)?;
        let parse = |(topic, text): (&String, &String)| match text.parse() {
            Ok(usage) => Ok((topic.clone(), usage)),
            Err(_) => Err(invalid(
                &format!("topics.\"{topic}\""),
                "ignore, body, marker, body:NAME or marker:NAME[,NAME...]",
                &format!("\"{text}\""),
            )),
        };
        Ok(ImportSettings {
            topics: self.topics.iter().map(parse).collect::<Result<_, _>>()?,
            length_unit,
            up_axis,
            rate_hz: self.source.rate_hz,
            is_point: is_fingertip_name,
        })
    }

    /// What the map from names to roles needs.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for an unknown finger or a malformed body.
    pub fn role_settings(&self) -> Result<RoleSettings, SessionError> {
        let mut fingers = PerFinger::<Option<String>>::default();
        for (name, marker) in &self.fingers {
            let earlier = fingers[finger(name, "fingers")?].replace(marker.clone());
            require(earlier.is_none(), "fingers", "each finger once", name)?;
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
            fingers,
            no_object,
        })
    }

    /// Which intervals of takes are used.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for a text that is no label.
    pub fn selection(&self) -> Result<Selection, SessionError> {
        let labels = |key, texts: &[String]| {
            let parse = |text: &String| {
                text.parse()
                    .map_err(|_| invalid(key, "KEY=VALUE, or a word", text))
            };
            texts.iter().map(parse).collect::<Result<Vec<_>, _>>()
        };
        Ok(Selection {
            with: labels("select.with", &self.select.with)?,
            without: labels("select.without", &self.select.without)?,
        })
    }

    /// The object's shape.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for a word that is no shape.
    pub fn shape(&self) -> Result<Option<Shape>, SessionError> {
        let parse = |text: &String| {
            text.parse()
                .map_err(|_| invalid("object.shape", Shape::EXPECTED, text))
        };
        self.object.shape.as_ref().map(parse).transpose()
    }

    /// What processing needs.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for a length of gaps below zero.
    pub fn process_settings(&self) -> Result<ProcessSettings, SessionError> {
        let section = &self.process;
        let filter = match section.filter {
            FilterKind::Median => Filter::Median {
                window: section.window,
            },
            FilterKind::SavitzkyGolay => Filter::SavitzkyGolay {
                window: section.window,
                order: section.order,
            },
            FilterKind::Butterworth => Filter::Butterworth {
                cutoff_hz: section.cutoff_hz,
                order: section.order,
            },
            FilterKind::None => Filter::None,
        };
        positive_or_zero("process.max_gap_s", section.max_gap_s)?;
        Ok(ProcessSettings {
            max_gap_s: section.max_gap_s,
            fill: section.fill,
            filter,
            object_offset_m: self.object.offset_m,
        })
    }

    /// Distance from marker to finger pad, metres.
    ///
    /// # Errors
    ///
    /// [`SessionError::Settings`] for an unknown finger.
    pub fn pad_offsets_m(&self) -> Result<PerFinger<f64>, SessionError> {
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
    /// [`SessionError::Settings`] for the first one that cannot be used.
    pub fn validate(&self) -> Result<(), SessionError> {
        self.import_settings()?;
        self.role_settings()?;
        self.selection()?;
        self.shape()?;
        self.clean.steps()?;
        self.process_settings()?;
        self.pad_offsets_m()?;
        let Settings {
            segments,
            plan,
            evaluate,
            ..
        } = self;
        self.learn.validate()?;
        let known = |entry: &&String| {
            let id = entry.split_once(':').map_or(entry.as_str(), |(id, _)| id);
            inhand_inspection::SESSION_CHECKS.contains(&id)
        };
        if let Some(id) = self.look.accept.iter().find(|id| !known(id)) {
            let ids = inhand_inspection::SESSION_CHECKS.join(", ");
            return Err(invalid("look.accept", &format!("one of {ids}"), id));
        }
        for (key, value) in [
            ("segments.margin_s", segments.margin_s),
            ("segments.ends_s", segments.ends_s),
            ("segments.missing_s", segments.missing_s),
            ("plan.velocity_factor", plan.velocity_factor),
            ("evaluate.min_contact_s", evaluate.min_contact_s),
            ("evaluate.max_lift_s", evaluate.max_lift_s),
        ] {
            positive_or_zero(key, value)?;
        }
        for (key, value) in [
            ("plan.sigma_mm", Some(plan.sigma_mm)),
            ("plan.object_sigma_mm", Some(plan.object_sigma_mm)),
            ("plan.object_sigma_deg", Some(plan.object_sigma_deg)),
            ("plan.ridge", Some(plan.ridge)),
            ("plan.velocity_m_s", plan.velocity_m_s),
            ("plan.acceleration_m_s2", plan.acceleration_m_s2),
            ("plan.separation_mm", plan.separation_mm),
            ("evaluate.tau_mm", Some(evaluate.tau_mm)),
            ("evaluate.collision_mm", Some(evaluate.collision_mm)),
        ] {
            positive(key, value)?;
        }
        let missing_s = segments.missing_s;
        let expected = "0 with learn.kind = \"pca\", which needs complete segments";
        let fits = self.learn.kind == DictionaryKind::Nmf || missing_s <= 0.0;
        require(fits, "segments.missing_s", expected, &missing_s)?;
        let margin_mm = plan.reachability_margin_mm;
        let key = "plan.reachability_margin_mm";
        require(margin_mm.is_finite(), key, "a finite number", &margin_mm)?;
        let fingers = evaluate.grasp_fingers;
        let known = (1..=Finger::COUNT).contains(&fingers);
        require(known, "evaluate.grasp_fingers", "1 to 5", &fingers)?;
        let draws = evaluate.draws;
        let usable = draws == 0 || DRAWS.contains(&draws);
        require(usable, "evaluate.draws", "0, or 100 to 1000000", &draws)?;
        for (key, share, example) in [
            ("evaluate.confidence", evaluate.confidence, "0.95"),
            ("segments.test_share", segments.test_share, "0.2"),
        ] {
            let expected = format!("a share above 0 and below 1, such as {example}");
            require(share > 0.0 && share < 1.0, key, &expected, &share)?;
        }
        let methods = &plan.methods;
        let some = !methods.is_empty();
        require(some, "plan.methods", "at least one method", &"none")?;
        let twice = |(place, method): &(usize, &Method)| methods[..*place].contains(method);
        match methods.iter().enumerate().find(twice) {
            None => Ok(()),
            Some((_, method)) => {
                let found = format!("{method} twice");
                Err(invalid("plan.methods", "each method once", &found))
            }
        }
    }

    /// The settings that a JSON object holds.
    ///
    /// # Errors
    ///
    /// What cannot be used.
    pub fn from_json(value: &Value) -> Result<Self, String> {
        // By way of TOML: one deserializer reads all settings.
        let text = toml::to_string(value).map_err(|error| error.to_string())?;
        toml::from_str(&text).map_err(|error| error.message().to_owned())
    }

    /// All settings as JSON.
    pub fn to_json(&self) -> Value {
        // Serialising plain structs of words and numbers cannot fail.
        serde_json::to_value(self).unwrap_or_default()
    }

    /// All settings as one line of JSON with sorted keys.
    pub(crate) fn json(&self) -> String {
        self.to_json().to_string()
    }

    /// Settings that affect numbers, as one line of JSON with sorted keys, for provenance.
    pub fn provenance_json(&self) -> String {
        let without_takes = Settings {
            takes: Vec::new(),
            ..self.clone()
        };
        without_takes.json()
    }
}

fn require(ok: bool, key: &str, expected: &str, found: &impl Display) -> Result<(), SessionError> {
    if ok {
        Ok(())
    } else {
        Err(invalid(key, expected, found))
    }
}

fn positive_or_zero(key: &str, value: f64) -> Result<(), SessionError> {
    let ok = value.is_finite() && value >= 0.0;
    require(ok, key, "a number not below zero", &value)
}

fn positive(key: &str, value: Option<f64>) -> Result<(), SessionError> {
    value.map_or(Ok(()), |value| {
        let ok = value.is_finite() && value > 0.0;
        require(ok, key, "a positive number", &value)
    })
}

pub(super) fn finger(name: &str, key: &str) -> Result<Finger, SessionError> {
    name.parse()
        .map_err(|_| invalid(key, "thumb, index, middle, ring or little", &name))
}

/// A setting that may be left out, as a reader of source files understands it.
fn parsed<T>(
    key: &str,
    text: &Option<String>,
    parse: fn(&str) -> Option<T>,
    expected: &str,
) -> Result<Option<T>, SessionError> {
    text.as_ref()
        .map(|text| parse(text).ok_or_else(|| invalid(key, expected, text)))
        .transpose()
}

impl LearnSection {
    fn validate(&self) -> Result<(), SessionError> {
        for (key, value) in [
            ("learn.rank", self.rank.unwrap_or(1)),
            ("learn.deviation_primitives", self.deviation_primitives),
            ("learn.deviation_segments", self.deviation_segments),
            ("learn.restarts", self.restarts),
            ("learn.sweeps", self.sweeps),
        ] {
            require(value > 0, key, "at least 1", &value)?;
        }
        for (key, value) in [
            ("learn.relative_change", self.relative_change),
            ("learn.left_out_change", self.left_out_change.unwrap_or(0.0)),
            ("learn.activation_l1", self.activation_l1),
            ("learn.activation_l2", self.activation_l2),
            ("learn.primitive_l1", self.primitive_l1),
            ("learn.primitive_l2", self.primitive_l2),
        ] {
            positive_or_zero(key, value)?;
        }
        if self.kind == DictionaryKind::Pca {
            return self.validate_pca();
        }
        crate::steps::nmf_settings_of(self)
            .check()
            .map_err(|error| match error {
                LearnError::Setting {
                    name,
                    expected,
                    found,
                } => invalid(&format!("learn.{name}"), expected, &found),
                other => SessionError::at("learning", other),
            })
    }

    /// Principal components are exact: what says how to iterate has no meaning for them.
    fn validate_pca(&self) -> Result<(), SessionError> {
        let plain = Self::default();
        let given = [
            ("learn.update", self.update != plain.update),
            ("learn.start", self.start != plain.start),
            ("learn.precision", self.precision != plain.precision),
            ("learn.restarts", self.restarts != plain.restarts),
            ("learn.stop_rms_mm", self.stop_rms_mm.is_some()),
            ("learn.activation_l1", self.activation_l1 != 0.0),
            ("learn.activation_l2", self.activation_l2 != 0.0),
            ("learn.primitive_l1", self.primitive_l1 != 0.0),
            ("learn.primitive_l2", self.primitive_l2 != 0.0),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((key, _)) => Err(invalid(
                key,
                "nothing with learn.kind = \"pca\", which is exact",
                &"a value",
            )),
        }
    }
}
