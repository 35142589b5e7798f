//! The motion of fingertips and object in the hand's frame, from a recording.

use inhand_model::{
    Finger, Frame, Hand, Motion, PerFinger, PointTrack, Pose, PoseTrack, Recording, Roles, Sample,
    Track, World,
};
use nalgebra::Translation3;
use rayon::prelude::*;

use crate::body::role_body;
use crate::error::MotionError;
use crate::filter::{smooth_points, smooth_poses, smoother};
use crate::gaps::{fill_points, fill_poses};
use crate::lookup::fingertip_markers;
use crate::settings::{Filter, ProcessSettings, gap_samples};
use crate::template::{BodyRole, Templates};

/// Takes a recording into the hand's frame and filters it: [`to_hand_frame`], then [`smooth`].
///
/// # Errors
///
/// [`MotionError::Setting`], [`MotionError::NotInTake`], [`MotionError::Body`].
pub fn process(
    recording: &Recording,
    roles: &Roles,
    templates: &Templates,
    settings: &ProcessSettings,
) -> Result<Motion, MotionError> {
    let mut motion = to_hand_frame(recording, roles, templates, settings)?;
    smooth(&mut motion, settings.filter)?;
    Ok(motion)
}

/// Takes a recording into the hand's frame: bodies from marker clusters, gaps, hand frame.
///
/// 1. The hand's pose comes from its rigid body or is fitted to its cluster (at least three
///    markers seen; a marker hidden from a larger cluster is no gap). Its gaps are filled in the
///    world.
/// 2. `hand_f(t) = hand_from_world(t) * f(t)` and `hand_from_object(t) = hand_from_world(t) *
///    world_from_object(t)`; the object's pose is first moved to its centre by `object_offset_m`.
///    Where the hand is missing, so is everything in its frame.
/// 3. Gaps of fingertips and object are filled in the hand's frame, not in the world: while a tip is
///    hidden the hand goes on moving, which is known, and only the motion within the hand has to be
///    guessed. The same for an object in the fingers.
///
/// A value is [`Filled`](inhand_model::Status::Filled) where its own sample was filled or the hand's
/// was; otherwise measured. The hand itself is given as filled. Independent of the number of threads.
///
/// # Errors
///
/// [`MotionError::Setting`], [`MotionError::NotInTake`], [`MotionError::Body`].
pub fn to_hand_frame(
    recording: &Recording,
    roles: &Roles,
    templates: &Templates,
    settings: &ProcessSettings,
) -> Result<Motion, MotionError> {
    let max_gap = gap_samples("max_gap_s", settings.max_gap_s, recording.clock.rate_hz())?;
    let hand = role_body(recording, BodyRole::Hand, &roles.hand, templates)?;
    let mut hand: PoseTrack<World, Hand> = hand.track.clone().in_role();
    fill_poses(&mut hand, max_gap, settings.fill);
    with_hand(recording, roles, hand, templates, settings)
}

/// Takes a recording into the frame of a hand whose pose is known, gaps filled: steps 2 and 3 of [`to_hand_frame`].
///
/// # Errors
///
/// As for [`to_hand_frame`].
pub fn with_hand(
    recording: &Recording,
    roles: &Roles,
    hand: PoseTrack<World, Hand>,
    templates: &Templates,
    settings: &ProcessSettings,
) -> Result<Motion, MotionError> {
    let max_gap = gap_samples("max_gap_s", settings.max_gap_s, recording.clock.rate_hz())?;
    let (offset_m, expected) = (settings.object_offset_m, "three finite numbers, metres");
    let finite = offset_m.iter().all(|c| c.is_finite());
    MotionError::unless(finite, "object_offset_m", format!("{offset_m:?}"), expected)?;
    let offset = Translation3::from(offset_m);

    let tips = fingertip_markers(recording, roles)?;
    let object = (roles.object.as_ref())
        .map(|source| role_body(recording, BodyRole::Object, source, templates))
        .transpose()?;

    let fingertip = |finger: Finger| {
        let tip = &recording.markers[tips[finger]].track;
        let mut track = in_hand(&hand, tip, |pose, tip| pose.inverse() * tip);
        fill_points(&mut track, max_gap, settings.fill);
        track
    };
    let object = || {
        object.map(|body| {
            let mut track = in_hand(&hand, &body.track, |pose, body| {
                pose.inverse() * Pose::new(body.isometry() * offset)
            });
            fill_poses(&mut track, max_gap, settings.fill);
            track
        })
    };
    let (fingertips, object) = rayon::join(|| each_finger(fingertip), object);
    Ok(Motion {
        name: recording.name.clone(),
        clock: recording.clock,
        fingertips,
        object,
        hand,
        selected: None,
    })
}

/// Smooths each coordinate of each interval without missing samples; the hand itself stays as it is. Memory is
/// taken for the tracks that are smoothed at once.
///
/// A sample keeps its status, whatever the filter's window held beside it.
///
/// # Errors
///
/// [`MotionError::Setting`].
pub fn smooth(motion: &mut Motion, filter: Filter) -> Result<(), MotionError> {
    let smoother = smoother(filter, motion.clock.rate_hz())?;
    let tips = motion.fingertips.as_mut_array();
    rayon::join(
        || (tips.par_iter_mut()).for_each(|track| *track = smooth_points(track, &smoother)),
        || (motion.object.iter_mut()).for_each(|track| *track = smooth_poses(track, &smoother)),
    );
    Ok(())
}

/// Makes one track for each finger, in parallel.
fn each_finger(
    make: impl Fn(Finger) -> PointTrack<Hand> + Sync + Send,
) -> PerFinger<PointTrack<Hand>> {
    let tracks: Vec<_> = Finger::ALL.into_par_iter().map(make).collect();
    let mut tracks = tracks.into_iter();
    PerFinger::from_fn(|_| tracks.next().expect("one track was made for each finger"))
}

/// Combines a hand's poses, of either direction, with something else at each sample where both are present; what is
/// known of the result is the lesser of what is known of the two.
pub fn in_hand<To: Frame, From: Frame, T: Sample, U: Sample>(
    hand: &PoseTrack<To, From>,
    track: &Track<T>,
    combine: impl Fn(Pose<To, From>, T) -> U,
) -> Track<U> {
    let sample = |k: usize| {
        let both = hand.get(k).zip(track.get(k));
        let status = hand.status(k).and(track.status(k));
        (both.map(|(pose, value)| combine(pose, value)), status)
    };
    (0..track.len()).map(sample).collect()
}
