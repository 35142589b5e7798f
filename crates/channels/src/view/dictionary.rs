//! Visualisation of a dictionary: the primitive that plays, its paths beside those of the mean motion,
//! and where fingertips have been.

use inhand_model::{Dictionary, Finger, Frame, Hand};
use nalgebra::UnitQuaternion;

use super::draw::{Dot, Paint, TRAIL_M, add_cloud, entity, point, scene, sphere, strip, text};
use super::{hulls, transforms};
use crate::colour::FINGER_COLOURS;
use crate::error::ChannelError;
use crate::streams::{Sampling, Streams};
use crate::take::scene_stride;
use crate::topic;

/// Colour and opacity of the mean motion.
const MEAN: Paint = ([0x99, 0x99, 0x99], 0.6);
/// Opacity of the paths of a primitive.
const PATH_ALPHA: f64 = 0.9;
/// Diameter of a fingertip, metres: less than most primitives move it.
const TIP_M: f64 = 0.003;
/// Height of the number of the primitive, metres, and its height above the fingertips.
const TEXT_M: f64 = 0.005;
const TEXT_ABOVE_M: f64 = 0.03;

/// Draws the primitives, which play one after the other: `mean_m` and `played_m` are positions of a fingertip
/// at a sample of the mean motion and of the whole file.
pub(crate) fn draw_dictionary<'a>(
    dictionary: &Dictionary,
    samples: Sampling,
    mean_m: impl Fn(usize, Finger) -> [f64; 3] + Copy + 'a,
    played_m: impl Fn(usize, Finger) -> [f64; 3] + Copy + 'a,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let (start, rate_hz) = (samples.clock.unix_nanos(0), samples.clock.rate_hz());
    // The hand's own axes are upright, as nothing is known of a world.
    transforms::write_static(Hand::NAME, UnitQuaternion::identity(), start, streams)?;
    hulls::draw_filled(&dictionary.demonstrated.hulls, start, streams)?;
    hulls::draw_points(&dictionary.demonstrated.hulls, start, streams)?;

    let place = (topic::VIEW_PRIMITIVES, Hand::NAME);
    let stride = scene_stride(rate_hz);
    add_cloud(
        streams,
        place,
        &["finger"],
        samples.every(stride),
        move |at, cloud| {
            for finger in Finger::ALL {
                cloud.push(
                    played_m(at.k, finger),
                    &[finger.index()],
                    FINGER_COLOURS[finger],
                );
            }
        },
    )?;
    let (hand, scenes) = (Some(Hand::NAME), samples.every(scene_stride(rate_hz)));
    streams.sampled(topic::VIEW_PRIMITIVES_SCENE, hand, scenes, move |at| {
        let mut tips = entity(Hand::NAME, "fingertips", at.unix_nanos);
        let sphere = |finger| sphere(played_m(at.k, finger), TIP_M, (FINGER_COLOURS[finger], 1.0));
        tips.spheres = Finger::ALL.map(sphere).into();
        Some(scene(vec![tips]))
    })?;

    draw_paths(
        dictionary.layout.samples,
        samples,
        mean_m,
        played_m,
        streams,
    )
}

/// Draws the whole second of a primitive, when it begins: the path of each fingertip and, in grey, the one
/// it has in the mean motion.
fn draw_paths<'a>(
    length: usize,
    samples: Sampling,
    mean_m: impl Fn(usize, Finger) -> [f64; 3] + Copy + 'a,
    played_m: impl Fn(usize, Finger) -> [f64; 3] + Copy + 'a,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let stride = scene_stride(samples.clock.rate_hz());
    let path = move |k: usize, finger: Finger| {
        let played = (0..length)
            .step_by(stride)
            .map(move |t| played_m(k + t, finger));
        let mean = (0..length).step_by(stride).map(move |t| mean_m(t, finger));
        [mean.collect::<Vec<_>>(), played.collect()]
    };
    let looks = |finger| [MEAN, (FINGER_COLOURS[finger], PATH_ALPHA)];
    let begins = samples.every(length);
    streams.sampled(topic::VIEW_PATHS, Some(Hand::NAME), begins, move |at| {
        let mut paths = entity(Hand::NAME, "paths", at.unix_nanos);
        for finger in Finger::ALL {
            let widths_m = [TRAIL_M / 2.0, TRAIL_M];
            for ((path, look), width_m) in path(at.k, finger)
                .into_iter()
                .zip(looks(finger))
                .zip(widths_m)
            {
                let points = path.into_iter().map(point).collect();
                paths.lines.push(strip(points, width_m, look));
            }
        }
        let tips = Finger::ALL.map(|finger| mean_m(0, finger));
        let [x, y, z] = [0, 1, 2]
            .map(|axis| tips.iter().map(|tip| tip[axis]).sum::<f64>() / Finger::COUNT as f64);
        let name = format!("primitive {}", at.k / length);
        (paths.texts).push(text([x, y, z + TEXT_ABOVE_M], TEXT_M, MEAN.0, name));
        Some(scene(vec![paths]))
    })?;
    // For viewers that draw no scenes. A star is where a path begins: most paths are shorter than it is wide.
    let place = (topic::VIEW_PATH_POINTS, Hand::NAME);
    add_cloud(streams, place, &["finger"], begins, move |at, cloud| {
        for finger in Finger::ALL {
            let begin_m = played_m(at.k, finger);
            cloud.push_dot(
                Dot::Star(TIP_M),
                begin_m,
                &[finger.index()],
                FINGER_COLOURS[finger],
            );
            for (path, look) in path(at.k, finger).into_iter().zip(looks(finger)) {
                for position_m in path {
                    cloud.push(position_m, &[finger.index()], look.0);
                }
            }
        }
    })
}
