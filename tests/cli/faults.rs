//! Faults of input planted in a small simulated session: none may pass without a word.

#![expect(
    clippy::semicolon_if_nothing_returned,
    reason = "a plant is one expression"
)]

use crate::plant::{ALL, Fault, Table, Takes, judge};
use crate::support::{Bench, SMALL, stderr};

const TRAIN: &str = "train/cube_train_01.csv";
const OTHER: &str = "train/cube_train_02.csv";
const TEST: &str = "test/cube_test_01.csv";

/// Changes every take.
fn every(takes: &mut Takes, plant: impl Fn(&mut Table)) {
    takes.values_mut().for_each(plant);
}

/// Changes one take.
fn one(takes: &mut Takes, take: &str, plant: impl FnOnce(&mut Table)) {
    plant(takes.get_mut(take).expect("the take is there"));
}

impl Table {
    /// Removes columns, such as the fourth number of rotations.
    fn remove(&mut self, remove: impl Fn(usize) -> bool) {
        let keep = |cells: Vec<String>| -> Vec<String> {
            let kept = cells
                .into_iter()
                .enumerate()
                .filter(|(column, _)| !remove(*column));
            kept.map(|(_, cell)| cell).collect()
        };
        for line in &mut self.head[2..] {
            let cells = line.split(self.separator).map(str::to_owned).collect();
            *line = keep(cells).join(self.separator);
        }
        self.columns = keep(std::mem::take(&mut self.columns));
        for row in &mut self.rows {
            *row = keep(std::mem::take(row));
        }
    }

    /// Quaternions as intrinsic Euler angles about x, y, z, in degrees.
    fn write_euler(&mut self) {
        self.change("Rotation", ALL, |q| {
            let [x, y, z, w] = [q[0], q[1], q[2], q[3]];
            let a = (2.0 * (x * w - y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
            let b = (2.0 * (x * z + y * w)).asin();
            let c = (2.0 * (z * w - x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
            q[..3].copy_from_slice(&[a, b, c].map(f64::to_degrees));
        });
        let columns = self.columns.clone();
        self.remove(|n| n >= 3 && columns[n].ends_with("Rotation") && columns[n - 3] == columns[n]);
    }
}

/// A body turned half about its own y axis.
fn turn_half(q: &mut [f64]) {
    let [x, y, z, w] = [q[0], q[1], q[2], q[3]];
    q.copy_from_slice(&[-z, w, x, -y]);
}

fn without_hand_markers(table: &mut Table) {
    let text = table.text();
    let cells: Vec<_> = text
        .lines()
        .nth(3)
        .expect("the header has names")
        .split(',')
        .map(|cell| cell.starts_with("Hand:"))
        .collect();
    table.remove(|column| cells[column]);
}

const FAULTS: [Fault<'_>; 42] = [
    (
        "millimetres in every header",
        "",
        |t| every(t, |t| t.state("Units,Meters", "Units,Millimeters")),
        &["units"],
        1,
    ),
    (
        "centimetres in one header",
        "",
        |t| one(t, OTHER, |t| t.state("Units,Meters", "Units,Centimeters")),
        &["units"],
        1,
    ),
    (
        "millimetres under metres",
        "",
        |t| {
            one(t, TEST, |t| {
                t.change("Position", ALL, |p| p.iter_mut().for_each(|x| *x *= 1000.0))
            })
        },
        &["units"],
        1,
    ),
    (
        "y and z of positions exchanged",
        "",
        |t| every(t, |t| t.change("Position", ALL, |p| p.swap(1, 2))),
        &["axes"],
        1,
    ),
    (
        "z of positions negated",
        "",
        |t| every(t, |t| t.change("Position", ALL, |p| p[2] = -p[2])),
        &["axes"],
        1,
    ),
    (
        "the same without markers on the hand",
        "",
        |t| {
            every(t, |t| {
                without_hand_markers(t);
                t.change("Position", ALL, |p| p[2] = -p[2]);
            })
        },
        &["hand-rotation"],
        1,
    ),
    (
        "one take mirrored, rotations too",
        "",
        |t| {
            one(t, TEST, |t| {
                t.change("Position", ALL, |p| p[0] = -p[0]);
                t.change("Rotation", ALL, |q| {
                    q[1] = -q[1];
                    q[2] = -q[2];
                });
            })
        },
        &["takes-disagree"],
        1,
    ),
    (
        "w before x, y and z",
        "",
        |t| every(t, |t| t.change("Rotation", ALL, |q| q.rotate_right(1))),
        &["axes"],
        1,
    ),
    (
        "the same without markers on the hand",
        "",
        |t| {
            every(t, |t| {
                without_hand_markers(t);
                t.change("Rotation", ALL, |q| q.rotate_right(1));
            })
        },
        &["hand-rotation"],
        1,
    ),
    (
        "opposite rotations",
        "",
        |t| every(t, |t| t.change("Rotation", ALL, |q| q[3] = -q[3])),
        &["axes"],
        1,
    ),
    (
        "the same without markers on the hand",
        "",
        |t| {
            every(t, |t| {
                without_hand_markers(t);
                t.change("Rotation", ALL, |q| q[3] = -q[3]);
            })
        },
        &["hand-rotation"],
        1,
    ),
    (
        "another order of Euler angles",
        "",
        |t| {
            every(t, |t| {
                t.write_euler();
                t.state("Type,Quaternion", "Type,ZYX");
            })
        },
        &["axes"],
        1,
    ),
    (
        "ring and little swapped in a take",
        "",
        |t| one(t, OTHER, |t| t.exchange("Ring", "Little", ALL)),
        &["finger-order"],
        0,
    ),
    (
        "thumb and middle swapped in the test take",
        "",
        |t| one(t, TEST, |t| t.exchange("Thumb", "Middle", ALL)),
        &["takes-disagree"],
        1,
    ),
    (
        "index and middle swapped in every take",
        "",
        |t| every(t, |t| t.exchange("Index", "Middle", ALL)),
        &["finger-order"],
        0,
    ),
    (
        "index and middle swapped for a second",
        "",
        |t| one(t, TRAIN, |t| t.exchange("Index", "Middle", 400..500)),
        &["swaps"],
        0,
    ),
    (
        "hand flipped for half a second",
        "",
        |t| one(t, TEST, |t| t.change("Hand Rotation", 400..450, turn_half)),
        &["flips"],
        0,
    ),
    (
        "hand flipped for a take",
        "",
        |t| one(t, TEST, |t| t.change("Hand Rotation", ALL, turn_half)),
        &["takes-disagree"],
        1,
    ),
    (
        "spikes of 20 mm",
        "",
        |t| {
            one(t, TRAIN, |t| {
                (1..5)
                    .for_each(|n| t.change("Ring Position", 200 * n..200 * n + 1, |p| p[0] += 0.02))
            })
        },
        &["spikes"],
        0,
    ),
    (
        "a marker lost for four seconds",
        "",
        |t| one(t, TEST, |t| t.lose("Middle", 400..800)),
        &["segments"],
        0,
    ),
    (
        "a take twice",
        "",
        |t| {
            t.insert("train/again.csv".into(), t[TRAIN].clone());
        },
        &["same-take"],
        1,
    ),
    (
        "a take twice, three seconds later",
        "",
        |t| {
            let mut again = t[TRAIN].clone();
            again.rows.drain(..300);
            again.renumber(0);
            t.insert("train/again.csv".into(), again);
        },
        &["same-take"],
        1,
    ),
    (
        "the test take among the training takes",
        "",
        |t| {
            t.insert("train/again.csv".into(), t[TEST].clone());
        },
        &["error: session/test/cube_test_01.csv: the test take is also"],
        1,
    ),
    (
        "a cube of 0.07",
        "--object cube:0.07",
        |_| {},
        &["object-fit", "contact-share"],
        0,
    ),
    (
        "a cube of 0.025",
        "--object cube:0.025",
        |_| {},
        &["contact-share"],
        0,
    ),
    (
        "a cylinder instead of a cube",
        "--object cylinder:0.02x0.12",
        |_| {},
        &["object-fit", "contact-share"],
        0,
    ),
    (
        "a cube of 50 m",
        "--object cube:50",
        |_| {},
        &["object-size"],
        1,
    ),
    (
        "an object that moves with the hand",
        "",
        |t| {
            every(t, |t| {
                let rows = t.rows.clone();
                let text = t.text();
                let names: Vec<_> = text
                    .lines()
                    .nth(3)
                    .expect("the header has names")
                    .split(',')
                    .map(str::to_owned)
                    .collect();
                let Some(object) = names.iter().position(|name| name == "Object") else {
                    return;
                };
                let hand = names
                    .iter()
                    .position(|name| name == "Hand")
                    .expect("the header has names");
                for (row, old) in t.rows.iter_mut().zip(&rows) {
                    row[object..object + 7].clone_from_slice(&old[hand..hand + 7]);
                }
            })
        },
        &["object-is-hand"],
        1,
    ),
    (
        "the hand as object",
        "--object-body Hand",
        |_| {},
        &["error: session/train/cube_train_01.csv: \"Hand\" is set as part of both"],
        1,
    ),
    (
        "120 Hz in a header over 100 Hz",
        "",
        |t| {
            every(t, |t| {
                t.state(
                    "Capture Frame Rate,100.000000",
                    "Capture Frame Rate,120.000000",
                );
                t.state(
                    "Export Frame Rate,100.000000",
                    "Export Frame Rate,120.000000",
                );
            })
        },
        &["source", "time-column", "exported-rate", "rate"],
        0,
    ),
    (
        "every 20th sample dropped",
        "",
        |t| one(t, TRAIN, Table::drop_samples),
        &["frame-jumps", "time-column"],
        3,
    ),
    (
        "every 20th sample dropped, numbered anew",
        "",
        |t| {
            one(t, TRAIN, |t| {
                t.drop_samples();
                t.renumber(0);
            })
        },
        &["rate", "cut-short", "time-column", "repeated-frames"],
        3,
    ),
    (
        "samples repeated",
        "",
        |t| one(t, TEST, Table::repeat_samples),
        &["repeated-frames", "rate"],
        0,
    ),
    (
        "a marker frozen for two seconds",
        "",
        |t| one(t, TEST, |t| t.freeze("Index", 400..600)),
        &["frozen"],
        0,
    ),
    (
        "a marker of the hand as a fingertip",
        "",
        |t| every(t, |t| t.copy("Hand:Marker1", "Middle")),
        &["error: training hull of the middle finger"],
        1,
    ),
    (
        "noise of 5 mm",
        "",
        |t| one(t, TEST, |t| t.shake("Ring Position", 0.005)),
        &["noise"],
        0,
    ),
    (
        "times that jump",
        "",
        |t| one(t, TEST, |t| t.jump(600..1200, 2.0)),
        &["time-column"],
        0,
    ),
    (
        "the hand's origin a metre off",
        "",
        |t| every(t, |t| t.change("Hand Position", ALL, |p| p[1] += 1.0)),
        &["units"],
        0,
    ),
    (
        "a window of 50 s",
        "--window 5000",
        |_| {},
        &["filter-window"],
        1,
    ),
    (
        "a primitive for every segment",
        "--rank 22 --stride 100",
        |_| {},
        &["primitives"],
        0,
    ),
    ("contacts from 20 mm", "--tau-mm 20", |_| {}, &["tau"], 0),
    ("no shape", "", |_| {}, &["no-shape"], 0),
];

#[test]
fn no_planted_fault_passes_without_a_word() {
    let bench = Bench::csv();
    let good: Takes = [TRAIN, OTHER, TEST]
        .map(|take| {
            let text =
                String::from_utf8(bench.bytes(&format!("session/{take}"))).expect("takes are text");
            (take.to_owned(), Table::new(&text))
        })
        .into();
    let wrong = FAULTS.iter().filter_map(|fault| {
        let (name, options, plant, ..) = fault;
        let mut takes = good.clone();
        plant(&mut takes);
        let bench = Bench::empty();
        for (take, table) in &takes {
            bench.write(&format!("session/{take}"), table.text());
        }
        let options: Vec<_> = options.split_whitespace().collect();
        let shape = match *name == "no shape" || options.contains(&"--object") {
            true => &[][..],
            false => &["--object", "cube:0.05"],
        };
        let small = match options.contains(&"--rank") {
            true => &[][..],
            false => &SMALL,
        };
        let output =
            bench.inhand(&[&["run", "session", "-o", "out"], small, shape, &options].concat());
        let evaluation = (matches!(output.status.code(), Some(0 | 3)))
            .then(|| bench.json("out/evaluation.json"));
        judge(
            fault,
            output.status.code(),
            &stderr(&output),
            evaluation.as_ref(),
        )
    });
    let wrong: Vec<_> = wrong.collect();
    assert!(
        wrong.is_empty(),
        "{} faults\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
