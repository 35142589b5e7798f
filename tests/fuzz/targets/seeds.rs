//! Writes the first inputs of every target to `$SEEDS/TARGET/NAME`. A target itself, since code built for coverage needs
//! the fuzzer.

#![no_main]

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Error, ErrorKind};
use std::path::Path;

use inhand_channels::{Views, write_annotations, write_dictionary, write_take};
use inhand_container::{ChannelFacts, Selection, Source, select};
use inhand_export::matrices::{self, MatrixFormat, Variable};
use inhand_export::{events, facts_json, recording_entities, wide, write_csv};
use inhand_model::{Annotations, Event};
use inhand_report::evaluation_json;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions};
use nalgebra::DMatrix;

#[path = "../../../crates/import/tests/bag.rs"]
#[allow(dead_code, reason = "shared with the tests of the crate")]
mod bag;
#[path = "../../../crates/channels/tests/common/mod.rs"]
mod common;
#[path = "../../../crates/report/tests/suite/sample.rs"]
#[allow(dead_code, reason = "shared with the tests of the crate")]
mod sample;

const START: u64 = 1_700_000_000_000_000_000;

const QUALISYS: &str = "NO_OF_FRAMES\t2\nNO_OF_CAMERAS\t8\nNO_OF_MARKERS\t2\nFREQUENCY\t100\nDATA_INCLUDED\t3D\n\
    EVENT\tgrasp\t1\t0.01\nTIME_STAMP\t2026-01-02, 03:04:05.678\t123.45\nMARKER_NAMES\ta_tip\tb\n\
    Frame\tTime\ta_tip X\ta_tip Y\ta_tip Z\tb X\tb Y\tb Z\n\
    1\t0.0\t1\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\tnan\tnan\tnan\n";

const TRC: &str = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n100\t2\t2\tmm\n\
    Frame#\tTime\ta_tip\t\t\tb\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n1\t0.0\t1\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\t\t\t\n";

const ROW_TYPED: &str = "comment,\"x\"\nrighthanded\ninfo,version,1.1\ninfo,framecount,3\n\
    rigidbody,\"Hand\",1,1,0.1,0.2,0.3\nframe,0,0.0,1,1,1,2,3,0,0,0,1,9,9,9,2,1.5,2.5,3.5,3,Hand,-1,-2,-3,55,Marker-55\n\
    rigidbody,0,0.0,\"Hand\",1,0,1,1.4,2.4,3.4,3,1.5,2.5,3.5,1,0.75,0.01\nframe,1,0.01,0,0\n\
    rigidbody,1,0.01,\"Hand\",1,1,1,1.4,2.4,3.4,3,NAN,NAN,NAN,0,0,0\nframe,3,0.03,0,1,0,0,1,0,\n";

const BAG_FACTS: &str = "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  \
    relative_file_paths:\n    - a_0.mcap\n    - a_1.mcap\n  compression_format: zstd\n  compression_mode: FILE\n";

libfuzzer_sys::fuzz_target!(init: write().expect("seeds are written"), |_bytes: &[u8]| ());

fn write() -> Result<(), Error> {
    let folder = std::env::var_os("SEEDS").ok_or(ErrorKind::NotFound)?;
    let put = |target: &str, name: &str, bytes: &[u8]| {
        let folder = Path::new(&folder).join(target);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(name), bytes)
    };
    let take = common::take(3, 20.0);
    let written = |write: &dyn Fn(&mut Vec<u8>)| {
        let mut out = Vec::new();
        write(&mut out);
        out
    };
    put(
        "motive",
        "own",
        &written(&|out| inhand_capture::motive::write(&take.recording, out).expect("a take")),
    )?;
    put("motive", "row_typed", ROW_TYPED.as_bytes())?;
    for (name, place) in [
        ("cube", "cube/train/cube_train_01.csv"),
        ("cylinder", "cylinder_gaps/train/cylinder_train_01.csv"),
    ] {
        let text = std::fs::read_to_string(
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../../fixtures")
                .join(place),
        )?;
        let rows: Vec<&str> = text.split_inclusive('\n').take(10).collect();
        put("motive", name, rows.concat().as_bytes())?;
    }
    put("qualisys_trc", "qualisys", QUALISYS.as_bytes())?;
    put("qualisys_trc", "trc", TRC.as_bytes())?;
    put(
        "qualisys_trc",
        "own",
        &written(&|out| inhand_capture::trc::write(&take.recording, out).expect("a take")),
    )?;
    put(
        "c3d",
        "own",
        &written(&|out| inhand_capture::c3d::write(&take.recording, out).expect("a take")),
    )?;
    let table = written(&|out| {
        let entities = recording_entities(&take.recording);
        write_csv(
            &wide(&entities, take.recording.clock, take.recording.len()),
            out,
        )
        .expect("memory takes all");
    });
    put(
        "tables",
        "wide",
        &[&table, facts_json(&take.recording).as_bytes()].concat(),
    )?;
    put("tables", "small", b"time_s,a.x_m,a.y_m,a.z_m,a.status\n0,1,2,3,measured\n0.01,,,,missing\n0.02,1,2,3,filled\n")?;
    let annotations = annotations();
    put(
        "tables",
        "events",
        &written(&|out| events::write(&annotations, START, out).expect("memory takes all")),
    )?;
    put(
        "tables",
        "bids",
        b"onset\tduration\ttrial_type\n0.5\t1\tgrasp\n2.5\tn/a\tslip\n",
    )?;
    for (n, form) in MatrixFormat::ALL.into_iter().enumerate() {
        let primitives = Variable::from(DMatrix::from_fn(60, 2, |i, j| (i * j) as f64));
        let file = matrices::write(
            form,
            "w",
            &[
                ("primitives", primitives),
                ("offset_m", Variable::from(1.0)),
            ],
        );
        put(
            "matrices",
            &format!("file{n}"),
            &[&[0], &file.expect("matrices")[..]].concat(),
        )?;
    }
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }\n";
    let array = [
        &b"\x01\x93NUMPY\x01\0"[..],
        &(head.len() as u16).to_le_bytes(),
        head.as_bytes(),
        &[0; 48],
    ]
    .concat();
    put("matrices", "array", &array)?;
    // A real 1 x 2 matrix "w": array flags, dimensions, name, numbers.
    let element = |kind: u32, bytes: &[u8]| {
        [
            &kind.to_le_bytes()[..],
            &(bytes.len() as u32).to_le_bytes(),
            bytes,
        ]
        .concat()
    };
    let parts = [
        element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
        element(5, &[1, 0, 0, 0, 2, 0, 0, 0]),
        element(1, b"w\0\0\0\0\0\0\0"),
        element(9, &[0; 16]),
    ];
    put(
        "matrices",
        "variable",
        &[vec![2], element(14, &parts.concat())].concat(),
    )?;
    for object in [false, true] {
        let mut evaluation = sample::evaluation(object);
        evaluation.methods.truncate(1);
        (
            evaluation.held_out,
            evaluation.movement,
            evaluation.contacts,
        ) = (None, None, None);
        let text = evaluation_json(&evaluation, &sample::provenance()).expect("an evaluation");
        let text = serde_json::from_str::<serde_json::Value>(&text)
            .expect("JSON")
            .to_string();
        put(
            "documents",
            &format!("evaluation_{object}"),
            &[b"\x01", text.as_bytes()].concat(),
        )?;
    }
    put(
        "documents",
        "bag",
        &[b"\x02", BAG_FACTS.as_bytes()].concat(),
    )?;
    put("documents", "topic", b"\x03marker:Thumb,Index")?;
    put("documents", "instant", b"\x042026-01-02T03:04:05.678Z")?;
    put(
        "settings",
        "some",
        include_bytes!("../../../fixtures/qualisys/inhand.toml"),
    )?;
    #[cfg(feature = "session")]
    {
        let all = inhand_session::Settings::default().to_toml();
        put("settings", "all", all.expect("TOML").as_bytes())?;
    }
    for (name, bytes) in bags() {
        put("import", &name, &bytes)?;
    }
    let segments = common::segments(&take);
    let generated = common::generated(&["prior"], &segments);
    let evaluated = common::evaluated(&["prior"], &take);
    let file = common::take_file(&take, &generated, &evaluated);
    let own = written(&|out| write_take(out, &file, Views::All).expect("a take"));
    put("channels", "take", &own)?;
    put(
        "channels",
        "plain",
        &written(&|out| write_take(out, &file, Views::None).expect("a take")),
    )?;
    let mut dictionary = common::dictionary(2, 4, 4.0);
    let model = written(&|out| write_dictionary(out, &dictionary, &[]).expect("a dictionary"));
    let of_model = |channel: &ChannelFacts| channel.topic == "/dictionary/model";
    put("channels", "model", &only(&model, true, &of_model))?;
    dictionary.residual = None;
    put(
        "channels",
        "dictionary",
        &written(&|out| write_dictionary(out, &dictionary, &[]).expect("a dictionary")),
    )?;
    for ros2 in [false, true] {
        put(
            "channels",
            &format!("events_{ros2}"),
            &written(&|out| write_annotations(out, &annotations, ros2).expect("events")),
        )?;
    }
    // Without what names it, the file is a third-party one with messages for viewers.
    let shown = |channel: &ChannelFacts| {
        (channel.schema_name()).is_some_and(|name| name.starts_with("foxglove."))
    };
    let views = only(&own, false, &shown);
    put("import", "views", &views)?;
    for target in ["records", "edit", "recover"] {
        for (name, bytes) in small_files() {
            put(target, &name, &bytes)?;
        }
    }
    Ok(())
}

/// Some channels of a file.
fn only(bytes: &[u8], metadata: bool, channels: &dyn Fn(&ChannelFacts) -> bool) -> Vec<u8> {
    let mut out = Vec::new();
    let mut source = Source::open("own.mcap", Cursor::new(bytes)).expect("own output");
    let selection = Selection {
        metadata,
        channels: Some(channels),
        ..Selection::default()
    };
    select(&mut source, &mut out, &selection).expect("own output");
    out
}

fn annotations() -> Annotations {
    let event = |start, end| Event {
        start_unix_nanos: START + start,
        end_unix_nanos: START + end,
        labels: BTreeMap::from([("label".to_owned(), "slip".to_owned())]),
    };
    Annotations {
        events: vec![event(0, 5), event(20_000_000, 20_000_000)],
        ..Annotations::default()
    }
}

/// Third-party recordings of some messages.
fn bags() -> Vec<(String, Vec<u8>)> {
    let turned = [0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0];
    let json = |time: u64| {
        format!("{{\"timestamp\":{{\"sec\":{},\"nsec\":{}}},\"frame_id\":\"world\",\"pose\":{{\"position\":{{\"x\":1,\"y\":2,\"z\":3}},\"orientation\":{{\"x\":0,\"y\":0,\"z\":0,\"w\":1}}}}}}", time / 1_000_000_000, time % 1_000_000_000).into_bytes()
    };
    let ros1 = |time: u64| {
        let numbers = turned.map(f64::to_le_bytes).concat();
        let stamp = [(time / 1_000_000_000) as u32, (time % 1_000_000_000) as u32]
            .map(u32::to_le_bytes)
            .concat();
        [
            &[0; 4],
            &stamp[..],
            &5_u32.to_le_bytes(),
            b"world",
            &numbers,
        ]
        .concat()
    };
    type Message<'a> = Box<dyn Fn(u64) -> Vec<u8> + 'a>;
    let kinds: Vec<(&str, (&str, &str), Message<'_>)> = vec![
        (
            "markers",
            bag::MARKERS,
            Box::new(|t| bag::markers(true, t, &[("Thumb", [0.1; 3]), ("", [0.2; 3])])),
        ),
        (
            "bodies",
            bag::BODIES,
            Box::new(|t| bag::bodies(false, t, &[("Hand", turned)])),
        ),
        (
            "pose",
            bag::POSE,
            Box::new(|t| bag::pose(t, "world", turned)),
        ),
        (
            "point",
            bag::POINT,
            Box::new(|t| bag::Cdr::new(true).header(t, "world").f64s(&[0.1; 3]).end()),
        ),
        (
            "array",
            ("geometry_msgs/msg/PoseArray", "cdr"),
            Box::new(|t| {
                bag::Cdr::new(true)
                    .header(t, "world")
                    .u32(1)
                    .f64s(&turned)
                    .end()
            }),
        ),
        (
            "transforms",
            bag::TRANSFORMS,
            Box::new(|t| bag::transforms(t, &[("world", "hand", turned), ("hand", "tip", turned)])),
        ),
        ("json", ("foxglove.PoseInFrame", "json"), Box::new(json)),
        (
            "ros1",
            ("geometry_msgs/PoseStamped", "ros1"),
            Box::new(ros1),
        ),
    ];
    let each = kinds.iter().map(|(name, kind, message)| {
        let mut bag = bag::Bag::new();
        for k in 0..4 {
            let time = START + k * 10_000_000;
            bag.add("/Hand/pose", *kind, time + 5, &message(time));
        }
        ((*name).to_owned(), bag.end())
    });
    each.collect()
}

/// Files in every layout of the `mcap` crate's writer.
fn small_files() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for (n, compression) in [None, Some(Compression::Lz4), Some(Compression::Zstd)]
        .into_iter()
        .enumerate()
    {
        for (chunks, summary) in [(true, true), (false, true), (true, false)] {
            let mut out = Cursor::new(Vec::new());
            let options = WriteOptions::new()
                .profile("x")
                .library("y")
                .compression(compression)
                .use_chunks(chunks)
                .chunk_size(Some(200));
            let options = options
                .emit_summary_records(summary)
                .emit_summary_offsets(summary)
                .emit_message_indexes(summary);
            let mut writer = options.create(&mut out).expect("memory takes all");
            let facts = BTreeMap::from([("key".to_owned(), "text".to_owned())]);
            writer
                .write_metadata(&Metadata {
                    name: "notes".to_owned(),
                    metadata: facts.clone(),
                })
                .expect("metadata");
            let schema = writer
                .add_schema("S", "jsonschema", b"{}")
                .expect("a schema");
            for topic in ["/tf_static", "/a", "/b"] {
                let schema = if topic == "/b" { 0 } else { schema };
                let channel_id = writer
                    .add_channel(schema, topic, "json", &facts)
                    .expect("a channel");
                for k in 0..3_u64 {
                    let header = MessageHeader {
                        channel_id,
                        sequence: k as u32,
                        log_time: 10 * k + 5,
                        publish_time: k,
                    };
                    writer
                        .write_to_known_channel(&header, format!("{{\"n\": {k}}}").as_bytes())
                        .expect("a message");
                }
            }
            let data = Cow::Borrowed(&b"1 2 3"[..]);
            let attachment = Attachment {
                log_time: 5,
                create_time: 6,
                name: "a".to_owned(),
                media_type: "text/plain".to_owned(),
                data,
            };
            writer.attach(&attachment).expect("an attachment");
            writer.finish().expect("memory takes all");
            drop(writer);
            files.push((format!("{n}_{chunks}_{summary}"), out.into_inner()));
        }
    }
    files
}
