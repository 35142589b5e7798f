//! Tables of fingers at samples of a take, a method after the other: generated motion, errors, contacts.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use inhand_model::{Clock, Configuration, Finger, PerFinger};

use crate::table::{Table, TableBuilder};

/// Layout of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableLayout {
    /// A row for each sample, columns for each entity.
    Wide,
    /// A row for each sample of each entity.
    Tidy,
}

/// N numbers of each finger at a sample of a take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerRow<'a, const N: usize> {
    /// Name of the method.
    pub method: &'a str,
    /// Sample of the take.
    pub sample: usize,
    /// The numbers; NaN where there is none.
    pub numbers: PerFinger<[f64; N]>,
}

/// Heading of a number of a finger, with its unit, the unit alone, and the frame of a coordinate.
pub type FingerColumn = (&'static str, &'static str, &'static str);

/// Columns of [`motion_rows`]: position and velocity.
pub const MOTION_COLUMNS: [FingerColumn; 6] = [
    ("x_m", "m", "hand"),
    ("y_m", "m", "hand"),
    ("z_m", "m", "hand"),
    ("vx_m_s", "m/s", "hand"),
    ("vy_m_s", "m/s", "hand"),
    ("vz_m_s", "m/s", "hand"),
];

/// Positions of a method with their velocities, a row for each sample.
///
/// Velocities are central differences, at the first and the last sample of a trajectory those to its other sample.
/// `starts` are the samples at which trajectories start; where they are not known, velocities are NaN.
pub fn motion_rows<'a>(
    method: &'a str,
    configurations_m: &'a BTreeMap<usize, Configuration>,
    starts: Option<&'a BTreeSet<usize>>,
    rate_hz: f64,
) -> impl Iterator<Item = FingerRow<'a, 6>> {
    let row = move |(&sample, here): (&usize, &Configuration)| {
        let next = (configurations_m.get(&(sample + 1)))
            .filter(|_| starts.is_some_and(|starts| !starts.contains(&(sample + 1))));
        let before = (sample.checked_sub(1))
            .filter(|_| starts.is_some_and(|starts| !starts.contains(&sample)))
            .and_then(|before| configurations_m.get(&before));
        let steps = usize::from(next.is_some()) + usize::from(before.is_some());
        let (from, to) = (before.unwrap_or(here), next.unwrap_or(here));
        // Without a neighbour it is 0 / 0: NaN.
        let velocity = |k: usize| (to[k] - from[k]) * rate_hz / steps as f64;
        let numbers = PerFinger::from_fn(|finger| {
            let [x, y, z] = [0, 1, 2].map(|axis| 3 * finger.index() + axis);
            let [vx, vy, vz] = [x, y, z].map(velocity);
            [here[x], here[y], here[z], vx, vy, vz]
        });
        FingerRow {
            method,
            sample,
            numbers,
        }
    };
    configurations_m.iter().map(row)
}

/// A table of such rows: `method`, `sample`, `time_s`, then for each finger `FINGER.HEADING`; tidy has a row for each
/// finger and its name as `finger`.
pub fn finger_table<'a, const N: usize>(
    rows: Vec<FingerRow<'a, N>>,
    columns: [FingerColumn; N],
    clock: Clock,
    layout: TableLayout,
) -> Table<'a> {
    let rows: Arc<[FingerRow<'a, N>]> = rows.into();
    let each = match layout {
        TableLayout::Wide => 1,
        TableLayout::Tidy => Finger::COUNT,
    };
    let mut table = TableBuilder::new(rows.len() * each, move |row| {
        (rows[row / each], Finger::ALL[row % each])
    });
    table.words("method", |(row, _)| row.method);
    table.counts("sample", |(row, _)| row.sample);
    table.numbers("time_s", "s", move |(row, _)| clock.time_s(row.sample));
    let columns = columns.into_iter().enumerate();
    match layout {
        TableLayout::Wide => {
            for (finger, (k, (heading, unit, frame))) in
                (Finger::ALL.into_iter()).flat_map(|f| columns.clone().map(move |c| (f, c)))
            {
                let name = format!("{}.{heading}", finger.name());
                let number = move |(row, _): (FingerRow<'a, N>, _)| row.numbers[finger][k];
                table.numbers(name, unit, number).frame = frame;
            }
        }
        TableLayout::Tidy => {
            table.words("finger", |(_, finger)| finger.name());
            for (k, (heading, unit, frame)) in columns {
                let number = move |(row, finger): (FingerRow<'a, N>, _)| row.numbers[finger][k];
                table.numbers(heading, unit, number).frame = frame;
            }
        }
    }
    table.finish()
}
