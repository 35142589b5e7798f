//! Several takes or methods over each other, on one time line, in one file.

mod input;
mod layers;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use inhand_channels::{OverlayFile, OverlayLayer, OverlayObject, Rgb, layer_colour};
use inhand_evaluation::overlay::{Apart, Tips, apart, distances_m, moved};
use inhand_model::{Clock, Finding, Frame, Label, PerFinger, PoseTrack, World};
use serde_json::json;

use self::input::{Input, Placed};
use self::layers::{Drawn, Shown};
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

/// How time lines lie over each other.
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

/// What to put over each other.
#[derive(Clone, Debug, Default)]
pub struct OverlayOptions {
    /// Takes; others are compared with the first.
    pub inputs: Vec<PathBuf>,
    /// Names of the first inputs, in their order; those of the files otherwise.
    pub names: Vec<String>,
    /// Generated motion to show.
    pub methods: OverlayMethods,
    /// How time lines lie over each other.
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
    /// How time lines lie over each other: `start`, `clock`, or `event` with the label.
    pub align: String,
    /// The motions, the first one first.
    pub layers: Vec<OverlaidLayer>,
    /// What was decided on the way, for people.
    pub notes: Vec<String>,
    /// What was odd about files, with their names.
    pub findings: Vec<(String, Finding)>,
}

/// Writes motions of several takes, or of several methods of one, over each other into one file.
///
/// All are in the frame of the hand where every take has processed motion, so that hands coincide;
/// otherwise in the world. Memory is taken for all takes at once.
///
/// # Errors
///
/// [`SessionError::Settings`] for options that leave nothing to compare, [`SessionError::Data`] for a
/// file that cannot be compared, with the reason; what reading and writing can find.
pub fn overlay(
    options: &OverlayOptions,
    output: &Path,
    settings: &Settings,
) -> Result<Overlaid, SessionError> {
    let inputs = input::read(options, settings)?;
    let mut notes = Vec::new();
    let unprocessed = (inputs.iter()).find(|input| input.take.stored_motion.is_none());
    let placed = input::align(&inputs, &options.align, &mut notes)?;
    match unprocessed {
        None => write::<inhand_model::Hand>(options, &inputs, placed, output, settings, notes),
        Some(input) => {
            notes.push(format!(
                "{} has no processed motion (`inhand process` adds it): all are shown in the world, \
                 where hands do not coincide",
                input.take.path.display()
            ));
            refuse_other_axes(&inputs)?;
            write::<World>(options, &inputs, placed, output, settings, notes)
        }
    }
}

/// A layer with its distances.
struct Compared<'a, F: Frame> {
    layer: &'a layers::Layer<F>,
    clock: Clock,
    distances_m: Vec<PerFinger<f64>>,
}

fn write<F: Shown>(
    options: &OverlayOptions,
    inputs: &[Input],
    placed: Placed,
    output: &Path,
    settings: &Settings,
    mut notes: Vec<String>,
) -> Result<Overlaid, SessionError> {
    let drawn: Drawn<F> = layers::of(inputs, &options.methods, &mut notes)?;
    let clocks = (inputs.iter().zip(&placed.offsets))
        .map(|(input, &offset)| {
            moved(input.take.recording.clock, offset).ok_or_else(|| {
                let message = "its times, moved to those of the others, lie outside those that \
                               files can state; --align start";
                input.take.error(message.to_owned())
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let compared = compare(&drawn, &clocks);
    let result = Overlaid {
        frame: F::NAME,
        align: placed.align,
        layers: (compared.iter().enumerate())
            .map(|(n, compared)| described(n, compared, inputs, &placed.offsets))
            .collect(),
        notes,
        findings: (inputs.iter())
            .flat_map(|input| {
                let findings = input.take.measured().findings.iter();
                findings.map(|finding| (input.take.hash.name.clone(), finding.clone()))
            })
            .collect(),
    };
    let layers: Vec<_> = (compared.iter())
        .map(|compared| OverlayLayer {
            name: &compared.layer.name,
            clock: compared.clock,
            tips: &compared.layer.tips,
            distances_m: &compared.distances_m,
        })
        .collect();
    let objects: Vec<_> = (drawn.objects.iter())
        .map(|object| OverlayObject {
            layer: object.layer,
            clock: clocks[object.input],
            track: &object.track,
            shape: inputs[object.input].shape,
        })
        .collect();
    let made = crate::run::provenance(
        "overlay",
        settings,
        inputs.iter().map(|input| input.take.hash.clone()),
    );
    let file = OverlayFile {
        layers: &layers,
        hand: first_hand(inputs, &clocks),
        objects: &objects,
        up_axis: inputs[0].take.recording.source.up_axis,
        about: &about(&result),
        provenance: &[made],
    };
    write_atomic(output, |out| {
        inhand_channels::write_overlay(out, &file).in_file(output)
    })?;
    Ok(result)
}

fn first_hand<'a>(
    inputs: &'a [Input],
    clocks: &[Clock],
) -> Option<(Clock, &'a PoseTrack<World, inhand_model::Hand>)> {
    let motion = inputs.first()?.take.stored_motion.as_ref()?;
    Some((*clocks.first()?, &motion.hand))
}

fn compare<'a, F: Frame>(drawn: &'a Drawn<F>, clocks: &[Clock]) -> Vec<Compared<'a, F>> {
    let tips = |layer: &'a layers::Layer<F>| Tips {
        clock: clocks[layer.input],
        tracks: &layer.tips,
    };
    (drawn.layers.iter().enumerate())
        .map(|(n, layer)| Compared {
            layer,
            clock: clocks[layer.input],
            distances_m: match drawn.layers.first() {
                Some(first) if n > 0 => distances_m(tips(first), tips(layer)),
                _ => Vec::new(),
            },
        })
        .collect()
}

fn described<F: Frame>(
    n: usize,
    compared: &Compared<'_, F>,
    inputs: &[Input],
    offsets: &[i128],
) -> OverlaidLayer {
    let layer = compared.layer;
    let take = &inputs[layer.input].take;
    OverlaidLayer {
        name: layer.name.clone(),
        file: take.hash.name.clone(),
        method: layer.method.clone(),
        colour: layer_colour(n),
        offset_nanos: offsets[layer.input],
        samples: take.recording.len(),
        rate_hz: compared.clock.rate_hz(),
        apart: (n > 0).then(|| apart(&compared.distances_m)),
    }
}

/// What the file says about itself.
fn about(result: &Overlaid) -> BTreeMap<String, String> {
    let layers: Vec<_> = (result.layers.iter())
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
        ("align".to_owned(), result.align.clone()),
        ("layers".to_owned(), json!(layers).to_string()),
    ])
}
