//! Marker cluster templates of a session, and the frames they define.

use std::fmt;

use inhand_model::{BodySource, Recording, Roles, Status, named};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rayon::prelude::*;

use crate::error::{MotionError, listed};
use crate::lookup::marker_track;
use crate::rigid_fit::{MIN_SPREAD, centroid, rigid_fit};

/// Change of the mean shape, root mean square over markers, below which it counts as found: far
/// below a micrometre, well above rounding (metres).
const SHAPE_TOLERANCE_M: f64 = 1e-12;

/// Rounds of alignment at most. With noise well below the cluster's size three to five are enough.
const MAX_ROUNDS: usize = 50;

/// Frames summed by one thread at a time. Fixed, so that sums do not depend on the threads.
const FRAMES_PER_CHUNK: usize = 1024;

named! {
    /// A body whose frame is defined by the roles.
    pub enum BodyRole {
        /// The back of the hand.
        Hand = "hand",
        /// The manipulated object.
        Object = "object",
    }
}

impl BodyRole {
    /// What `roles` say the body is.
    pub fn source(self, roles: &Roles) -> Option<&BodySource> {
        match self {
            BodyRole::Hand => Some(&roles.hand),
            BodyRole::Object => roles.object.as_ref(),
        }
    }
}

impl fmt::Display for BodyRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The mean shape of a marker cluster in the frame that it defines: origin in its centroid, x from
/// the first to the second named marker, z along the normal of the first three,
/// `(m2 - m1) x (m3 - m1)`, y completing a right-handed frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Template {
    /// Names of the markers, in the order that defines the axes.
    pub markers: Vec<String>,
    /// Position of each marker in the body's frame, metres.
    pub positions_m: Vec<Vector3<f64>>,
    /// Complete frames that the shape is the mean of.
    pub frames: usize,
    /// Root mean square distance of the markers of those frames from their place in the shape,
    /// metres: the noise of the markers and how much the cluster deforms.
    pub rms_m: f64,
}

/// The templates of a session. Empty where hand and object are rigid bodies of the takes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Templates([Option<Template>; BodyRole::ALL.len()]);

impl Templates {
    /// The template of a body, where it is a cluster.
    pub fn get(&self, role: BodyRole) -> Option<&Template> {
        self.0[role as usize].as_ref()
    }
}

/// Fits one template for each body that is a marker cluster, over all takes of a session: the mean
/// shape by generalised Procrustes analysis without scaling (Gower, *Generalized Procrustes
/// analysis*, Psychometrika 40, 1975) of the frames that show the whole cluster.
///
/// Each round aligns every frame to the shape by the rigid motion of least squares and takes the
/// mean of the aligned frames for the new shape, until it no longer changes. Cost: one small
/// eigenvalue problem a frame and round.
///
/// Takes that do not track a body (no object in training) have no say in its template; where every
/// body is a rigid body there is nothing to do.
///
/// # Errors
///
/// [`MotionError::Body`] unless a body is the same cluster (names and their order, which defines the
/// axes) or a rigid body in all takes that have it, and for clusters of fewer than three markers, on a
/// line, or never seen whole; [`MotionError::NotInTake`].
pub fn fit_templates<'a>(
    takes: impl IntoIterator<Item = (&'a Recording, &'a Roles)>,
) -> Result<Templates, MotionError> {
    fit_templates_to(takes, &|_| true)
}

/// The same with the shape of those takes alone whose place in the list is chosen; of all where these never show the
/// whole cluster. Samples of the other takes have then no say in the frames of hand and object.
///
/// # Errors
///
/// As [`fit_templates`].
pub fn fit_templates_to<'a>(
    takes: impl IntoIterator<Item = (&'a Recording, &'a Roles)>,
    chosen: &dyn Fn(usize) -> bool,
) -> Result<Templates, MotionError> {
    let takes: Vec<_> = takes.into_iter().collect();
    let [hand, object] = BodyRole::ALL.map(|role| fit_template(&takes, chosen, role));
    Ok(Templates([hand?, object?]))
}

fn fit_template(
    takes: &[(&Recording, &Roles)],
    chosen: &dyn Fn(usize) -> bool,
    role: BodyRole,
) -> Result<Option<Template>, MotionError> {
    let with_body: Vec<(usize, &Recording, &BodySource)> = (takes.iter().enumerate())
        .filter_map(|(n, &(recording, roles))| Some((n, recording, role.source(roles)?)))
        .collect();
    let Some(&(_, first_take, first)) = with_body.first() else {
        return Ok(None);
    };
    for &(_, take, source) in &with_body {
        let same = match (source, first) {
            // Takes may call one rigid body by different names; what its frame is, the capture
            // software knows.
            (BodySource::RigidBody(_), BodySource::RigidBody(_)) => true,
            (source, first) => source == first,
        };
        if !same {
            let (take, found) = (&take.name, in_words(source));
            let (first_take, expected) = (&first_take.name, in_words(first));
            return Err(MotionError::Body(format!(
                "the {role} is {found} in take \"{take}\", but {expected} in take \"{first_take}\": \
                 its frame needs one definition for the session"
            )));
        }
    }
    let BodySource::Markers(names) = first else {
        return Ok(None);
    };
    let repeated = (1..names.len()).any(|i| names[..i].contains(&names[i]));
    if names.len() < 3 || repeated {
        let names = listed(names);
        return Err(MotionError::Body(format!(
            "the {role} is a cluster of {names}: a pose needs three different markers or more"
        )));
    }

    let mut frames = Vec::new();
    for &(_, take, _) in with_body.iter().filter(|(n, ..)| chosen(*n)) {
        complete_frames(take, role, names, &mut frames)?;
    }
    if frames.is_empty() {
        for &(_, take, _) in &with_body {
            complete_frames(take, role, names, &mut frames)?;
        }
    }
    if frames.is_empty() {
        let takes: Vec<_> = with_body
            .iter()
            .map(|(_, take, _)| take.name.clone())
            .collect();
        let (names, takes) = (listed(names), listed(&takes));
        return Err(MotionError::Body(format!(
            "the markers of the {role} ({names}) are never all seen at once in {takes}: name a cluster \
             with fewer markers, or other takes"
        )));
    }
    let count = names.len();
    let (shape, rms_m) = mean_shape(&frames, count);
    Ok(Some(Template {
        positions_m: in_own_axes(&shape, role, names)?,
        markers: names.clone(),
        frames: frames.len() / count,
        rms_m,
    }))
}

fn in_words(source: &BodySource) -> String {
    match source {
        BodySource::RigidBody(name) => format!("the rigid body \"{name}\""),
        BodySource::Markers(names) => format!("the cluster \"{}\"", names.join("\", \"")),
    }
}

/// Appends the cluster's markers of every sample at which all of them were measured.
fn complete_frames(
    take: &Recording,
    role: BodyRole,
    names: &[String],
    frames: &mut Vec<Vector3<f64>>,
) -> Result<(), MotionError> {
    let tracks = (names.iter())
        .map(|name| marker_track(take, role.name(), name))
        .collect::<Result<Vec<_>, MotionError>>()?;
    for k in 0..take.len() {
        if (tracks.iter()).all(|track| track.status(k) == Status::Measured) {
            frames.extend(tracks.iter().map(|track| track.value(k).coords_m()));
        }
    }
    Ok(())
}

/// The mean shape of frames of `count` points each, centred on its centroid, and the root mean
/// square distance of their points from it. The shape's orientation is that of the first frame.
///
/// A sample of the frames finds the shape nearly; from there all of them need two or three rounds.
fn mean_shape(frames: &[Vector3<f64>], count: usize) -> (Vec<Vector3<f64>>, f64) {
    let step = (frames.len() / count).div_ceil(FRAMES_PER_CHUNK);
    let sample: Vec<Vector3<f64>> = (frames.chunks_exact(count).step_by(step))
        .flatten()
        .copied()
        .collect();
    let (nearly, _) = aligned_mean(&sample, centred(&frames[..count]));
    aligned_mean(frames, nearly)
}

/// Alternates between aligning every frame to the shape and taking the mean of the aligned frames
/// for the new shape, until it no longer changes.
fn aligned_mean(frames: &[Vector3<f64>], mut shape: Vec<Vector3<f64>>) -> (Vec<Vector3<f64>>, f64) {
    let count = shape.len();
    let mut rms_m = 0.0;
    for _ in 0..MAX_ROUNDS {
        let chunks: Vec<Aligned> = frames
            .par_chunks(FRAMES_PER_CHUNK * count)
            .map(|chunk| Aligned::to(&shape, chunk))
            .collect();
        // A frame that cannot be aligned is degenerate; if all are, so is the shape, as
        // `in_own_axes` finds.
        let points = count * chunks.iter().map(|chunk| chunk.frames).sum::<usize>();
        if points == 0 {
            break;
        }
        let frames = (points / count) as f64;
        let mut mean = vec![Vector3::zeros(); count];
        for chunk in &chunks {
            for (mean, sum) in mean.iter_mut().zip(&chunk.sum) {
                *mean += sum / frames;
            }
        }
        let mean = centred(&mean);
        rms_m = (chunks.iter().map(|chunk| chunk.squares).sum::<f64>() / points as f64).sqrt();
        let change: f64 = (mean.iter().zip(&shape))
            .map(|(new, old)| (new - old).norm_squared())
            .sum();
        shape = mean;
        if (change / count as f64).sqrt() < SHAPE_TOLERANCE_M {
            break;
        }
    }
    (shape, rms_m)
}

/// Sums over frames aligned to a shape.
struct Aligned {
    /// Sum of each aligned point.
    sum: Vec<Vector3<f64>>,
    /// Sum of the squared distances of all points from the shape.
    squares: f64,
    /// Frames that could be aligned.
    frames: usize,
}

impl Aligned {
    fn to(shape: &[Vector3<f64>], frames: &[Vector3<f64>]) -> Self {
        let mut aligned = Self {
            sum: vec![Vector3::zeros(); shape.len()],
            squares: 0.0,
            frames: 0,
        };
        for frame in frames.chunks_exact(shape.len()) {
            let Some(fit) = rigid_fit(frame, shape) else {
                continue;
            };
            aligned.frames += 1;
            for ((sum, point), place) in aligned.sum.iter_mut().zip(frame).zip(shape) {
                let point = fit.isometry.rotation * point + fit.isometry.translation.vector;
                *sum += point;
                aligned.squares += (point - place).norm_squared();
            }
        }
        aligned
    }
}

fn centred(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let centre = centroid(points);
    points.iter().map(|point| point - centre).collect()
}

/// Turns a centred shape into the axes that its first three points define.
fn in_own_axes(
    shape: &[Vector3<f64>],
    role: BodyRole,
    names: &[String],
) -> Result<Vec<Vector3<f64>>, MotionError> {
    let collinear = |count: usize, spread: f64| {
        let (names, spread, least) = (listed(&names[..count]), 100.0 * spread, 100.0 * MIN_SPREAD);
        MotionError::Body(format!(
            "the markers {names} of the {role} lie on a line: they spread {spread:.1} % as far across it \
             as along it, expected {least:.0} % at least; name markers that span a triangle"
        ))
    };
    for points in [shape, &shape[..3]] {
        let spread = rigid_fit(points, points).map_or(0.0, |fit| fit.spread);
        if spread < MIN_SPREAD {
            return Err(collinear(points.len(), spread));
        }
    }
    let first_to_second = shape[1] - shape[0];
    let normal = first_to_second.cross(&(shape[2] - shape[0]));
    let axes = (first_to_second.try_normalize(0.0)).zip(normal.try_normalize(0.0));
    // Two of three points that coincide lie on a line with the third, which was refused above unless
    // rounding hid it.
    let (x, z) = axes.ok_or_else(|| collinear(3, 0.0))?;
    let body_from_shape =
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]).transpose());
    Ok(shape.iter().map(|point| body_from_shape * point).collect())
}
