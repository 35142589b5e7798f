//! Coordinate frames as types, positions in them, and rigid transforms between them.
//!
//! The hand moves: `Hand` is another frame at every sample. No type catches a pose of one instant
//! applied to a point of another, so poses and points of one instant stay together in tracks.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Mul;

use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion, Vector3};

/// A coordinate frame. All frames are right-handed, in metres.
pub trait Frame: Copy + fmt::Debug + PartialEq + Send + Sync + 'static {
    /// The frame's name in files.
    const NAME: &'static str;
}

macro_rules! frames {
    ($($(#[$doc:meta])* $frame:ident = $name:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $frame;

        impl Frame for $frame {
            const NAME: &'static str = $name;
        }
    )*};
}

frames! {
    /// The capture volume, with the axes of the source file.
    World = "world";
    /// The rigid body on the back of the hand.
    Hand = "hand";
    /// The manipulated object, origin at its centre, cylinder axis along z.
    Object = "object";
    /// Any tracked rigid body whose role is not known.
    Body = "body";
}

/// A point, by its coordinates in frame `F`, metres.
#[derive(Clone, Copy, PartialEq)]
pub struct Position<F: Frame> {
    point: Point3<f64>,
    frame: PhantomData<F>,
}

impl<F: Frame> Position<F> {
    /// From coordinates in metres.
    pub const fn new(x_m: f64, y_m: f64, z_m: f64) -> Self {
        Self::from_point(Point3::new(x_m, y_m, z_m))
    }

    /// From a point with coordinates in metres.
    pub const fn from_point(point: Point3<f64>) -> Self {
        Self {
            point,
            frame: PhantomData,
        }
    }

    /// From a coordinate vector in metres.
    pub fn from_coords(coords_m: Vector3<f64>) -> Self {
        Self::from_point(Point3::from(coords_m))
    }

    /// The point without its frame.
    pub const fn point(self) -> Point3<f64> {
        self.point
    }

    /// Coordinates, metres.
    pub const fn coords_m(self) -> Vector3<f64> {
        self.point.coords
    }

    /// Coordinates as an array, metres.
    pub fn to_array(self) -> [f64; 3] {
        self.point.coords.into()
    }

    /// Whether every coordinate is a finite number.
    pub fn is_finite(self) -> bool {
        self.point.coords.iter().all(|c| c.is_finite())
    }

    /// Distance to another point of the same frame, metres.
    pub fn distance_m(self, other: Self) -> f64 {
        (self.point - other.point).norm()
    }
}

impl<F: Frame> From<[f64; 3]> for Position<F> {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self::new(x, y, z)
    }
}

impl<F: Frame> fmt::Debug for Position<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.to_array();
        write!(f, "{}({x}, {y}, {z})", F::NAME)
    }
}

/// A quaternion whose length is further from 1 than this is no rotation: six decimals leave 1e-6,
/// a spreadsheet set to three decimals 1e-3.
const QUATERNION_LENGTH_TOLERANCE: f64 = 1e-2;

/// Squared length up to which a quaternion counts as normalised already and is kept bit by bit.
const NORMALISED: f64 = 4.0 * f64::EPSILON;

/// A rotation from x, y, z, w as a file states them, unless their length is nowhere near 1. Its sign
/// is kept.
pub fn rotation_from_xyzw([x, y, z, w]: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    let quaternion = Quaternion::new(w, x, y, z);
    let squared = quaternion.norm_squared();
    if (squared - 1.0).abs() <= NORMALISED {
        return Some(UnitQuaternion::new_unchecked(quaternion));
    }
    let length = squared.sqrt();
    ((length - 1.0).abs() <= QUATERNION_LENGTH_TOLERANCE)
        .then(|| UnitQuaternion::new_unchecked(quaternion / length))
}

/// A rigid transform that takes coordinates in `From` to coordinates in `To`; equally the pose of
/// frame `From` seen from `To`. Named target-first: `hand_from_world: Pose<Hand, World>`.
#[derive(Clone, Copy, PartialEq)]
pub struct Pose<To: Frame, From: Frame> {
    isometry: Isometry3<f64>,
    frames: PhantomData<(To, From)>,
}

impl<To: Frame, From: Frame> Pose<To, From> {
    /// Wraps a transform whose translation is in metres.
    pub const fn new(isometry: Isometry3<f64>) -> Self {
        Self {
            isometry,
            frames: PhantomData,
        }
    }

    /// Both frames coincide.
    pub fn identity() -> Self {
        Self::new(Isometry3::identity())
    }

    /// The transform without its frames.
    pub const fn isometry(self) -> Isometry3<f64> {
        self.isometry
    }

    /// The opposite direction.
    pub fn inverse(self) -> Pose<From, To> {
        Pose::new(self.isometry.inverse())
    }

    /// Where the origin of `From` lies in `To`.
    pub fn origin(self) -> Position<To> {
        Position::from_coords(self.isometry.translation.vector)
    }

    /// Unit quaternion as `[x, y, z, w]`.
    pub fn quaternion_xyzw(self) -> [f64; 4] {
        self.isometry.rotation.coords.into()
    }

    /// Whether translation and rotation are finite numbers.
    pub fn is_finite(self) -> bool {
        self.origin().is_finite() && self.isometry.rotation.coords.iter().all(|c| c.is_finite())
    }
}

impl<To: Frame, From: Frame> fmt::Debug for Pose<To, From> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let t = self.isometry.translation.vector;
        let q = self.quaternion_xyzw();
        write!(f, "{}_from_{}({t:?}, xyzw {q:?})", To::NAME, From::NAME)
    }
}

impl<A: Frame, B: Frame, C: Frame> Mul<Pose<B, C>> for Pose<A, B> {
    type Output = Pose<A, C>;

    fn mul(self, rhs: Pose<B, C>) -> Pose<A, C> {
        Pose::new(self.isometry * rhs.isometry)
    }
}

impl<A: Frame, B: Frame> Mul<Position<B>> for Pose<A, B> {
    type Output = Position<A>;

    fn mul(self, rhs: Position<B>) -> Position<A> {
        Position::from_point(self.isometry * rhs.point)
    }
}
