//! `inhand overlay TAKE TAKE... -o OUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::ValueEnum;
use inhand_model::{Finger, Label};
use inhand_session::check_target;
use inhand_session::overlay::{
    Align, Overlaid, OverlaidLayer, OverlayMethods, OverlayOptions, overlay,
};
use serde_json::{Value, json};

use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};
use crate::options::{Format, SourceOptions};

/// Overlay takes or methods in one file, each in its colour
///
/// Writes motions of several takes, or of several methods of one take, into one file for viewers, on one
/// time line and each in a colour of its own, and prints how far their fingertips are from those of the
/// first.
///
/// Two takes: `inhand overlay a.mcap b.mcap -o c.mcap`. Two methods: `inhand overlay run/take.mcap
/// --methods prior,hermite -o c.mcap`. Two settings: `inhand overlay run1/take.mcap run2/take.mcap
/// --methods prior -o c.mcap`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes, the one that others are compared with first; one alone with --methods.
    #[arg(required = true, value_name = "TAKE")]
    inputs: Vec<PathBuf>,
    /// Generated motion to show beside what was recorded: methods separated by commas, or all.
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<String>,
    /// How time lines lie over each other [default: clock for one take or takes that overlap in time,
    /// start otherwise].
    #[arg(long, value_enum)]
    align: Option<AlignWord>,
    /// Put the start of the first event with this label in each take at one instant, such as
    /// task=rotate, or slip (short for label=slip).
    #[arg(long, value_name = "LABEL", conflicts_with = "align")]
    event: Option<String>,
    /// Name of a take in topics, in the order of the takes; repeat for each [default: that of its file].
    #[arg(long, value_name = "NAME")]
    name: Vec<String>,
    /// Shape of the objects, where files do not state it: cube:0.05, box:0.04x0.05x0.06 or
    /// cylinder:0.05x0.07 (metres).
    #[arg(long, value_name = "SHAPE")]
    object: Option<String>,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    /// Output file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print distances as text or JSON.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace an output that is there.
    #[arg(long)]
    force: bool,
}

/// How time lines lie over each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AlignWord {
    /// All begin where the first begins.
    Start,
    /// As their times say.
    Clock,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut settings = args.source.effective(None)?;
    if args.object.is_some() {
        settings.object.shape.clone_from(&args.object);
    }
    settings.validate()?;
    let options = OverlayOptions {
        inputs: args.inputs.clone(),
        names: args.name.clone(),
        methods: methods(&args.methods),
        align: align(args)?,
    };
    let inputs: Vec<&Path> = args.inputs.iter().map(PathBuf::as_path).collect();
    check_target(&args.output, &inputs, || args.force)?;
    let overlaid = overlay(&options, &args.output, &settings)?;
    for (file, finding) in &overlaid.findings {
        console.finding(file, finding);
    }
    for note in &overlaid.notes {
        console.say(note);
    }
    data(&match args.format {
        Format::Text => text(&overlaid),
        Format::Json => format!("{:#}\n", as_json(&overlaid)),
    })?;
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}

fn methods(given: &[String]) -> OverlayMethods {
    let names: Vec<String> = given.iter().map(|name| name.trim().to_owned()).collect();
    match &names[..] {
        [] => OverlayMethods::None,
        [all] if all == "all" => OverlayMethods::All,
        _ => OverlayMethods::Named(names),
    }
}

fn align(args: &Args) -> Result<Align> {
    let Some(label) = &args.event else {
        return Ok(match args.align {
            None => Align::Auto,
            Some(AlignWord::Start) => Align::Start,
            Some(AlignWord::Clock) => Align::Clock,
        });
    };
    let label: Label =
        (label.parse()).map_err(|error| UsageError(format!("--event {label}: {error}")))?;
    Ok(Align::Event(label))
}

fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// A table: a line for each finger of each layer but the first.
fn text(overlaid: &Overlaid) -> String {
    let width = (overlaid.layers.iter().map(|layer| layer.name.len()).max()).unwrap_or_default();
    let mut lines = String::new();
    for layer in &overlaid.layers {
        let method = layer.method.as_deref().unwrap_or("recorded");
        lines.push_str(&format!(
            "{:<width$}  {}  {method} motion of {}, {} samples at {} Hz\n",
            layer.name,
            hex(layer.colour),
            layer.file,
            layer.samples,
            (layer.rate_hz * 1e3).round() / 1e3
        ));
    }
    let Some(first) = overlaid.layers.first() else {
        return lines;
    };
    lines.push_str(&format!(
        "\ndistance to {} (mm)\n{:<width$}  {:<6} {:>8} {:>9} {:>9}\n",
        first.name, "", "finger", "n", "median", "p95"
    ));
    for layer in &overlaid.layers {
        lines.push_str(&distances(layer, width));
    }
    lines
}

fn distances(layer: &OverlaidLayer, width: usize) -> String {
    let Some(apart) = &layer.apart else {
        return String::new();
    };
    let mm = |metres: Option<f64>| metres.map_or("-".to_owned(), |m| format!("{:.3}", m * 1e3));
    (Finger::ALL.into_iter())
        .map(|finger| {
            let of = &apart[finger];
            format!(
                "{:<width$}  {:<6} {:>8} {:>9} {:>9}\n",
                layer.name,
                finger.name(),
                of.n,
                mm(of.median_m),
                mm(of.p95_m)
            )
        })
        .collect()
}

fn as_json(overlaid: &Overlaid) -> Value {
    let mm = |metres: Option<f64>| metres.map(|metres| metres * 1e3);
    let layers: Vec<Value> = (overlaid.layers.iter())
        .map(|layer| {
            let fingers = layer.apart.as_ref().map(|apart| -> Value {
                let of = |finger: Finger| {
                    let of = &apart[finger];
                    let numbers = json!({
                        "n": of.n,
                        "median_mm": mm(of.median_m),
                        "p95_mm": mm(of.p95_m),
                    });
                    (finger.name().to_owned(), numbers)
                };
                Value::Object(Finger::ALL.into_iter().map(of).collect())
            });
            json!({
                "name": layer.name,
                "file": layer.file,
                "method": layer.method,
                "colour": hex(layer.colour),
                "offset_s": layer.offset_nanos as f64 * 1e-9,
                "samples": layer.samples,
                "rate_hz": layer.rate_hz,
                "distance": fingers,
            })
        })
        .collect();
    json!({ "frame": overlaid.frame, "align": overlaid.align, "layers": layers })
}
