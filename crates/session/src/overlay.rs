//! Overlays: several takes or methods on one time line, in one file.

mod input;
mod layers;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use inhand_channels::{OverlayFile, OverlayLayer, OverlayObject, Rgb, layer_colour};
use inhand_evaluation::overlay::{Apart, Tips, apart, distances_m};
use inhand_model::{Finding, Frame, Hand, Label, PerFinger, World};
use serde_json::json;

use self::input::Input;
use self::layers::{Drawn, Layer, Shown};
use crate::error::{Located, SessionError};
use crate::output::write_atomic;
use crate::settings::Settings;

/// Worlds with other axes up are no place to compare in.
fn refuse_other_axes(inputs: &[Input]) -> Result<(), SessionError> {
    let up = |input: &Input| input.take.recording.source.up_axis;
    let Some(first) = inputs.first() else {
        return Ok(());
    };
    match inputs.iter().find(|input| up(input) != up(first)) {
        None => Ok(()),
        Some(other) => Err(other.take.error(format!(
            "its {} axis points up, and that of {} {}: process both (`inhand process`), so that they \
             are compared in the frame of the hand",
            up(other).name(),
            first.take.path.display(),
            up(first).name(),
        ))),
    }
}

/// Which generated motion is shown beside what was recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum OverlayMethods {
    /// None.
    #[default]
    None,
    /// That of these methods, in this order.
    Named(Vec<String>),
    /// That of all methods a file has.
    All,
}

/// How time lines are aligned.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// By the clock where files are of one take or overlap in time that was stated, by their starts
    /// otherwise.
    #[default]
    Auto,
    /// All begin where the first begins.
    Start,
    /// As their times say.
    Clock,
    /// The first event with this label in each file starts at one instant.
    Event(Label),
}

/// Content of an overlay.
#[derive(Clone, Debug, Default)]
pub struct OverlayOptions {
    /// Takes; others are compared with the first.
    pub inputs: Vec<PathBuf>,
    /// Names of the first inputs, in their order; those of the files otherwise.
    pub names: Vec<String>,
    /// Generated motion to show.
    pub methods: OverlayMethods,
    /// How time lines are aligned.
    pub align: Align,
}

/// One motion of an overlay.
#[derive(Clone, Debug, PartialEq)]
pub struct OverlaidLayer {
    /// Its name in topics.
    pub name: String,
    /// The file that it is from.
    pub file: String,
    /// The method that generated it; `None` for what was recorded.
    pub method: Option<String>,
    /// Its colour.
    pub colour: Rgb,
    /// By how much its times were moved, nanoseconds.
    pub offset_nanos: i128,
    /// Samples.
    pub samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// How far its fingertips are from those of the first layer; `None` for that one.
    pub apart: Option<PerFinger<Apart>>,
}

/// What an overlay shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlaid {
    /// The frame that motions are shown in.
    pub frame: &'static str,
    /// How time lines are aligned: `start`, `clock`, or `event` with the label.
    pub align: String,
    /// The motions, the first one first.
    pub layers: Vec<OverlaidLayer>,
    /// What was decided on the way, for people.
    pub notes: Vec<String>,
    /// What was odd about files, with their names.
    pub findings: Vec<(String, Finding)>,
}

/// Writes an overlay: motions of several takes, or of several methods of one, in one file.
///
/// All are in the frame of the hand where every take has processed motion, so that hands coincide;
/// otherwise in the world. Memory is taken for all takes at once. `settings` are those of each input.
///
/// # Errors
///
/// [`SessionError::Settings`] for options that leave nothing to compare, [`SessionError::Data`] for a
/// file that cannot be compared, with the reason; what reading and writing can find.
pub fn overlay(
    options: &OverlayOptions,
    output: &Path,
    settings: &[Settings],
) -> Result<Overlaid, SessionError> {
    let mut inputs = input::read(options, settings)?;
    let mut notes = Vec::new();
    let align = input::align(&mut inputs, &options.align, &mut notes)?;
    let unprocessed = (inputs.iter()).find(|input| input.take.stored_motion.is_none());
    let mut overlaid = Overlaid {
        frame: Hand::NAME,
        align,
        layers: Vec::new(),
        notes,
        findings: (inputs.iter())
            .flat_map(|input| {
                let findings = input.take.measured().findings.iter();
                findings.map(|finding| (input.take.hash.name.clone(), finding.clone()))
            })
            .collect(),
    };
    match unprocessed {
        None => write::<Hand>(options, &inputs, output, settings, &mut overlaid)?,
        Some(input) => {
            overlaid.frame = World::NAME;
            overlaid.notes.push(format!(
                "{} has no processed motion (`inhand process` adds it): all are shown in the world, \
                 where hands do not coincide",
                input.take.path.display()
            ));
            refuse_other_axes(&inputs)?;
            write::<World>(options, &inputs, output, settings, &mut overlaid)?;
        }
    }
    Ok(overlaid)
}

fn write<F: Shown>(
    options: &OverlayOptions,
    inputs: &[Input],
    output: &Path,
    settings: &[Settings],
    overlaid: &mut Overlaid,
) -> Result<(), SessionError> {
    let drawn: Drawn<F> = layers::of(inputs, &options.methods, &mut overlaid.notes)?;
    let distances_m: Vec<_> = (0..drawn.layers.len())
        .map(|n| from_first(&drawn.layers, n, inputs))
        .collect();
    overlaid.layers = (drawn.layers.iter().zip(&distances_m).enumerate())
        .map(|(n, (layer, distances_m))| {
            let input = &inputs[layer.input];
            OverlaidLayer {
                name: layer.name.clone(),
                file: input.take.hash.name.clone(),
                method: layer.method.clone(),
                colour: layer_colour(n),
                offset_nanos: input.offset_nanos,
                samples: input.take.recording.len(),
                rate_hz: input.clock.rate_hz(),
                apart: (n > 0).then(|| apart(distances_m)),
            }
        })
        .collect();
    let layers: Vec<_> = (drawn.layers.iter().zip(&distances_m))
        .map(|(layer, distances_m)| OverlayLayer {
            name: &layer.name,
            clock: inputs[layer.input].clock,
            tips: &layer.tips,
            distances_m,
        })
        .collect();
    let objects: Vec<_> = (drawn.objects.iter())
        .map(|object| OverlayObject {
            layer: object.layer,
            clock: inputs[object.input].clock,
            track: &object.track,
            shape: inputs[object.input].shape,
        })
        .collect();
    let hashes = inputs.iter().map(|input| input.take.hash.clone());
    let made = crate::run::provenance("overlay", &settings[0], hashes);
    let first = &inputs[0];
    let motion = first.take.stored_motion.as_ref();
    let file = OverlayFile {
        layers: &layers,
        hand: motion.map(|motion| (first.clock, &motion.hand)),
        objects: &objects,
        up_axis: first.take.recording.source.up_axis,
        about: &about(overlaid),
        provenance: &[made],
    };
    write_atomic(output, |out| {
        inhand_channels::write_overlay(out, &file).in_file(output)
    })
}

/// Distances of a layer's fingertips from those of the first one; none for that.
fn from_first<F: Frame>(layers: &[Layer<F>], n: usize, inputs: &[Input]) -> Vec<PerFinger<f64>> {
    let [first, layer] = [&layers[0], &layers[n]].map(|layer| Tips {
        clock: inputs[layer.input].clock,
        tracks: &layer.tips,
    });
    match n {
        0 => Vec::new(),
        _ => distances_m(first, layer),
    }
}

/// What the file says about itself.
fn about(overlaid: &Overlaid) -> BTreeMap<String, String> {
    let layers: Vec<_> = (overlaid.layers.iter())
        .map(|layer| {
            let [r, g, b] = layer.colour;
            json!({
                "name": layer.name,
                "file": layer.file,
                "method": layer.method,
                "colour": format!("#{r:02X}{g:02X}{b:02X}"),
                // Beyond 2^53 a JSON number would be rounded.
                "offset_nanos": layer.offset_nanos.to_string(),
                "samples": layer.samples,
                "rate_hz": layer.rate_hz,
            })
        })
        .collect();
    BTreeMap::from([
        ("align".to_owned(), overlaid.align.clone()),
        ("layers".to_owned(), json!(layers).to_string()),
    ])
}
