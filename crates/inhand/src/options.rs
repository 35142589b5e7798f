//! Options that several commands share.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Result;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use inhand_channels::Views;
use inhand_dictionary::{Precision, Start, Update};
use inhand_model::{DictionaryKind, Finger, Level, UnknownFinger};
use inhand_session::{EndsKind, FilterKind, GapFill, Method, ObjectInSegments, Settings};
use serde::de::value::Error as ValueError;
use serde::de::{DeserializeOwned, IntoDeserializer};

use crate::exit::UsageError;

/// Format of printed results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For reading.
    #[default]
    Text,
    /// For programs.
    Json,
}

/// Level from which on a command exits with 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum FailOn {
    /// A warning, or worse.
    Warn,
    /// A take or a setting that cannot be used as it is.
    #[default]
    Fail,
    /// Nothing.
    Never,
}

impl FailOn {
    /// Whether this is the worst level that was found, or a better one is.
    pub(crate) fn is_met(self, worst: Option<Level>) -> bool {
        match self {
            FailOn::Warn => worst >= Some(Level::Warn),
            FailOn::Fail => worst >= Some(Level::Fail),
            FailOn::Never => false,
        }
    }
}

/// Inspection of a session before anything is learned.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct LookOptions {
    /// Accept findings of this identifier, such as units, or in one take, units:TAKE; repeat for several.
    ///
    /// A finding of level fail ends the command with exit code 1 unless it is accepted.
    #[arg(long, value_name = "ID[:TAKE]", hide_short_help = true)]
    accept: Vec<String>,
    /// Exit with 3 from this level on, once everything is written; accepted findings do not count.
    #[arg(
        long,
        value_enum,
        default_value_t,
        value_name = "LEVEL",
        hide_short_help = true
    )]
    pub(crate) fail_on: FailOn,
}

impl LookOptions {
    pub(crate) fn apply(&self, settings: &mut Settings) {
        if !self.accept.is_empty() {
            settings.look.accept.clone_from(&self.accept);
        }
    }

    /// Whether entries are typed, which a settings file does not see.
    pub(crate) fn is_typed(&self) -> bool {
        !self.accept.is_empty()
    }
}

/// Refuses entries of `look.accept` for takes that there are not: they would accept nothing.
pub(crate) fn check_accepted(accept: &[String], takes: &[String]) -> Result<(), UsageError> {
    let unknown = |entry: &&String| {
        let take = entry.split_once(':').map(|(_, take)| take);
        take.is_some_and(|take| !takes.iter().any(|known| known == take))
    };
    match accept.iter().find(unknown) {
        None => Ok(()),
        Some(entry) => Err(UsageError(format!(
            "--accept {entry} (look.accept): expected a take, one of {}",
            takes.join(", ")
        ))),
    }
}

/// Facts that source files may not state, and the roles of bodies and markers.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct SourceOptions {
    /// Settings file [default: inhand.toml of the session].
    ///
    /// none: options alone, neither settings of a session nor those stored in takes.
    #[arg(long, value_name = "FILE")]
    pub(crate) settings: Option<PathBuf>,
    /// Unit of length where a file does not state it: m, cm, mm, in or ft.
    #[arg(long, value_name = "UNIT")]
    units: Option<String>,
    /// Form of rotations where a file does not state it: quaternion, or an order of Euler angles such as XYZ.
    #[arg(long, value_name = "ORDER")]
    rotation_order: Option<String>,
    /// Axis that points up where a file does not state it: y or z.
    #[arg(long, value_name = "AXIS")]
    up: Option<String>,
    /// Meaning of a topic of a third-party MCAP recording: TOPIC=body:Hand, TOPIC=marker:Thumb or
    /// TOPIC=ignore; repeat for each topic whose name does not show it.
    #[arg(long, value_name = "TOPIC=WORD", value_parser = topic)]
    topic: Vec<(String, String)>,
    /// The hand: a rigid body, or three or more markers separated by commas.
    #[arg(long, value_name = "NAME[,NAME...]")]
    hand: Option<String>,
    /// The object: a rigid body, or three or more markers; none ignores objects.
    #[arg(long, value_name = "NAME[,NAME...]")]
    object_body: Option<String>,
    /// Marker on a fingertip; repeat for each finger that is not recognised by its name.
    #[arg(long, value_name = "FINGER=MARKER", value_parser = finger_marker)]
    finger: Vec<(String, String)>,
}

/// Processing of takes.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ProcessOptions {
    /// Shape of the object, metres: cube:EDGE, box:XxYxZ, cylinder:DIAMETERxHEIGHT.
    #[arg(long, value_name = "SHAPE")]
    object: Option<String>,
    /// Offset from the tracked body's origin to the object's centre, in the body's frame, metres.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = three_numbers)]
    object_offset: Option<[f64; 3]>,
    /// Longest gap to fill, seconds [default: 0.1].
    #[arg(long, value_name = "SECONDS")]
    max_gap: Option<f64>,
    /// Method of filling gaps: cubic, linear or none [default: cubic].
    #[arg(long, value_name = "METHOD", value_parser = word::<GapFill>)]
    fill: Option<GapFill>,
    /// Filter: median, savitzky-golay, butterworth or none [default: median].
    #[arg(long, value_name = "FILTER", value_parser = word::<FilterKind>)]
    filter: Option<FilterKind>,
    /// Window of the median and Savitzky-Golay filters, samples [default: 50].
    #[arg(long, value_name = "SAMPLES")]
    window: Option<usize>,
    /// Order of the Savitzky-Golay and Butterworth filters [default: 2].
    #[arg(long, value_name = "N")]
    filter_order: Option<usize>,
    /// Cut-off of the Butterworth filter after both passes, Hz [default: 6].
    #[arg(long, value_name = "HZ")]
    cutoff: Option<f64>,
}

/// Source, selection and processing of takes.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct TakeOptions {
    #[command(flatten, next_help_heading = "Source")]
    pub(crate) source: SourceOptions,
    /// Use only the times of events with this label, such as task=rotate, or slip (short for
    /// label=slip); repeat for any of several.
    #[arg(long, help_heading = "Events", value_name = "LABEL")]
    event: Vec<String>,
    /// Leave out the times of events with this label; repeat for several.
    #[arg(long, help_heading = "Events", value_name = "LABEL")]
    without: Vec<String>,
    #[command(flatten, next_help_heading = "Processing")]
    pub(crate) process: ProcessOptions,
}

impl TakeOptions {
    /// The settings of [`SourceOptions::effective`] with all of these options on top.
    pub(crate) fn settings(&self, beside: Option<&Path>) -> Result<Settings> {
        let mut settings = self.source.effective(beside)?;
        self.apply(&mut settings);
        Ok(settings)
    }

    pub(crate) fn apply(&self, settings: &mut Settings) {
        if !self.event.is_empty() {
            settings.select.with.clone_from(&self.event);
        }
        if !self.without.is_empty() {
            settings.select.without.clone_from(&self.without);
        }
        self.process.apply(settings);
    }
}

/// Learning of a dictionary.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct LearnOptions {
    /// Kind of primitives: nmf or pca [default: nmf].
    #[arg(long, value_name = "KIND", value_parser = word::<DictionaryKind>)]
    kind: Option<DictionaryKind>,
    /// Number of primitives [default: 200, or the number of segments].
    ///
    /// With `learn`, also FROM..TO or FROM..TO:STEP: of these ranks the smallest whose prediction error on left-out
    /// takes is within one standard error of the least.
    #[arg(long, value_name = "N|FROM..TO")]
    rank: Option<RankOption>,
    /// Primitives of each finger's deviation from the cubic Hermite baseline [default: 28].
    #[arg(long, value_name = "N")]
    deviation_primitives: Option<usize>,
    /// Include the object in segments: auto (where all takes track it), yes or no [default: auto].
    #[arg(long, value_name = "WORD", value_parser = word::<ObjectInSegments>)]
    object_in_segments: Option<ObjectInSegments>,
    /// Samples between the starts of training segments; 0 for no overlap [default: 0].
    #[arg(long, value_name = "SAMPLES")]
    stride: Option<usize>,
    /// Margin without segments at both ends of an interval, seconds [default: 0.04].
    #[arg(long, value_name = "SECONDS")]
    margin: Option<f64>,
    /// Time of the lines that give boundary conditions of the held-out protocol, seconds [default: 0.08].
    #[arg(long, value_name = "SECONDS")]
    ends_s: Option<f64>,
    /// Longest missing part of a training segment between its ends, seconds [default: 0].
    #[arg(long, value_name = "SECONDS")]
    missing: Option<f64>,
    /// Largest number of segments to learn deviations from; of more, a sample is drawn [default: 4096].
    #[arg(long, value_name = "N")]
    deviation_segments: Option<usize>,
    /// Update of the factors: hals, or multiplicative for comparison with earlier work [default: hals].
    #[arg(long, value_name = "WORD", value_parser = word::<Update>)]
    update: Option<Update>,
    /// Initial primitives: random, segments, nndsvd, or online for one pass in batches [default: random].
    #[arg(long, value_name = "WORD", value_parser = word::<Start>)]
    start: Option<Start>,
    /// Seed of the random start [default: 0].
    #[arg(long)]
    seed: Option<u64>,
    /// Number of random starts; the best is kept and their similarity is reported [default: 1].
    #[arg(long, value_name = "N")]
    restarts: Option<usize>,
    /// Precision of numbers: f64 or f32 [default: f64].
    #[arg(long, value_name = "WORD", value_parser = word::<Precision>)]
    precision: Option<Precision>,
    /// Weight of the sum of activations; use with a penalty of primitives [default: 0].
    #[arg(long, value_name = "WEIGHT")]
    activation_l1: Option<f64>,
    /// Weight of half the sum of their squares [default: 0].
    #[arg(long, value_name = "WEIGHT")]
    activation_l2: Option<f64>,
    /// Weight of the sum of the primitives' numbers [default: 0].
    #[arg(long, value_name = "WEIGHT")]
    primitive_l1: Option<f64>,
    /// Weight of half the sum of their squares [default: 0].
    #[arg(long, value_name = "WEIGHT")]
    primitive_l2: Option<f64>,
    /// Largest number of iterations [default: 10].
    #[arg(long, value_name = "N")]
    max_iterations: Option<usize>,
    /// Sweeps over activations, twice those over primitives [default: 4].
    #[arg(long, value_name = "N")]
    sweeps: Option<usize>,
    /// Stop when an iteration lowers the objective by less than this fraction [default: 1e-4].
    #[arg(long, value_name = "SHARE")]
    relative_change: Option<f64>,
    /// Stop when an iteration gains less than this share on left-out takes [default: 0.1; 0 where another end is set].
    #[arg(long, value_name = "SHARE")]
    left_out_change: Option<f64>,
    /// Stop at this reconstruction error, millimetres.
    #[arg(long, value_name = "MM")]
    stop_rms_mm: Option<f64>,
}

/// Choice of methods.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct MethodOptions {
    /// Methods, separated by commas; the first is the default one.
    ///
    /// The report keeps their order. auto is the one with the lowest error on training takes left out of learning.
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',', value_parser = word::<Method>)]
    methods: Vec<Method>,
}

/// Generation of trajectories.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct PlanOptions {
    /// Standard deviation of start and goal, millimetres [default: 0.1].
    #[arg(long, value_name = "MM")]
    sigma_mm: Option<f64>,
    /// Start and goal: soft (within --sigma-mm) or hard (met exactly) [default: soft].
    #[arg(long, value_name = "WORD", value_parser = word::<EndsKind>)]
    ends: Option<EndsKind>,
    /// Ridge that makes the solution of `paper` unique, millimetres [default: 1e-4].
    #[arg(long, value_name = "WEIGHT")]
    ridge: Option<f64>,
    /// Velocity bounds as a multiple of the training extremes; 0 for none [default: 1.1].
    #[arg(long, value_name = "FACTOR")]
    velocity_factor: Option<f64>,
    /// Velocity bound of every finger and axis instead, m/s.
    #[arg(long, value_name = "M/S")]
    velocity_m_s: Option<f64>,
    /// Acceleration bound of every finger and axis, m/s².
    #[arg(long, value_name = "M/S2")]
    acceleration_m_s2: Option<f64>,
    /// Keep fingertips inside their training hulls.
    #[arg(long)]
    reachability: bool,
    /// Least distance between two fingertips, millimetres.
    #[arg(long, value_name = "MM")]
    separation_mm: Option<f64>,
    /// Keep fingers in contact at start and goal within --tau-mm of their contact points.
    #[arg(long)]
    holding: bool,
}

/// Thresholds of the evaluation.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct EvaluateOptions {
    /// Largest distance to the object that counts as contact, millimetres [default: 5].
    #[arg(long, value_name = "MM")]
    tau_mm: Option<f64>,
    /// Distance below which two fingertips collide, millimetres [default: 10].
    #[arg(long, value_name = "MM")]
    collision_mm: Option<f64>,
    /// Distance from a finger's marker to its pad, millimetres.
    #[arg(long, value_name = "FINGER=MM", value_parser = finger_mm)]
    pad_offset_mm: Vec<(String, f64)>,
    /// Shortest contact or lift that counts as a change of contact, seconds [default: 0.05].
    #[arg(long, value_name = "S")]
    min_contact_s: Option<f64>,
    /// Longest lift of a gait, seconds; after a longer one the finger has left the grasp [default: 1].
    #[arg(long, value_name = "S")]
    max_lift_s: Option<f64>,
    /// Fingers in contact that make a grasp, for phases [default: 3].
    #[arg(long, value_name = "N")]
    grasp_fingers: Option<usize>,
    /// Draws of the bootstrap for intervals; 0 for no intervals [default: 2000].
    #[arg(long, value_name = "N")]
    draws: Option<usize>,
    /// Confidence of intervals, 0 to 1 [default: 0.95].
    #[arg(long, value_name = "SHARE")]
    confidence: Option<f64>,
}

/// Values of `--views`.
const VIEWS: &[(&str, Views)] = &[
    ("default", Views::Default),
    ("all", Views::All),
    ("none", Views::None),
];

/// Writing of outputs.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct OutputOptions {
    /// Replace existing outputs that were made from other inputs.
    #[arg(long)]
    pub(crate) force: bool,
    /// Visualisation channels: default (recording, first method), all or none.
    #[arg(
        long,
        value_name = "WORD",
        hide_possible_values = true,
        default_value = "default",
        value_parser = one_of(VIEWS)
    )]
    pub(crate) views: Views,
}

/// Value of `--settings` for no settings but options.
const NO_SETTINGS: &str = "none";

impl SourceOptions {
    /// Settings from the file named by `--settings`, else the one found beside the session, else
    /// the defaults, with these options on top.
    pub(crate) fn effective(&self, beside: Option<&Path>) -> Result<Settings> {
        let file = match self.settings {
            Some(_) => self.named(),
            None => beside,
        };
        let mut settings = file.map(Settings::read).transpose()?.unwrap_or_default();
        self.apply(&mut settings);
        Ok(settings)
    }

    /// The file that is named.
    pub(crate) fn named(&self) -> Option<&Path> {
        let named = self.settings.as_deref();
        named.filter(|file| *file != Path::new(NO_SETTINGS))
    }

    pub(crate) fn apply(&self, settings: &mut Settings) {
        let source = &mut settings.source;
        replace_some(&mut source.units, &self.units);
        replace_some(&mut source.rotation_order, &self.rotation_order);
        replace_some(&mut source.up, &self.up);
        settings.topics.extend(self.topic.iter().cloned());
        replace_some(&mut settings.roles.hand, &self.hand);
        replace_some(&mut settings.roles.object, &self.object_body);
        settings.fingers.extend(self.finger.iter().cloned());
    }
}

impl ProcessOptions {
    pub(crate) fn apply(&self, settings: &mut Settings) {
        replace_some(&mut settings.object.shape, &self.object);
        replace(&mut settings.object.offset_m, self.object_offset);
        let process = &mut settings.process;
        replace(&mut process.max_gap_s, self.max_gap);
        replace(&mut process.fill, self.fill);
        replace(&mut process.filter, self.filter);
        replace(&mut process.window, self.window);
        replace(&mut process.order, self.filter_order);
        replace(&mut process.cutoff_hz, self.cutoff);
    }
}

impl LearnOptions {
    /// The ranks to choose from, where `--rank` names a range.
    pub(crate) fn ranks(&self) -> Option<&[usize]> {
        match &self.rank {
            Some(RankOption::Choose(ranks)) => Some(ranks),
            _ => None,
        }
    }

    /// Refuses a range of ranks, for commands that do not choose one.
    pub(crate) fn check_one_rank(&self) -> Result<(), UsageError> {
        let ranks = self.ranks().unwrap_or_default();
        let (Some(first), Some(last)) = (ranks.first(), ranks.last()) else {
            return Ok(());
        };
        Err(UsageError(format!(
            "--rank {first}..{last}: expected one number, such as the one that `inhand learn TAKE... \
             --rank {first}..{last} -o DICTIONARY` suggests"
        )))
    }

    pub(crate) fn apply(&self, settings: &mut Settings) {
        replace(&mut settings.segments.stride, self.stride);
        replace(&mut settings.segments.margin_s, self.margin);
        replace(&mut settings.segments.ends_s, self.ends_s);
        replace(&mut settings.segments.missing_s, self.missing);
        let learn = &mut settings.learn;
        if let Some(RankOption::One(rank)) = self.rank {
            learn.rank = Some(rank);
        }
        replace(&mut learn.kind, self.kind);
        replace(&mut learn.deviation_primitives, self.deviation_primitives);
        replace(&mut learn.object, self.object_in_segments);
        replace(&mut learn.seed, self.seed);
        replace(&mut learn.deviation_segments, self.deviation_segments);
        replace(&mut learn.update, self.update);
        replace(&mut learn.start, self.start);
        replace(&mut learn.restarts, self.restarts);
        replace(&mut learn.precision, self.precision);
        replace(&mut learn.activation_l1, self.activation_l1);
        replace(&mut learn.activation_l2, self.activation_l2);
        replace(&mut learn.primitive_l1, self.primitive_l1);
        replace(&mut learn.primitive_l2, self.primitive_l2);
        replace(&mut learn.max_iterations, self.max_iterations);
        replace(&mut learn.sweeps, self.sweeps);
        replace(&mut learn.relative_change, self.relative_change);
        replace_some(&mut learn.left_out_change, &self.left_out_change);
        replace_some(&mut learn.stop_rms_mm, &self.stop_rms_mm);
    }
}

impl MethodOptions {
    pub(crate) fn apply(&self, settings: &mut Settings) {
        if !self.methods.is_empty() {
            settings.plan.methods.clone_from(&self.methods);
        }
    }
}

impl PlanOptions {
    pub(crate) fn apply(&self, settings: &mut Settings) {
        let plan = &mut settings.plan;
        replace(&mut plan.sigma_mm, self.sigma_mm);
        replace(&mut plan.ridge, self.ridge);
        replace(&mut plan.ends, self.ends);
        replace(&mut plan.velocity_factor, self.velocity_factor);
        replace_some(&mut plan.velocity_m_s, &self.velocity_m_s);
        replace_some(&mut plan.acceleration_m_s2, &self.acceleration_m_s2);
        replace_some(&mut plan.separation_mm, &self.separation_mm);
        plan.reachability |= self.reachability;
        plan.holding |= self.holding;
    }
}

impl EvaluateOptions {
    pub(crate) fn apply(&self, settings: &mut Settings) {
        let evaluate = &mut settings.evaluate;
        replace(&mut evaluate.tau_mm, self.tau_mm);
        replace(&mut evaluate.collision_mm, self.collision_mm);
        replace(&mut evaluate.min_contact_s, self.min_contact_s);
        replace(&mut evaluate.max_lift_s, self.max_lift_s);
        replace(&mut evaluate.grasp_fingers, self.grasp_fingers);
        replace(&mut evaluate.draws, self.draws);
        replace(&mut evaluate.confidence, self.confidence);
        let offsets_mm = self.pad_offset_mm.iter().cloned();
        evaluate.pad_offset_mm.extend(offsets_mm);
    }
}

/// A parser of words that stand for values; help and errors list the words.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static>(
    values: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(values.iter().map(|&(word, _)| word)).try_map(|found| {
        let value = values.iter().find(|(word, _)| *word == found);
        value.map(|&(_, value)| value).ok_or("no such word")
    })
}

/// A word of a setting, by its name in inhand.toml.
pub(crate) fn word<T: DeserializeOwned>(text: &str) -> Result<T, ValueError> {
    T::deserialize(text.trim().into_deserializer())
}

fn replace<T>(setting: &mut T, option: Option<T>) {
    if let Some(value) = option {
        *setting = value;
    }
}

fn replace_some<T: Clone>(setting: &mut Option<T>, option: &Option<T>) {
    if option.is_some() {
        setting.clone_from(option);
    }
}

/// `KEY=VALUE` with something on both sides.
pub(crate) fn pair(text: &str) -> Result<(String, String), &'static str> {
    parts(text.split_once('='))
}

/// The same of a topic, which may itself have a `=`.
fn topic(text: &str) -> Result<(String, String), &'static str> {
    parts(text.rsplit_once('='))
}

fn parts(parts: Option<(&str, &str)>) -> Result<(String, String), &'static str> {
    let parts = parts.map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned()));
    let whole = parts.filter(|(key, value)| !key.is_empty() && !value.is_empty());
    whole.ok_or("expected a name and a value around \"=\"")
}

/// Something of a finger, with the finger's name as settings have it.
fn finger_marker(text: &str) -> Result<(String, String), String> {
    let (name, value) = pair(text)?;
    let finger: Finger = name.parse().map_err(|e: UnknownFinger| e.to_string())?;
    Ok((finger.name().to_owned(), value))
}

fn finger_mm(text: &str) -> Result<(String, f64), String> {
    let (finger, number) = finger_marker(text)?;
    let number = number.parse();
    Ok((finger, number.map_err(|_| "expected a number after \"=\"")?))
}

pub(crate) fn three_numbers(text: &str) -> Result<[f64; 3], &'static str> {
    let numbers = text.split(',').map(|n| n.trim().parse().ok());
    let finite = numbers.map(|n| n.filter(|n: &f64| n.is_finite()));
    let numbers: Option<Vec<f64>> = finite.collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or("expected three numbers, X,Y,Z")
}

/// Ranks that a range without a step is cut into, about.
const RANKS: usize = 12;
/// Most ranks of a range: a dictionary is learned for each, several times over.
const MOST_RANKS: usize = 500;

/// Value of `--rank`: a number of primitives, or a range to choose from.
#[derive(Clone, Debug, PartialEq, Eq)]
enum RankOption {
    /// This many primitives.
    One(usize),
    /// The best of these, in rising order.
    Choose(Vec<usize>),
}

impl FromStr for RankOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((from, rest)) = text.split_once("..") else {
            return Ok(Self::One(rank(text)?));
        };
        let (to, step) = match rest.split_once(':') {
            Some((to, step)) => (rank(to)?, Some(rank(step)?)),
            None => (rank(rest)?, None),
        };
        ranks(rank(from)?, to, step).map(Self::Choose)
    }
}

fn rank(text: &str) -> Result<usize, String> {
    text.trim().parse().map_err(|_| {
        format!("expected a number, FROM..TO or FROM..TO:STEP, such as 20..240, found \"{text}\"")
    })
}

/// From the first to the last rank: every `step`-th, or a dozen in even steps and the last.
fn ranks(from: usize, to: usize, step: Option<usize>) -> Result<Vec<usize>, String> {
    if from == 0 {
        return Err("a range of ranks starts at 1 at least, found 0".to_owned());
    }
    if from > to {
        return Err(format!(
            "a range of ranks rises, found {from} before {to}: did you mean {to}..{from}?"
        ));
    }
    let step_or_even = match step {
        Some(0) => return Err("the step of a range is 1 at least, found 0".to_owned()),
        Some(step) => step,
        None => (to - from).div_ceil(RANKS - 1).max(1),
    };
    if (to - from) / step_or_even >= MOST_RANKS {
        return Err(format!(
            "expected {MOST_RANKS} ranks at most, found {}: take a larger step",
            (to - from) / step_or_even + 1
        ));
    }
    let mut ranks: Vec<usize> = (from..=to).step_by(step_or_even).collect();
    if step.is_none() && ranks.last() != Some(&to) {
        ranks.push(to);
    }
    Ok(ranks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_ranges() {
        let dozen: Vec<usize> = (1..=12).map(|i| 20 * i).collect();
        for (text, expected) in [
            ("200", RankOption::One(200)),
            ("0", RankOption::One(0)),
            ("20..240", RankOption::Choose(dozen)),
            ("5..8", RankOption::Choose(vec![5, 6, 7, 8])),
            ("7..7", RankOption::Choose(vec![7])),
            ("20..100:50", RankOption::Choose(vec![20, 70])),
            ("20..120:50", RankOption::Choose(vec![20, 70, 120])),
            ("1..2:9", RankOption::Choose(vec![1])),
            (" 3 .. 4 : 1 ", RankOption::Choose(vec![3, 4])),
        ] {
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
    }

    #[test]
    fn even_steps_end_at_the_last_rank() {
        for (from, to) in [(20, 241), (1, 13), (3, 1000), (1, usize::MAX)] {
            let ranks = ranks(from, to, None).unwrap();
            assert_eq!((ranks[0], ranks[ranks.len() - 1]), (from, to));
            assert!(ranks.len() <= RANKS + 1, "{ranks:?}");
            assert!(ranks.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn ranges_that_make_no_sense() {
        for (text, word) in [
            ("240..20", "20..240"),
            ("0..20", "starts at 1"),
            ("1..20:0", "step"),
            ("1..1000000:1", "larger step"),
            ("..20", "FROM..TO"),
            ("20..", "FROM..TO"),
            ("20..40:", "FROM..TO"),
            ("-3..4", "FROM..TO"),
            ("many", "FROM..TO"),
            ("1..2..3", "FROM..TO"),
        ] {
            let error = text.parse::<RankOption>().unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
