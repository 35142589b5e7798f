//! Takes as tables of other tools, and back.

use std::collections::BTreeMap;

use inhand_model::{Finger, Protocol, Recording, Sample, Status, Track};

use crate::support::{Bench, stderr};

const TAKE: &str = "session/test/cube_test_01.csv";

fn recording(bench: &Bench, name: &str) -> Recording {
    inhand_channels::read_take(&bench.bytes(name), name)
        .expect("convert wrote a take")
        .recording
}

fn bits<T: Sample, const N: usize>(
    track: &Track<T>,
    numbers: impl Fn(T) -> [f64; N],
) -> Vec<(Status, Option<[u64; N]>)> {
    (track.iter().zip(track.statuses()))
        .map(|(value, &status)| (status, value.map(|v| numbers(v).map(f64::to_bits))))
        .collect()
}

#[test]
fn a_take_goes_to_a_table_and_back_unchanged() {
    // With gaps, as missing samples are what tables lose most easily.
    let bench = Bench::simulated(&["--format", "csv", "--gaps", "0.05"]);
    bench.ok(&["convert", TAKE, "-o", "a.mcap"]);
    bench.ok(&["export", "a.mcap", "-o", "wide.csv"]);
    bench.ok(&["convert", "wide.csv", "-o", "b.mcap"]);

    let (a, b) = (recording(&bench, "a.mcap"), recording(&bench, "b.mcap"));
    assert_eq!((&a.name, a.clock, &a.source), (&b.name, b.clock, &b.source));
    assert_eq!(a.markers.len(), b.markers.len());
    for (a, b) in a.markers.iter().zip(&b.markers) {
        assert_eq!((&a.name, &a.id, a.kind), (&b.name, &b.id, b.kind));
        let of = |m: &inhand_model::Marker| bits(&m.track, inhand_model::Position::to_array);
        assert_eq!(of(a), of(b));
    }
    assert!(
        a.markers
            .iter()
            .any(|marker| marker.track.counts().missing > 0)
    );
    assert_eq!(a.bodies.len(), b.bodies.len());
    for (a, b) in a.bodies.iter().zip(&b.bodies) {
        let of = |body: &inhand_model::TrackedBody| {
            bits(&body.track, |pose| {
                let ([x, y, z], [a, b, c, d]) = (pose.origin().to_array(), pose.quaternion_xyzw());
                [x, y, z, a, b, c, d]
            })
        };
        assert_eq!(of(a), of(b));
    }
    // And the way of the data goes on from the table as from the take.
    bench.ok(&["process", "wide.csv", "-o", "p.mcap"]);

    // Exporting again gives the same bytes, and neither the table nor its facts are replaced by others.
    let export = ["export", "b.mcap", "-o", "wide.csv"];
    let before = (bench.bytes("wide.csv"), bench.bytes("wide.csv.json"));
    bench.ok(&export);
    for gone in [
        &["wide.csv.json"][..],
        &["wide.csv"],
        &["wide.csv", "wide.csv.json"],
    ] {
        for name in gone {
            bench.write(name, "somebody's");
        }
        let refused = bench.inhand(&export);
        assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
        assert!(stderr(&refused).contains("--force"));
        bench.ok(&[&export[..], &["--force"]].concat());
        assert!((bench.bytes("wide.csv"), bench.bytes("wide.csv.json")) == before);
    }
    std::fs::remove_file(bench.path("wide.csv")).expect("it was written");
    assert_eq!(
        bench.inhand(&export).status.code(),
        Some(2),
        "facts are left"
    );
}

#[test]
fn every_form_is_written() {
    let bench = Bench::csv();
    bench.ok(&["process", TAKE, "-o", "p.mcap"]);
    bench.ok(&["export", "p.mcap", "-o", "tidy.csv", "--layout", "tidy"]);
    bench.ok(&["export", "p.mcap", "-o", "hand.csv", "--what", "processed"]);
    bench.ok(&["export", "p.mcap", "-o", "wide.parquet"]);
    bench.ok(&["export", TAKE, "-o", "tidy.parquet", "--layout", "tidy"]);
    let text = |name: &str| String::from_utf8(bench.bytes(name)).expect("tables are text");
    assert!(text("tidy.csv").starts_with("time_s,sample,entity,kind,frame,x_m,"));
    assert!(text("hand.csv").starts_with("time_s,thumb.x_m,thumb.y_m,thumb.z_m,thumb.status,"));
    assert!(!bench.path("hand.csv.json").exists());
    for name in ["wide.parquet", "tidy.parquet"] {
        assert!(bench.bytes(name).starts_with(b"PAR1") && bench.bytes(name).ends_with(b"PAR1"));
    }
    let unprocessed = bench.inhand(&["export", TAKE, "-o", "x.csv", "--what", "processed"]);
    assert_eq!(unprocessed.status.code(), Some(1));
    assert!(stderr(&unprocessed).contains("inhand process"));
    assert!(!bench.path("x.csv").exists());
}

#[test]
fn a_take_joins_a_bids_dataset() {
    let bench = Bench::csv();
    bench.ok(&["export", TAKE, "-o", "bids", "--bids", "sub=01,task=rotate"]);
    let prefix = "bids/sub-01/motion/sub-01_task-rotate_tracksys-OptiTrack";
    let facts = bench.json(&format!("{prefix}_motion.json"));
    assert_eq!(facts["SamplingFrequency"], 100.0);
    let channels = bench.bytes(&format!("{prefix}_channels.tsv"));
    let channels = String::from_utf8(channels).expect("text").lines().count() - 1;
    assert_eq!(facts["MotionChannelCount"], channels);

    // A second take joins; what is of the dataset as a whole stays.
    bench.write("bids/dataset_description.json", "{\"Name\": \"mine\"}");
    bench.ok(&[
        "export",
        TAKE,
        "-o",
        "bids",
        "--bids",
        "sub=02,task=rotate,ses=a,run=1",
    ]);
    assert_eq!(bench.json("bids/dataset_description.json")["Name"], "mine");
    assert!(bench.path("bids/sub-02/ses-a/motion").is_dir());

    for (names, code, expected) in [
        ("sub=01,task=rotate", 2, "--force"),
        ("task=rotate", 2, "expected sub=LABEL"),
        ("sub=0_1,task=rotate", 1, "letters and digits"),
        ("subject=01", 2, "expected sub, ses"),
    ] {
        let refused = bench.inhand(&["export", TAKE, "-o", "bids", "--bids", names]);
        assert_eq!(refused.status.code(), Some(code), "{}", stderr(&refused));
        assert!(stderr(&refused).contains(expected), "{}", stderr(&refused));
    }
}

#[test]
fn tables_that_are_none_are_refused_with_their_place() {
    let bench = Bench::empty();
    bench.write("a.csv", "time_s,a.x_m,a.y_m,a.z_m\n0,1,2,3\n0.01,1,2,x\n");
    let refused = bench.inhand(&["convert", "a.csv", "-o", "a.mcap"]);
    assert_eq!(refused.status.code(), Some(1));
    let said = stderr(&refused);
    assert!(
        said.contains("a.csv, line 3, column 4 (\"a.z_m\")"),
        "{said}"
    );
    assert!(!bench.path("a.mcap").exists());

    let refused = bench.inhand(&["export", "a.csv", "-o", "a.xlsx"]);
    assert_eq!(refused.status.code(), Some(2));
}

/// Heading and rows of a table without quotes.
fn table(bench: &Bench, name: &str) -> Vec<BTreeMap<String, String>> {
    let text = String::from_utf8(bench.bytes(name)).expect("tables are text");
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
    let heading: Vec<String> = lines.next().expect("a heading").collect();
    lines
        .map(|cells| heading.iter().cloned().zip(cells).collect())
        .collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column]
        .parse()
        .unwrap_or_else(|_| panic!("{column}: {:?}", row[column]))
}

#[test]
fn what_was_planned_and_evaluated_leaves_with_the_numbers_of_the_channels() {
    let bench = Bench::csv();
    bench.run("out", &["--methods", "residual,line", "--row-positions"]);
    let take = "out/cube_test_01.mcap";
    for what in ["generated", "errors", "contacts"] {
        for layout in ["wide", "tidy"] {
            let name = format!("{what}.{layout}.csv");
            bench.ok(&[
                "export", take, "-o", &name, "--what", what, "--layout", layout,
            ]);
        }
        bench.ok(&["export", take, "-o", "x.parquet", "--what", what, "--force"]);
        assert!(bench.bytes("x.parquet").starts_with(b"PAR1"));
        let (wide, tidy) = (format!("{what}.wide.csv"), format!("{what}.tidy.csv"));
        let (wide, tidy) = (table(&bench, &wide), table(&bench, &tidy));
        assert_eq!(tidy.len(), 5 * wide.len());
        // One row of the other layout, for all.
        for (column, value) in tidy[5 * 7 + 3]
            .iter()
            .filter(|(column, _)| column.contains("_m"))
        {
            assert_eq!(wide[7][&format!("ring.{column}")], *value);
        }
    }

    let bytes = bench.bytes(take);
    let of = Protocol::Published;
    let generated = inhand_channels::read_generated(&bytes, take, of).expect("a take");
    let rows = table(&bench, "generated.wide.csv");
    let count: usize = generated
        .iter()
        .map(|method| method.configurations_m.len())
        .sum();
    assert_eq!(rows.len(), count);
    let starts: Vec<usize> = generated[0].plans.keys().copied().collect();
    let method = |name: &str| {
        generated
            .iter()
            .find(|method| method.name == name)
            .expect("it ran")
    };
    for row in &rows {
        let configurations_m = &method(&row["method"]).configurations_m;
        let sample = number(row, "sample") as usize;
        assert_eq!(number(row, "time_s"), sample as f64 / 100.0);
        for (k, column) in ["thumb.x_m", "thumb.y_m", "thumb.z_m"]
            .into_iter()
            .enumerate()
        {
            assert_eq!(number(row, column), configurations_m[&sample][k]);
        }
        // No difference reaches into another segment.
        let from = if starts.contains(&sample) {
            sample
        } else {
            sample - 1
        };
        let ends = starts.contains(&(sample + 1)) || !configurations_m.contains_key(&(sample + 1));
        let to = if ends { sample } else { sample + 1 };
        let moved_m = configurations_m[&to][14] - configurations_m[&from][14];
        let velocity_m_s = moved_m * 100.0 / (to - from) as f64;
        assert!(
            (number(row, "little.vz_m_s") - velocity_m_s).abs() < 1e-12,
            "{sample}"
        );
    }

    let evaluated = inhand_channels::read_evaluated(&bytes, take).expect("a take");
    let samples = evaluated
        .iter()
        .flat_map(|m| m.samples.iter().map(|s| (&m.name, s)));
    let mut contacts = table(&bench, "contacts.wide.csv").into_iter();
    let mut errors = table(&bench, "errors.wide.csv").into_iter();
    for (name, sample) in samples {
        if let Some(error_m) = sample.error_m {
            let row = errors.next().expect("a row for each error");
            assert_eq!(
                (&row["method"], number(&row, "sample")),
                (name, sample.sample as f64)
            );
            assert_eq!(number(&row, "index.error_m"), error_m[Finger::Index]);
        }
        if let Some(contact) = sample.contact {
            let row = contacts.next().expect("a row for each contact");
            assert_eq!(
                (&row["method"], number(&row, "sample")),
                (name, sample.sample as f64)
            );
            assert_eq!(
                number(&row, "index.distance_m"),
                contact.distance_m[Finger::Index]
            );
            let in_contact = f64::from(u8::from(contact.in_contact[Finger::Index]));
            assert_eq!(number(&row, "index.in_contact"), in_contact);
        }
    }
    assert!(contacts.next().is_none() && errors.next().is_none());

    // Positions beside the errors, on request.
    let evaluate = [
        "evaluate",
        take,
        "-d",
        "out/dictionary.mcap",
        "-o",
        "e.json",
        "--rows",
        "rows.csv",
    ];
    bench.ok(&[&evaluate[..], &["--row-positions"]].concat());
    for row in table(&bench, "rows.csv") {
        let sample = (number(&row, "start_sample") + number(&row, "sample")) as usize;
        let planned_m = &method(&row["method"]).configurations_m[&sample];
        let squares = ["x", "y", "z"]
            .into_iter()
            .enumerate()
            .map(|(axis, letter)| {
                let planned = number(&row, &format!("middle.planned_{letter}_m"));
                assert_eq!(planned, planned_m[6 + axis]);
                (planned - number(&row, &format!("middle.recorded_{letter}_m"))).powi(2)
            });
        let distance_m = squares.sum::<f64>().sqrt();
        assert!((distance_m - number(&row, "middle.error_m")).abs() < 1e-9);
    }
    // Readers of rows pass over them, and a run with other columns is another run.
    bench.ok(&["report", "merge", "out", "-o", "with.json"]);
    let with = bench.bytes("out/rows.parquet");
    bench.run("out", &["--methods", "residual,line"]);
    assert!(bench.bytes("out/rows.parquet").len() < with.len());
    bench.ok(&["report", "merge", "out", "-o", "without.json"]);
    assert!(bench.bytes("with.json") == bench.bytes("without.json"));
}

#[test]
fn a_part_that_is_not_stored_is_refused_with_the_command_that_stores_it() {
    let bench = Bench::csv();
    bench.ok(&["convert", TAKE, "-o", "a.mcap"]);
    for (input, what, advice) in [
        (TAKE, "generated", "`inhand generate`"),
        ("a.mcap", "generated", "`inhand generate`"),
        (TAKE, "errors", "`inhand run`"),
        ("a.mcap", "contacts", "`inhand run`"),
    ] {
        let refused = bench.inhand(&["export", input, "-o", "x.csv", "--what", what]);
        assert_eq!(refused.status.code(), Some(1), "{what}");
        assert!(stderr(&refused).contains(advice), "{}", stderr(&refused));
        assert!(!bench.path("x.csv").exists());
    }
}
