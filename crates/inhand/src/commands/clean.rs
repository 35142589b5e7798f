//! `inhand clean TAKE... [-o OUTPUT]`.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::{Context, Result};
use inhand_inspection::{FillMethod, SuspectKind, detect};
use inhand_model::{Change, ChangeKind, Clock, Finger};
use inhand_session::{CleanSection, Settings, Take, clean_take, provenance, write_cleaned};
use serde::Serialize;
use serde_json::json;

use crate::commands::{file_part, files_task, read_take, targets};
use crate::console::{Console, print};
use crate::exit::{Exit, usage};
use crate::options::{Format, OutputOptions, SourceOptions, one_of, three_numbers};
use crate::output::{check_outputs, write_output};

/// List suspect samples in takes; with steps and -o, repair them and write cleaned takes.
///
/// Suspect samples are swapped fingertips, flipped bodies, spikes, and fingertips lost among unlabelled markers.
/// The measured data stays in cleaned takes beside the cleaned recording, and every change is listed.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Output file; a folder for several inputs.
    ///
    /// Without steps nothing is written.
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Steps, in this order")]
    steps: StepOptions,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    writing: OutputOptions,
}

/// The steps of cleaning.
#[derive(Clone, Debug, Default, clap::Args)]
struct StepOptions {
    /// Turn flipped bodies back.
    #[arg(long)]
    flips: bool,
    /// Exchange swapped fingertips back.
    #[arg(long)]
    swaps: bool,
    /// Remove spikes.
    #[arg(long)]
    spikes: bool,
    /// Assign unlabelled intervals to their fingertips.
    #[arg(long)]
    stitch: bool,
    /// All four repairs.
    #[arg(long)]
    repair: bool,
    /// Fill gaps.
    ///
    /// linear is a straight line, cubic continues the motion on both sides, cluster uses the other markers of the
    /// same rigid cluster, neighbours the other fingertips.
    #[arg(long, value_parser = one_of(&FILLS), value_name = "METHOD")]
    fill: Option<FillMethod>,
    /// Longest gap to fill, seconds [default: 0.1].
    #[arg(long, value_name = "SECONDS", requires = "fill")]
    fill_limit: Option<f64>,
    /// Move a fingertip from its marker to its pad, millimetres.
    ///
    /// In the axes of the hand's body; repeat for each finger.
    #[arg(long, value_name = "FINGER=X,Y,Z", allow_hyphen_values = true, value_parser = pad)]
    pad_mm: Vec<(Finger, [f64; 3])>,
    /// Resample to this rate, after a low-pass filter.
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
    resample: Option<f64>,
}

const FILLS: [(&str, FillMethod); 4] = [
    ("linear", FillMethod::Linear),
    ("cubic", FillMethod::Cubic),
    ("cluster", FillMethod::Cluster),
    ("neighbours", FillMethod::Neighbours),
];

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut asked = CleanSection::default();
    args.steps.apply(&mut asked);
    let typed = |settings: &mut Settings| args.steps.apply(&mut settings.clean);
    let settings = args.source.for_each(console, &args.inputs, &typed)?;
    let steps = settings.iter().map(|settings| settings.clean.steps());
    let steps = steps.collect::<Result<Option<Vec<_>>, _>>()?;
    // Takes are read as measured; the steps follow here.
    let as_measured = |(path, settings): (&PathBuf, &Settings)| {
        let settings = Settings {
            clean: CleanSection::default(),
            ..settings.clone()
        };
        read_take(console, path, &settings)
    };
    let takes = args.inputs.iter().zip(&settings).map(as_measured);
    let only_look = args.output.is_none() && asked == CleanSection::default();
    let Some(steps) = steps.filter(|_| !only_look) else {
        if args.output.is_some() {
            return usage(
                "-o writes cleaned takes: say which steps to take, such as --repair or \
                           --swaps --fill cubic",
            );
        }
        let files: Vec<_> = takes
            .map(|take| suggestions(&take?))
            .collect::<Result<_>>()?;
        let text = || files.iter().map(CleanOutcome::text).collect();
        print(args.format, text, || json!({ "files": files }))?;
        return Ok(Exit::Done);
    };
    let Some(output) = &args.output else {
        return usage(
            "steps change takes: name the output with -o, or leave the steps out to list \
                       suspect samples",
        );
    };
    let targets = targets(&args.inputs, output, &["mcap"])?;
    check_outputs(&targets, &args.inputs)?;
    let takes = takes.collect::<Result<Vec<_>>>()?;
    for take in &takes {
        take.roles()?;
    }
    let mut files = Vec::with_capacity(takes.len());
    let task = files_task(console, "cleaning", &args.inputs, 1.0);
    for (((take, target), settings), steps) in takes.iter().zip(&targets).zip(&settings).zip(&steps)
    {
        file_part(&task, &take.path, 1.0);
        let cleaned = clean_take(take, steps)?;
        let made = provenance("clean", settings, [take.hash.clone()]);
        let shape = settings.shape()?;
        write_output(target, args.writing.force, |path| {
            write_cleaned(path, take, &cleaned, &made, shape, args.writing.views)
        })?;
        console.wrote_with(target, &counted(&cleaned.changes));
        let clock = take.measured().clock;
        let changes = cleaned.changes.iter();
        let change =
            |c: &Change| CleanInterval::new(&c.samples, clock, c.kind.name(), c.to_string());
        files.push(CleanOutcome {
            input: take.path.display().to_string(),
            output: Some(target.display().to_string()),
            suspects: Vec::new(),
            changes: changes.map(change).collect(),
        });
    }
    let text = || files.iter().map(CleanOutcome::text).collect();
    print(args.format, text, || json!({ "files": files }))?;
    Ok(Exit::Done)
}

impl StepOptions {
    fn apply(&self, clean: &mut CleanSection) {
        clean.flips |= self.flips || self.repair;
        clean.swaps |= self.swaps || self.repair;
        clean.spikes |= self.spikes || self.repair;
        clean.stitch |= self.stitch || self.repair;
        clean.fill = self.fill.unwrap_or(clean.fill);
        clean.fill_limit_s = self.fill_limit.unwrap_or(clean.fill_limit_s);
        clean.resample_hz = self.resample.or(clean.resample_hz);
        let pad_mm = self.pad_mm.iter();
        let pad_mm = pad_mm.map(|&(finger, offset_mm)| (finger.name().to_owned(), offset_mm));
        clean.pad_mm.extend(pad_mm);
    }
}

fn pad(text: &str) -> Result<(Finger, [f64; 3]), &'static str> {
    let parsed = text.split_once('=').and_then(|(finger, numbers)| {
        Some((finger.trim().parse().ok()?, three_numbers(numbers).ok()?))
    });
    parsed.ok_or("expected FINGER=X,Y,Z, such as index=0,0,8")
}

/// Suspect samples of a take, or what was changed in it.
#[derive(Debug, Serialize)]
struct CleanOutcome {
    input: String,
    output: Option<String>,
    suspects: Vec<CleanInterval>,
    changes: Vec<CleanInterval>,
}

/// Samples that are suspect or were changed: from the first to the end of the last, after the take's start.
#[derive(Debug, Serialize)]
struct CleanInterval {
    from_s: f64,
    to_s: f64,
    /// The step that repairs suspect samples, or the kind of a change.
    kind: &'static str,
    found: String,
}

impl CleanInterval {
    fn new(samples: &Range<usize>, clock: Clock, kind: &'static str, found: String) -> Self {
        let (from_s, to_s) = (clock.time_s(samples.start), clock.time_s(samples.end));
        Self {
            from_s,
            to_s,
            kind,
            found,
        }
    }
}

/// Suspect samples of a take in order of time, with the steps that would repair them.
fn suggestions(take: &Take) -> Result<CleanOutcome> {
    let recording = &take.recording;
    let suspects = detect::all(recording, take.roles.as_ref().ok())
        .with_context(|| take.path.display().to_string())?;
    let step = |kind: &SuspectKind| match kind {
        SuspectKind::Flip { .. } => "flips",
        SuspectKind::Swap { .. } => "swaps",
        SuspectKind::Spike { .. } => "spikes",
        SuspectKind::Unlabelled { .. } => "stitch",
    };
    let mut lines: Vec<_> = (suspects.iter())
        .map(|suspect| (&suspect.samples, step(&suspect.kind), suspect.to_string()))
        .collect();
    lines.sort_by(|a, b| (a.0.start, a.1, &a.2).cmp(&(b.0.start, b.1, &b.2)));
    let interval =
        |(samples, step, found)| CleanInterval::new(samples, recording.clock, step, found);
    Ok(CleanOutcome {
        input: take.path.display().to_string(),
        output: None,
        suspects: lines.into_iter().map(interval).collect(),
        changes: Vec::new(),
    })
}

impl CleanOutcome {
    fn text(&self) -> String {
        let when = |i: &CleanInterval| format!("{:9.3} .. {:9.3} s", i.from_s, i.to_s);
        let count = |step: &str| self.suspects.iter().filter(|i| i.kind == step).count();
        let mut text = String::new();
        if self.output.is_none() {
            text = format!(
                "{}: {} swaps, {} flips, {} spikes, {} lost fingertips\n",
                self.input,
                count("swaps"),
                count("flips"),
                count("spikes"),
                count("stitch")
            );
        }
        for suspect in &self.suspects {
            let step = format!("--{}", suspect.kind);
            text += &format!("{}  {step:<8}  {}\n", when(suspect), suspect.found);
        }
        for change in &self.changes {
            text += &format!("{}  {}\n", when(change), change.found);
        }
        if !self.suspects.is_empty() {
            let take = &self.input;
            text += &format!("to repair them: inhand clean {take} --repair -o CLEANED.mcap\n");
        }
        text
    }
}

fn counted(changes: &[Change]) -> String {
    let counts: Vec<String> = (ChangeKind::ALL.into_iter())
        .filter_map(|kind| {
            let count = changes.iter().filter(|change| change.kind == kind).count();
            (count > 0).then(|| format!("{count} {}", kind.name().replace('_', " ")))
        })
        .collect();
    match counts.is_empty() {
        true => "nothing to change was found".to_owned(),
        false => counts.join(", "),
    }
}
