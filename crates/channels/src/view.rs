//! Visualisation channels: one connected tree of frames, point clouds, a scene.
//!
//! The tree is `upright` (z up) -> `world` (the source's axes) -> `hand` -> `object`; where there is
//! no processed motion, `object` hangs under `world`. A frame is in the tree only if the take
//! shows it at a sample that views show, and nothing is drawn in a frame that is not in the tree:
//! a single unconnected frame empties a whole view in some viewers.
//!
//! Every message has all that is drawn at its instant, since a viewer that jumps in time sees
//! only the last message of each topic. What holds for the whole take is sent once, on topics of
//! its own.

mod dictionary;
mod draw;
mod hulls;
mod object;
mod overlay;
mod tips;
mod transforms;

pub(crate) use dictionary::draw_dictionary;
pub(crate) use overlay::draw_overlay;
pub(crate) use transforms::{UPRIGHT, transform};

use std::rc::Rc;

use foxglove::messages::{Log, log};
use inhand_model::{
    Change, Clock, Finger, Frame, Hand, MarkerKind, PerFinger, PlanStatus, Protocol, World,
};

use crate::colour::{FINGER_COLOURS, Rgb, method_colour};
use crate::error::ChannelError;
use crate::made::ByStart;
use crate::streams::{Instant, Sampling, Streams};
use crate::take::{
    EvaluatedMethod, GeneratedMethod, Outline, RECORDED, TakeFile, Views, marker_indices,
    scene_stride, stride,
};
use crate::topic;
use crate::view::draw::{add_cloud, cloud_once};
use crate::view::tips::{TipTopics, Tips};
use crate::wire::viewer_time;

const LABELLED: Rgb = [0xF0, 0xE4, 0x42];
const OF_BODY: Rgb = [0x00, 0x72, 0xB2];
const UNLABELLED: Rgb = [0x99, 0x99, 0x99];

/// Draws a take. `file.recording` is the one that is drawn; `measured` is the clock that changes by
/// cleaning are counted by. There is at least the default.
pub(crate) fn draw_take<'a>(
    file: &TakeFile<'a>,
    (measured, outline): (Clock, &Outline),
    views: Views,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let clock = file.recording.clock;
    let start = clock.unix_nanos(0);
    let samples = Sampling::all(clock, outline.samples);
    let rate_hz = clock.rate_hz();
    let shown = samples.every(stride(rate_hz));
    let tree = transforms::add(file, outline, shown, streams)?;
    draw_entities(file, samples.every(scene_stride(rate_hz)), streams)?;
    if let Some(tips) = recorded_tips(file, tree.hand) {
        let topics = TipTopics {
            cloud: topic::VIEW_FINGERTIPS,
            scene: Some(topic::VIEW_FINGERTIPS_SCENE),
            contacts: Some(topic::VIEW_CONTACTS),
        };
        tips.add(&topics, samples, streams)?;
    }
    let drawn = match views {
        _ if !tree.hand => 0,
        Views::All => file.generated.len(),
        _ => 1,
    };
    for (place, method) in file.generated.iter().enumerate().take(drawn) {
        // Planned motion alone needs telling apart from nothing: its fingers show which is which.
        let alone = file.motion.is_none() && file.roles.is_none() && place == 0;
        let [cloud, scene, contacts_topic] = ["fingertips", "fingertips_scene", "contacts"]
            .map(|leaf| topic::named(topic::VIEW_GENERATED, method.name, leaf));
        let topics = TipTopics {
            cloud: &cloud,
            // Scenes of all methods on top of each other would show none.
            scene: (place == 0).then_some(&scene),
            contacts: (place == 0 && views == Views::All).then_some(&contacts_topic),
        };
        if alone {
            draw_planned_path(method, shown, streams)?;
        }
        let tips = Tips {
            frame: Hand::NAME,
            position_m: Rc::new(move |at, finger| {
                let segments = at.made()?.generated(Protocol::Published, place)?;
                segments.position_m(at.k, finger)
            }),
            contacts: contacts(file, method.name),
            shells: (!alone).then(|| method_colour(place)),
            links: alone,
        };
        tips.add(&topics, samples, streams)?;
    }
    if let Some(hulls) = file.hulls.filter(|_| tree.hand) {
        hulls::draw_outlines(hulls, start, streams)?;
    }
    if tree.object {
        object::draw(file.object_shape, start, streams)?;
    }
    add_log(file, measured, samples, streams)
}

/// Fingertips of the motion, frame `hand`, or else of the markers that have the roles, frame `world`.
fn recorded_tips<'a>(file: &TakeFile<'a>, hand: bool) -> Option<Tips<'a>> {
    let contacts = contacts(file, RECORDED);
    if let Some(motion) = file.motion.filter(|_| hand) {
        return Some(Tips {
            frame: Hand::NAME,
            position_m: Rc::new(|at, finger| Some(motion.fingertips[finger].get(at.k)?.to_array())),
            contacts,
            shells: None,
            links: true,
        });
    }
    let markers = marker_indices(file.recording, file.roles?);
    let position_m = move |at: &Instant<'_>, finger| {
        let (recording, row) = at.recorded(None)?;
        let marker = recording.markers.get(markers[finger]?)?;
        Some(marker.track.get(row)?.to_array())
    };
    Some(Tips {
        frame: World::NAME,
        position_m: Rc::new(position_m),
        contacts,
        shells: None,
        links: false,
    })
}

/// Draws the whole planned path of each fingertip once as points, for viewers that draw no scenes.
fn draw_planned_path(
    method: &GeneratedMethod<'_>,
    shown: Sampling,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let segments = &ByStart::new(method.segments);
    let path_m = Finger::ALL.into_iter().flat_map(|finger| {
        let samples = (0..shown.samples).step_by(shown.stride);
        samples.filter_map(move |k| Some((finger.index(), segments.position_m(k, finger)?)))
    });
    let topic = topic::named(topic::VIEW_GENERATED, method.name, "path_points");
    let place = (&*topic, Hand::NAME, "finger");
    let colour = |finger: usize| FINGER_COLOURS[Finger::ALL[finger]];
    cloud_once(place, path_m, colour, shown.clock.unix_nanos(0), streams)
}

/// Place of the method of this name among those that contacts are known of.
fn contacts(file: &TakeFile<'_>, method: &str) -> Option<usize> {
    let has_contacts = |method: &EvaluatedMethod| {
        let mut samples = method.samples.iter();
        samples.any(|judged| judged.contact.is_some())
    };
    let mut methods = file.evaluated.iter();
    methods.position(|evaluated| evaluated.name == method && has_contacts(evaluated))
}

/// Draws markers and bodies as points.
fn draw_entities<'a>(
    file: &TakeFile<'a>,
    sampling: Sampling,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let recording = file.recording;
    if !recording.markers.is_empty() {
        let tips = file.roles.map(|roles| marker_indices(recording, roles));
        let finger_of = |n: usize| {
            let mut tips = tips.iter().flat_map(PerFinger::iter);
            tips.find_map(|(finger, tip)| (*tip == Some(n)).then_some(finger))
        };
        let colours: Vec<Rgb> = (recording.markers.iter().enumerate())
            .map(|(n, marker)| match (finger_of(n), marker.kind) {
                (Some(finger), _) => FINGER_COLOURS[finger],
                (None, MarkerKind::Labelled) => LABELLED,
                (None, MarkerKind::RigidBodyMarker) => OF_BODY,
                (None, MarkerKind::Unlabelled) => UNLABELLED,
            })
            .collect();
        let place = (topic::VIEW_MARKERS, World::NAME);
        add_cloud(streams, place, &["marker"], sampling, move |at, cloud| {
            let Some((recording, row)) = at.recorded(None) else {
                return;
            };
            for (n, (marker, &colour)) in recording.markers.iter().zip(&colours).enumerate() {
                if let Some(position) = marker.track.get(row) {
                    cloud.push(position.to_array(), &[n], colour);
                }
            }
        })?;
    }
    if !recording.bodies.is_empty() {
        let place = (topic::VIEW_BODIES, World::NAME);
        add_cloud(streams, place, &["body"], sampling, |at, cloud| {
            let Some((recording, row)) = at.recorded(None) else {
                return;
            };
            for (n, body) in recording.bodies.iter().enumerate() {
                if let Some(pose) = body.track.get(row) {
                    cloud.push(pose.origin().to_array(), &[n], OF_BODY);
                }
            }
        })?;
    }
    Ok(())
}

/// Adds the log of changes made by cleaning and of plans without a solution, if there are any.
fn add_log(
    file: &TakeFile<'_>,
    measured: Clock,
    samples: Sampling,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let clock = samples.clock;
    let log = |unix_nanos, level: log::Level, name: &str, message: String| Log {
        timestamp: Some(viewer_time(unix_nanos)),
        level: level.into(),
        name: name.to_owned(),
        message,
        ..Log::default()
    };
    if let Some(cleaned) = file.cleaned.filter(|cleaned| !cleaned.changes.is_empty()) {
        let last = cleaned.recording.len().saturating_sub(1);
        // The first sample of the cleaned recording that a change concerns.
        let sample = |change: &Change| {
            let sample = clock.nearest_sample(measured.time_s(change.samples.start));
            sample.min(last)
        };
        let mut changes: Vec<_> = (cleaned.changes.iter())
            .map(|change| (sample(change), change.to_string()))
            .collect();
        // The order of those at one sample stays.
        changes.sort_by_key(|(sample, _)| *sample);
        let messages = changes.into_iter().map(move |(sample, message)| {
            let unix_nanos = clock.unix_nanos(sample);
            (
                sample,
                unix_nanos,
                log(unix_nanos, log::Level::Info, "clean", message),
            )
        });
        let channel = streams.output.channel::<Log>(topic::VIEW_LOG, None)?;
        streams.listed(channel, messages);
    }
    for (place, method) in file.generated.iter().enumerate().filter(|(_, m)| m.plans) {
        let name = method.name.to_owned();
        streams.add(samples, move |at, output| {
            let segments = at
                .made()
                .and_then(|made| made.generated(Protocol::Published, place));
            for segment in segments.map_or(&[][..], |segments| segments.starting(at.k)) {
                let (None, Some(plan)) = (segment.trajectory, segment.plan) else {
                    continue;
                };
                let how = match plan.status {
                    PlanStatus::Infeasible => "no motion keeps to all constraints",
                    _ => "the solver found no motion",
                };
                let message = format!("no trajectory: {how}");
                // Plans are made while they are written: before one fails there is nothing to log.
                let channel = output.channel::<Log>(topic::VIEW_LOG, None)?;
                let message = log(at.unix_nanos, log::Level::Warning, &name, message);
                output.message(channel, at.k, at.unix_nanos, &message)?;
            }
            Ok(())
        });
    }
    Ok(())
}
