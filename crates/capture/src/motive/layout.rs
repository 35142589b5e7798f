//! Which columns make which marker or body.

use std::collections::BTreeMap;

use inhand_model::{BodyKind, Finding, MarkerKind, RotationOrder, Setting};

use super::header::Header;
use crate::assembly::{Entity, RotationColumns};
use crate::error::CaptureError;
use crate::table::Column;
use crate::text;

/// Columns named in the finding about those not read; the rest is counted.
const NAMED_UNREAD: usize = 4;

/// What the label rows say.
pub(super) struct Layout {
    pub(super) columns: Vec<Column>,
    pub(super) labels: Vec<String>,
    pub(super) entities: Vec<Entity>,
    pub(super) has_bones: bool,
    pub(super) has_fitted_markers: bool,
    /// How rotations are written; `None` where there are none.
    pub(super) rotation: Option<RotationOrder>,
    pub(super) findings: Vec<Finding>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Type {
    RigidBody,
    Bone,
    FittedMarker,
    Marker,
}

impl Type {
    fn parse(text: &str) -> Option<Self> {
        Some(match text.to_ascii_lowercase().as_str() {
            "rigid body" => Type::RigidBody,
            "bone" => Type::Bone,
            "rigid body marker" | "bone marker" => Type::FittedMarker,
            "marker" => Type::Marker,
            _ => return None,
        })
    }

    fn is_body(self) -> bool {
        matches!(self, Type::RigidBody | Type::Bone)
    }
}

// Places of an entity's columns in `Candidate::columns`.
const ROTATION: usize = 0; // x, y, z, w
const POSITION: usize = 4; // x, y, z
const MARKER_ERROR: usize = 7;
const QUALITY: usize = 8;
const PLACES: usize = 9;

/// The place of a column among those of its entity, unless it is of no use to it.
fn place(of: Type, kind: &str, axis: &str) -> Option<usize> {
    let axis_number = |axis: &str| "xyzw".find(axis).filter(|_| axis.len() == 1);
    match (
        kind.to_ascii_lowercase().as_str(),
        axis.to_ascii_lowercase().as_str(),
    ) {
        ("rotation", axis) if of.is_body() => Some(ROTATION + axis_number(axis)?),
        ("position", axis) => Some(POSITION + axis_number(axis).filter(|&number| number < 3)?),
        ("error per marker" | "mean marker error", _) if of.is_body() => Some(MARKER_ERROR),
        ("marker quality", _) if !of.is_body() => Some(QUALITY),
        _ => None,
    }
}

/// An entity while its columns are collected.
struct Candidate<'a> {
    of: Type,
    name: &'a str,
    id: &'a str,
    /// Columns of the file by place.
    columns: [Option<usize>; PLACES],
}

/// Groups the columns into entities.
///
/// # Errors
///
/// [`CaptureError`] where a marker or body lacks columns, a body's columns do not fit the rotation
/// type, or three rotation columns stand without any.
pub(super) fn resolve(
    header: &Header,
    file: &str,
    order: Option<RotationOrder>,
) -> Result<Layout, CaptureError> {
    let width = [
        &header.axes,
        &header.kinds,
        &header.names,
        &header.types,
        &header.ids,
    ]
    .into_iter()
    .map(Vec::len)
    .max()
    .unwrap_or(0);
    let mut columns = vec![Column::Skip; width];
    columns[0] = Column::Frame;
    let mut candidates: Vec<Candidate<'_>> = Vec::new();
    let mut latest: BTreeMap<(Type, &str, &str), usize> = BTreeMap::new();
    let mut unread = Vec::new();

    for (c, column) in columns.iter_mut().enumerate().skip(1) {
        let [of, name, id, kind, axis] = [
            &header.types,
            &header.names,
            &header.ids,
            &header.kinds,
            &header.axes,
        ]
        .map(|row| row.get(c).map_or("", String::as_str));
        let [of, kind, axis] = [of, kind, axis].map(str::trim);
        if c == 1 && axis.to_ascii_lowercase().starts_with("time") && !axis.contains("ode") {
            *column = Column::Time;
            continue;
        }
        if c == 1
            || [of, name, id, kind, axis]
                .iter()
                .all(|cell| cell.trim().is_empty())
        {
            continue;
        }
        let Some(known) = Type::parse(of) else {
            if of.is_empty() && !kind.is_empty() {
                return Err(cut_label(header, file, c, kind, axis));
            }
            unread.push((c, format!("{of} {name} {kind} {axis}")));
            continue;
        };
        let Some(place) = place(known, kind, axis) else {
            unread.push((c, format!("\"{name}\" {kind} {axis}")));
            continue;
        };
        *column = Column::Value;
        let fresh = candidates.len();
        let entity = latest.entry((known, name, id)).or_insert(fresh);
        // Entities may share type, name and ID; a column that is there already starts the next.
        if candidates
            .get(*entity)
            .is_none_or(|candidate| candidate.columns[place].is_some())
        {
            *entity = fresh;
            candidates.push(Candidate {
                of: known,
                name,
                id,
                columns: [None; PLACES],
            });
        }
        candidates[*entity].columns[place] = Some(c);
    }

    let slots = slots(&columns);
    let mut layout = Layout {
        labels: labels(header, width),
        has_bones: candidates
            .iter()
            .any(|candidate| candidate.of == Type::Bone),
        has_fitted_markers: candidates
            .iter()
            .any(|candidate| candidate.of == Type::FittedMarker),
        columns,
        entities: Vec::with_capacity(candidates.len()),
        rotation: None,
        findings: unread_finding(&unread).into_iter().collect(),
    };
    for candidate in &candidates {
        let (entity, rotation) = candidate.entity(header, file, order, &slots)?;
        layout.rotation = layout.rotation.or(rotation);
        layout.entities.push(entity);
    }
    Ok(layout)
}

impl Candidate<'_> {
    fn entity(
        &self,
        header: &Header,
        file: &str,
        order: Option<RotationOrder>,
        slots: &[usize],
    ) -> Result<(Entity, Option<RotationOrder>), CaptureError> {
        let at = |place: usize| self.columns[place].map(|column| slots[column]);
        let all = |places: [usize; 3]| match places.map(at) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        let position = all([POSITION, POSITION + 1, POSITION + 2]);
        let (name, id) = (self.name.to_owned(), self.id.to_owned());
        if !self.of.is_body() {
            let Some(position) = position else {
                return Err(self.incomplete(header, file, "Position X, Y, Z"));
            };
            let kind = match self.of {
                Type::FittedMarker => MarkerKind::RigidBodyMarker,
                _ if text::is_unlabelled(self.name) => MarkerKind::Unlabelled,
                _ => MarkerKind::Labelled,
            };
            let marker = Entity::Marker {
                name,
                id,
                kind,
                position,
                quality: at(QUALITY),
            };
            return Ok((marker, None));
        }

        let angles = all([ROTATION, ROTATION + 1, ROTATION + 2]);
        let (Some(position), Some(angles)) = (position, angles) else {
            return Err(self.incomplete(
                header,
                file,
                "Rotation X, Y, Z (and W) and Position X, Y, Z",
            ));
        };
        let contradiction = |columns: &str, stated: RotationOrder| CaptureError::Contradiction {
            file: file.to_owned(),
            option: if header.fact("Rotation Type").is_none_or(str::is_empty) {
                Setting::RotationOrder.to_string()
            } else {
                "\"Rotation Type\"".to_owned()
            },
            given: stated.to_string(),
            stated: format!("{columns} for body \"{}\"", self.name),
        };
        let (rotation, order) = match (at(ROTATION + 3), order) {
            (Some(w), None | Some(RotationOrder::Quaternion)) => {
                let [x, y, z] = angles;
                (
                    RotationColumns::Quaternion([x, y, z, w]),
                    RotationOrder::Quaternion,
                )
            }
            (None, Some(RotationOrder::Euler(axes))) => (
                RotationColumns::Euler { angles, axes },
                RotationOrder::Euler(axes),
            ),
            (None, None) => {
                return Err(CaptureError::NoRotationOrder {
                    file: file.to_owned(),
                    entity: format!("body \"{}\"", self.name),
                    no_units: false,
                });
            }
            (Some(_), Some(stated)) => {
                return Err(contradiction("four rotation columns, X, Y, Z, W,", stated));
            }
            (None, Some(stated)) => {
                return Err(contradiction("three rotation columns", stated));
            }
        };
        let body = Entity::Body {
            name,
            id,
            kind: match self.of {
                Type::Bone => BodyKind::Bone,
                _ => BodyKind::RigidBody,
            },
            rotation,
            position,
            marker_error: at(MARKER_ERROR),
        };
        Ok((body, Some(order)))
    }

    fn incomplete(&self, header: &Header, file: &str, expected: &'static str) -> CaptureError {
        let mut present: Vec<usize> = self.columns.iter().flatten().copied().collect();
        present.sort_unstable();
        let names: Vec<String> = present
            .iter()
            .map(|&c| {
                format!(
                    "{} {}",
                    header.kinds[c],
                    header.axes.get(c).map_or("", String::as_str)
                )
                .trim()
                .to_owned()
            })
            .collect();
        CaptureError::Columns {
            file: file.to_owned(),
            line: header.axes_line,
            column: present.first().map_or(0, |first| first + 1),
            entity: format!(
                "{} \"{}\"",
                if self.of.is_body() { "body" } else { "marker" },
                self.name
            ),
            expected,
            found: format!("only {}", names.join(", ")),
        }
    }
}

/// For each column its place among the values of a row.
fn slots(columns: &[Column]) -> Vec<usize> {
    columns
        .iter()
        .scan(0, |next, &column| {
            let slot = *next;
            *next += usize::from(column == Column::Value);
            Some(slot)
        })
        .collect()
}

/// What messages call each column: `"Ring" Position Y`, `Frame`.
fn labels(header: &Header, width: usize) -> Vec<String> {
    (0..width)
        .map(|c| {
            let [name, kind, axis] = [&header.names, &header.kinds, &header.axes]
                .map(|row| row.get(c).map_or("", String::as_str));
            if c < 2 || name.is_empty() {
                format!("{kind} {axis}").trim().to_owned()
            } else {
                format!("\"{name}\" {kind} {axis}").trim().to_owned()
            }
        })
        .collect()
}

fn cut_label(header: &Header, file: &str, c: usize, kind: &str, axis: &str) -> CaptureError {
    CaptureError::Header {
        file: file.to_owned(),
        line: header.axes_line,
        expected: format!("a type such as Marker for column {} ({kind} {axis})", c + 1),
        found: "none".to_owned(),
        hint: "the header is cut; export the take again",
    }
}

fn unread_finding(unread: &[(usize, String)]) -> Option<Finding> {
    let (first, _) = unread.first()?;
    let mut names: Vec<String> = unread
        .iter()
        .take(NAMED_UNREAD)
        .map(|(c, what)| {
            let words: Vec<&str> = what.split_whitespace().collect();
            format!("{} ({})", c + 1, words.join(" "))
        })
        .collect();
    if unread.len() > NAMED_UNREAD {
        names.push(format!("{} more", unread.len() - NAMED_UNREAD));
    }
    Some(Finding::warning(
        format!("column {}", first + 1),
        format!(
            "columns {} are neither position, rotation nor quality of a marker or body: not read",
            names.join(", ")
        ),
    ))
}
