//! Round trips, bit for bit.

use std::io::Cursor;

use inhand_channels::{
    ChannelError, EvaluatedMethod, GeneratedMethod, GeneratedSegment, Outline, TakeFile,
    TakeWriter, Views, read_dictionary, read_generated, read_leading_metadata, read_metadata,
    read_take, write_dictionary, write_take,
};
use inhand_model::{
    BodySource, Clock, DictionaryKind, Finger, Frame, LengthUnit, Motion, Plan, PoseTrack,
    Position, Protocol, Recording, Roles, RotationOrder, Sample, SegmentLayout, Shape, Source,
    StartTime, Status, Track, UpAxis,
};

use crate::common;

pub(crate) fn written(file: &TakeFile, view: bool) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let views = if view { Views::All } else { Views::None };
    write_take(&mut out, file, views).unwrap();
    out.into_inner()
}

/// Present values bit for bit, and every status.
fn bits<T: Sample, const N: usize>(
    track: &Track<T>,
    numbers: impl Fn(T) -> [f64; N],
) -> Vec<(Status, Option<[u64; N]>)> {
    (track.iter().zip(track.statuses()))
        .map(|(value, &status)| (status, value.map(|v| numbers(v).map(f64::to_bits))))
        .collect()
}

fn point_bits<F: Frame>(track: &Track<Position<F>>) -> Vec<(Status, Option<[u64; 3]>)> {
    bits(track, Position::to_array)
}

fn pose_bits<A: Frame, B: Frame>(track: &PoseTrack<A, B>) -> Vec<(Status, Option<[u64; 7]>)> {
    bits(track, |pose| {
        let ([x, y, z], [a, b, c, d]) = (pose.origin().to_array(), pose.quaternion_xyzw());
        [x, y, z, a, b, c, d]
    })
}

fn series_bits(series: Option<&Vec<f64>>) -> Option<Vec<u64>> {
    series.map(|values| values.iter().map(|value| value.to_bits()).collect())
}

pub(crate) fn assert_same_recording(found: &Recording, expected: &Recording) {
    assert_eq!(found.name, expected.name);
    assert_eq!(found.clock, expected.clock);
    assert_eq!(found.source, expected.source);
    assert_eq!(found.findings, expected.findings);
    assert_eq!(found.len(), expected.len());
    assert_eq!(found.markers.len(), expected.markers.len());
    for (found, expected) in found.markers.iter().zip(&expected.markers) {
        assert_eq!(found.name, expected.name);
        assert_eq!(found.id, expected.id);
        assert_eq!(found.kind, expected.kind);
        assert_eq!(point_bits(&found.track), point_bits(&expected.track));
        assert_eq!(
            series_bits(found.quality.as_ref()),
            series_bits(expected.quality.as_ref())
        );
    }
    assert_eq!(found.bodies.len(), expected.bodies.len());
    for (found, expected) in found.bodies.iter().zip(&expected.bodies) {
        assert_eq!(found.name, expected.name);
        assert_eq!(found.id, expected.id);
        assert_eq!(found.kind, expected.kind);
        assert_eq!(pose_bits(&found.track), pose_bits(&expected.track));
        assert_eq!(
            series_bits(found.marker_error_m.as_ref()),
            series_bits(expected.marker_error_m.as_ref())
        );
    }
}

fn assert_same_motion(found: &Motion, expected: &Motion) {
    assert_eq!(found.name, expected.name);
    assert_eq!(found.clock, expected.clock);
    for finger in Finger::ALL {
        assert_eq!(
            point_bits(&found.fingertips[finger]),
            point_bits(&expected.fingertips[finger])
        );
    }
    assert_eq!(
        found.object.as_ref().map(pose_bits),
        expected.object.as_ref().map(pose_bits)
    );
    assert_eq!(pose_bits(&found.hand), pose_bits(&expected.hand));
}

#[test]
fn a_whole_take_comes_back() {
    // 120 Hz: sample times are no whole numbers of nanoseconds.
    let mut take = common::take(450, 120.0);
    // Zeros of either sign and numbers at the ends of the range.
    for (k, number) in [-0.0, 0.0, f64::MIN_POSITIVE / 4.0, f64::MAX]
        .into_iter()
        .enumerate()
    {
        let position = Position::new(number, -number, 0.1);
        take.recording.markers[0]
            .track
            .set(k, Some(position), Status::Measured);
    }
    let segments = common::segments(&take);
    let generated = common::generated(&["prior", "line"], &segments);
    let evaluated = common::evaluated(&["prior", "recorded"], &take);
    let file = common::take_file(&take, &generated, &evaluated);
    for view in [false, true] {
        let read = read_take(&written(&file, view), "take.mcap").unwrap();
        assert_same_recording(&read.recording, &take.recording);
        assert_same_motion(&read.motion.unwrap(), &take.motion);
        assert_eq!(read.roles.as_ref(), Some(&take.roles));
        assert_eq!(read.provenance, take.provenance);
    }
}

#[test]
fn the_same_take_gives_the_same_bytes() {
    let take = common::take(300, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(&["prior"], &segments);
    let evaluated = common::evaluated(&["prior"], &take);
    let file = common::take_file(&take, &generated, &evaluated);
    let first = written(&file, true);
    assert_eq!(first, written(&file, true));
    // And what was read back gives the same bytes again.
    let read = read_take(&first, "take.mcap").unwrap();
    let again = TakeFile {
        recording: &read.recording,
        roles: read.roles.as_ref(),
        motion: read.motion.as_ref(),
        provenance: &read.provenance,
        ..file
    };
    assert_eq!(first, written(&again, true));
}

#[test]
fn parts_that_are_absent_stay_absent() {
    let take = common::take(20, 100.0);
    let read = read_take(&written(&TakeFile::new(&take.recording), true), "bare.mcap").unwrap();
    assert_same_recording(&read.recording, &take.recording);
    assert!(read.roles.is_none() && read.motion.is_none() && read.provenance.is_empty());

    let mut motion = take.motion.clone();
    motion.object = None;
    let file = TakeFile {
        motion: Some(&motion),
        ..TakeFile::new(&take.recording)
    };
    let read = read_take(&written(&file, true), "no_object.mcap").unwrap();
    assert_same_motion(&read.motion.unwrap(), &motion);

    // Tracked by name, yet never seen: that is not the same as not tracked.
    motion.object = Some(PoseTrack::missing(20));
    let file = TakeFile {
        motion: Some(&motion),
        ..TakeFile::new(&take.recording)
    };
    let read = read_take(&written(&file, true), "unseen.mcap").unwrap();
    assert_same_motion(&read.motion.unwrap(), &motion);
}

#[test]
fn takes_without_entities_or_samples_come_back() {
    for samples in [0, 7] {
        for (up_axis, length_unit, rotation) in [
            (
                UpAxis::Y,
                LengthUnit::Inches,
                Some(RotationOrder::Quaternion),
            ),
            (UpAxis::Z, LengthUnit::Feet, None),
        ] {
            let source = Source {
                format: "nothing".to_owned(),
                length_unit,
                up_axis,
                rotation,
                header: Default::default(),
            };
            let clock = Clock::new(u64::MAX, StartTime::Unknown, 1.0 / 3.0).unwrap();
            let recording =
                Recording::new(String::new(), clock, source, samples, vec![], vec![]).unwrap();
            let read = read_take(&written(&TakeFile::new(&recording), true), "empty.mcap").unwrap();
            assert_same_recording(&read.recording, &recording);
        }
    }
    let empty = common::take(5, 100.0);
    let (recording, motion) = (
        empty.recording.slice(0..0),
        Motion {
            fingertips: empty.motion.fingertips.map(|track| track.slice(0..0)),
            object: Some(PoseTrack::missing(0)),
            hand: PoseTrack::missing(0),
            ..empty.motion
        },
    );
    let file = TakeFile {
        motion: Some(&motion),
        roles: Some(&empty.roles),
        ..TakeFile::new(&recording)
    };
    let read = read_take(&written(&file, true), "no_samples.mcap").unwrap();
    assert_same_recording(&read.recording, &recording);
    assert_same_motion(&read.motion.unwrap(), &motion);
}

/// Appends a block with what methods have of its samples in the whole file.
fn append(writer: &mut TakeWriter<'_>, first: usize, block: &Recording, whole: &TakeFile<'_>) {
    let samples = first..first + block.len();
    let [method] = whole.generated else {
        panic!("one method");
    };
    let inside = |segment: &&GeneratedSegment<'_>| {
        let end = segment.start_sample + segment.samples;
        segment.start_sample < samples.end && samples.start < end
    };
    let segments: Vec<_> = method.segments.iter().filter(inside).copied().collect();
    let generated = [GeneratedMethod {
        segments: &segments,
        ..*method
    }];
    let evaluated = whole.evaluated.iter().map(|method| {
        let inside = method.samples.iter();
        let inside = inside.filter(|judged| samples.contains(&judged.sample));
        EvaluatedMethod {
            name: method.name.clone(),
            samples: inside.copied().collect(),
        }
    });
    let evaluated: Vec<_> = evaluated.collect();
    let block = TakeFile {
        generated: &generated,
        evaluated: &evaluated,
        ..TakeFile::new(block)
    };
    writer.append(&block).unwrap();
}

#[test]
fn blocks_give_the_bytes_of_the_whole() {
    for rate_hz in [30.0, 120.0] {
        let take = common::take(450, rate_hz);
        let segments = common::segments(&take);
        let generated = [GeneratedMethod {
            name: "prior",
            plans: true,
            segments: &segments,
        }];
        let evaluated = common::evaluated(&["recorded", "prior"], &take);
        let mut recording = take.recording.clone();
        // Seen by the views once, in the middle of a block, at a sample that no block starts with.
        let object = recording.bodies.len() - 1;
        for k in (0..recording.len()).filter(|&k| k != 6 * 41) {
            recording.bodies[object].track.set(k, None, Status::Missing);
        }
        let header = recording.slice(0..0);
        for motion in [None, Some(&take.motion)] {
            let file = |recording| TakeFile {
                roles: Some(&take.roles),
                motion,
                generated: &generated,
                evaluated: &evaluated,
                object_shape: Some(Shape::Cuboid { edges_m: [0.05; 3] }),
                provenance: &take.provenance,
                ..TakeFile::new(recording)
            };
            for length in [1, 7, 100, 449, 450] {
                let blocks = || {
                    let starts = (0..recording.len()).step_by(length);
                    starts.map(|k| recording.slice(k..k + length))
                };
                let mut outline = Outline::default();
                blocks().for_each(|block| outline.add(&block));
                let outline = outline.with_findings(recording.findings.clone());
                let mut out = Vec::new();
                // The names of methods are enough before the first sample.
                let named = [GeneratedMethod {
                    segments: &[],
                    ..generated[0]
                }];
                let start = TakeFile {
                    generated: &named,
                    ..file(&header)
                };
                let mut writer = TakeWriter::begin(&mut out, &start, &outline, Views::All).unwrap();
                let mut first = 0;
                for block in blocks() {
                    append(&mut writer, first, &block, &file(&recording));
                    first += block.len();
                }
                writer.finish().unwrap();
                assert!(
                    out == written(&file(&recording), true),
                    "blocks of {length}"
                );
                let metadata = read_leading_metadata(&out[..]).unwrap();
                assert_eq!(metadata.provenance("").unwrap(), take.provenance);
                for cut in (0..2000).step_by(13) {
                    read_leading_metadata(&out[..cut]).unwrap();
                }
            }
        }
    }
}

#[test]
fn a_take_that_ends_early_is_no_file() {
    let take = common::take(40, 30.0);
    let mut out = Vec::new();
    let file = TakeFile::new(&take.recording);
    let outline = Outline::new(&take.recording);
    let mut writer = TakeWriter::begin(&mut out, &file, &outline, Views::All).unwrap();
    let block = take.recording.slice(0..39);
    writer.append(&TakeFile::new(&block)).unwrap();
    let error = writer.finish().unwrap_err().to_string();
    assert!(
        error.contains("expected 40") && error.contains("39"),
        "{error}"
    );
}

#[test]
fn a_later_start_and_marker_clusters_come_back() {
    let take = common::take(40, 30.0);
    let recording = take.recording.slice(11..40);
    let roles = Roles {
        hand: BodySource::Markers(vec!["a, \"b\"".to_owned(), String::new()]),
        object: None,
        ..take.roles
    };
    let mut out = Cursor::new(Vec::new());
    let file = TakeFile {
        roles: Some(&roles),
        provenance: &take.provenance,
        ..TakeFile::new(&recording)
    };
    write_take(&mut out, &file, Views::All).unwrap();
    let read = read_take(out.get_ref(), "slice.mcap").unwrap();
    assert_same_recording(&read.recording, &recording);
    assert_eq!(read.roles, Some(roles));
}

#[test]
fn trajectories_and_plans_come_back() {
    let take = common::take(450, 120.0);
    let segments = common::segments(&take);
    let bare: Vec<_> = (segments.iter())
        .map(|segment| GeneratedSegment {
            plan: None,
            ..*segment
        })
        .collect();
    // A plan without a motion says why.
    let infeasible = common::infeasible(&take);
    let unsolved = GeneratedSegment {
        start_sample: 1,
        samples: 120,
        trajectory: None,
        plan: Some(&infeasible),
    };
    let with_unsolved = [&segments[..], &[unsolved]].concat();
    let generated = [
        GeneratedMethod {
            name: "prior",
            plans: true,
            segments: &with_unsolved,
        },
        GeneratedMethod {
            name: "line",
            plans: false,
            segments: &bare,
        },
    ];
    let file = common::take_file(&take, &generated, &[]);
    let read = read_generated(&written(&file, true), "take.mcap", Protocol::Published).unwrap();
    let names: Vec<&str> = read.iter().map(|method| method.name.as_str()).collect();
    assert_eq!(names, ["prior", "line"]);
    assert!(read[1].plans.is_empty());
    for (start, trajectory, plan) in &take.trajectories {
        for method in &read {
            for t in 0..trajectory.layout().samples {
                let found = method.configurations_m[&(start + t)];
                assert_eq!(found, trajectory.configuration_m(t));
            }
        }
        let expected = Plan {
            trajectory: None,
            ..plan.clone()
        };
        assert_eq!(read[0].plans[start], expected);
    }
    assert_eq!(read[0].plans[&1], infeasible);
    let none = read_generated(
        &written(&TakeFile::new(&take.recording), true),
        "x",
        Protocol::Published,
    )
    .unwrap();
    assert!(none.is_empty());
    // Motion of the held-out protocol has topics of its own.
    let file = TakeFile {
        held_out: &generated[..1],
        ..common::take_file(&take, &[], &[])
    };
    let bytes = written(&file, true);
    let held_out = read_generated(&bytes, "take.mcap", Protocol::HeldOut).unwrap();
    assert_eq!(held_out, read[..1]);
    let none = read_generated(&bytes, "take.mcap", Protocol::Published).unwrap();
    assert!(none.is_empty());
}

#[test]
fn metadata_says_what_messages_do_not() {
    let take = common::take(20, 100.0);
    let bytes = written(&common::take_file(&take, &[], &[]), false);
    let metadata = read_metadata(&bytes, "take.mcap").unwrap().0;
    let recording = &metadata["inhand.recording"];
    for (key, value) in [
        ("rate_hz", "100"),
        ("length_unit", "metres"),
        ("source_length_unit", "millimetres"),
        ("source_rotation", "ZYX"),
        ("start_time", "assumed_utc"),
        ("samples", "20"),
    ] {
        assert_eq!(recording[key], value, "{key}");
    }
    assert!(recording["markers"].contains("Unlabeled 1036"));
    assert_eq!(metadata["inhand.object"]["shape"], "cube:0.05");
    assert_eq!(metadata["inhand.provenance.11"]["step"], "step 10");
}

#[test]
fn a_dictionary_comes_back() {
    for kind in [DictionaryKind::Nmf, DictionaryKind::Pca] {
        let mut dictionary = common::dictionary(7, 30, 30.0);
        dictionary.kind = kind;
        let provenance = common::provenance();
        let mut out = Cursor::new(Vec::new());
        write_dictionary(&mut out, &dictionary, &provenance).unwrap();
        let mut again = Cursor::new(Vec::new());
        write_dictionary(&mut again, &dictionary, &provenance).unwrap();
        assert_eq!(out.get_ref(), again.get_ref());
        let (read, steps) = read_dictionary(out.get_ref(), "d.mcap").unwrap();
        assert_eq!(read, dictionary);
        let offset = |d: &inhand_model::Dictionary| {
            d.demonstrated.hulls[Finger::Ring].offsets_m[1].to_bits()
        };
        assert_eq!(offset(&read), offset(&dictionary));
        assert_eq!(steps, provenance);
    }
}

#[test]
fn a_dictionary_with_the_object_comes_back_and_plays_its_fingertips() {
    let layout = |object| SegmentLayout {
        samples: 20,
        rate_hz: 20.0,
        object,
    };
    let with = common::dictionary_of(3, layout(true));
    let mut out = Cursor::new(Vec::new());
    write_dictionary(&mut out, &with, &[]).unwrap();
    let (read, _) = read_dictionary(out.get_ref(), "d.mcap").unwrap();
    assert_eq!(read, with);
    assert_eq!(read.layout.rows(), 21 * 20);

    // The same fingertips without the object are played the same.
    let fingers = layout(false).rows();
    let mut without = with.clone();
    without.layout = layout(false);
    without.offset_m = with.offset_m.rows(0, fingers).clone_owned();
    without.primitives = with.primitives.rows(0, fingers).clone_owned();
    let mut of_fingers = Cursor::new(Vec::new());
    write_dictionary(&mut of_fingers, &without, &[]).unwrap();
    let played = |bytes: &[u8]| {
        let messages = mcap::MessageStream::new(bytes).unwrap().map(Result::unwrap);
        (messages.filter(|message| message.channel.topic == "/dictionary/primitives"))
            .map(|message| (message.log_time, message.data.into_owned()))
            .collect::<Vec<_>>()
    };
    assert_eq!(played(out.get_ref()).len(), 3 * 20);
    assert_eq!(played(out.get_ref()), played(of_fingers.get_ref()));
}

/// What `write_take` says to parts that do not belong together; nothing may be written then.
fn refusal(file: &TakeFile) -> String {
    let mut out = Cursor::new(Vec::new());
    let error = write_take(&mut out, file, Views::All).unwrap_err();
    assert!(matches!(error, ChannelError::Mismatch { .. }), "{error:?}");
    assert!(out.get_ref().is_empty());
    error.to_string()
}

#[test]
fn parts_of_different_takes_are_refused() {
    let take = common::take(250, 100.0);
    let other = common::take(249, 100.0);
    let faster = common::take(250, 120.0);
    let bare = TakeFile::new(&take.recording);
    let with_motion = |motion| TakeFile {
        motion: Some(motion),
        ..bare.clone()
    };
    assert!(refusal(&with_motion(&other.motion)).contains("expected 250, found 249"));
    assert!(refusal(&with_motion(&faster.motion)).contains("clock of the motion"));

    let (_, trajectory, _) = &take.trajectories[0];
    let segment = |start_sample| GeneratedSegment {
        start_sample,
        samples: trajectory.layout().samples,
        trajectory: Some(trajectory),
        plan: None,
    };
    let with_segment = |segment: GeneratedSegment, name: &str| {
        let segments = [segment];
        let generated = [GeneratedMethod {
            name,
            plans: false,
            segments: &segments,
        }];
        refusal(&TakeFile {
            generated: &generated,
            ..bare.clone()
        })
    };
    assert!(with_segment(segment(151), "prior").contains("at most 250"));
    assert!(with_segment(segment(usize::MAX), "prior").contains("at most 250"));
    for name in ["", "a/b", "a b", "präzise"] {
        assert!(
            with_segment(segment(0), name).contains("part of a topic"),
            "{name}"
        );
    }
    let (_, trajectory, _) = &faster.trajectories[0];
    let segment = GeneratedSegment {
        start_sample: 0,
        samples: trajectory.layout().samples,
        trajectory: Some(trajectory),
        plan: None,
    };
    assert!(with_segment(segment, "prior").contains("rate"));

    let mut late = common::evaluated(&["prior"], &take);
    late[0].samples[0].sample = 250;
    let twice: Vec<EvaluatedMethod> = common::evaluated(&["prior", "prior"], &take);
    for (evaluated, says) in [(&late, "below 250"), (&twice, "\"prior\" twice")] {
        let error = refusal(&TakeFile {
            evaluated,
            ..bare.clone()
        });
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn a_cleaned_recording_comes_back_beside_the_measured_one() {
    use inhand_channels::CleanedTake;
    use inhand_model::{Change, ChangeKind, Clock, Marker, Recording};

    let take = common::take(40, 100.0);
    let raw = &take.recording;
    // At half the rate, so that the two do not share a clock.
    let clock = Clock::new(raw.clock.start_unix_nanos(), raw.clock.start_time(), 50.0).unwrap();
    let markers: Vec<Marker> = (raw.markers.iter())
        .map(|marker| Marker {
            track: inhand_model::Track::from_measured((0..20).map(|k| marker.track.get(2 * k))),
            quality: None,
            ..marker.clone()
        })
        .collect();
    let recording = Recording::new(
        raw.name.clone(),
        clock,
        raw.source.clone(),
        20,
        markers,
        vec![],
    )
    .unwrap();
    let change = |kind, samples: std::ops::Range<usize>| Change {
        kind,
        entity: "Thumb".to_owned(),
        samples,
        message: format!("what {} did", ChangeKind::name(kind)),
    };
    // In the order of the steps, which is not that of time.
    let changes = [
        change(ChangeKind::Swapped, 30..35),
        change(ChangeKind::Removed, 3..4),
        change(ChangeKind::Resampled, 0..40),
    ];
    let file = TakeFile {
        cleaned: Some(CleanedTake {
            recording: &recording,
            changes: &changes,
        }),
        ..TakeFile::new(raw)
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    inhand_channels::write_take(&mut bytes, &file, Views::All).unwrap();
    let bytes = bytes.into_inner();
    let read = inhand_channels::read_take(&bytes, "a.mcap").unwrap();
    let same = |a: &Recording, b: &Recording| {
        assert_eq!(
            (a.clock, a.len(), a.markers.len()),
            (b.clock, b.len(), b.markers.len())
        );
        for (a, b) in a.markers.iter().zip(&b.markers) {
            assert!(a.track.iter().eq(b.track.iter()), "{}", a.name);
        }
    };
    same(&read.recording, raw);
    let cleaned = read.cleaned.unwrap();
    same(&cleaned.recording, &recording);
    assert_eq!(cleaned.changes, changes);

    // Messages lie in the file in time order, whichever clock they follow.
    let mut last = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let time = message.unwrap().log_time;
        assert!(time >= last, "{time} after {last}");
        last = time;
    }
    assert!(inhand_channels::read_take(&bytes[..bytes.len() - 300], "cut.mcap").is_err());
}
