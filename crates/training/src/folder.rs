//! Names in a learning folder, and what all of its files belong to.

use std::path::{Path, PathBuf};

use inhand_dictionary::NmfProblem;
use inhand_model::{Demonstrated, Hull, InputHash, PerFinger, SegmentLayout, VelocityBounds};
use inhand_session::{SessionError, Settings, TOOL, hex_sha256, steps, write_text};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::arrays::{self, Arrays, Label};

/// Version of the folder's form.
const FORMAT: u32 = 1;

/// What a run of learning is: the content of `learning.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearningPlan {
    /// Version of the folder's form.
    pub format: u32,
    /// Tool and version that made it.
    pub tool: String,
    /// Samples per second of every take.
    pub rate_hz: f64,
    /// Samples of a segment.
    pub samples: usize,
    /// Whether segments carry the object.
    pub object: bool,
    /// Training segments.
    pub segments: usize,
    /// Segments that the takes would have given without gaps in addition.
    pub left_out: usize,
    /// Blocks of segments, the unit of shards.
    pub blocks: usize,
    /// Training takes in order.
    pub takes: Vec<PlannedTake>,
    /// Effective settings.
    pub settings: Settings,
}

/// A take of the run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedTake {
    /// Name of its file.
    pub name: String,
    /// SHA-256 of its file.
    pub sha256: String,
    /// Samples.
    pub samples: usize,
    /// Training segments in it.
    pub segments: usize,
}

impl LearningPlan {
    /// Shape of the segments.
    pub const fn layout(&self) -> SegmentLayout {
        SegmentLayout {
            samples: self.samples,
            rate_hz: self.rate_hz,
            object: self.object,
        }
    }

    /// The takes as inputs of a step.
    pub fn inputs(&self) -> impl Iterator<Item = InputHash> {
        self.takes.iter().map(|take| InputHash {
            name: take.name.clone(),
            sha256: take.sha256.clone(),
        })
    }

    fn json(&self) -> String {
        serde_json::to_string_pretty(self).map_or_else(|e| e.to_string(), |text| text + "\n")
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
        let plan: LearningPlan = serde_json::from_str(&text)
            .map_err(|error| wrong(format!("not the plan of a run: {error}")))?;
        if plan.format != FORMAT || plan.tool != TOOL {
            return Err(wrong(format!(
                "the run was begun by {} (form {}), this is {} (form {FORMAT}): go on with the \
                 version that began it, or begin again",
                plan.tool, plan.format, TOOL
            )));
        }
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
        if let Some(key) = first_difference(&self.plan.settings, settings) {
            return Err(wrong(&format!("another value of setting {key}")));
        }
        if self.plan.takes.len() != takes.len() {
            let found = self.plan.takes.len();
            return Err(wrong(&format!("{found} takes, not {}", takes.len())));
        }
        for (planned, path) in self.plan.takes.iter().zip(takes) {
            let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
            if hex_sha256(&bytes) != planned.sha256 {
                return Err(wrong(&format!(
                    "another take in the place of {} ({})",
                    path.display(),
                    planned.name
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

    pub(crate) const fn new_format() -> u32 {
        FORMAT
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What the run is.
    pub const fn plan(&self) -> &LearningPlan {
        &self.plan
    }

    /// SHA-256 of `learning.json`.
    pub fn id(&self) -> &str {
        &self.id
    }

    pub(crate) fn table(&self, take: usize) -> PathBuf {
        table_path(&self.root, take)
    }

    fn problem(&self) -> PathBuf {
        self.root.join("problem.bin")
    }

    pub(crate) fn start(&self, start: usize) -> PathBuf {
        self.root.join(format!("start-{start:03}"))
    }

    pub(crate) fn round(&self, start: usize, round: usize) -> PathBuf {
        self.start(start).join(format!("round-{round:05}"))
    }

    pub(crate) fn state(&self, start: usize, round: usize) -> PathBuf {
        self.round(start, round).join("state.bin")
    }

    pub(crate) fn activations(&self, start: usize, round: usize, block: usize) -> PathBuf {
        let folder = self.round(start, round).join("activations");
        folder.join(format!("{block:08}.bin"))
    }

    pub(crate) fn label(&self, kind: &'static str, start: usize, round: usize) -> Label {
        Label {
            kind,
            id: self.id.clone(),
            start,
            round,
        }
    }

    pub(crate) fn wrong(path: &Path) -> impl Fn(String) -> SessionError {
        let path = path.to_owned();
        move |message| SessionError::data(&path, message)
    }

    /// Writes what does not change from round to round.
    pub(crate) fn write_problem(
        &self,
        problem: &NmfProblem,
        demonstrated: &Demonstrated,
    ) -> Result<(), SessionError> {
        let mut arrays = Arrays::default();
        arrays.push_u64("numbers", [problem.numbers]);
        arrays.push_f64("offset_m", problem.offset_m.clone());
        arrays.push_f64("velocity_min_m_s", demonstrated.velocity.min_m_s.to_vec());
        arrays.push_f64("velocity_max_m_s", demonstrated.velocity.max_m_s.to_vec());
        for (finger, hull) in demonstrated.hulls.iter() {
            let name = |part: &str| format!("{finger}.{part}");
            arrays.push_f64(&name("vertices_m"), hull.vertices_m.concat());
            let triangles = hull.triangles.as_flattened().iter().map(|&v| v as usize);
            arrays.push_u64(&name("triangles"), triangles);
            arrays.push_f64(&name("normals"), hull.normals.concat());
            arrays.push_f64(&name("offsets_m"), hull.offsets_m.clone());
        }
        arrays::write(&self.problem(), &self.label("problem", 0, 0), &arrays)
    }

    /// What does not change from round to round, with the seed of a start.
    ///
    /// # Errors
    ///
    /// [`SessionError::Data`].
    pub(crate) fn read_problem(
        &self,
        start: usize,
    ) -> Result<(NmfProblem, Demonstrated), SessionError> {
        let path = self.problem();
        let mut arrays = arrays::read(&path, &self.label("problem", 0, 0))?;
        let mut settings = steps::nmf_settings(self.plan.segments, &self.plan.settings);
        settings.seed = settings.seed.wrapping_add(start as u64);
        let parse = || {
            let numbers = arrays.take_u64("numbers")?;
            let problem = NmfProblem {
                layout: self.plan.layout(),
                count: self.plan.segments,
                numbers: *numbers.first().ok_or("there are no `numbers`")?,
                offset_m: arrays.take_f64("offset_m")?,
                settings,
            };
            let mut bounds = |name: &str| {
                (arrays.take_f64(name)?.try_into())
                    .map_err(|_| format!("`{name}` has a wrong size"))
            };
            let velocity = VelocityBounds {
                min_m_s: bounds("velocity_min_m_s")?,
                max_m_s: bounds("velocity_max_m_s")?,
            };
            let hulls = PerFinger::try_from_fn(|finger| {
                let name = |part: &str| format!("{finger}.{part}");
                let triangles = arrays.take_u64(&name("triangles"))?;
                let triangles: Vec<u32> = triangles.into_iter().map(|v| v as u32).collect();
                Ok::<_, String>(Hull {
                    vertices_m: arrays.take_f64(&name("vertices_m"))?.as_chunks().0.to_vec(),
                    triangles: triangles.as_chunks().0.to_vec(),
                    normals: arrays.take_f64(&name("normals"))?.as_chunks().0.to_vec(),
                    offsets_m: arrays.take_f64(&name("offsets_m"))?,
                })
            })?;
            Ok((problem, Demonstrated { hulls, velocity }))
        };
        parse().map_err(Self::wrong(&path))
    }
}

/// Name of the first setting that differs.
fn first_difference(a: &Settings, b: &Settings) -> Option<String> {
    fn walk(a: &Value, b: &Value, key: &str) -> Option<String> {
        if a == b {
            return None;
        }
        let (Value::Object(of_a), Value::Object(of_b)) = (a, b) else {
            return Some(key.to_owned());
        };
        let names = of_a.keys().chain(of_b.keys());
        names.into_iter().find_map(|name| {
            let of = |map: &serde_json::Map<String, Value>| map.get(name).cloned();
            let [a, b] = [of(of_a), of(of_b)].map(Option::unwrap_or_default);
            let dot = if key.is_empty() { "" } else { "." };
            walk(&a, &b, &format!("{key}{dot}{name}"))
        })
    }
    let value = |settings| serde_json::to_value(settings).unwrap_or_default();
    walk(&value(a), &value(b), "")
}

fn plan_path(root: &Path) -> PathBuf {
    root.join("learning.json")
}

pub(crate) fn table_path(root: &Path, take: usize) -> PathBuf {
    root.join("takes").join(format!("{take:05}.table"))
}
