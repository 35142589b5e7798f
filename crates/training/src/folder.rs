//! Names and files of a learning folder, and the plan that they belong to.

use std::path::{Path, PathBuf};

use inhand_dictionary::{Activations, NmfProblem, NmfState};
use inhand_model::{Demonstrated, Finger, InputHash, PerFinger, Protocol, SegmentLayout};
use inhand_session::{SessionError, Settings, TOOL, hash_take, hex_sha256, write_text};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::file::{self, Label};

/// Label of the problem's file, which belongs to no round.
const PROBLEM: (&str, usize, usize) = ("problem", 0, 0);

/// Version of the folder's form.
pub(crate) const FORMAT: u32 = 5;

/// Plan of a run of learning: the content of `learning.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearningPlan {
    /// Version of the folder's form.
    pub format: u32,
    /// Tool and version that made it.
    pub tool: String,
    /// Shape of the segments.
    pub layout: SegmentLayout,
    /// Training segments.
    pub segments: usize,
    /// Segments that the takes would have given without gaps in addition.
    pub left_out: usize,
    /// Blocks of segments, the unit of shards.
    pub blocks: usize,
    /// Training takes in order.
    pub takes: Vec<PlannedTake>,
    /// Effective settings.
    #[serde(with = "settings_json")]
    pub settings: Settings,
}

/// A take of the run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedTake {
    /// Its file.
    pub file: InputHash,
    /// Samples.
    pub samples: usize,
    /// Training segments in it.
    pub segments: usize,
    /// Segments of the held-out protocol in it.
    pub held_out_segments: usize,
}

impl PlannedTake {
    /// Segments in it under a protocol.
    pub(crate) const fn segments(&self, protocol: Protocol) -> usize {
        match protocol {
            Protocol::Published => self.segments,
            Protocol::HeldOut => self.held_out_segments,
        }
    }
}

impl LearningPlan {
    fn json(&self) -> String {
        serde_json::to_string_pretty(self).map_or_else(|e| e.to_string(), |text| text + "\n")
    }
}

/// Settings as their own crate writes and reads them.
mod settings_json {
    use super::{Deserialize, Serialize, Settings, Value};

    pub(super) fn serialize<S: serde::Serializer>(
        settings: &Settings,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        settings.to_json().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: serde::Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Settings, D::Error> {
        Settings::from_json(&Value::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

/// A folder that a run of learning lives in.
#[derive(Clone, Debug)]
pub struct LearningFolder {
    root: PathBuf,
    id: String,
    plan: LearningPlan,
}

impl LearningFolder {
    /// The folder of a run that was begun.
    ///
    /// # Errors
    ///
    /// [`SessionError::Data`] where there is none or it cannot be used.
    pub fn open(root: &Path) -> Result<Self, SessionError> {
        let path = plan_path(root);
        let wrong = |message: String| SessionError::data(&path, message);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(wrong(
                    "there is none: begin a run with `inhand learn init TAKES... -o FOLDER`"
                        .to_owned(),
                ));
            }
            Err(error) => return Err(SessionError::io("read", &path)(error)),
        };
        let not_a_plan = |error: String| wrong(format!("not the plan of a run: {error}"));
        let json: Value =
            serde_json::from_str(&text).map_err(|error| not_a_plan(error.to_string()))?;
        // The rest of another version's plan may be anything.
        let (Some(format), Some(tool)) = (json["format"].as_u64(), json["tool"].as_str()) else {
            return Err(not_a_plan("it names no format and tool".to_owned()));
        };
        if format != u64::from(FORMAT) || tool != TOOL {
            return Err(wrong(format!(
                "the run was begun by {tool} (form {format}), this is {TOOL} (form {FORMAT}): begin \
                 again in another folder"
            )));
        }
        let plan: LearningPlan =
            serde_json::from_value(json).map_err(|error| not_a_plan(error.to_string()))?;
        plan.settings.validate()?;
        Ok(Self {
            root: root.to_owned(),
            id: hex_sha256(text.as_bytes()),
            plan,
        })
    }

    /// Checks that the run is of these takes and settings.
    ///
    /// # Errors
    ///
    /// [`SessionError::Data`] with what is different, [`SessionError::Io`].
    pub fn check_same(&self, takes: &[PathBuf], settings: &Settings) -> Result<(), SessionError> {
        let wrong = |what: &str| {
            SessionError::data(
                plan_path(&self.root),
                format!(
                    "the run was begun with {what}: remove the folder to begin again, or name another"
                ),
            )
        };
        let [begun, now] = [&self.plan.settings, settings].map(Settings::to_json);
        if let Some(key) = first_difference(&begun, &now, "") {
            return Err(wrong(&format!("another value of setting {key}")));
        }
        if self.plan.takes.len() != takes.len() {
            let found = self.plan.takes.len();
            return Err(wrong(&format!("{found} takes, not {}", takes.len())));
        }
        for (planned, path) in self.plan.takes.iter().zip(takes) {
            if hash_take(path)?.sha256 != planned.file.sha256 {
                return Err(wrong(&format!(
                    "another take in the place of {} ({})",
                    path.display(),
                    planned.file.name
                )));
            }
        }
        Ok(())
    }

    /// Whether a run was begun here.
    pub fn exists(root: &Path) -> bool {
        plan_path(root).is_file()
    }

    /// Begins a run; `learning.json` is written last, by [`commit`](Self::commit).
    pub(crate) fn begin(root: &Path, plan: LearningPlan) -> Self {
        Self {
            root: root.to_owned(),
            id: hex_sha256(plan.json().as_bytes()),
            plan,
        }
    }

    pub(crate) fn commit(&self) -> Result<(), SessionError> {
        write_text(&plan_path(&self.root), &self.plan.json())
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Plan of the run.
    pub const fn plan(&self) -> &LearningPlan {
        &self.plan
    }

    /// SHA-256 of `learning.json`.
    pub fn id(&self) -> &str {
        &self.id
    }

    pub(crate) fn table(&self, take: usize, protocol: Protocol) -> PathBuf {
        table_path(&self.root, take, protocol)
    }

    fn start(&self, start: usize) -> PathBuf {
        self.root.join(format!("start-{start:03}"))
    }

    pub(crate) fn round(&self, start: usize, round: usize) -> PathBuf {
        self.start(start).join(format!("round-{round:05}"))
    }

    fn state_path(&self, start: usize, round: usize) -> PathBuf {
        self.round(start, round).join("state.bin")
    }

    /// Rounds of a start that have a folder.
    pub(crate) fn rounds(&self, start: usize) -> impl Iterator<Item = usize> {
        let entries = std::fs::read_dir(self.start(start));
        (entries.into_iter().flatten().flatten()).filter_map(|entry| {
            let name = entry.file_name();
            name.to_str()?.strip_prefix("round-")?.parse().ok()
        })
    }

    /// The latest round of a start; `None` for a start that was not begun.
    pub(crate) fn latest_round(&self, start: usize) -> Option<usize> {
        self.rounds(start)
            .filter(|&round| self.state_path(start, round).is_file())
            .max()
    }

    fn label(&self, (kind, start, round): (&str, usize, usize)) -> Label {
        Label {
            kind: kind.to_owned(),
            id: self.id.clone(),
            start,
            round,
        }
    }

    /// Writes a file of this run: its kind, start and round are part of it.
    pub(crate) fn write(
        &self,
        path: &Path,
        label: (&str, usize, usize),
        value: &impl Serialize,
    ) -> Result<(), SessionError> {
        file::write(path, &self.label(label), value, true)
    }

    /// Reads a file of this run, which has to be of this kind, start and round.
    pub(crate) fn read<T: DeserializeOwned>(
        &self,
        path: &Path,
        label: (&str, usize, usize),
    ) -> Result<T, SessionError> {
        file::read(path, &self.label(label))
    }

    /// Writes what does not change from round to round.
    pub(crate) fn write_problem(
        &self,
        problem: &NmfProblem,
        demonstrated: &Demonstrated,
    ) -> Result<(), SessionError> {
        let hulls = Finger::ALL.map(|finger| &demonstrated.hulls[finger]);
        let content = (problem, hulls, demonstrated.velocity);
        self.write(&self.root.join("problem.bin"), PROBLEM, &content)
    }

    /// Reads what does not change from round to round.
    pub(crate) fn problem(&self) -> Result<(NmfProblem, Demonstrated), SessionError> {
        let (problem, hulls, velocity) = self.read(&self.root.join("problem.bin"), PROBLEM)?;
        let hulls = PerFinger::new(hulls);
        Ok((problem, Demonstrated { hulls, velocity }))
    }

    pub(crate) fn write_state(&self, start: usize, state: &NmfState) -> Result<(), SessionError> {
        let path = self.state_path(start, state.round);
        self.write(&path, ("state", start, state.round), state)
    }

    /// The state of the latest round of a start.
    pub(crate) fn state(
        &self,
        problem: &NmfProblem,
        start: usize,
    ) -> Result<NmfState, SessionError> {
        let round = self.latest_round(start).unwrap_or(0);
        let path = self.state_path(start, round);
        let state: NmfState = self.read(&path, ("state", start, round))?;
        let rank = problem.settings.rank;
        if state.primitives.len() != rank * problem.layout.rows()
            || state.revived.iter().any(|&j| j >= rank)
        {
            let found = state.primitives.len();
            let message = format!("{found} numbers are not those of {rank} primitives");
            return Err(SessionError::data(path, message));
        }
        Ok(state)
    }

    pub(crate) fn activations_path(&self, start: usize, round: usize, block: usize) -> PathBuf {
        let folder = self.round(start, round).join("activations");
        folder.join(format!("{block:08}.bin"))
    }

    pub(crate) fn write_activations(
        &self,
        start: usize,
        round: usize,
        block: usize,
        activations: &Activations,
    ) -> Result<(), SessionError> {
        let path = self.activations_path(start, round, block);
        self.write(&path, ("activations", start, round), activations)
    }

    /// The activations that a block had last: those of the round before, except after the round in which
    /// learning stopped.
    pub(crate) fn activations(
        &self,
        start: usize,
        state: &NmfState,
        block: usize,
    ) -> Result<Activations, SessionError> {
        let round = match state.stop {
            Some(_) => state.round,
            None => state.round.saturating_sub(1),
        };
        let path = self.activations_path(start, round, block);
        self.read(&path, ("activations", start, round))
    }
}

/// Name of the first setting that differs.
fn first_difference(a: &Value, b: &Value, key: &str) -> Option<String> {
    let (Value::Object(in_a), Value::Object(in_b)) = (a, b) else {
        return (a != b).then(|| key.to_owned());
    };
    in_a.keys().chain(in_b.keys()).find_map(|name| {
        let dot = if key.is_empty() { "" } else { "." };
        first_difference(&a[name], &b[name], &format!("{key}{dot}{name}"))
    })
}

fn plan_path(root: &Path) -> PathBuf {
    root.join("learning.json")
}

pub(crate) fn table_path(root: &Path, take: usize, protocol: Protocol) -> PathBuf {
    let kind = match protocol {
        Protocol::Published => "",
        Protocol::HeldOut => ".unfiltered",
    };
    root.join("takes").join(format!("{take:05}{kind}.table"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_an_earlier_form_is_refused_with_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = plan_path(folder.path());
        // Everything else of such a plan may be different.
        std::fs::write(
            &path,
            r#"{"format": 1, "tool": "inhand 0.0.9", "shape": []}"#,
        )
        .unwrap();
        let message = LearningFolder::open(folder.path()).unwrap_err().to_string();
        let expected = format!(
            "{}: the run was begun by inhand 0.0.9 (form 1), this is {TOOL} (form {FORMAT}): begin again \
             in another folder",
            path.display()
        );
        assert_eq!(message, expected);
    }

    #[test]
    fn a_plan_is_read_as_it_was_written() {
        let mut plan = LearningPlan {
            format: FORMAT,
            tool: TOOL.to_owned(),
            layout: SegmentLayout::one_second(100.0),
            segments: 2,
            left_out: 0,
            blocks: 1,
            takes: Vec::new(),
            settings: Settings::default(),
        };
        // No short decimal fraction.
        plan.settings.plan.velocity_m_s = Some(0.1 + 0.2);
        plan.settings.participant = Some("a\n\"b\"".to_owned());
        let read: LearningPlan = serde_json::from_str(&plan.json()).unwrap();
        assert_eq!(read, plan);
    }
}
