//! `inhand overlay TAKE TAKE... -o OUT`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_model::{Label, PerFinger};
use inhand_session::overlay::{Align, Overlaid, OverlayMethods, OverlayOptions, overlay};
use serde_json::{Value, json};

use crate::console::{Console, by_finger, print};
use crate::exit::Exit;
use crate::options::{Format, SourceOptions, one_of};
use crate::output::OutputFile;

/// Overlay takes or methods in one file, each in its colour
///
/// Writes motions of several takes, or of several methods of one take, into one file for viewers, on one
/// time line and each in a colour of its own, and prints how far their fingertips are from those of the
/// first.
///
/// Two takes: `inhand overlay a.mcap b.mcap -o c.mcap`. Two methods: `inhand overlay run/take.mcap
/// --methods residual,hermite -o c.mcap`. Two settings: `inhand overlay run1/take.mcap run2/take.mcap
/// --methods residual -o c.mcap`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes, the reference first; one take with --methods.
    #[arg(required = true, value_name = "TAKE")]
    inputs: Vec<PathBuf>,
    /// Generated motion to show beside the recording: methods separated by commas, or all.
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<String>,
    /// Alignment of times: takes start together, or by their stated times.
    ///
    /// [default: clock for one take or takes that overlap in time, start otherwise]
    #[arg(long, value_parser = one_of(&ALIGNS))]
    align: Option<ClockAlign>,
    /// Align the first event with this label in each take, such as task=rotate.
    ///
    /// The starts of the events are put at one instant. A word such as slip is short for label=slip.
    #[arg(long, value_name = "LABEL", conflicts_with = "align")]
    event: Option<Label>,
    /// Name of a take in topics [default: that of its file].
    ///
    /// Repeat for each take, in their order.
    #[arg(long, value_name = "NAME")]
    name: Vec<String>,
    /// Shape of the objects [default: as the settings or the files state it], such as cube:0.05.
    ///
    /// In metres: cube:0.05, box:0.04x0.05x0.06 or cylinder:0.05x0.07.
    #[arg(long, value_name = "SHAPE")]
    object: Option<String>,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    #[command(flatten)]
    output: OutputFile,
    /// Print distances as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Alignments without a label.
type ClockAlign = fn() -> Align;

const ALIGNS: [(&str, ClockAlign); 2] = [("start", || Align::Start), ("clock", || Align::Clock)];

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let settings = (args.source).for_each(console, &args.inputs, &|settings| {
        settings.object.shape = args.object.clone().or(settings.object.shape.take());
    })?;
    let options = OverlayOptions {
        inputs: args.inputs.clone(),
        names: args.name.clone(),
        methods: methods(&args.methods),
        align: align(args),
    };
    args.output.check_mcap(&args.inputs)?;
    let output = &args.output.output;
    let write = |path: &Path| overlay(&options, path, &settings);
    let overlaid = args.output.write(write)?;
    for (file, finding) in &overlaid.findings {
        console.finding(file, finding);
    }
    for note in &overlaid.notes {
        console.say(note);
    }
    print(args.format, || text(&overlaid), || as_json(&overlaid))?;
    console.wrote(output);
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

fn align(args: &Args) -> Align {
    match &args.event {
        Some(label) => Align::Event(label.clone()),
        None => args.align.map_or(Align::Auto, |align| align()),
    }
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
        lines += &format!(
            "{:<width$}  {}  {method} motion of {}, {} samples at {} Hz\n",
            layer.name,
            hex(layer.colour),
            layer.file,
            layer.samples,
            (layer.rate_hz * 1e3).round() / 1e3
        );
    }
    let Some(first) = overlaid.layers.first() else {
        return lines;
    };
    lines += &format!(
        "\ndistance to {} (mm)\n{:<width$}  {:<6} {:>8} {:>9} {:>9}\n",
        first.name, "", "finger", "n", "median", "p95"
    );
    let mm = |metres: Option<f64>| metres.map_or("-".to_owned(), |m| format!("{:.3}", m * 1e3));
    for layer in &overlaid.layers {
        for (finger, of) in layer.apart.iter().flat_map(PerFinger::iter) {
            lines += &format!(
                "{:<width$}  {:<6} {:>8} {:>9} {:>9}\n",
                layer.name,
                finger.name(),
                of.n,
                mm(of.median_m),
                mm(of.p95_m)
            );
        }
    }
    lines
}

fn as_json(overlaid: &Overlaid) -> Value {
    let mm = |metres: Option<f64>| metres.map(|metres| metres * 1e3);
    let layers: Vec<Value> = (overlaid.layers.iter())
        .map(|layer| {
            let fingers = layer.apart.as_ref().map(|apart| {
                by_finger(
                    apart,
                    |of| json!({ "n": of.n, "median_mm": mm(of.median_m), "p95_mm": mm(of.p95_m) }),
                )
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
