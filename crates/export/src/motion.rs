//! Tables of the segments, contacts and phases behind an evaluation.

use std::ops::Range;
use std::sync::Arc;

use inhand_model::{ContactRows, Finger, FingerSet, MotionRows};

use crate::table::{Table, TableBuilder, table_of};

/// A table of how each segment moves: a row for the recording and each method, segment and finger.
///
/// Columns: `session`, `motion` (`recorded`, or the method), `take`, `segment` (counted over all takes, from 0),
/// `start_sample` of the segment in its take, `finger`; `filled` (1 where any recorded sample of the fingertip was
/// filled); `length_m`, `peak_speed_m_s`, `static_share`, `sparc`, `ldlj`; of the whole hand, in each finger's row,
/// `nearest_demonstration_m` and which it is, `nearest_demonstration` (counted over all training segments); and, where an
/// object is known, `known_s` (time over which it is known whether the finger touches), `duty`, `makes`, `breaks`.
/// A blank cell is a number that does not exist: the plan failed, or the fingertip never moved.
pub fn segment_rows<'a>(session: &'a str, rows: &'a MotionRows) -> Table<'a> {
    struct Row {
        motion: usize,
        segment: usize,
        finger: Finger,
    }
    let segments = rows.segments.len();
    let count = rows.movement.len() * segments * Finger::COUNT;
    // Without segments there are no rows, so that nothing is divided by zero.
    let mut table = TableBuilder::new(count, move |row| Row {
        motion: row / Finger::COUNT / segments,
        segment: row / Finger::COUNT % segments,
        finger: Finger::ALL[row % Finger::COUNT],
    });
    let movement = |r: &Row| &rows.movement[r.motion].segments[r.segment];
    let path = move |r: &Row| &movement(r).by_finger[r.finger];
    table.words("session", move |_| session);
    table.words("motion", |r| &rows.movement[r.motion].name);
    table.words("take", |r| &rows.takes[rows.segments[r.segment].take]);
    table.counts("segment", |r| r.segment);
    table.counts("start_sample", |r| rows.segments[r.segment].start);
    table.words("finger", |r| r.finger.name());
    table.counts("filled", |r| rows.filled[r.segment][r.finger].into());
    table.numbers("length_m", "m", move |r| path(&r).length_m);
    table.numbers("peak_speed_m_s", "m/s", move |r| path(&r).peak_speed_m_s);
    table.numbers("static_share", "1", move |r| path(&r).static_share);
    table.numbers("sparc", "1", move |r| path(&r).sparc);
    table.numbers("ldlj", "1", move |r| path(&r).ldlj);
    table.numbers("nearest_demonstration_m", "m", move |r| {
        movement(&r).nearest_demonstration_m
    });
    table.numbers("nearest_demonstration", "1", move |r| {
        number(movement(&r).nearest_demonstration)
    });
    if let Some(contacts) = &rows.contacts {
        let contacts = move |r: &Row| &contacts[r.motion][r.segment];
        let known = move |r: &Row| contacts(r).known(r.finger) as f64;
        let of_finger = move |r: &Row| contacts(r).contacts[r.finger].iter();
        let rate_hz = rows.layout.rate_hz;
        table.numbers("known_s", "s", move |r| known(&r) / rate_hz);
        table.numbers("duty", "1", move |r| {
            let touching: usize = of_finger(&r).map(|contact| contact.samples.len()).sum();
            touching as f64 / known(&r)
        });
        table.counts("makes", move |r| of_finger(&r).filter(|c| c.made).count());
        table.counts("breaks", move |r| {
            of_finger(&r).filter(|c| c.broken).count()
        });
    }
    table.finish()
}

fn number(count: Option<usize>) -> f64 {
    count.map_or(f64::NAN, |count| count as f64)
}

/// Contacts over a time range of one motion: a whole take, or a segment.
#[derive(Clone, Copy)]
struct Scope<'a> {
    motion: &'a str,
    take: &'a str,
    segment: Option<usize>,
    rows: &'a ContactRows,
}

/// All scopes: whole takes as recorded, then the segments of the recording and of each method.
fn scopes(rows: &MotionRows) -> impl Iterator<Item = Scope<'_>> {
    let takes = rows.takes.iter().zip(&rows.take_contacts);
    let takes = takes.filter_map(|(take, rows)| {
        Some(Scope {
            motion: MotionRows::RECORDED,
            take,
            segment: None,
            rows: rows.as_ref()?,
        })
    });
    let motions = rows.movement.iter().zip(rows.contacts.iter().flatten());
    let segments = motions.flat_map(|(motion, contacts)| {
        (contacts.iter().enumerate()).map(|(segment, contacts)| Scope {
            motion: &motion.name,
            take: &rows.takes[rows.segments[segment].take],
            segment: Some(segment),
            rows: contacts,
        })
    });
    takes.chain(segments)
}

/// A row of the tables of contacts and phases.
#[derive(Clone)]
struct Row<'a> {
    scope: Scope<'a>,
    kind: &'static str,
    samples: Range<usize>,
    /// The finger, or the fingers of a state, or the name of a phase.
    name: Arc<str>,
    holding: FingerSet,
    /// Of a contact: made, broken, filled; of a state: complete.
    flags: [bool; 3],
    length_m: f64,
}

impl<'a> Row<'a> {
    fn new(scope: Scope<'a>, kind: &'static str, samples: &Range<usize>, name: &str) -> Self {
        Self {
            scope,
            kind,
            samples: samples.clone(),
            name: name.into(),
            holding: FingerSet::NONE,
            flags: [false; 3],
            length_m: f64::NAN,
        }
    }
}

/// A table of these rows with the columns that say where a row is.
fn placed<'a>(
    session: &'a str,
    rate_hz: f64,
    rows: Vec<Row<'a>>,
) -> TableBuilder<'a, impl Fn(usize) -> Row<'a> + Clone + Sync + 'a> {
    let mut table = table_of(rows);
    table.words("session", move |_| session);
    table.words("kind", |r| r.kind);
    table.words("motion", |r| r.scope.motion);
    table.words("scope", |r| match r.scope.segment {
        None => "take",
        Some(_) => "segment",
    });
    table.words("take", |r| r.scope.take);
    table.numbers("segment", "1", |r| number(r.scope.segment));
    let time_s = move |sample: usize| sample as f64 / rate_hz;
    table.numbers("start_s", "s", move |r| time_s(r.samples.start));
    table.numbers("end_s", "s", move |r| time_s(r.samples.end));
    table.counts("samples", |r| r.samples.len());
    table
}

/// A table of contacts: a row for each contact of a finger (`kind` is `contact`) and each interval over which it is not
/// known whether it touches (`unknown`).
///
/// Columns: `session`, `kind`, `motion` (`recorded`, or the method), `scope` (`take`: a whole take as recorded;
/// `segment`: inside a segment, apart from the rest of its take), `take`, `segment` (blank for a whole take); `start_s`
/// and `end_s` since the first sample of take or segment, `samples`; `finger`; `made` and `broken` (1 where the contact
/// was seen to begin, to end), `filled` (1 where the fingertip or the object was filled at any of its samples), `slip_m`.
pub fn contact_rows<'a>(session: &'a str, rows: &'a MotionRows) -> Table<'a> {
    let mut list = Vec::new();
    for scope in scopes(rows) {
        for finger in Finger::ALL {
            let row = |kind, samples| Row::new(scope, kind, samples, finger.name());
            let contacts = scope.rows.contacts[finger].iter();
            list.extend(contacts.map(|contact| Row {
                flags: [contact.made, contact.broken, contact.filled],
                length_m: contact.slip_m,
                ..row("contact", &contact.samples)
            }));
            let unknown = scope.rows.unknown[finger].iter();
            list.extend(unknown.map(|samples| row("unknown", samples)));
        }
    }
    let mut table = placed(session, rows.layout.rate_hz, list);
    table.words("finger", |r| r.name.to_string());
    for (place, name) in ["made", "broken", "filled"].into_iter().enumerate() {
        table.counts(name, move |r| r.flags[place].into());
    }
    table.numbers("slip_m", "m", |r| r.length_m);
    table.finish()
}

/// A table of what fingers do together: a row for each interval in which the same fingers touch (`kind` is `state`), and
/// of whole takes for each phase (`phase`) and each step of a finger (`gait`).
///
/// Columns: those of [`contact_rows`] up to `samples`; `what` (the fingers of a state, the name of a phase, the finger of
/// a step), `holding` (the fingers that touch all the while), `complete` (1 for a state with both ends seen, blank
/// otherwise), `step_m` (how far over the object the finger stepped).
pub fn phase_rows<'a>(session: &'a str, rows: &'a MotionRows) -> Table<'a> {
    let mut list = Vec::new();
    for scope in scopes(rows) {
        let contacts = scope.rows;
        list.extend(contacts.states.iter().map(|state| Row {
            flags: [state.complete, false, false],
            holding: state.fingers,
            ..Row::new(scope, "state", &state.samples, &state.fingers.to_string())
        }));
        list.extend(contacts.phases.iter().map(|phase| Row {
            holding: phase.holding,
            ..Row::new(scope, "phase", &phase.samples, phase.kind.name())
        }));
        list.extend(contacts.gaits.iter().map(|gait| Row {
            holding: gait.holding,
            length_m: gait.step_m,
            ..Row::new(scope, "gait", &gait.samples, gait.finger.name())
        }));
    }
    let mut table = placed(session, rows.layout.rate_hz, list);
    table.words("what", |r| r.name.to_string());
    table.words("holding", |r| r.holding.to_string());
    table.numbers("complete", "1", |r| match r.kind {
        "state" => f64::from(u8::from(r.flags[0])),
        _ => f64::NAN,
    });
    table.numbers("step_m", "m", |r| r.length_m);
    table.finish()
}
