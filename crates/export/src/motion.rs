//! The single segments, contacts and phases behind an evaluation as tables.

use std::sync::{Arc, LazyLock};

use inhand_model::{
    ContactRows, Finger, FingerSet, MotionRows, PathFacts, PerFinger, SegmentMovement,
};

use crate::rows::{counts, numbers, words};
use crate::table::Table;

/// A table of how each segment moves: a row for the recording and each method, segment and finger.
///
/// Columns: `session`, `motion` (`recorded`, or the method), `take`, `segment` (counted over all takes, from 0),
/// `start_sample` of the segment in its take, `finger`; `filled` (1 where any recorded sample of the fingertip was
/// filled); `length_m`, `peak_speed_m_s`, `static_share`, `sparc`, `ldlj`; of the whole hand, in each finger's row,
/// `nearest_demonstration_m` and which it is, `nearest_demonstration` (counted over all training segments); and, where an
/// object is known, `known_s` (time over which it is known whether the finger touches), `duty`, `makes`, `breaks`.
/// A blank cell is a number that does not exist: the plan failed, or the fingertip never moved.
pub fn segment_rows<'a>(session: &'a str, rows: &'a MotionRows) -> Table<'a> {
    let segments = rows.segments.len();
    let place = move |row: usize| {
        let (segment, finger) = (row / Finger::COUNT, Finger::ALL[row % Finger::COUNT]);
        let at = (segment / segments.max(1), segment % segments.max(1));
        (at.0, at.1, finger)
    };
    let moved = move |row: usize| -> &'a SegmentMovement {
        let (motion, segment, _) = place(row);
        &rows.movement[motion].segments[segment]
    };
    let path = move |part: fn(&PathFacts) -> f64| {
        move |row: usize| part(&moved(row).by_finger[place(row).2])
    };
    let origin = move |row: usize| rows.segments[place(row).1];
    let mut columns = vec![
        words("session", move |_| session),
        words("motion", move |row| {
            rows.movement[place(row).0].name.as_str()
        }),
        words("take", move |row| rows.takes[origin(row).take].as_str()),
        counts("segment", move |row| place(row).1),
        counts("start_sample", move |row| origin(row).start),
        words("finger", move |row| place(row).2.name()),
        counts("filled", move |row| {
            let (_, segment, finger) = place(row);
            usize::from(rows.filled[segment][finger])
        }),
        numbers("length_m".to_owned(), "m", path(|path| path.length_m)),
        numbers(
            "peak_speed_m_s".to_owned(),
            "m/s",
            path(|path| path.peak_speed_m_s),
        ),
        numbers(
            "static_share".to_owned(),
            "1",
            path(|path| path.static_share),
        ),
        numbers("sparc".to_owned(), "1", path(|path| path.sparc)),
        numbers("ldlj".to_owned(), "1", path(|path| path.ldlj)),
        numbers("nearest_demonstration_m".to_owned(), "m", move |row| {
            moved(row).nearest_demonstration_m
        }),
        numbers("nearest_demonstration".to_owned(), "1", move |row| {
            moved(row)
                .nearest_demonstration
                .map_or(f64::NAN, |place| place as f64)
        }),
    ];
    if let Some(contacts) = &rows.contacts {
        let rate_hz = rows.layout.rate_hz;
        let of = move |row: usize| {
            let (motion, segment, finger) = place(row);
            let contacts = &contacts[motion][segment];
            (contacts, &contacts.contacts[finger], contacts.known(finger))
        };
        columns.push(numbers("known_s".to_owned(), "s", move |row| {
            of(row).2 as f64 / rate_hz
        }));
        columns.push(numbers("duty".to_owned(), "1", move |row| {
            let (_, contacts, known) = of(row);
            let touching: usize = contacts.iter().map(|contact| contact.samples.len()).sum();
            touching as f64 / known as f64
        }));
        columns.push(counts("makes", move |row| {
            of(row).1.iter().filter(|c| c.made).count()
        }));
        columns.push(counts("breaks", move |row| {
            of(row).1.iter().filter(|c| c.broken).count()
        }));
    }
    Table {
        columns,
        rows: rows.movement.len() * segments * Finger::COUNT,
    }
}

/// A stretch of time of one motion: a whole take, or a segment.
#[derive(Clone, Copy)]
struct Stretch<'a> {
    motion: &'a str,
    take: &'a str,
    segment: Option<usize>,
    rows: &'a ContactRows,
}

/// All stretches: whole takes as recorded, then the segments of the recording and of each method.
fn stretches(rows: &MotionRows) -> Vec<Stretch<'_>> {
    let takes = rows.takes.iter().zip(&rows.take_contacts);
    let takes = takes.filter_map(|(take, rows)| {
        Some(Stretch {
            motion: MotionRows::RECORDED,
            take,
            segment: None,
            rows: rows.as_ref()?,
        })
    });
    let motions = rows.movement.iter().zip(rows.contacts.iter().flatten());
    let segments = motions.flat_map(|(motion, contacts)| {
        contacts
            .iter()
            .enumerate()
            .map(|(segment, contacts)| Stretch {
                motion: &motion.name,
                take: &rows.takes[rows.segments[segment].take],
                segment: Some(segment),
                rows: contacts,
            })
    });
    takes.chain(segments).collect()
}

/// What a row of a table of stretches says.
struct Row<'a> {
    of: Stretch<'a>,
    kind: &'static str,
    samples: std::ops::Range<usize>,
    /// The finger, or the name of the phase.
    what: &'static str,
    fingers: FingerSet,
    flags: [bool; 3],
    length_m: f64,
}

/// The columns that say where a row is.
fn place_columns<'a>(
    session: &'a str,
    rate_hz: f64,
    rows: &Arc<Vec<Row<'a>>>,
) -> Vec<crate::table::Column<'a>> {
    let at = |_: ()| Arc::clone(rows);
    let [a, b, c, d, e, f, g, h] = [(); 8].map(at);
    vec![
        words("session", move |_| session),
        words("kind", move |row| a[row].kind),
        words("motion", move |row| b[row].of.motion),
        words("scope", move |row| match c[row].of.segment {
            None => "take",
            Some(_) => "segment",
        }),
        words("take", move |row| d[row].of.take),
        numbers("segment".to_owned(), "1", move |row| {
            e[row].of.segment.map_or(f64::NAN, |segment| segment as f64)
        }),
        numbers("start_s".to_owned(), "s", move |row| {
            f[row].samples.start as f64 / rate_hz
        }),
        numbers("end_s".to_owned(), "s", move |row| {
            g[row].samples.end as f64 / rate_hz
        }),
        counts("samples", move |row| h[row].samples.len()),
    ]
}

/// A table of contacts: a row for each contact of a finger (`kind` is `contact`) and each stretch over which it is not
/// known whether it touches (`unknown`).
///
/// Columns: `session`, `kind`, `motion` (`recorded`, or the method), `scope` (`take`: a whole take as recorded;
/// `segment`: inside a segment, which stands alone), `take`, `segment` (blank for a whole take); `start_s` and
/// `end_s` since the first sample of take or segment, `samples`; `finger`; `made` and `broken` (1 where the contact was
/// seen to begin, to end), `filled` (1 where the fingertip or the object was filled at any of its samples), `slip_m`.
pub fn contact_rows<'a>(session: &'a str, rows: &'a MotionRows) -> Table<'a> {
    let mut list = Vec::new();
    for of in stretches(rows) {
        for finger in Finger::ALL {
            let row = |kind, samples, flags, length_m| Row {
                of,
                kind,
                samples,
                what: finger.name(),
                fingers: FingerSet::NONE,
                flags,
                length_m,
            };
            list.extend(of.rows.contacts[finger].iter().map(|contact| {
                let flags = [contact.made, contact.broken, contact.filled];
                row("contact", contact.samples.clone(), flags, contact.slip_m)
            }));
            list.extend(
                of.rows.unknown[finger]
                    .iter()
                    .map(|samples| row("unknown", samples.clone(), [false; 3], f64::NAN)),
            );
        }
    }
    let list = Arc::new(list);
    let mut columns = place_columns(session, rows.layout.rate_hz, &list);
    let finger = Arc::clone(&list);
    columns.push(words("finger", move |row| finger[row].what));
    for (place, name) in ["made", "broken", "filled"].into_iter().enumerate() {
        let list = Arc::clone(&list);
        columns.push(counts(name, move |row| usize::from(list[row].flags[place])));
    }
    let slip = Arc::clone(&list);
    columns.push(numbers("slip_m".to_owned(), "m", move |row| {
        slip[row].length_m
    }));
    Table {
        columns,
        rows: list.len(),
    }
}

/// A table of what fingers do together: a row for each stretch in which the same fingers touch (`kind` is `state`), and of
/// whole takes for each phase (`phase`) and each step of a finger (`gait`).
///
/// Columns: those of [`contact_rows`] up to `samples`; `what` (the fingers of a state, the name of a phase, the finger of
/// a step), `holding` (the fingers that touch all the while), `complete` (1 for a state with both ends seen, blank
/// otherwise), `step_m` (how far over the object the finger stepped).
pub fn phase_rows<'a>(session: &'a str, rows: &'a MotionRows) -> Table<'a> {
    let mut list = Vec::new();
    for of in stretches(rows) {
        let row = |kind, samples: &std::ops::Range<usize>, what, fingers| Row {
            of,
            kind,
            samples: samples.clone(),
            what,
            fingers,
            flags: [false; 3],
            length_m: f64::NAN,
        };
        list.extend(of.rows.states.iter().map(|state| Row {
            flags: [state.complete, false, false],
            ..row(
                "state",
                &state.samples,
                set_name(state.fingers),
                state.fingers,
            )
        }));
        list.extend(
            (of.rows.phases.iter())
                .map(|phase| row("phase", &phase.samples, phase.kind.name(), phase.holding)),
        );
        list.extend(of.rows.gaits.iter().map(|gait| Row {
            length_m: gait.step_m,
            ..row("gait", &gait.samples, gait.finger.name(), gait.holding)
        }));
    }
    let list = Arc::new(list);
    let mut columns = place_columns(session, rows.layout.rate_hz, &list);
    let [what, holding, complete, step] = [(); 4].map(|()| Arc::clone(&list));
    columns.push(words("what", move |row| what[row].what));
    columns.push(words("holding", move |row| set_name(holding[row].fingers)));
    columns.push(numbers(
        "complete".to_owned(),
        "1",
        move |row| match complete[row].kind {
            "state" => f64::from(u8::from(complete[row].flags[0])),
            _ => f64::NAN,
        },
    ));
    columns.push(numbers("step_m".to_owned(), "m", move |row| {
        step[row].length_m
    }));
    Table {
        columns,
        rows: list.len(),
    }
}

/// The name of a set of fingers, such as `thumb+index`.
fn set_name(fingers: FingerSet) -> &'static str {
    static NAMES: LazyLock<[String; FingerSet::COUNT]> = LazyLock::new(|| {
        std::array::from_fn(|bits| {
            FingerSet::of(PerFinger::from_fn(|finger| {
                bits & (1 << finger.index()) != 0
            }))
            .to_string()
        })
    });
    &NAMES[usize::from(fingers.bits())]
}
