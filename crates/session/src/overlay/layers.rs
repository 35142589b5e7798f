//! The motions of takes in one frame.

use inhand_channels::{MAX_LAYERS, ReadMethod};
use inhand_model::{
    BodySource, Finger, Frame, Hand, Object, PerFinger, PointTrack, Pose, PoseTrack, Position,
    SegmentLayout, Status, World,
};

use super::OverlayMethods;
use super::input::Input;
use crate::error::{SessionError, invalid};

/// One motion.
pub(super) struct Layer<F: Frame> {
    pub(super) name: String,
    /// Which of the inputs it is from.
    pub(super) input: usize,
    pub(super) method: Option<String>,
    pub(super) tips: PerFinger<PointTrack<F>>,
}

/// The object of an input, shown with the first layer of it.
pub(super) struct DrawnObject<F: Frame> {
    pub(super) layer: usize,
    pub(super) input: usize,
    pub(super) track: PoseTrack<F, Object>,
}

/// Everything that is shown.
pub(super) struct Drawn<F: Frame> {
    pub(super) layers: Vec<Layer<F>>,
    pub(super) objects: Vec<DrawnObject<F>>,
}

/// A frame in which motion of takes can be shown.
pub(super) trait Shown: Frame {
    /// Fingertips as recorded.
    fn recorded(input: &Input) -> Result<PerFinger<PointTrack<Self>>, SessionError>;
    /// A generated position at a sample of the take.
    fn generated(input: &Input, k: usize, position: Position<Hand>) -> Option<Position<Self>>;
    /// The object.
    fn object(input: &Input) -> Option<PoseTrack<Self, Object>>;
}

impl Shown for Hand {
    fn recorded(input: &Input) -> Result<PerFinger<PointTrack<Hand>>, SessionError> {
        match &input.take.stored_motion {
            Some(motion) => Ok(motion.fingertips.clone()),
            None => Err((input.take).error("no processed motion: `inhand process` adds it".into())),
        }
    }

    fn generated(_: &Input, _: usize, position: Position<Hand>) -> Option<Position<Hand>> {
        Some(position)
    }

    fn object(input: &Input) -> Option<PoseTrack<Hand, Object>> {
        input.take.stored_motion.as_ref()?.object.clone()
    }
}

impl Shown for World {
    fn recorded(input: &Input) -> Result<PerFinger<PointTrack<World>>, SessionError> {
        let (roles, recording) = (input.take.roles()?, &input.take.recording);
        Ok(PerFinger::from_fn(|finger| {
            let marker = recording.marker(&roles.fingers[finger]);
            marker.map_or_else(
                || PointTrack::missing(recording.len()),
                |marker| marker.track.clone(),
            )
        }))
    }

    fn generated(input: &Input, k: usize, position: Position<Hand>) -> Option<Position<World>> {
        let hand = input.take.stored_motion.as_ref()?.hand.get(k)?;
        Some(Position::from_point(hand.isometry() * position.point()))
    }

    fn object(input: &Input) -> Option<PoseTrack<World, Object>> {
        let BodySource::RigidBody(name) = input.take.roles.as_ref().ok()?.object.as_ref()? else {
            return None;
        };
        let body = input.take.recording.body(name)?;
        Some(body.track.map(|pose| Pose::new(pose.isometry())))
    }
}

/// The layers of all inputs: what was recorded, then the methods that were asked for.
pub(super) fn of<F: Shown>(
    inputs: &[Input],
    methods: &OverlayMethods,
    notes: &mut Vec<String>,
) -> Result<Drawn<F>, SessionError> {
    check_methods(inputs, methods)?;
    let mut drawn = Drawn::<F> {
        layers: Vec::new(),
        objects: Vec::new(),
    };
    for (n, input) in inputs.iter().enumerate() {
        let tips = F::recorded(input)?;
        if tips
            .iter()
            .all(|(_, track)| track.counts().missing == track.len())
        {
            let message = "no fingertip is there at any sample: nothing can be compared";
            return Err(input.take.error(message.to_owned()));
        }
        let chosen = chosen(input, methods);
        let known = drawn.layers.iter().find(|layer| {
            layer.method.is_none()
                && inputs[layer.input].take.recording.clock == input.take.recording.clock
                && same(&layer.tips, &tips)
        });
        let layer = drawn.layers.len();
        match known.filter(|_| !chosen.is_empty()) {
            Some(known) => notes.push(format!(
                "{} was recorded as {}: shown once",
                input.name, known.name
            )),
            None => {
                let single = inputs.len() == 1;
                let name = if single { "recorded" } else { &input.name };
                drawn.layers.push(Layer {
                    name: name.to_owned(),
                    input: n,
                    method: None,
                    tips,
                });
                let track = F::object(input);
                drawn.objects.extend(track.map(|track| DrawnObject {
                    layer,
                    input: n,
                    track,
                }));
            }
        }
        if let OverlayMethods::Named(names) = methods {
            let lacking = names
                .iter()
                .filter(|name| chosen.iter().all(|m| m.name != **name));
            notes.extend(lacking.map(|name| format!("{} has no motion of {name}", input.name)));
        }
        for method in chosen {
            drawn.layers.push(Layer {
                name: match inputs.len() {
                    1 => method.name.clone(),
                    _ => format!("{}_{}", input.name, method.name),
                },
                input: n,
                method: Some(method.name.clone()),
                tips: generated(input, method),
            });
        }
    }
    check_layers(&drawn)?;
    Ok(drawn)
}

fn chosen<'a>(input: &'a Input, methods: &OverlayMethods) -> Vec<&'a ReadMethod> {
    match methods {
        OverlayMethods::None => Vec::new(),
        OverlayMethods::All => input.methods.iter().collect(),
        OverlayMethods::Named(names) => (names.iter())
            .filter_map(|name| input.methods.iter().find(|method| method.name == *name))
            .collect(),
    }
}

/// A method that no file has is a mistake.
fn check_methods(inputs: &[Input], methods: &OverlayMethods) -> Result<(), SessionError> {
    let known: Vec<&str> = (inputs.iter())
        .flat_map(|input| input.methods.iter().map(|method| method.name.as_str()))
        .collect();
    let missing = match methods {
        OverlayMethods::None => None,
        OverlayMethods::All => known.is_empty().then_some("all"),
        OverlayMethods::Named(names) => {
            let unknown = names.iter().find(|name| !known.contains(&name.as_str()));
            unknown.map(String::as_str)
        }
    };
    let Some(missing) = missing else {
        return Ok(());
    };
    let mut names = known;
    names.sort_unstable();
    names.dedup();
    let expected = match names.len() {
        0 => "files with generated motion, as `inhand run` and `inhand generate` write".to_owned(),
        _ => format!("some of {}", names.join(", ")),
    };
    Err(invalid("methods", &expected, &missing))
}

fn check_layers<F: Frame>(drawn: &Drawn<F>) -> Result<(), SessionError> {
    let names: Vec<&str> = drawn
        .layers
        .iter()
        .map(|layer| layer.name.as_str())
        .collect();
    if names.len() > MAX_LAYERS {
        let expected = format!("at most {MAX_LAYERS} motions, which colours can distinguish");
        let found = format!("{}; choose some by --methods", names.len());
        return Err(invalid("takes and methods", &expected, &found));
    }
    let twice = (1..names.len()).find(|&n| names[..n].contains(&names[n]));
    match twice {
        None => Ok(()),
        Some(n) => {
            let found = format!("\"{}\" twice", names[n]);
            Err(invalid("name", "another for each motion", &found))
        }
    }
}

fn same<F: Frame>(a: &PerFinger<PointTrack<F>>, b: &PerFinger<PointTrack<F>>) -> bool {
    (a.iter())
        .all(|(finger, track)| track.len() == b[finger].len() && track.iter().eq(b[finger].iter()))
}

fn generated<F: Shown>(input: &Input, method: &ReadMethod) -> PerFinger<PointTrack<F>> {
    let samples = input.take.recording.len();
    let mut tips = PerFinger::from_fn(|_| PointTrack::missing(samples));
    for (&k, configuration) in method.configurations_m.range(..samples) {
        for finger in Finger::ALL {
            let [x, y, z] =
                [0, 1, 2].map(|axis| configuration[SegmentLayout::row(0, finger, axis)]);
            if let Some(position) = F::generated(input, k, Position::new(x, y, z)) {
                tips[finger].set(k, Some(position), Status::Measured);
            }
        }
    }
    tips
}
