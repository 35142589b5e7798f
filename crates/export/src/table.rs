//! Tables: named columns with units over rows.

use std::collections::BTreeMap;

use inhand_model::Clock;

use crate::entity::Entity;

/// Components of a value in the order of columns, with the unit of each.
const COMPONENTS: [(&str, &str); 7] = [
    ("x_m", "m"),
    ("y_m", "m"),
    ("z_m", "m"),
    ("qx", "1"),
    ("qy", "1"),
    ("qz", "1"),
    ("qw", "1"),
];

/// A column of a table.
pub struct Column<'a> {
    /// Heading; has the unit in it where there is one.
    pub name: String,
    /// Unit: `m`, `s`, `1`, or nothing for words.
    pub unit: &'static str,
    /// Frame of a coordinate, else nothing.
    pub frame: &'static str,
    /// The cells.
    pub values: Values<'a>,
}

/// Cells of a column, by row.
pub enum Values<'a> {
    /// Numbers; NaN is a blank cell.
    Numbers(Box<dyn Fn(usize) -> f64 + Sync + 'a>),
    /// Whole numbers.
    Counts(Box<dyn Fn(usize) -> i64 + Sync + 'a>),
    /// Words.
    Words(Box<dyn Fn(usize) -> &'a str + Sync + 'a>),
}

/// Columns of one length.
pub struct Table<'a> {
    /// The columns.
    pub columns: Vec<Column<'a>>,
    /// Rows of each.
    pub rows: usize,
}

impl std::fmt::Debug for Table<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        write!(f, "Table({} rows of {})", self.rows, names.join(", "))
    }
}

/// Names of entities that differ: the second of a name is `name#2`.
pub(crate) fn unique_names(entities: &[Entity<'_>]) -> Vec<String> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let mut names: Vec<String> = Vec::with_capacity(entities.len());
    for entity in entities {
        let name = loop {
            let count = seen.entry(entity.name.clone()).or_insert(0);
            *count += 1;
            let name = match *count {
                1 => entity.name.clone(),
                n => format!("{}#{n}", entity.name),
            };
            // A source may itself name something `a#2`.
            if !names.contains(&name) {
                break name;
            }
        };
        names.push(name);
    }
    names
}

/// One row for each sample, and for each entity its columns: `NAME.x_m`, `.y_m`, `.z_m`, with a
/// rotation `.qx`, `.qy`, `.qz`, `.qw`, then `.status`, and what else the source says.
pub fn wide<'a>(entities: &'a [Entity<'a>], clock: Clock, samples: usize) -> Table<'a> {
    let mut columns = vec![time_column(move |row| clock.time_s(row))];
    for (entity, name) in entities.iter().zip(unique_names(entities)) {
        let components = if entity.has_rotation { 7 } else { 3 };
        for (component, (suffix, unit)) in COMPONENTS.iter().enumerate().take(components) {
            columns.push(Column {
                name: format!("{name}.{suffix}"),
                unit,
                frame: entity.frame,
                values: Values::Numbers(Box::new(move |row| number(entity, row, component))),
            });
        }
        columns.push(Column {
            name: format!("{name}.status"),
            unit: "",
            frame: "",
            values: Values::Words(Box::new(move |row| entity.track.status(row).name())),
        });
        if let Some((suffix, unit, series)) = entity.extra {
            columns.push(Column {
                name: format!("{name}.{suffix}"),
                unit,
                frame: "",
                values: Values::Numbers(Box::new(move |row| series[row])),
            });
        }
    }
    Table {
        columns,
        rows: samples,
    }
}

/// One row for each sample of each entity, all entities of a sample after one another.
pub fn tidy<'a>(entities: &'a [Entity<'a>], clock: Clock, samples: usize) -> Table<'a> {
    let count = entities.len();
    // Without entities there are no rows, so that nothing is divided by zero.
    let at = move |row: usize| (row / count, &entities[row % count]);
    let word = |name: &str, words: Box<dyn Fn(usize) -> &'a str + Sync + 'a>| Column {
        name: name.to_owned(),
        unit: "",
        frame: "",
        values: Values::Words(words),
    };
    let mut columns = vec![
        time_column(move |row| clock.time_s(at(row).0)),
        Column {
            name: "sample".to_owned(),
            unit: "1",
            frame: "",
            values: Values::Counts(Box::new(move |row| at(row).0 as i64)),
        },
        word("entity", Box::new(move |row| at(row).1.name.as_str())),
        word("kind", Box::new(move |row| at(row).1.kind)),
        word("frame", Box::new(move |row| at(row).1.frame)),
    ];
    for (component, (name, unit)) in COMPONENTS.iter().enumerate() {
        columns.push(Column {
            name: (*name).to_owned(),
            unit,
            frame: "",
            values: Values::Numbers(Box::new(move |row| {
                let (sample, entity) = at(row);
                number(entity, sample, component)
            })),
        });
    }
    columns.push(word(
        "status",
        Box::new(move |row| {
            let (sample, entity) = at(row);
            entity.track.status(sample).name()
        }),
    ));
    for (name, unit) in [("marker_error_m", "m"), ("quality", "1")] {
        columns.push(Column {
            name: name.to_owned(),
            unit,
            frame: "",
            values: Values::Numbers(Box::new(move |row| {
                let (sample, entity) = at(row);
                match entity.extra {
                    Some((extra, _, series)) if extra == name => series[sample],
                    _ => f64::NAN,
                }
            })),
        });
    }
    Table {
        columns,
        rows: samples * count,
    }
}

fn time_column<'a>(time_s: impl Fn(usize) -> f64 + Sync + 'a) -> Column<'a> {
    Column {
        name: "time_s".to_owned(),
        unit: "s",
        frame: "",
        values: Values::Numbers(Box::new(time_s)),
    }
}

/// A component of a value, NaN where missing.
fn number(entity: &Entity<'_>, sample: usize, component: usize) -> f64 {
    let value = entity.track.value(sample);
    let number = value.and_then(|(position, rotation)| match component {
        0..3 => Some(position[component]),
        _ => rotation.map(|quaternion| quaternion[component - 3]),
    });
    number.unwrap_or(f64::NAN)
}
