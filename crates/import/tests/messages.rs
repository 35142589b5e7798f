//! Each kind of message, to the last bit.

use foxglove::messages as viewer;
use foxglove::messages::packed_element_field::NumericType;
use inhand_model::{LengthUnit, MarkerKind, StartTime, UpAxis};
use prost::Message;

use super::bag::{self, Bag, Cdr, Seven};
use super::{at, body, marker, read, stamp, straight, turned};

#[test]
fn markers_and_bodies_in_either_order_of_bytes() {
    for little_endian in [true, false] {
        let mut bag = Bag::new();
        for k in 0..20 {
            let x = k as f64;
            let all = [("Thumb", [x, 0.1, 0.2]), ("Index", [0.3, -x, 0.5])];
            // The thumb is out of sight at samples 7 and 8, the index is no number at 9.
            let mut seen = if (7..9).contains(&k) {
                &all[1..]
            } else {
                &all[..]
            }
            .to_vec();
            if k == 9 {
                seen[1].1[1] = f64::NAN;
            }
            let message = bag::markers(little_endian, stamp(k), &seen);
            bag.add("/markers", bag::MARKERS, stamp(k) + 4_000_000, &message);
            let message = bag::bodies(little_endian, stamp(k), &[("Hand", turned(x, 1.0, 2.0))]);
            bag.add("/rigid_bodies", bag::BODIES, stamp(k) + 4_000_000, &message);
        }
        let recording = read(&bag.end());
        assert_eq!((recording.name.as_str(), recording.len()), ("bag", 20));
        let clock = recording.clock;
        assert_eq!(
            (clock.rate_hz(), clock.start_unix_nanos()),
            (100.0, stamp(0))
        );
        assert_eq!(clock.start_time(), StartTime::Stated);
        assert_eq!(recording.source.up_axis, UpAxis::Z);
        assert_eq!(recording.source.length_unit, LengthUnit::Metres);
        let thumb = marker(&recording, "Thumb");
        assert_eq!(at(thumb, 6), Some([6.0, 0.1, 0.2]));
        assert_eq!((at(thumb, 7), at(thumb, 8)), (None, None));
        assert_eq!(thumb.track.counts().missing, 2);
        let index = marker(&recording, "Index");
        assert_eq!(at(index, 8), Some([0.3, -8.0, 0.5]));
        assert_eq!((at(index, 9), index.track.counts().missing), (None, 1));
        let pose = body(&recording, "Hand").track.get(3).unwrap();
        assert_eq!(pose.origin().to_array(), [3.0, 1.0, 2.0]);
        assert_eq!(pose.quaternion_xyzw(), [0.0, 0.0, 1.0, 0.0]);
        let own = marker(&recording, "Hand:4");
        assert_eq!(own.kind, MarkerKind::RigidBodyMarker);
        assert_eq!(at(own, 3), Some([3.0, 1.0, 2.0]));
    }
}

#[test]
fn markers_without_names_go_by_their_numbers_and_are_unlabelled() {
    let mut bag = Bag::new();
    for k in 0..5 {
        let message = bag::markers(
            true,
            stamp(k),
            &[("", [1.0, 2.0, 3.0]), ("", [4.0, 5.0, 6.0])],
        );
        bag.add("/markers", bag::MARKERS, stamp(k), &message);
    }
    let recording = read(&bag.end());
    let second = marker(&recording, "1");
    assert_eq!(
        (second.kind, second.id.as_str()),
        (MarkerKind::Unlabelled, "1")
    );
    assert_eq!(at(second, 4), Some([4.0, 5.0, 6.0]));
}

#[test]
fn two_markers_of_one_name_stay_two() {
    let mut bag = Bag::new();
    for k in 0..5 {
        let seen = [("tip", [1.0, 2.0, 3.0]), ("tip", [4.0, 5.0, 6.0])];
        // The first of two is the first one, also where there is one alone.
        let seen = if k == 2 { &seen[..1] } else { &seen[..] };
        bag.add(
            "/markers",
            bag::MARKERS,
            stamp(k),
            &bag::markers(true, stamp(k), seen),
        );
    }
    let recording = read(&bag.end());
    let names: Vec<_> = recording.markers.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["tip", "tip"]);
    assert_eq!(at(&recording.markers[0], 2), Some([1.0, 2.0, 3.0]));
    assert_eq!(at(&recording.markers[1], 1), Some([4.0, 5.0, 6.0]));
    assert_eq!(at(&recording.markers[1], 2), None);
}

#[test]
fn points_and_pose_arrays() {
    let mut bag = Bag::new();
    for k in 0..5 {
        let point = Cdr::new(true)
            .header(stamp(k), "world")
            .f64s(&[0.1, 0.2, 0.3])
            .end();
        bag.add(
            "/natnet_ros/Hand/marker2/pose",
            bag::POINT,
            stamp(k),
            &point,
        );
        let poses = Cdr::new(false).header(stamp(k), "world").u32(2);
        let poses = poses
            .f64s(&turned(1.0, 2.0, 3.0))
            .f64s(&turned(4.0, 5.0, 6.0))
            .end();
        bag.add(
            "/poses",
            ("geometry_msgs/msg/PoseArray", "cdr"),
            stamp(k),
            &poses,
        );
    }
    let recording = read(&bag.end());
    assert_eq!(
        at(marker(&recording, "Hand:marker2"), 4),
        Some([0.1, 0.2, 0.3])
    );
    let second = body(&recording, "1").track.get(0).unwrap();
    assert_eq!(second.origin().to_array(), [4.0, 5.0, 6.0]);
}

fn quarter_turn_about_z(x: f64, y: f64, z: f64) -> Seven {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    [x, y, z, 0.0, 0.0, half, half]
}

#[test]
fn transforms_are_chained_up_to_the_highest_frame_that_moves() {
    let mut bag = Bag::new();
    let fixed = bag::transforms(
        0,
        &[
            ("building", "world", straight(100.0, 0.0, 0.0)),
            ("hand", "mount", straight(0.0, 0.0, 1.0)),
        ],
    );
    bag.add("/tf_static", bag::TRANSFORMS, stamp(0), &fixed);
    for k in 0..5 {
        let moving = [
            ("world", "hand", quarter_turn_about_z(1.0, 0.0, 0.0)),
            ("mount", "object", straight(1.0, 0.0, 0.0)),
        ];
        // The hand is not seen at sample 3: where the object is in the world is not known either.
        let seen = if k == 3 { &moving[1..] } else { &moving[..] };
        bag.add(
            "/tf",
            bag::TRANSFORMS,
            stamp(k),
            &bag::transforms(stamp(k), seen),
        );
    }
    let recording = read(&bag.end());
    let names: Vec<_> = recording.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["hand", "object"]);
    let hand = body(&recording, "hand").track.get(4).unwrap();
    assert_eq!(hand.origin().to_array(), [1.0, 0.0, 0.0]);
    // One along the x axis of the mount, which a quarter turn has pointed along y.
    let object = &body(&recording, "object").track;
    let origin = object.get(4).unwrap().origin().to_array();
    let expected = [1.0, 1.0, 1.0];
    assert!(
        origin
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-15),
        "{origin:?}"
    );
    assert_eq!(object.get(3), None);
}

#[test]
fn frames_in_a_circle_are_left_out() {
    let mut bag = Bag::new();
    for k in 0..5 {
        let message = [
            ("a", "b", turned(1.0, 0.0, 0.0)),
            ("b", "a", turned(1.0, 0.0, 0.0)),
            ("world", "hand", turned(1.0, 2.0, 3.0)),
        ];
        bag.add(
            "/tf",
            bag::TRANSFORMS,
            stamp(k),
            &bag::transforms(stamp(k), &message),
        );
    }
    let recording = read(&bag.end());
    assert_eq!(recording.bodies.len(), 1);
    super::assert_found(&recording, "in a circle");
}

fn viewer_time(k: u64) -> Option<viewer::Timestamp> {
    let nanos = stamp(k);
    let seconds = (nanos / 1_000_000_000) as u32;
    Some(viewer::Timestamp::new(
        seconds,
        (nanos % 1_000_000_000) as u32,
    ))
}

fn viewer_pose([x, y, z, qx, qy, qz, qw]: Seven) -> viewer::Pose {
    viewer::Pose {
        position: Some(viewer::Vector3 { x, y, z }),
        orientation: Some(viewer::Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w: qw,
        }),
    }
}

/// Two markers with numbers 7 and 9, in a cloud that is turned and moved.
fn cloud(k: u64) -> viewer::PointCloud {
    let mut data = Vec::new();
    for (number, at) in [(7_u16, [1.0_f32, 2.0, 3.0]), (9, [4.0, 5.0, 6.0])] {
        data.extend(at.iter().flat_map(|c| c.to_le_bytes()));
        data.extend(number.to_le_bytes());
    }
    let field = |name: &str, offset, numeric: NumericType| viewer::PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: numeric.into(),
    };
    viewer::PointCloud {
        timestamp: viewer_time(k),
        frame_id: "world".to_owned(),
        pose: Some(viewer_pose(turned(10.0, 20.0, 30.0))),
        point_stride: 14,
        fields: vec![
            field("x", 0, NumericType::Float32),
            field("y", 4, NumericType::Float32),
            field("z", 8, NumericType::Float32),
            field("id", 12, NumericType::Uint16),
        ],
        data: data.into(),
    }
}

fn viewer_bag(encoding: &'static str, encode: impl Fn(u64) -> [Vec<u8>; 4]) -> Vec<u8> {
    let mut bag = Bag::new();
    for k in 0..5 {
        let [pose, poses, transforms, cloud] = encode(k);
        bag.add(
            "/Hand/pose",
            ("foxglove.PoseInFrame", encoding),
            stamp(k),
            &pose,
        );
        bag.add(
            "/poses",
            ("foxglove.PosesInFrame", encoding),
            stamp(k),
            &poses,
        );
        bag.add(
            "/tf",
            ("foxglove.FrameTransforms", encoding),
            stamp(k),
            &transforms,
        );
        bag.add(
            "/points",
            ("foxglove.PointCloud", encoding),
            stamp(k),
            &cloud,
        );
    }
    bag.end()
}

fn assert_viewer_take(bytes: &[u8]) {
    let recording = read(bytes);
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 5));
    let hand = body(&recording, "Hand").track.get(2).unwrap();
    assert_eq!(hand.origin().to_array(), [2.0, 0.25, 0.5]);
    let second = body(&recording, "1").track.get(2).unwrap();
    assert_eq!(second.origin().to_array(), [4.0, 5.0, 6.0]);
    let object = body(&recording, "object").track.get(2).unwrap();
    assert_eq!(object.origin().to_array(), [7.0, 8.0, 9.0]);
    // Half a turn about z, then the way to where the cloud stands.
    assert_eq!(at(marker(&recording, "7"), 4), Some([9.0, 18.0, 33.0]));
    assert_eq!(at(marker(&recording, "9"), 4), Some([6.0, 15.0, 36.0]));
}

#[test]
fn viewer_messages_in_protobuf() {
    assert_viewer_take(&viewer_bag("protobuf", |k| {
        let pose = viewer::PoseInFrame {
            timestamp: viewer_time(k),
            frame_id: "world".to_owned(),
            pose: Some(viewer_pose(turned(k as f64, 0.25, 0.5))),
        };
        let poses = viewer::PosesInFrame {
            timestamp: viewer_time(k),
            frame_id: "world".to_owned(),
            poses: vec![
                viewer_pose(turned(1.0, 2.0, 3.0)),
                viewer_pose(turned(4.0, 5.0, 6.0)),
            ],
        };
        let transform = viewer::FrameTransform {
            timestamp: viewer_time(k),
            parent_frame_id: "world".to_owned(),
            child_frame_id: "object".to_owned(),
            translation: Some(viewer::Vector3 {
                x: 7.0,
                y: 8.0,
                z: 9.0,
            }),
            rotation: Some(viewer::Quaternion {
                x: 0.0,
                y: 0.0,
                z: 0.0,
                w: 1.0,
            }),
        };
        let transforms = viewer::FrameTransforms {
            transforms: vec![transform],
        };
        [
            pose.encode_to_vec(),
            poses.encode_to_vec(),
            transforms.encode_to_vec(),
            cloud(k).encode_to_vec(),
        ]
    }));
}

#[test]
fn viewer_messages_in_json() {
    let about = |k: u64| {
        let nanos = stamp(k);
        let (sec, nsec) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
        format!(r#""timestamp":{{"sec":{sec},"nsec":{nsec}}},"frame_id":"world""#)
    };
    let pose = |[x, y, z, qx, qy, qz, qw]: Seven| {
        format!(
            r#"{{"position":{{"x":{x},"y":{y},"z":{z}}},"orientation":{{"x":{qx},"y":{qy},"z":{qz},"w":{qw}}}}}"#
        )
    };
    assert_viewer_take(&viewer_bag("json", |k| {
        let about = about(k);
        let time = about.split(",\"frame").next().unwrap();
        let of = cloud(k);
        let fields: Vec<String> = (of.fields.iter())
            .map(|f| {
                format!(
                    r#"{{"name":"{}","offset":{},"type":{}}}"#,
                    f.name, f.offset, f.r#type
                )
            })
            .collect();
        [
            format!("{{{about},\"pose\":{}}}", pose(turned(k as f64, 0.25, 0.5))),
            format!(
                "{{{about},\"poses\":[{},{}]}}",
                pose(turned(1.0, 2.0, 3.0)),
                pose(turned(4.0, 5.0, 6.0))
            ),
            format!(
                r#"{{"transforms":[{{{time},"parent_frame_id":"world","child_frame_id":"object","translation":{{"x":7,"y":8,"z":9}},"rotation":{{"x":0,"y":0,"z":0,"w":1}}}}]}}"#
            ),
            format!(
                r#"{{{about},"pose":{},"point_stride":14,"fields":[{}],"data":"{}"}}"#,
                pose(turned(10.0, 20.0, 30.0)),
                fields.join(","),
                // The bytes of `cloud` by another program.
                "AACAPwAAAEAAAEBABwAAAIBAAACgQAAAwEAJAA=="
            ),
        ]
        .map(String::into_bytes)
    }));
}

#[test]
fn messages_of_ros_1_are_read_as_those_of_ros_2() {
    fn header(k: u64) -> Vec<u8> {
        let (seconds, nanos) = (stamp(k) / 1_000_000_000, stamp(k) % 1_000_000_000);
        let numbers = [k as u32, seconds as u32, nanos as u32, 5].map(u32::to_le_bytes);
        [numbers.concat(), b"world".to_vec()].concat()
    }
    fn reals(values: &[f64]) -> Vec<u8> {
        values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect()
    }
    const NAME: &[u8] = b"\x04\0\0\0Cube";
    let mut bag = Bag::new();
    let ros1 = |schema| (schema, "ros1");
    for k in 0..50 {
        let pose = turned(k as f64, 1.0, 2.0);
        let log = stamp(k) + 4_000_000;
        let stamped = [header(k), reals(&pose)].concat();
        bag.add(
            "/Hand/pose",
            ros1("geometry_msgs/PoseStamped"),
            log,
            &stamped,
        );
        let point = [header(k), reals(&[k as f64, 0.5, 0.25])].concat();
        bag.add(
            "/Thumb/point",
            ros1("geometry_msgs/PointStamped"),
            log,
            &point,
        );
        let transform = [header(k), NAME.to_vec(), reals(&pose)].concat();
        bag.add(
            "/cube",
            ros1("geometry_msgs/TransformStamped"),
            log,
            &transform,
        );
        let poses = [header(k), vec![2, 0, 0, 0], reals(&pose), reals(&pose)].concat();
        bag.add("/poses", ros1("geometry_msgs/PoseArray"), log, &poses);
    }
    let recording = read(&bag.end());
    assert_eq!(
        (recording.len(), recording.clock.start_unix_nanos()),
        (50, stamp(0))
    );
    assert_eq!(at(marker(&recording, "Thumb"), 49), Some([49.0, 0.5, 0.25]));
    for name in ["Hand", "Cube"] {
        let pose = body(&recording, name).track.get(7).unwrap();
        assert_eq!(pose.origin().to_array(), [7.0, 1.0, 2.0], "{name}");
        assert_eq!(pose.quaternion_xyzw(), [0.0, 0.0, 1.0, 0.0], "{name}");
    }
    assert_eq!(recording.bodies.len(), 4);
    assert_eq!(
        recording.source.header["topic /Hand/pose"],
        "geometry_msgs/PoseStamped, ros1, 50 messages"
    );
    super::assert_found(&recording, "times are capture times");
}

#[test]
fn an_encoding_that_is_not_read_is_named() {
    let add = |bag: &mut Bag, k| {
        let kind = ("geometry_msgs/msg/PoseStamped", "protobuf");
        bag.add("/Hand/pose", kind, stamp(k), b"whatever");
    };
    let mut bag = Bag::new();
    add(&mut bag, 0);
    let error = super::refusal(&bag.end(), &Default::default());
    let words = "/Hand/pose has geometry_msgs/msg/PoseStamped in encoding \"protobuf\", which is read in \
                 cdr, ros1 alone; record it in one of those encodings, or convert the file";
    assert!(error.contains(words), "{error}");
    // Beside a topic that is read it is a finding, unless the user leaves it out.
    let mut bag = Bag::new();
    for k in 0..20 {
        add(&mut bag, k);
        let message = bag::markers(true, stamp(k), &[("Thumb", [1.0, 2.0, 3.0])]);
        bag.add("/markers", bag::MARKERS, stamp(k), &message);
    }
    let bytes = bag.end();
    super::assert_found(
        &read(&bytes),
        "/Hand/pose: geometry_msgs/msg/PoseStamped in encoding",
    );
    let settings = super::topics(&[("/Hand/pose", "ignore")]);
    assert!(!super::findings(&super::read_with(&bytes, &settings)).contains("protobuf"));
}
