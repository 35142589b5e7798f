//! Shapes of manipulated objects.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A solid centred on the origin of the object frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A box with edges along x, y, z, metres.
    Cuboid {
        /// Edge lengths, metres.
        edges_m: [f64; 3],
    },
    /// A cylinder with its axis along z, metres.
    Cylinder {
        /// Diameter, metres.
        diameter_m: f64,
        /// Height along z, metres.
        height_m: f64,
    },
}

impl Shape {
    /// Words that are a shape, for errors.
    pub const EXPECTED: &str =
        "cube:EDGE, box:XxYxZ or cylinder:DIAMETERxHEIGHT in metres, such as cube:0.05";
}

/// Why a word is no shape.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("expected {}, found \"{found}\"", Shape::EXPECTED)]
pub struct ShapeError {
    /// What was found.
    pub found: String,
}

impl FromStr for Shape {
    type Err = ShapeError;

    /// `cube:0.05`, `box:0.04x0.05x0.06`, `cylinder:0.05x0.05` (diameter x height), metres; in any case.
    fn from_str(text: &str) -> Result<Self, ShapeError> {
        let error = || ShapeError {
            found: text.to_owned(),
        };
        let lower = text.to_lowercase();
        let (kind, sizes) = lower.split_once(':').ok_or_else(error)?;
        let sizes_m = sizes
            .split('x')
            .map(|size| {
                size.trim()
                    .parse::<f64>()
                    .ok()
                    .filter(|&s| s.is_finite() && s > 0.0)
            })
            .collect::<Option<Vec<_>>>()
            .ok_or_else(error)?;
        match (kind.trim(), sizes_m.as_slice()) {
            ("cube", &[edge]) => Ok(Shape::Cuboid { edges_m: [edge; 3] }),
            ("box", &[x, y, z]) => Ok(Shape::Cuboid { edges_m: [x, y, z] }),
            ("cylinder", &[diameter_m, height_m]) => Ok(Shape::Cylinder {
                diameter_m,
                height_m,
            }),
            _ => Err(error()),
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::Cuboid { edges_m: [x, y, z] } if x == y && y == z => write!(f, "cube:{x}"),
            Shape::Cuboid { edges_m: [x, y, z] } => write!(f, "box:{x}x{y}x{z}"),
            Shape::Cylinder {
                diameter_m,
                height_m,
            } => write!(f, "cylinder:{diameter_m}x{height_m}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_round_trips() {
        for text in ["cube:0.05", "box:0.04x0.05x0.06", "cylinder:0.05x0.07"] {
            assert_eq!(text.parse::<Shape>().unwrap().to_string(), text);
            let upper = text.to_uppercase();
            assert_eq!(upper.parse::<Shape>().unwrap().to_string(), text);
        }
        for text in [
            "",
            "cube",
            "cube:",
            "cube:-1",
            "cube:0",
            "cube:nan",
            "sphere:1",
            "cylinder:1",
            "box:1x2",
        ] {
            assert!(text.parse::<Shape>().is_err(), "{text}");
        }
    }
}
