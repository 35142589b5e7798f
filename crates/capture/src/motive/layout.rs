//! Columns of markers and bodies.

use std::collections::BTreeMap;

use inhand_model::{BodyKind, Finding, LengthUnit, MarkerKind, RotationOrder, Setting};

use super::header::Header;
use crate::assembly::{RotationColumns, Series};
use crate::error::CaptureError;
use crate::table::{Column, Table};
use crate::text::is_unlabelled;

/// Columns named in the finding about those not read; the rest is counted.
const NAMED_UNREAD: usize = 4;

/// Meaning of the columns of a file.
pub(super) struct ColumnLayout {
    pub(super) table: Table,
    pub(super) series: Vec<Series>,
    /// Notation of rotations; `None` where there are none.
    pub(super) rotation: Option<RotationOrder>,
    pub(super) findings: Vec<Finding>,
    /// The finding about coordinates that are not in the world.
    pub(super) local_space: Option<Finding>,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum EntityType {
    RigidBody,
    Bone,
    FittedMarker,
    Marker,
}

impl EntityType {
    fn parse(text: &str) -> Option<Self> {
        Some(match text.to_ascii_lowercase().as_str() {
            "rigid body" => Self::RigidBody,
            "bone" => Self::Bone,
            "rigid body marker" | "bone marker" => Self::FittedMarker,
            "marker" => Self::Marker,
            _ => return None,
        })
    }

    fn is_body(self) -> bool {
        matches!(self, Self::RigidBody | Self::Bone)
    }
}

// Places of an entity's columns in `Candidate::columns`.
const ROTATION: usize = 0; // x, y, z, w
const POSITION: usize = 4; // x, y, z
const EXTRA: usize = 7; // quality of a marker, error of a body
const PLACES: usize = 8;

/// The place of a column among those of its entity, unless it is of no use to it.
fn place(entity: EntityType, kind: &str, axis: &str) -> Option<usize> {
    let axis = axis.to_ascii_lowercase();
    let axis_number = || "xyzw".find(axis.as_str()).filter(|_| axis.len() == 1);
    match kind.to_ascii_lowercase().as_str() {
        "rotation" if entity.is_body() => Some(ROTATION + axis_number()?),
        "position" => Some(POSITION + axis_number().filter(|&number| number < 3)?),
        "error per marker" | "mean marker error" if entity.is_body() => Some(EXTRA),
        "marker quality" if !entity.is_body() => Some(EXTRA),
        _ => None,
    }
}

/// An entity while its columns are collected.
struct Candidate<'a> {
    entity: EntityType,
    name: &'a str,
    id: &'a str,
    /// Column of the file and place among the values of a row.
    columns: [Option<(usize, usize)>; PLACES],
}

impl ColumnLayout {
    /// Groups the columns into entities.
    ///
    /// # Errors
    ///
    /// A marker or body lacks columns, a body's columns do not fit the rotation order, or there are
    /// three rotation columns without any.
    pub(super) fn new(
        header: &Header<'_>,
        order: Option<RotationOrder>,
        length_unit: Option<LengthUnit>,
    ) -> Result<Self, CaptureError> {
        let mut table = Table::new(header.facts.file, header.delimiter);
        let (candidates, unread) = collect(header, &mut table)?;
        let mut rotation = None;
        let mut series = Vec::with_capacity(candidates.len());
        for candidate in &candidates {
            series.push(match candidate.entity.is_body() {
                true => {
                    let (body, order) = candidate.body(header, order, length_unit)?;
                    rotation = rotation.or(Some(order));
                    body
                }
                false => candidate.marker(header)?,
            });
        }
        let has = |entity| {
            candidates
                .iter()
                .any(|candidate| candidate.entity == entity)
        };
        Ok(Self {
            local_space: local_space(header, has(EntityType::Bone), has(EntityType::FittedMarker)),
            table,
            series,
            rotation,
            findings: unread_findings(&unread),
        })
    }
}

/// Columns that Motive's manual describes and that hold nothing for a take, without spaces, lower case.
const DOCUMENTED: [&str; 3] = ["timecode", "size", "markersize"];

/// Column that is not read.
struct Unread {
    column: usize,
    name: String,
    is_documented: bool,
}

impl Unread {
    fn new(column: usize, cells: [&str; 5], has_entity: bool) -> Self {
        let [of, name, _, kind, axis] = cells;
        let name = match has_entity {
            true => format!("\"{name}\" {kind} {axis}"),
            false => format!("{of} {name} {kind} {axis}"),
        };
        let words = |cell: &str| cell.split_whitespace().collect::<String>().to_lowercase();
        Self {
            column,
            name,
            is_documented: [kind, axis]
                .iter()
                .any(|cell| DOCUMENTED.contains(&&*words(cell))),
        }
    }
}

/// Adds all columns to a table; the entities they belong to, and the columns that are not read.
fn collect<'a>(
    header: &'a Header<'_>,
    table: &mut Table,
) -> Result<(Vec<Candidate<'a>>, Vec<Unread>), CaptureError> {
    let mut candidates: Vec<Candidate<'_>> = Vec::new();
    let mut latest: BTreeMap<(EntityType, &str, &str), usize> = BTreeMap::new();
    let mut unread = Vec::new();
    for c in 0..header.width() {
        let [of, name, id, kind, axis] = header.column(c);
        let [of, kind, axis] = [of, kind, axis].map(str::trim);
        let label = match c < 2 || name.is_empty() {
            true => format!("{kind} {axis}").trim().to_owned(),
            false => format!("\"{name}\" {kind} {axis}").trim().to_owned(),
        };
        if c < 2 {
            let is_time = axis.to_ascii_lowercase().starts_with("time") && !axis.contains("ode");
            let column = match c {
                0 => Column::Frame,
                _ if is_time => Column::Time,
                _ => Column::Skip,
            };
            table.push(column, label);
            continue;
        }
        let entity = EntityType::parse(of);
        let Some((entity, place)) =
            entity.and_then(|entity| Some((entity, place(entity, kind, axis)?)))
        else {
            let cells = [of, name, id, kind, axis];
            let column = Unread::new(c, cells, entity.is_some());
            if of.is_empty() && !kind.is_empty() && !column.is_documented {
                let expected =
                    format!("a type such as Marker for column {} ({kind} {axis})", c + 1);
                let (file, line) = (header.facts.file, header.axes_line);
                return Err(CaptureError::header(file, line, expected, "none"));
            }
            if cells.iter().any(|cell| !cell.trim().is_empty()) {
                unread.push(column);
            }
            table.push(Column::Skip, label);
            continue;
        };
        let fresh = candidates.len();
        let known = latest.entry((entity, name, id)).or_insert(fresh);
        // Entities may share type, name and ID; a column that is there already starts the next.
        if (candidates.get(*known)).is_none_or(|known| known.columns[place].is_some()) {
            *known = fresh;
            candidates.push(Candidate {
                entity,
                name,
                id,
                columns: [None; PLACES],
            });
        }
        candidates[*known].columns[place] = Some((c, table.push_value(label)));
    }
    Ok((candidates, unread))
}

impl Candidate<'_> {
    /// The place of a column among the values of a row.
    fn at(&self, place: usize) -> Option<usize> {
        self.columns[place].map(|(_, value)| value)
    }

    /// The places of three columns that follow each other.
    fn three(&self, first: usize) -> Option<[usize; 3]> {
        let [x, y, z] = [first, first + 1, first + 2].map(|place| self.at(place));
        Some([x?, y?, z?])
    }

    fn marker(&self, header: &Header<'_>) -> Result<Series, CaptureError> {
        let position = self.three(POSITION);
        let position = position.ok_or_else(|| self.incomplete(header, "Position X, Y, Z"))?;
        let kind = match self.entity {
            EntityType::FittedMarker => MarkerKind::RigidBodyMarker,
            _ if is_unlabelled(self.name) => MarkerKind::Unlabelled,
            _ => MarkerKind::Labelled,
        };
        let quality = self.at(EXTRA);
        Ok(Series::marker(self.name, self.id, kind, position, quality))
    }

    fn body(
        &self,
        header: &Header<'_>,
        order: Option<RotationOrder>,
        length_unit: Option<LengthUnit>,
    ) -> Result<(Series, RotationOrder), CaptureError> {
        let (Some(position), Some(angles)) = (self.three(POSITION), self.three(ROTATION)) else {
            let expected = "Rotation X, Y, Z (and W) and Position X, Y, Z";
            return Err(self.incomplete(header, expected));
        };
        let file = header.facts.file;
        let contradiction = |columns: &str, given: RotationOrder| {
            let option = match header.facts.get("Rotation Type") {
                None => Setting::RotationOrder.to_string(),
                Some(_) => "\"Rotation Type\"".to_owned(),
            };
            let stated = format!("{columns} for body \"{}\"", self.name);
            CaptureError::contradiction(file, option, given, stated)
        };
        let (rotation, order) = match (self.at(ROTATION + 3), order) {
            (Some(w), None | Some(RotationOrder::Quaternion)) => {
                let [x, y, z] = angles;
                let columns = RotationColumns::Quaternion([x, y, z, w]);
                (columns, RotationOrder::Quaternion)
            }
            (None, Some(order @ RotationOrder::Euler(axes))) => {
                (RotationColumns::Euler { angles, axes }, order)
            }
            (None, None) => return Err(self.no_rotation_order(file, length_unit)),
            (Some(_), Some(given)) => {
                return Err(contradiction("four rotation columns, X, Y, Z, W,", given));
            }
            (None, Some(given)) => return Err(contradiction("three rotation columns", given)),
        };
        let kind = match self.entity {
            EntityType::Bone => BodyKind::Bone,
            _ => BodyKind::RigidBody,
        };
        let error = self.at(EXTRA);
        let body = Series::body(self.name, self.id, kind, rotation, position, error);
        Ok((body, order))
    }

    /// Names what is unknown of the unit too, so that one run shows both.
    fn no_rotation_order(&self, file: &str, length_unit: Option<LengthUnit>) -> CaptureError {
        let units = match length_unit {
            Some(_) => String::new(),
            None => format!(
                "; it has no \"Length Units\" either: say it with {} (metres, centimetres, \
                 millimetres, inches, feet)",
                Setting::Units
            ),
        };
        let problem = format!(
            "the header has no \"Rotation Type\" and body \"{}\" has three rotation columns: say \
             in which order the angles apply with {} (XYZ, XZY, YXZ, YZX, ZXY or ZYX){units}",
            self.name,
            Setting::RotationOrder
        );
        CaptureError::in_file(file, problem)
    }

    fn incomplete(&self, header: &Header<'_>, expected: &str) -> CaptureError {
        let mut present: Vec<usize> = self.columns.iter().flatten().map(|&(c, _)| c).collect();
        present.sort_unstable();
        let names = present.iter().map(|&c| {
            let [.., kind, axis] = header.column(c);
            format!("{kind} {axis}").trim().to_owned()
        });
        let problem = format!(
            "{} \"{}\" has only {}: expected {expected}; export the take again with all its columns",
            if self.entity.is_body() {
                "body"
            } else {
                "marker"
            },
            self.name,
            names.collect::<Vec<_>>().join(", "),
        );
        let column = present.first().map_or(0, |first| first + 1);
        CaptureError::in_cell(header.facts.file, header.axes_line, column, problem)
    }
}

fn local_space(header: &Header<'_>, has_bones: bool, has_fitted: bool) -> Option<Finding> {
    const KEY: &str = "Coordinate Space";
    let space = header.facts.get(KEY)?;
    let bones = has_bones.then_some("poses of bones are relative to their parent bone");
    let markers =
        has_fitted.then_some("positions of rigid-body markers may be relative to their body");
    let local: Vec<&str> = bones.into_iter().chain(markers).collect();
    (space.eq_ignore_ascii_case("Local") && !local.is_empty()).then(|| {
        let message = format!(
            "Local: {}, not to the world: kept as they are",
            local.join(", ")
        );
        Finding::warning(KEY, message)
    })
}

/// Findings about columns that are not read: those that Motive's manual describes are no reason to worry.
fn unread_findings(unread: &[Unread]) -> Vec<Finding> {
    let finding = |is_documented: bool| {
        let columns = unread
            .iter()
            .filter(|column| column.is_documented == is_documented);
        let columns: Vec<&Unread> = columns.collect();
        let first = columns.first()?.column + 1;
        let named = columns.iter().take(NAMED_UNREAD).map(|column| {
            let words: Vec<&str> = column.name.split_whitespace().collect();
            format!("{} ({})", column.column + 1, words.join(" "))
        });
        let mut names: Vec<String> = named.collect();
        if columns.len() > NAMED_UNREAD {
            names.push(format!("{} more", columns.len() - NAMED_UNREAD));
        }
        let message = format!(
            "columns {} are neither position, rotation nor quality of a marker or body: not read",
            names.join(", ")
        );
        let place = format!("column {first}");
        Some(match is_documented {
            true => Finding::info(place, message),
            false => Finding::warning(place, message),
        })
    };
    [false, true].into_iter().filter_map(finding).collect()
}
