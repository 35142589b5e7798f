//! Tables of fingers at samples of a take, a method after the other: generated motion, errors, contacts.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use inhand_model::{Clock, ClockError, Configuration, Finger, PerFinger, StartTime, Trajectory};

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

/// Columns of errors.
pub const ERROR_COLUMNS: [FingerColumn; 1] = [("error_m", "m", "")];

/// Columns of contacts: distance to the object's surface, and 1 where that is contact.
pub const CONTACT_COLUMNS: [FingerColumn; 2] = [("distance_m", "m", ""), ("in_contact", "1", "")];

const MOTION_COLUMNS: [FingerColumn; 6] = [
    ("x_m", "m", "hand"),
    ("y_m", "m", "hand"),
    ("z_m", "m", "hand"),
    ("vx_m_s", "m/s", "hand"),
    ("vy_m_s", "m/s", "hand"),
    ("vz_m_s", "m/s", "hand"),
];

/// Positions and velocities of methods, named, by sample of the take: a table by [`finger_table`].
///
/// Velocities are central differences, at the first and the last sample of a trajectory those to its other sample.
/// `starts` are the samples at which trajectories start; where they are not known, velocities are blank.
pub fn motion_table<'a>(
    methods: impl IntoIterator<Item = (&'a str, &'a BTreeMap<usize, Configuration>)>,
    starts: Option<&BTreeSet<usize>>,
    clock: Clock,
    layout: TableLayout,
) -> Table<'a> {
    let rows = methods.into_iter().flat_map(|(method, configurations_m)| {
        let row = |&sample| motion_row(method, sample, configurations_m, starts, clock.rate_hz());
        configurations_m.keys().map(row).collect::<Vec<_>>()
    });
    finger_table(rows.collect(), MOTION_COLUMNS, clock, layout)
}

/// Planned motion as such a table; its time starts at zero.
///
/// # Errors
///
/// [`ClockError`] for a trajectory without a rate.
pub fn trajectory_table<'a>(
    method: &'a str,
    trajectory: &Trajectory,
) -> Result<Table<'a>, ClockError> {
    let (layout, starts) = (trajectory.layout(), BTreeSet::new());
    let clock = Clock::new(0, StartTime::Unknown, layout.rate_hz)?;
    let configurations_m = (0..layout.samples).map(|k| (k, trajectory.configuration_m(k)));
    let configurations_m = configurations_m.collect();
    let rate_hz = layout.rate_hz;
    let row = |k| motion_row(method, k, &configurations_m, Some(&starts), rate_hz);
    let rows = (0..layout.samples).map(row).collect();
    Ok(finger_table(rows, MOTION_COLUMNS, clock, TableLayout::Wide))
}

fn motion_row<'a>(
    method: &'a str,
    sample: usize,
    configurations_m: &BTreeMap<usize, Configuration>,
    starts: Option<&BTreeSet<usize>>,
    rate_hz: f64,
) -> FingerRow<'a, 6> {
    // A neighbour of the same trajectory.
    let neighbour = |sample: Option<usize>, later: usize| {
        let is_same = starts.is_some_and(|starts| !starts.contains(&later));
        sample
            .filter(|_| is_same)
            .and_then(|sample| configurations_m.get(&sample))
    };
    let before = neighbour(sample.checked_sub(1), sample);
    let next = neighbour(Some(sample + 1), sample + 1);
    let steps = f64::from(u8::from(before.is_some()) + u8::from(next.is_some()));
    let here = &configurations_m[&sample];
    let (from, to) = (before.unwrap_or(here), next.unwrap_or(here));
    // Without a neighbour it is 0 / 0: NaN.
    let velocity = |k: usize| (to[k] - from[k]) * rate_hz / steps;
    let numbers = PerFinger::from_fn(|finger| {
        let [x, y, z] = [0, 1, 2].map(|axis| 3 * finger.index() + axis);
        [
            here[x],
            here[y],
            here[z],
            velocity(x),
            velocity(y),
            velocity(z),
        ]
    });
    FingerRow {
        method,
        sample,
        numbers,
    }
}

/// A table of rows: `method`, `sample`, `time_s`, then for each finger `FINGER.HEADING`; tidy has a row for each
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
