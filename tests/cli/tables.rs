//! Takes as tables of other tools, and back.

use inhand_model::{Recording, Sample, Status, Track};

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
