//! Primitives that were learned elsewhere.

use std::fmt::Display;

use inhand_model::{DictionaryKind, OBJECT_COORDINATES, SEGMENT_COORDINATES, SegmentLayout};
use nalgebra::{DMatrix, DVector};

use super::{Variable, Variables};
use crate::error::ExportError;

/// Names under which primitives are looked for, and whether they are the rows there.
const PRIMITIVES: [(&str, bool); 4] = [
    ("primitives", false),
    ("W", false),
    // Attribute of scikit-learn's NMF and PCA after `fit(segments)`: rank x features.
    ("components_", true),
    ("components", true),
];

/// Names of the offset; the last is scikit-learn's PCA's.
const OFFSETS: [&str; 3] = ["offset_m", "offset", "mean_"];

/// No fingertip is farther from its hand; numbers above are not metres.
const FARTHEST_M: f64 = 10.0;

/// Primitives from outside, checked: what `inhand learn --primitives` goes on from.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Primitives as unit-length columns (rows x rank), without unit.
    pub primitives: DMatrix<f64>,
    /// Offset of each row, metres, where the file has one.
    pub offset_m: Option<DVector<f64>>,
}

/// Takes primitives from the variables of a file.
///
/// They are `primitives` or `W` (rows x rank), or `components_`, as scikit-learn has them after
/// `fit(segments)` (rank x rows). Rows are those of the layout. Beside them there may be an offset
/// (`offset_m`, `offset` or scikit-learn's `mean_`: a number for each row, or one for all). Columns are
/// scaled to unit length. Activations are not taken: they are those of other segments.
///
/// # Errors
///
/// [`ExportError::Content`] where the file has none or several, where sizes are not those of the
/// layout, for numbers that are not finite, below zero where the kind allows none, or not metres, and
/// for a primitive of nothing but zeros.
pub fn import_primitives(
    variables: &Variables,
    layout: SegmentLayout,
    kind: DictionaryKind,
) -> Result<Given, ExportError> {
    let source = Source {
        variables,
        layout,
        kind,
    };
    let (name, mut primitives) = source.primitives()?;
    let offset_m = source.offset_m()?;
    for (i, mut primitive) in primitives.column_iter_mut().enumerate() {
        let length = primitive.norm();
        // Below the smallest normal number dividing by it would not give unit length.
        if !(f64::MIN_POSITIVE..f64::INFINITY).contains(&length) {
            return Err(source.error(
                name,
                "primitives of a length above zero",
                format!("primitive {i} of length {length}"),
                "leave it out",
            ));
        }
        primitive /= length;
    }
    Ok(Given {
        primitives,
        offset_m,
    })
}

/// Variables with what an error about them has to say.
struct Source<'a> {
    variables: &'a Variables,
    layout: SegmentLayout,
    kind: DictionaryKind,
}

impl Source<'_> {
    fn error(
        &self,
        what: impl Display,
        expected: impl Display,
        found: impl Display,
        hint: impl Display,
    ) -> ExportError {
        let message = format!("{what}: expected {expected}, found {found}; {hint}");
        ExportError::Content(message)
    }

    /// A matrix of finite numbers; `None` where there is no such variable.
    fn matrix(&self, name: &str) -> Result<Option<&DMatrix<f64>>, ExportError> {
        let matrix = match self.variables.get(name) {
            None => return Ok(None),
            Some(Variable::Other(what)) => {
                let hint = "save it as a matrix of real numbers";
                return Err(self.error(name, "a matrix of real numbers", what, hint));
            }
            Some(Variable::Numbers(matrix)) => matrix,
        };
        match matrix.as_slice().iter().position(|v| !v.is_finite()) {
            None => Ok(Some(matrix)),
            Some(at) => Err(self.error(
                name,
                "finite numbers",
                place(matrix, at),
                "learn it again without what is missing",
            )),
        }
    }

    fn not_negative(&self, name: &str, matrix: &DMatrix<f64>) -> Result<(), ExportError> {
        if self.kind != DictionaryKind::Nmf {
            return Ok(());
        }
        match matrix.as_slice().iter().position(|&v| v < 0.0) {
            None => Ok(()),
            Some(at) => Err(self.error(
                name,
                "no number below zero in a non-negative factorisation",
                place(matrix, at),
                "use it as principal components, or learn it by NMF",
            )),
        }
    }

    /// The primitives as columns, and the name that they have.
    fn primitives(&self) -> Result<(&'static str, DMatrix<f64>), ExportError> {
        let mut there = (PRIMITIVES.iter()).filter(|(name, _)| self.variables.contains_key(*name));
        let Some(&(name, as_rows)) = there.next() else {
            return Err(self.no_primitives());
        };
        if let Some((second, _)) = there.next() {
            return Err(self.error(
                "the primitives",
                "one of primitives, W and components_",
                format!("{name} and {second}"),
                "save one of them alone",
            ));
        }
        let Some(matrix) = self.matrix(name)? else {
            return Err(self.no_primitives());
        };
        self.check_size(name, matrix, as_rows)?;
        self.not_negative(name, matrix)?;
        let columns = if as_rows {
            matrix.transpose()
        } else {
            matrix.clone()
        };
        Ok((name, columns))
    }

    fn no_primitives(&self) -> ExportError {
        let names: Vec<_> = self.variables.keys().take(20).map(String::as_str).collect();
        let hint = if self.variables.contains_key("H") {
            "H is ambiguous: scikit-learn's holds primitives as rows where segments are rows (save it \
             as components_), that of V = W H holds activations (save W as well)"
        } else {
            "save them under one of these names"
        };
        self.error(
            "the primitives",
            "primitives or W (rows x rank), or scikit-learn's components_ (rank x rows)",
            if names.is_empty() {
                "no variable".to_owned()
            } else {
                names.join(", ")
            },
            hint,
        )
    }

    fn check_size(
        &self,
        name: &str,
        matrix: &DMatrix<f64>,
        as_rows: bool,
    ) -> Result<(), ExportError> {
        let rows = self.layout.rows();
        let (long, rank) = if as_rows {
            (matrix.ncols(), matrix.nrows())
        } else {
            matrix.shape()
        };
        if long == rows && rank > 0 {
            return Ok(());
        }
        let expected = if as_rows {
            format!("rank x {rows} numbers")
        } else {
            format!("{rows} x rank numbers")
        };
        let expected = format!("{expected} ({})", shape(self.layout));
        let found = format!("{} x {}", matrix.nrows(), matrix.ncols());
        let other = SegmentLayout {
            object: !self.layout.object,
            ..self.layout
        };
        let hint = if rank == rows {
            format!("it looks transposed: save the transpose of {name}")
        } else if name == "W" && self.columns_of("H") == Some(rows) {
            "in this file segments are rows, so that H holds the primitives: save H as components_"
                .to_owned()
        } else if long == other.rows() {
            format!("it looks like one for {}", shape(other))
        } else {
            "learn from segments of this length and rate, ordered time, finger (thumb to little), axis"
                .to_owned()
        };
        Err(self.error(name, expected, found, hint))
    }

    fn columns_of(&self, name: &str) -> Option<usize> {
        Some(self.variables.get(name)?.numbers()?.ncols())
    }

    fn offset_m(&self) -> Result<Option<DVector<f64>>, ExportError> {
        for name in OFFSETS {
            let Some(offset) = self.matrix(name)? else {
                continue;
            };
            let rows = self.layout.rows();
            let one_for_all = offset.len() == 1;
            let is_vector = offset.nrows() == 1 || offset.ncols() == 1;
            if !(one_for_all || is_vector && offset.len() == rows) {
                let expected = format!("one number or {rows}");
                let found = format!("{} x {}", offset.nrows(), offset.ncols());
                let hint = "save the offset of each row of the primitives";
                return Err(self.error(name, expected, found, hint));
            }
            if let Some(at) = (offset.as_slice().iter()).position(|v| v.abs() > FARTHEST_M) {
                return Err(self.error(
                    name,
                    format!("metres, at most {FARTHEST_M}"),
                    place(offset, at),
                    "if it is in millimetres, divide it by 1000",
                ));
            }
            return Ok(Some(if one_for_all {
                DVector::from_element(rows, offset[0])
            } else {
                DVector::from_column_slice(offset.as_slice())
            }));
        }
        Ok(None)
    }
}

/// The number at this place of a matrix, in words.
fn place(matrix: &DMatrix<f64>, at: usize) -> String {
    let (row, column) = (at % matrix.nrows(), at / matrix.nrows());
    format!(
        "{} in row {row}, column {column} (from 0)",
        matrix.as_slice()[at]
    )
}

fn shape(layout: SegmentLayout) -> String {
    let (each, what) = if layout.object {
        (
            SEGMENT_COORDINATES + OBJECT_COORDINATES,
            "fingertips and object",
        )
    } else {
        (SEGMENT_COORDINATES, "fingertips")
    };
    format!(
        "{what}: {each} numbers at each of {} samples, {} Hz",
        layout.samples, layout.rate_hz
    )
}

#[cfg(test)]
mod tests;
