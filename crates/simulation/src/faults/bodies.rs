//! Bodies that take a wrong pose for a while.

use std::ops::Range;

use inhand_model::{Body, Pose, Position, Status};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::{Planting, log_uniform};
use crate::camera_system::Fit;
use crate::error::SimulationError;
use crate::random::Random;
use crate::take::FaultKind;

const FLIP_RANGE_S: (f64, f64) = (0.05, 1.5);
const TURN_CHANCE: f64 = 0.4;
/// How much larger the marker error is in a turn about an own axis.
const TURN_ERROR_RANGE: (f64, f64) = (1.0, 3.0);
/// Offset of such a turn along each axis at most, metres.
const TURN_OFFSET_M: f64 = 0.002;
const LOST_AT_FLIP_CHANCE: f64 = 0.3;
const LOST_AT_FLIP_RANGE_S: (f64, f64) = (0.01, 0.06);
/// Time between flips of a body, seconds.
const APART_S: f64 = 0.1;
/// Every order of three markers but the right one.
const WRONG_ORDERS: [[usize; 3]; 5] = [[1, 0, 2], [0, 2, 1], [2, 1, 0], [1, 2, 0], [2, 0, 1]];

/// Marker error of a wrong solution.
enum WrongError {
    Times(f64),
    Metres(f64),
}

impl Planting<'_> {
    pub(super) fn flips(
        &mut self,
        count: usize,
        random: &mut Random,
    ) -> Result<(), SimulationError> {
        let apart = self.in_samples(APART_S);
        let samples = self.recording.len();
        let mut taken: Vec<Vec<Range<usize>>> = vec![Vec::new(); self.recording.bodies.len()];
        for number in 1..=count {
            let body = random.below(self.recording.bodies.len());
            let len = self.in_samples(log_uniform(FLIP_RANGE_S, random));
            let stretch = (self.free_stretch(len, apart, &taken[body], random))
                .ok_or_else(|| self.crowded("flip", number, count))?;
            let markers = self.markers_of(body);
            let template = self.template(body, markers);
            let (true_from_recorded, error) = draw_wrong(&template, random);
            let wrong = (true_from_recorded, &error);
            self.flip(body, markers, &template, &stretch, wrong);
            for end in [stretch.start, stretch.end] {
                if random.chance(LOST_AT_FLIP_CHANCE) {
                    let len = self.in_samples(random.between(LOST_AT_FLIP_RANGE_S));
                    let start = end.saturating_sub(random.below(len + 1));
                    self.lose_body(body, markers, start..(start + len).min(samples));
                }
            }
            taken[body].push(stretch.clone());
            let name = self.recording.bodies[body].name.clone();
            self.add(FaultKind::Flip { true_from_recorded }, vec![name], stretch);
        }
        Ok(())
    }

    /// Bodies' markers come three each, in the order of the bodies, before all others.
    fn markers_of(&self, body: usize) -> [usize; 3] {
        [3 * body, 3 * body + 1, 3 * body + 2]
    }

    fn template(&self, body: usize, markers: [usize; 3]) -> [Position<Body>; 3] {
        let clean = &self.clean.recording;
        let body_from_world = clean.bodies[body].track.value(0).inverse();
        markers.map(|marker| body_from_world * clean.markers[marker].track.value(0))
    }

    fn flip(
        &mut self,
        body: usize,
        markers: [usize; 3],
        template: &[Position<Body>; 3],
        stretch: &Range<usize>,
        (true_from_recorded, error): (Isometry3<f64>, &WrongError),
    ) {
        for k in stretch.clone() {
            let tracked = &mut self.recording.bodies[body];
            let Some(pose) = tracked.track.get(k) else {
                continue;
            };
            let flipped = Pose::new(pose.isometry() * true_from_recorded);
            tracked.track.set(k, Some(flipped), Status::Measured);
            if let Some(error_m) = &mut tracked.marker_error_m {
                error_m[k] = match *error {
                    WrongError::Times(factor) => error_m[k] * factor,
                    WrongError::Metres(wrong_m) => error_m[k].hypot(wrong_m),
                };
            }
            for (marker, &place) in markers.into_iter().zip(template) {
                let track = &mut self.recording.markers[marker].track;
                track.set(k, Some(flipped * place), Status::Measured);
            }
        }
    }

    fn lose_body(&mut self, body: usize, markers: [usize; 3], samples: Range<usize>) {
        for k in samples {
            let tracked = &mut self.recording.bodies[body];
            tracked.track.set(k, None, Status::Missing);
            if let Some(error_m) = &mut tracked.marker_error_m {
                error_m[k] = f64::NAN;
            }
            for marker in markers {
                (self.recording.markers[marker].track).set(k, None, Status::Missing);
            }
        }
    }
}

fn draw_wrong(template: &[Position<Body>; 3], random: &mut Random) -> (Isometry3<f64>, WrongError) {
    let centre = template.iter().map(|m| m.coords_m()).sum::<Vector3<f64>>() / 3.0;
    if random.chance(TURN_CHANCE) {
        let axis = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()][random.below(3)];
        let quarters = [1.0, -1.0, 2.0][random.below(3)];
        let turn = UnitQuaternion::from_axis_angle(&axis, quarters * std::f64::consts::FRAC_PI_2);
        let mut off = || random.between((-TURN_OFFSET_M, TURN_OFFSET_M));
        let off = Vector3::new(off(), off(), off());
        let place = Translation3::from(centre - turn * centre + off);
        let error = WrongError::Times(random.between(TURN_ERROR_RANGE));
        return (Isometry3::from_parts(place, turn), error);
    }
    // The body as fitted when its markers are taken for one another: in its own true frame, marker
    // i of the template is seen where marker `order[i]` is.
    let order = WRONG_ORDERS[random.below(WRONG_ORDERS.len())];
    let seen = order.map(|marker| template[marker].coords_m());
    let near = Isometry3::from_parts(
        Translation3::identity(),
        triad(&seen) * triad(&template.map(Position::coords_m)).inverse(),
    );
    let fitted = Fit::new(template).pose(&seen, near);
    let off =
        (template.iter().zip(&seen)).map(|(m, seen)| ((fitted * m.point()).coords - seen).norm());
    let error_m = off.sum::<f64>() / 3.0;
    (fitted, WrongError::Metres(error_m))
}

/// Axes along the first side of a triangle and its normal.
fn triad([a, b, c]: &[Vector3<f64>; 3]) -> UnitQuaternion<f64> {
    let x = (b - a).normalize();
    let z = (b - a).cross(&(c - a)).normalize();
    let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}
