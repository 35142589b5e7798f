//! C3D files: by hand in every kind of numbers, by the writer, and damaged.

use inhand_capture::roles::{RoleSettings, resolve};
use inhand_capture::{ReadSettings, c3d};
use inhand_model::{
    Clock, Finger, LengthUnit, Marker, MarkerKind, PointTrack, Position, Recording, Source,
    StartTime, UpAxis, World,
};
use proptest::prelude::*;

/// How a file by hand writes its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Numbers {
    /// 84 Intel, 85 DEC, 86 MIPS.
    processor: u8,
    floats: bool,
}

const fn numbers(processor: u8, floats: bool) -> Numbers {
    Numbers { processor, floats }
}

const ALL: [Numbers; 6] = [
    numbers(84, false),
    numbers(84, true),
    numbers(85, false),
    numbers(85, true),
    numbers(86, false),
    numbers(86, true),
];

impl Numbers {
    fn word(self, value: i32) -> Vec<u8> {
        let word = value as u16;
        if self.processor == 86 {
            word.to_be_bytes().to_vec()
        } else {
            word.to_le_bytes().to_vec()
        }
    }

    fn real(self, value: f32) -> Vec<u8> {
        match self.processor {
            84 => value.to_le_bytes().to_vec(),
            86 => value.to_be_bytes().to_vec(),
            _ => {
                // The bits of four times the number, the words swapped.
                let [a, b, c, d] = (4.0 * value).to_le_bytes();
                vec![c, d, a, b]
            }
        }
    }
}

/// A file by hand: two frames of two points and one analog channel of two samples.
#[derive(Clone)]
struct ByHand {
    numbers: Numbers,
    parameters: Vec<(&'static str, Vec<u8>)>,
    header_points: i32,
    header_last: i32,
}

impl ByHand {
    fn new(numbers: Numbers) -> Self {
        let word = |value| [vec![2, 0], numbers.word(value)].concat();
        let real = |value| [vec![4, 0], numbers.real(value)].concat();
        let text = |text: &str| [&[0xFF, 1, text.len() as u8], text.as_bytes()].concat();
        let labels = [&[0xFF, 2, 5, 2], &b"ThumbIndex"[..]].concat();
        Self {
            numbers,
            parameters: vec![
                ("POINT:USED", word(2)),
                ("POINT:SCALE", real(if numbers.floats { -0.5 } else { 0.5 })),
                ("POINT:RATE", real(160.0)),
                ("POINT:FRAMES", word(2)),
                ("POINT:DATA_START", word(0)),
                ("POINT:UNITS", text("mm  ")),
                ("POINT:LABELS", labels),
                ("ANALOG:USED", word(1)),
            ],
            header_points: 2,
            header_last: 2,
        }
    }

    fn with(mut self, name: &'static str, content: Vec<u8>) -> Self {
        self.parameters.retain(|(known, _)| *known != name);
        self.parameters.push((name, content));
        self
    }

    fn without(mut self, name: &str) -> Self {
        self.parameters.retain(|(known, _)| *known != name);
        self
    }

    fn bytes(&self) -> Vec<u8> {
        let numbers = self.numbers;
        let scale = if numbers.floats { -0.5 } else { 0.5 };
        let mut file = vec![2, 0x50];
        for value in [self.header_points, 2, 1, self.header_last, 0] {
            file.extend(numbers.word(value));
        }
        file.extend(numbers.real(scale));
        file.extend(numbers.word(3)); // block of the data
        file.extend(numbers.word(2)); // analog samples a frame
        file.extend(numbers.real(160.0));
        file.resize(512, 0);
        file.extend([1, 0x50, 1, numbers.processor]);
        for (number, group) in [(1_i8, "POINT"), (2, "ANALOG"), (3, "TRIAL"), (4, "EVENT")] {
            file.push(group.len() as u8);
            file.extend((-number).to_le_bytes());
            file.extend(group.as_bytes());
            file.extend(numbers.word(3));
            file.push(0);
            for (name, content) in &self.parameters {
                let Some(name) = name.strip_prefix(group).and_then(|n| n.strip_prefix(':')) else {
                    continue;
                };
                file.extend((-(name.len() as i8)).to_le_bytes()); // locked
                file.extend(number.to_le_bytes());
                file.extend(name.as_bytes());
                file.extend(numbers.word(content.len() as i32 + 3));
                file.extend(content);
                file.push(0);
            }
        }
        file.push(0);
        file.resize(1024, 0);
        // Halves of millimetres. The index is missing in the second frame.
        let frames = [
            [[2, 4, 6, 0], [-8, 10, 12, 0]],
            [[200, 400, 600, 0], [0, 0, 0, -1]],
        ];
        for frame in frames {
            for [x, y, z, residual] in frame {
                for value in [x, y, z] {
                    file.extend(match numbers.floats {
                        true => numbers.real(value as f32 * 0.5),
                        false => numbers.word(value),
                    });
                }
                file.extend(match numbers.floats {
                    true => numbers.real(residual as f32),
                    false => numbers.word(residual),
                });
            }
            for analog in [77, 78] {
                file.extend(match numbers.floats {
                    true => numbers.real(analog as f32),
                    false => numbers.word(analog),
                });
            }
        }
        file
    }

    fn read(&self) -> Recording {
        let settings = ReadSettings::default();
        inhand_capture::read(&self.bytes(), "walk.c3d", &settings).expect("the file is sound")
    }

    fn word(&self, value: i32) -> Vec<u8> {
        [vec![2, 0], self.numbers.word(value)].concat()
    }

    /// A number in two words, the less significant one first.
    fn long(&self, value: i32) -> Vec<u8> {
        let words = [value, value >> 16].map(|word| self.numbers.word(word));
        [vec![2, 1, 2], words.concat()].concat()
    }

    fn reals(&self, dimensions: &[u8], values: &[f32]) -> Vec<u8> {
        let values = values.iter().flat_map(|&value| self.numbers.real(value));
        let kind = [4, dimensions.len() as u8];
        (kind.iter().chain(dimensions).copied().chain(values)).collect()
    }
}

/// Texts of one length.
fn texts(texts: &[&str]) -> Vec<u8> {
    let head = [0xFF, 2, texts[0].len() as u8, texts.len() as u8];
    [&head[..], texts.concat().as_bytes()].concat()
}

fn at(recording: &Recording, marker: usize, k: usize) -> Option<[f64; 3]> {
    recording.markers[marker]
        .track
        .get(k)
        .map(Position::to_array)
}

fn has_finding(recording: &Recording, words: &str) -> bool {
    recording
        .findings
        .iter()
        .any(|f| f.to_string().contains(words))
}

#[test]
fn numbers_of_every_kind_are_the_same_take() {
    for numbers in ALL {
        let recording = ByHand::new(numbers).read();
        assert_eq!(
            (recording.name.as_str(), recording.len()),
            ("walk", 2),
            "{numbers:?}"
        );
        assert_eq!(recording.clock.rate_hz(), 160.0);
        assert_eq!(recording.clock.start_time(), StartTime::Unknown);
        assert_eq!(recording.source.length_unit, LengthUnit::Millimetres);
        let names: Vec<_> = recording.markers.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["Thumb", "Index"]);
        assert_eq!(
            at(&recording, 0, 0),
            Some([0.001, 0.002, 0.003]),
            "{numbers:?}"
        );
        assert_eq!(at(&recording, 1, 0), Some([-0.004, 0.005, 0.006]));
        assert_eq!(at(&recording, 0, 1), Some([0.1, 0.2, 0.3]));
        assert_eq!(at(&recording, 1, 1), None);
        assert_eq!(recording.source.header["POINT:UNITS"], "mm");
    }
}

#[test]
fn parameters_count_where_the_header_disagrees() {
    let mut file = ByHand::new(ALL[0]);
    file.header_points = 7;
    file.header_last = 9;
    let recording = file.read();
    assert_eq!((recording.markers.len(), recording.len()), (2, 2));
    for words in [
        "POINT:USED: the header says 7, the parameter 2",
        "POINT:FRAMES: the header says 9",
    ] {
        assert!(
            has_finding(&recording, words),
            "{words}: {:?}",
            recording.findings
        );
    }
}

#[test]
fn the_up_axis_is_that_of_the_screen() {
    let text = |text: &str| [&[0xFF, 1, text.len() as u8], text.as_bytes()].concat();
    let up = |file: ByHand| file.read().source.up_axis;
    let file = || ByHand::new(ALL[1]);
    assert_eq!(up(file()), UpAxis::Z);
    let assumed = "z is assumed; set `source.up`";
    assert!(has_finding(&file().read(), assumed));
    let stated = file().with("POINT:Y_SCREEN", text("+Z")).read();
    assert!(!has_finding(&stated, assumed));
    assert_eq!(up(file().with("POINT:Y_SCREEN", text("+Y"))), UpAxis::Y);
    assert_eq!(up(file().with("POINT:Y_SCREEN", text("+Z"))), UpAxis::Z);
    let odd = file().with("POINT:Y_SCREEN", text("-X")).read();
    assert!(has_finding(&odd, "expected +Y or +Z"));
    let bytes = file().with("POINT:Y_SCREEN", text("+Y")).bytes();
    let settings = ReadSettings {
        up_axis: Some(UpAxis::Z),
        ..ReadSettings::default()
    };
    let error = inhand_capture::read(&bytes, "a.c3d", &settings).expect_err("they disagree");
    assert!(error.to_string().contains("`source.up` says z"), "{error}");
}

#[test]
fn labels_go_on_in_further_parameters_and_may_be_too_few() {
    let file = ByHand::new(ALL[0]).with("POINT:LABELS", texts(&["Thumb"]));
    let recording = file.read();
    assert_eq!(recording.markers[1].kind, MarkerKind::Unlabelled);
    assert!(has_finding(&recording, "1 labels for 2 points"));
    let recording = file.with("POINT:LABELS2", texts(&["*113 "])).read();
    assert_eq!(recording.markers[1].name, "*113");
    assert_eq!(recording.markers[1].kind, MarkerKind::Unlabelled);
}

#[test]
fn points_without_labels_are_called_by_their_numbers() {
    let names = |file: &ByHand| -> Vec<String> {
        (file.read().markers.into_iter())
            .map(|marker| marker.name)
            .collect()
    };
    let file = ByHand::new(ALL[0]).without("POINT:LABELS");
    assert_eq!(names(&file), ["1", "2"]);
    let blank = file
        .clone()
        .with("POINT:LABELS", texts(&["Thumb", "     "]));
    assert_eq!(names(&blank), ["Thumb", "2"]);
    // Such a name can be chosen like any other, and the error lists it.
    let mut settings = RoleSettings::default();
    settings.fingers[Finger::Index] = Some("2".to_owned());
    let error = resolve(&file.read(), &settings).expect_err("the thumb is open");
    assert!(error.to_string().contains("the markers: 1, 2"), "{error}");
    assert!(!error.to_string().contains("index"), "{error}");
}

#[test]
fn outputs_of_a_model_are_no_markers() {
    let file = ByHand::new(ALL[1]);
    for (name, labels) in [
        ("POINT:ANGLES", &["Index"][..]),
        ("POINT:FORCES", &["Other", "Index"]),
        ("POINT:MOMENTS", &["Index"]),
        ("POINT:POWERS", &["Index"]),
        ("POINT:SCALARS", &["Index"]),
    ] {
        let recording = file.clone().with(name, texts(labels)).read();
        assert_eq!(recording.markers.len(), 1, "{name}");
        assert_eq!(at(&recording, 0, 1), at(&file.read(), 0, 1), "{name}");
        let words = "1 of 2 points are outputs of a model and no positions: left out: Index";
        assert!(has_finding(&recording, words), "{:?}", recording.findings);
        // None is taken for a missing sample either.
        assert!(!has_finding(&recording, "origin"));
    }
    let first = file.clone().with("POINT:ANGLES", texts(&["Thumb"])).read();
    assert_eq!(first.markers[0].name, "Index");
    assert_eq!(at(&first, 0, 0), at(&file.read(), 1, 0));
    // A list that goes on, as that of labels does.
    let file = file.with("POINT:SCALARS", texts(&["None"]));
    let recording = file.with("POINT:SCALARS2", texts(&["Index"])).read();
    assert_eq!(recording.markers.len(), 1);
}

#[test]
fn events_have_times_labels_and_contexts() {
    let file = ByHand::new(ALL[3]);
    let file = file
        .clone()
        .with("EVENT:USED", file.word(3))
        .with(
            "EVENT:TIMES",
            file.reals(&[2, 3], &[0.0, 0.5, 1.0, 2.25, 0.0, 0.0]),
        )
        .with("EVENT:LABELS", texts(&["grasp  ", "release", "       "]))
        .with("EVENT:CONTEXTS", texts(&["Right", "Left "]));
    let found = |file: &ByHand| -> Vec<(u64, Vec<(String, String)>)> {
        let events = file.read().annotations.events.into_iter();
        events
            .map(|event| {
                assert_eq!(event.start_unix_nanos, event.end_unix_nanos);
                (event.start_unix_nanos, event.labels.into_iter().collect())
            })
            .collect()
    };
    let labels = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
        let pairs = pairs.iter();
        pairs.map(|&(k, v)| (k.to_owned(), v.to_owned())).collect()
    };
    let grasp = labels(&[("context", "Right"), ("label", "grasp")]);
    let release = labels(&[("context", "Left"), ("label", "release")]);
    let all = [
        (500_000_000, grasp.clone()),
        (62_250_000_000, release.clone()),
        (0, labels(&[("label", "event")])),
    ];
    assert_eq!(found(&file), all);
    // A file that starts later: frame 25 of 160 Hz is 0.15 s after frame 1. What was before is left out.
    let later = file.clone().with("TRIAL:ACTUAL_START_FIELD", file.long(25));
    assert_eq!(
        found(&later),
        [(350_000_000, grasp), (62_100_000_000, release)]
    );
    assert!(has_finding(
        &later.read(),
        "event event at 0.000 s is before the first frame"
    ));
    let few = file
        .clone()
        .with("EVENT:TIMES", file.reals(&[2, 1], &[0.0, 0.5]));
    assert_eq!(found(&few).len(), 1);
    assert!(has_finding(
        &few.read(),
        "3 events are counted, 1 have a time"
    ));
    assert!(found(&file.clone().with("EVENT:USED", file.word(0))).is_empty());
}

#[test]
fn a_count_beyond_a_word_is_in_a_parameter_of_its_own() {
    let mut file = ByHand::new(ALL[1]);
    file.header_last = 65535;
    let file = file.clone().with("POINT:FRAMES", file.word(-1));
    for long in [file.reals(&[], &[2.0]), file.long(2)] {
        let recording = file.clone().with("POINT:LONG_FRAMES", long).read();
        assert_eq!(recording.len(), 2);
        assert!(
            !has_finding(&recording, "frames"),
            "{:?}",
            recording.findings
        );
    }
}

#[test]
fn frames_behind_those_that_are_counted_are_a_finding() {
    let file = ByHand::new(ALL[0]);
    let with_rest = |rest: usize| {
        let bytes = [file.bytes(), vec![0; rest]].concat();
        inhand_capture::read(&bytes, "a.c3d", &ReadSettings::default()).expect("sound")
    };
    // What fills up a block are no frames.
    assert!(!has_finding(&with_rest(500), "FRAMES"));
    let recording = with_rest(1000);
    assert_eq!(recording.len(), 2);
    let words = "POINT:FRAMES: the file counts 2 frames of 2 points and has room for 52";
    assert!(has_finding(&recording, words), "{:?}", recording.findings);
}

#[test]
fn a_count_that_fills_its_word_is_taken_from_the_trial() {
    let file = ByHand::new(ALL[0]);
    let long = |low, high| {
        [
            vec![2, 1, 2],
            file.numbers.word(low),
            file.numbers.word(high),
        ]
        .concat()
    };
    let mut file = file
        .clone()
        .with("POINT:FRAMES", file.word(-1))
        .with("TRIAL:ACTUAL_START_FIELD", long(1, 0))
        .with("TRIAL:ACTUAL_END_FIELD", long(2, 0));
    file.header_last = 65535;
    assert_eq!(file.read().len(), 2);
    assert!(!has_finding(&file.read(), "frames"));
    // 0x1_0002 frames are more than there are: what is there is read.
    let cut = file.with("TRIAL:ACTUAL_END_FIELD", long(2, 1)).read();
    assert_eq!(cut.len(), 2);
    assert!(
        has_finding(&cut, "promises 65538 frames"),
        "{:?}",
        cut.findings
    );
}

#[test]
fn units_may_come_from_the_user_alone() {
    let file = ByHand::new(ALL[0]).without("POINT:UNITS");
    let bytes = file.bytes();
    let error =
        inhand_capture::read(&bytes, "a.c3d", &ReadSettings::default()).expect_err("no units");
    assert!(error.to_string().contains("`source.units`"), "{error}");
    let settings = ReadSettings {
        length_unit: Some(LengthUnit::Metres),
        ..ReadSettings::default()
    };
    let recording = inhand_capture::read(&bytes, "a.c3d", &settings).expect("the user says it");
    assert_eq!(at(&recording, 0, 0), Some([1.0, 2.0, 3.0]));
}

#[test]
fn files_that_are_none_say_where() {
    let refusal = |bytes: &[u8]| {
        let refused = inhand_capture::read(bytes, "a.c3d", &ReadSettings::default());
        refused.expect_err("must be refused").to_string()
    };
    let bytes = ByHand::new(ALL[0]).bytes();
    let change = |at: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = value;
        bytes
    };
    assert!(refusal(&change(515, 1)).contains("byte 515 expected the processor"));
    assert!(refusal(&bytes[..600]).contains("to the end of the file"));
    assert!(refusal(&bytes[..1024]).contains("no samples"));
    assert!(refusal(&change(16, 200)[..]).contains("block 200"));
    // 65535 points in a file of a kilobyte.
    let many = ByHand::new(ALL[0]).with("POINT:USED", ByHand::new(ALL[0]).word(-1));
    assert!(refusal(&many.bytes()).contains("no samples"));
    let none = ByHand::new(ALL[0]).with("POINT:USED", ByHand::new(ALL[0]).word(0));
    assert!(refusal(&none.bytes()).contains("analog data alone"));
    let array = [0xFF, 7, 255, 255, 255, 255, 255, 255, 255].to_vec();
    let absurd = ByHand::new(ALL[0]).with("POINT:LABELS", array);
    assert!(refusal(&absurd.bytes()).contains("bytes of a parameter"));
}

#[test]
fn counts_that_no_file_can_mean_are_refused() {
    let names = [
        "POINT:USED",
        "POINT:DATA_START",
        "POINT:FRAMES",
        "TRIAL:ACTUAL_START_FIELD",
        "TRIAL:ACTUAL_END_FIELD",
        "ANALOG:USED",
    ];
    let values = [
        2_f32.powi(62),
        2_f32.powi(63),
        1e30,
        -1.0,
        f32::NAN,
        f32::INFINITY,
    ];
    let intel = ALL[1];
    for name in names {
        for value in values {
            let content = [vec![4, 0], intel.real(value)].concat();
            let bytes = ByHand::new(intel).with(name, content).bytes();
            let refused = inhand_capture::read(&bytes, "a.c3d", &ReadSettings::default());
            let error = refused.expect_err(name).to_string();
            assert!(error.contains(&format!("as {name}")), "{value}: {error}");
        }
    }
    // What a word can count is a matter of the file's size.
    let real = |value| [vec![4, 0], intel.real(value)].concat();
    let analog = ByHand::new(intel).with("ANALOG:USED", real(65535.0));
    assert_eq!(analog.read().len(), 2);
    let used = ByHand::new(intel).with("POINT:USED", real(2.0));
    assert_eq!(used.read().markers.len(), 2);
    let analog_alone = ByHand::new(intel).with("POINT:USED", real(65536.0)).bytes();
    assert!(inhand_capture::read(&analog_alone, "a.c3d", &ReadSettings::default()).is_err());
}

#[test]
fn a_first_frame_beyond_one_is_told() {
    let file = ByHand::new(ALL[0]);
    assert!(!has_finding(&file.read(), "first frame"));
    for (number, start) in [
        (25, file.word(25)),
        (70_000, file.long(70_000)),
        (-5, file.long(-5)),
    ] {
        let recording = file.clone().with("TRIAL:ACTUAL_START_FIELD", start).read();
        let words = format!("the first frame is number {number} of its trial: it is at 0 s here");
        assert!(has_finding(&recording, &words), "{:?}", recording.findings);
        assert_eq!((recording.len(), recording.clock.time_s(0)), (2, 0.0));
    }
    let from_zero = file.clone().with("TRIAL:ACTUAL_START_FIELD", file.word(0));
    assert!(!has_finding(&from_zero.read(), "first frame"));
}

fn recording(names: &[String], values: &[Vec<Option<[f64; 3]>>], up_axis: UpAxis) -> Recording {
    let samples = values.first().map_or(0, Vec::len);
    let markers = names.iter().zip(values).map(|(name, values)| Marker {
        name: name.clone(),
        id: String::new(),
        kind: MarkerKind::Labelled,
        track: PointTrack::<World>::from_measured(values.iter().map(|v| v.map(Position::from))),
        quality: None,
    });
    let source = Source {
        format: "test".to_owned(),
        length_unit: LengthUnit::Metres,
        up_axis,
        rotation: None,
        header: [].into(),
    };
    let clock = Clock::new(0, StartTime::Unknown, 120.0).expect("a rate");
    let markers = markers.collect();
    Recording::new("take".to_owned(), clock, source, samples, markers, vec![]).expect("one length")
}

fn written(recording: &Recording) -> Vec<u8> {
    let mut bytes = Vec::new();
    c3d::write(recording, &mut bytes).expect("memory takes all");
    assert!(bytes.len().is_multiple_of(512));
    bytes
}

fn assert_same_to_single_precision(found: &Recording, expected: &Recording) {
    assert_eq!(found.len(), expected.len());
    assert_eq!(found.clock.rate_hz(), expected.clock.rate_hz());
    assert_eq!(found.source.up_axis, expected.source.up_axis);
    assert_eq!(found.markers.len(), expected.markers.len());
    for (a, b) in found.markers.iter().zip(&expected.markers) {
        assert_eq!((&a.name, a.kind), (&b.name, b.kind));
        assert_eq!(a.track.statuses(), b.track.statuses(), "{}", a.name);
        for (a, b) in a.track.iter().flatten().zip(b.track.iter().flatten()) {
            for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
                assert!((a - b).abs() <= 6e-8 * b.abs() + 1e-40, "{a} {b}");
            }
        }
    }
}

#[test]
fn more_markers_than_a_byte_counts_and_long_names() {
    let names: Vec<String> = (0..600)
        .map(|k| format!("{k}{}", "x".repeat(120)))
        .collect();
    let values: Vec<_> = (0..600)
        .map(|k| vec![Some([f64::from(k) + 0.5, 1.0, 2.0]); 3])
        .collect();
    let expected = recording(&names, &values, UpAxis::Y);
    let found = inhand_capture::read(&written(&expected), "a.c3d", &ReadSettings::default())
        .expect("sound");
    assert_same_to_single_precision(&found, &expected);
}

#[test]
fn more_frames_than_a_word_counts() {
    let values = vec![vec![Some([0.1, 0.2, 0.3]); 70_000]];
    let expected = recording(&["Thumb".to_owned()], &values, UpAxis::Z);
    let found = inhand_capture::read(&written(&expected), "a.c3d", &ReadSettings::default())
        .expect("sound");
    assert_eq!(found.len(), 70_000);
    assert!(!has_finding(&found, "POINT"), "{:?}", found.findings);
    assert_same_to_single_precision(&found, &expected);
}

#[test]
fn more_names_than_parameters_hold_are_refused() {
    let names: Vec<String> = (0..1000)
        .map(|k| format!("{k}{}", "x".repeat(200)))
        .collect();
    let values = vec![vec![None; 2]; 1000];
    let error = c3d::write(&recording(&names, &values, UpAxis::Z), &mut Vec::new());
    let error = error.expect_err("too many").to_string();
    assert!(error.contains("bytes of marker names"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_reads_back_to_single_precision(
        values in prop::collection::vec(
            prop::collection::vec(prop::option::of(prop::array::uniform3(-3.0..3.0_f64)), 1..40),
            1..6,
        ),
        y_up in any::<bool>(),
    ) {
        let samples = values.iter().map(Vec::len).min().unwrap_or(0);
        let values: Vec<_> = values.iter().map(|v| v[..samples].to_vec()).collect();
        let names: Vec<String> = (0..values.len()).map(|k| format!("Marker {k}")).collect();
        let up_axis = if y_up { UpAxis::Y } else { UpAxis::Z };
        let expected = recording(&names, &values, up_axis);
        let found = inhand_capture::read(&written(&expected), "a.c3d", &ReadSettings::default());
        assert_same_to_single_precision(&found.expect("the file is sound"), &expected);
    }

    #[test]
    fn damage_is_refused_or_read(
        kind in 0..ALL.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        length in any::<prop::sample::Index>(),
    ) {
        let mut bytes = ByHand::new(ALL[kind]).bytes();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        bytes.truncate(length.index(bytes.len() + 1));
        let _ = inhand_capture::read(&bytes, "a.c3d", &ReadSettings::default());
    }
}
