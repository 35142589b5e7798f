//! Serde adapters for numbers of documents: millimetres and degrees in the file, SI in the structs, and null for
//! a number that does not exist.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::finger::{HandAndFingers, PerFinger};

/// A number of a document, or null. A type of its own, because serde takes a missing `Option` for null and a missing
/// key must be an error.
#[derive(Serialize, Deserialize)]
pub(crate) struct Number(Option<f64>);

/// Numbers whose unit in a document differs from that in the struct. Not finite is null, and null is NaN.
pub(crate) trait Numbers: Sized {
    /// The form in the document.
    type Written: Serialize + DeserializeOwned;

    /// Changes every number to the unit of the document.
    fn write(&self, unit: fn(f64) -> f64) -> Self::Written;

    /// Changes every number back.
    fn read(written: Self::Written, unit: fn(f64) -> f64) -> Self;
}

/// A unit of a document. Its functions `serialize` and `deserialize` are those that serde's `with` calls.
pub(crate) trait Unit {
    /// From SI to the document.
    const WRITE: fn(f64) -> f64;
    /// From the document to SI.
    const READ: fn(f64) -> f64;

    fn serialize<T: Numbers, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        value.write(Self::WRITE).serialize(serializer)
    }

    fn deserialize<'de, T: Numbers, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        T::Written::deserialize(deserializer).map(|written| T::read(written, Self::READ))
    }
}

/// The unit of the struct.
pub(crate) struct AsIs;

impl Unit for AsIs {
    const WRITE: fn(f64) -> f64 = |si| si;
    const READ: fn(f64) -> f64 = |si| si;
}

/// Metres as millimetres, also for speeds.
pub(crate) struct Millimetres;

impl Unit for Millimetres {
    const WRITE: fn(f64) -> f64 = |metres| metres * 1e3;
    const READ: fn(f64) -> f64 = |mm| mm / 1e3;
}

/// Square metres as square millimetres.
pub(crate) struct SquareMillimetres;

impl Unit for SquareMillimetres {
    const WRITE: fn(f64) -> f64 = |square_metres| square_metres * 1e6;
    const READ: fn(f64) -> f64 = |mm2| mm2 / 1e6;
}

/// Radians as degrees.
pub(crate) struct Degrees;

impl Unit for Degrees {
    const WRITE: fn(f64) -> f64 = f64::to_degrees;
    const READ: fn(f64) -> f64 = f64::to_radians;
}

/// Millimetres in which null is infinity: the mean error of a method whose plans failed.
pub(crate) mod millimetres_or_infinite {
    use super::{Millimetres, Unit};
    use serde::{Deserializer, Serializer};

    pub(crate) fn serialize<S: Serializer>(metres: &f64, s: S) -> Result<S::Ok, S::Error> {
        Millimetres::serialize(metres, s)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
        let metres: f64 = Millimetres::deserialize(d)?;
        Ok(if metres.is_nan() {
            f64::INFINITY
        } else {
            metres
        })
    }
}

impl Numbers for f64 {
    type Written = Number;

    fn write(&self, unit: fn(f64) -> f64) -> Number {
        Number(Some(unit(*self)).filter(|value| value.is_finite()))
    }

    fn read(written: Number, unit: fn(f64) -> f64) -> Self {
        written.0.map_or(f64::NAN, unit)
    }
}

impl<T: Numbers> Numbers for Option<T> {
    type Written = Option<T::Written>;

    fn write(&self, unit: fn(f64) -> f64) -> Self::Written {
        self.as_ref().map(|value| value.write(unit))
    }

    fn read(written: Self::Written, unit: fn(f64) -> f64) -> Self {
        written.map(|value| T::read(value, unit))
    }
}

impl<T: Numbers> Numbers for Vec<T> {
    type Written = Vec<T::Written>;

    fn write(&self, unit: fn(f64) -> f64) -> Self::Written {
        self.iter().map(|value| value.write(unit)).collect()
    }

    fn read(written: Self::Written, unit: fn(f64) -> f64) -> Self {
        (written.into_iter())
            .map(|value| T::read(value, unit))
            .collect()
    }
}

/// Two ends of an interval.
impl Numbers for [f64; 2] {
    type Written = [Number; 2];

    fn write(&self, unit: fn(f64) -> f64) -> Self::Written {
        self.each_ref().map(|value| value.write(unit))
    }

    fn read(written: Self::Written, unit: fn(f64) -> f64) -> Self {
        written.map(|value| f64::read(value, unit))
    }
}

impl<T: Numbers> Numbers for PerFinger<T> {
    type Written = PerFinger<T::Written>;

    fn write(&self, unit: fn(f64) -> f64) -> Self::Written {
        self.each_ref().map(|value| value.write(unit))
    }

    fn read(written: Self::Written, unit: fn(f64) -> f64) -> Self {
        written.map(|value| T::read(value, unit))
    }
}

impl<T: Numbers> Numbers for HandAndFingers<T> {
    type Written = HandAndFingers<T::Written>;

    fn write(&self, unit: fn(f64) -> f64) -> Self::Written {
        HandAndFingers {
            all: self.all.write(unit),
            by_finger: self.by_finger.write(unit),
        }
    }

    fn read(written: Self::Written, unit: fn(f64) -> f64) -> Self {
        Self {
            all: T::read(written.all, unit),
            by_finger: PerFinger::read(written.by_finger, unit),
        }
    }
}

/// What belongs to methods, as objects with the method's name among their keys.
pub(crate) mod named {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Named<N, T> {
        name: N,
        #[serde(flatten)]
        value: T,
    }

    pub(crate) fn serialize<T: Serialize, S: Serializer>(
        methods: &[(String, T)],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(methods.iter().map(|(name, value)| Named { name, value }))
    }

    pub(crate) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<(String, T)>, D::Error> {
        let methods = Vec::<Named<String, T>>::deserialize(deserializer)?;
        Ok((methods.into_iter())
            .map(|Named { name, value }| (name, value))
            .collect())
    }
}
