//! The instants behind an evaluation as a table: a row for each method, segment and sample.

use inhand_model::{EvaluationRows, Finger, MethodRows, PerFinger};

use crate::table::{Column, Table, Values};

/// A table of every judged instant, for whoever computes its own numbers or draws its own figures.
///
/// Columns: `session`, `method`, `take`; `segment` (counted over all takes, from 0), `start_sample` of the
/// segment in its take, `sample` inside the segment, `time_s` since the segment's first sample; for each
/// finger `FINGER.error_m`, `FINGER.filled` (1 where the recorded fingertip was filled), and, where an
/// object is known, `FINGER.distance_m` and `FINGER.recorded_distance_m` (signed, to its surface) and once
/// `object_filled`; `FINGER.hull_distance_m` (signed, to the training hull) and
/// `FINGER.recorded_hull_distance_m`; `nearest_pair_m` and `recorded_nearest_pair_m`; where a method plans them,
/// `FINGER.mahalanobis` (of the recorded fingertip from the corridor, no unit), `object_position_error_m` and
/// `object_angle_error_rad`. A blank cell
/// is a number that does not exist: the plan failed, or the object is missing.
pub fn evaluation_rows<'a>(session: &'a str, rows: &'a EvaluationRows) -> Table<'a> {
    let instants = rows.instants();
    let samples = rows.layout.samples.max(1);
    let place = move |row: usize| {
        let instant = row % instants.max(1);
        (instant / samples, instant % samples)
    };
    // A table without rows is asked for no cell.
    let method = move |row: usize| &rows.methods[row / instants.max(1)];
    let origin = move |row: usize| rows.segments[place(row).0];

    let mut columns = vec![
        words("session", move |_| session),
        words("method", move |row| &method(row).name),
        words("take", move |row| &rows.takes[origin(row).take]),
        counts("segment", move |row| place(row).0),
        counts("start_sample", move |row| origin(row).start),
        counts("sample", move |row| place(row).1),
        numbers("time_s".to_owned(), "s", move |row| {
            place(row).1 as f64 / rows.layout.rate_hz
        }),
    ];
    for finger in Finger::ALL {
        let of = move |part: fn(&MethodRows) -> Option<&Vec<PerFinger<f64>>>, row: usize| {
            part(method(row)).map_or(f64::NAN, |values| values[row % instants.max(1)][finger])
        };
        let name = |suffix: &str| format!("{}.{suffix}", finger.name());
        columns.push(numbers(name("error_m"), "m", move |row| {
            of(|method| Some(&method.error_m), row)
        }));
        columns.push(counts(&name("filled"), move |row| {
            usize::from(rows.filled[row % instants.max(1)][finger])
        }));
        if let Some(recorded_m) = &rows.recorded_distance_m {
            columns.push(numbers(name("distance_m"), "m", move |row| {
                of(|method| method.distance_m.as_ref(), row)
            }));
            columns.push(numbers(name("recorded_distance_m"), "m", move |row| {
                recorded_m[row % instants.max(1)][finger]
            }));
        }
        columns.push(numbers(name("hull_distance_m"), "m", move |row| {
            of(|method| Some(&method.hull_distance_m), row)
        }));
        columns.push(numbers(name("recorded_hull_distance_m"), "m", move |row| {
            rows.recorded_hull_distance_m[row % instants.max(1)][finger]
        }));
        if rows
            .methods
            .iter()
            .any(|method| method.mahalanobis.is_some())
        {
            columns.push(numbers(name("mahalanobis"), "1", move |row| {
                of(|method| method.mahalanobis.as_ref(), row)
            }));
        }
    }
    if rows.recorded_distance_m.is_some() {
        columns.push(counts("object_filled", move |row| {
            usize::from(rows.object_filled[row % instants.max(1)])
        }));
    }
    columns.push(numbers("nearest_pair_m".to_owned(), "m", move |row| {
        method(row).nearest_pair_m[row % instants.max(1)]
    }));
    columns.push(numbers(
        "recorded_nearest_pair_m".to_owned(),
        "m",
        move |row| rows.recorded_nearest_pair_m[row % instants.max(1)],
    ));
    let plans_object = |method: &MethodRows| method.object_position_error_m.is_some();
    if rows.methods.iter().any(plans_object) {
        let of = move |part: fn(&MethodRows) -> Option<&Vec<f64>>, row: usize| {
            part(method(row)).map_or(f64::NAN, |values| values[row % instants.max(1)])
        };
        columns.push(numbers(
            "object_position_error_m".to_owned(),
            "m",
            move |row| of(|method| method.object_position_error_m.as_ref(), row),
        ));
        columns.push(numbers(
            "object_angle_error_rad".to_owned(),
            "rad",
            move |row| of(|method| method.object_angle_error_rad.as_ref(), row),
        ));
    }
    Table {
        columns,
        rows: rows.methods.len() * instants,
    }
}

pub(crate) fn words<'a>(name: &str, word: impl Fn(usize) -> &'a str + Sync + 'a) -> Column<'a> {
    Column {
        name: name.to_owned(),
        unit: "",
        frame: "",
        values: Values::Words(Box::new(word)),
    }
}

pub(crate) fn counts<'a>(name: &str, count: impl Fn(usize) -> usize + Sync + 'a) -> Column<'a> {
    Column {
        name: name.to_owned(),
        unit: "1",
        frame: "",
        // Lists in memory have far fewer places than 63 bits count.
        values: Values::Counts(Box::new(move |row| count(row) as i64)),
    }
}

pub(crate) fn numbers<'a>(
    name: String,
    unit: &'static str,
    number: impl Fn(usize) -> f64 + Sync + 'a,
) -> Column<'a> {
    Column {
        name,
        unit,
        frame: "",
        values: Values::Numbers(Box::new(number)),
    }
}
