//! Visualisation channels, read with the mcap and foxglove crates.

use std::collections::{BTreeMap, BTreeSet};

use foxglove::messages::{FrameTransforms, Log, Point3, PointCloud, SceneUpdate};
use inhand_channels::{
    FINGER_COLOURS, GeneratedMethod, GeneratedSegment, RECORDED, TakeFile, info, method_colour,
    write_dictionary,
};
use inhand_model::{Finger, PointTrack, PoseTrack, Recording, Shape, UpAxis};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use prost::Message;

use crate::common;
use crate::round_trip::written;

/// Log times and bytes of every message by topic, after the mcap crate's own checks.
fn messages(bytes: &[u8]) -> BTreeMap<String, Vec<(u64, Vec<u8>)>> {
    let options = mcap::read::Options::ValidateChunkCrcs.into();
    let mut by_topic: BTreeMap<String, Vec<(u64, Vec<u8>)>> = BTreeMap::new();
    let mut last = 0;
    for message in mcap::MessageStream::new_with_options(bytes, options).unwrap() {
        let message = message.unwrap();
        assert_eq!(message.log_time, message.publish_time);
        assert!(message.log_time >= last, "out of order");
        last = message.log_time;
        by_topic
            .entry(message.channel.topic.clone())
            .or_default()
            .push((message.log_time, message.data.to_vec()));
    }
    by_topic
}

fn decoded<M: Message + Default>(messages: &[(u64, Vec<u8>)]) -> Vec<M> {
    let decode = |(_, data): &(u64, Vec<u8>)| M::decode(data.as_slice()).unwrap();
    messages.iter().map(decode).collect()
}

/// Parents by child, over `/tf` and `/tf_static`; each child has one parent.
fn tree(messages: &BTreeMap<String, Vec<(u64, Vec<u8>)>>) -> BTreeMap<String, String> {
    let mut parents = BTreeMap::new();
    for topic in ["/tf_static", "/tf"] {
        let messages = messages.get(topic).map_or(&[][..], Vec::as_slice);
        for update in decoded::<FrameTransforms>(messages) {
            for edge in update.transforms {
                let parent = edge.parent_frame_id;
                let before = parents.insert(edge.child_frame_id, parent.clone());
                assert!(before.is_none_or(|before| before == parent));
            }
        }
    }
    parents
}

/// Every frame that a message draws in.
fn frames_drawn(messages: &BTreeMap<String, Vec<(u64, Vec<u8>)>>) -> BTreeSet<String> {
    let mut frames = BTreeSet::new();
    for (topic, messages) in messages
        .iter()
        .filter(|(topic, _)| topic.starts_with("/view/"))
    {
        // The two schemas differ in their fields; a topic has one of them.
        if topic == "/view/log" {
            continue;
        }
        let scenes = ["scene", "object", "hulls", "paths"];
        if scenes.iter().any(|end| topic.ends_with(end)) {
            for update in decoded::<SceneUpdate>(messages) {
                frames.extend(update.entities.into_iter().map(|entity| entity.frame_id));
            }
        } else {
            frames.extend(
                decoded::<PointCloud>(messages)
                    .into_iter()
                    .map(|c| c.frame_id),
            );
        }
    }
    frames
}

/// Draws in nothing but the tree, which is one and stands on `upright`.
fn assert_connected(bytes: &[u8], expected: &[&str]) {
    let messages = messages(bytes);
    let parents = tree(&messages);
    for frame in frames_drawn(&messages) {
        assert!(
            parents.contains_key(&frame),
            "{frame} is drawn but not placed"
        );
    }
    for (child, parent) in &parents {
        assert!(
            parent == "upright" || parents.contains_key(parent),
            "{child}"
        );
        assert!(!child.starts_with('/'));
    }
    let frames: Vec<&str> = parents.keys().map(String::as_str).collect();
    assert_eq!(frames, expected);
}

#[test]
fn the_tree_holds_what_is_drawn_and_no_more() {
    let take = common::take(300, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(&["prior"], &segments);
    let hulls = common::dictionary(3, 10, 10.0).demonstrated.hulls;
    let full = TakeFile {
        hulls: Some(&hulls),
        ..common::take_file(&take, &generated, &[])
    };
    assert_connected(&written(&full, true), &["hand", "object", "world"]);

    // Recorded bodies alone, and nothing known at all.
    let recorded = TakeFile {
        motion: None,
        generated: &[],
        ..full.clone()
    };
    assert_connected(&written(&recorded, true), &["hand", "object", "world"]);
    assert_connected(&written(&TakeFile::new(&take.recording), true), &["world"]);

    // Planned motion alone: the hand is all there is.
    let (clock, source) = (take.recording.clock, take.recording.source.clone());
    let nothing = Recording::new("plan".into(), clock, source, 300, vec![], vec![]).unwrap();
    let planned = TakeFile {
        generated: &generated,
        ..TakeFile::new(&nothing)
    };
    assert_connected(&written(&planned, true), &["hand"]);

    // No hand: nothing hangs under it, whatever else the motion claims.
    let mut motion = take.motion.clone();
    motion.hand = PoseTrack::missing(300);
    let file = TakeFile {
        motion: Some(&motion),
        ..full.clone()
    };
    assert_connected(&written(&file, true), &["world"]);

    // A hand that is seen only between the instants that views show.
    motion
        .hand
        .set(1, take.motion.hand.get(1), inhand_model::Status::Measured);
    let file = TakeFile {
        motion: Some(&motion),
        ..full.clone()
    };
    assert_connected(&written(&file, true), &["world"]);

    // No object, or one never seen.
    for object in [None, Some(PoseTrack::missing(300))] {
        let mut motion = take.motion.clone();
        motion.object = object;
        let file = TakeFile {
            motion: Some(&motion),
            ..full.clone()
        };
        assert_connected(&written(&file, true), &["hand", "world"]);
    }
}

#[test]
fn the_world_stands_upright() {
    for (up_axis, up) in [(UpAxis::Y, Vector3::y()), (UpAxis::Z, Vector3::z())] {
        let mut take = common::take(10, 100.0);
        take.recording.source.up_axis = up_axis;
        let bytes = written(&TakeFile::new(&take.recording), true);
        let statics = decoded::<FrameTransforms>(&messages(&bytes)["/tf_static"]);
        let edge = &statics[0].transforms[0];
        assert_eq!((statics.len(), edge.child_frame_id.as_str()), (1, "world"));
        let q = edge.rotation.as_ref().unwrap();
        let rotation = UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z));
        assert!((rotation * up - Vector3::z()).norm() < 1e-8);
    }
}

#[test]
fn transforms_place_fingertips_where_they_were_seen() {
    let take = common::take(100, 100.0);
    let bytes = written(&common::take_file(&take, &[], &[]), true);
    let messages = messages(&bytes);
    let edges = decoded::<FrameTransforms>(&messages["/tf"]);
    let edge = &edges[7].transforms[0];
    assert_eq!(
        (edge.parent_frame_id.as_str(), edge.child_frame_id.as_str()),
        ("world", "hand")
    );
    let (t, q) = (
        edge.translation.as_ref().unwrap(),
        edge.rotation.as_ref().unwrap(),
    );
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z));
    let world_from_hand = |p: Vector3<f64>| rotation * p + Vector3::new(t.x, t.y, t.z);
    // View 7 is sample 14; the markers shake by 0.1 mm an axis.
    let tip = take.motion.fingertips[Finger::Index]
        .get(14)
        .unwrap()
        .coords_m();
    let marker = take.recording.markers[1].track.get(14).unwrap().coords_m();
    assert!((world_from_hand(tip) - marker).norm() < 2e-4);
}

fn points(cloud: &PointCloud) -> Vec<([f32; 3], u32, [u8; 4])> {
    let names: Vec<&str> = cloud
        .fields
        .iter()
        .map(|field| field.name.as_str())
        .collect();
    assert_eq!(names[..3], ["x", "y", "z"]);
    assert_eq!(names[4..], ["red", "green", "blue", "alpha"]);
    let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
    (cloud.data.chunks(cloud.point_stride as usize))
        .map(|p| {
            (
                [float(&p[0..4]), float(&p[4..8]), float(&p[8..12])],
                u32::from_le_bytes(p[12..16].try_into().unwrap()),
                p[16..20].try_into().unwrap(),
            )
        })
        .collect()
}

#[test]
fn clouds_leave_out_what_is_missing_and_colour_the_rest() {
    let mut take = common::take(100, 100.0);
    take.motion.fingertips[Finger::Middle] = PointTrack::missing(100);
    let bytes = written(&common::take_file(&take, &[], &[]), true);
    let clouds = decoded::<PointCloud>(&messages(&bytes)["/view/fingertips"]);
    assert_eq!(clouds.len(), 25);
    // Six points around each fingertip.
    let shown = points(&clouds[3]);
    let fingers = [Finger::Thumb, Finger::Index, Finger::Ring, Finger::Little];
    assert_eq!(shown.len(), 6 * fingers.len());
    for (star, finger) in shown.chunks(6).zip(fingers) {
        let expected = take.motion.fingertips[finger].get(12).unwrap().to_array();
        for axis in 0..3 {
            let sum: f64 = (star.iter())
                .map(|(position, ..)| f64::from(position[axis]))
                .sum();
            assert!((sum / 6.0 - expected[axis]).abs() < 2e-6);
        }
        for (_, number, rgba) in star {
            assert_eq!(*number as usize, finger.index());
            assert_eq!(rgba[..3], FINGER_COLOURS[finger]);
        }
    }
    // Sample 44 lies in the ring finger's gap.
    assert!(
        points(&clouds[11])
            .iter()
            .all(|(_, number, _)| *number != 3)
    );
}

#[test]
fn scenes_light_up_contacts_and_leave_trails() {
    let take = common::take(250, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(&["prior"], &segments);
    let evaluated = common::evaluated(&["prior", RECORDED], &take);
    let bytes = written(&common::take_file(&take, &generated, &evaluated), true);
    let messages = messages(&bytes);
    let topic = "/view/generated/prior/fingertips_scene";
    let recorded = decoded::<SceneUpdate>(&messages["/view/fingertips_scene"]);
    let balls = decoded::<PointCloud>(&messages["/view/generated/prior/contacts"]);
    let (mut lit, mut dim) = (0, 0);
    let times = messages[topic].iter().map(|(unix_nanos, _)| unix_nanos);
    assert!(
        times.eq(messages["/view/generated/prior/contacts"]
            .iter()
            .map(|(at, _)| at))
    );
    for ((((unix_nanos, _), update), ball), recorded) in messages[topic]
        .iter()
        .zip(decoded::<SceneUpdate>(&messages[topic]))
        .zip(&balls)
        .zip(&recorded)
    {
        let k = take
            .recording
            .clock
            .nearest_sample((unix_nanos - take.recording.clock.start_unix_nanos()) as f64 * 1e-9);
        let judged = evaluated[0]
            .samples
            .iter()
            .find(|judged| judged.sample == k);
        let spheres = &update.entities[0].spheres;
        let Some(contact) = judged.and_then(|judged| judged.contact) else {
            assert!(spheres.is_empty(), "nothing is generated at sample {k}");
            continue;
        };
        assert_eq!(spheres.len(), Finger::COUNT);
        let shown: BTreeSet<u32> = points(ball).iter().map(|(_, finger, _)| *finger).collect();
        // Lights are of what was recorded; a plan has balls of points alone.
        assert!(update.entities[1].spheres.is_empty());
        let tips = &recorded.entities[0].spheres;
        let mut lights = recorded.entities[1].spheres.iter();
        for (finger, &touches) in contact.in_contact.iter() {
            let sphere = &spheres[finger.index()];
            // A shell in the colour of the method, which no finger has.
            assert_eq!(sphere.size.unwrap().x, 0.007);
            let colour = sphere.color.unwrap();
            let rgb = [colour.r, colour.g, colour.b].map(|c| (c * 255.0).round() as u8);
            assert_eq!(rgb, method_colour(0));
            assert_eq!(shown.contains(&(finger.index() as u32)), touches);
            if touches && tips.len() == Finger::COUNT {
                let tip = &tips[finger.index()];
                assert_eq!(lights.next().unwrap().pose, tip.pose);
                lit += 1;
            } else {
                dim += 1;
            }
        }
        assert!(tips.len() < Finger::COUNT || lights.next().is_none());
    }
    assert!(lit > 0 && dim > 0);
    let last = decoded::<SceneUpdate>(&messages["/view/fingertips_scene"])
        .pop()
        .unwrap();
    assert_eq!(last.entities[0].spheres[0].size.unwrap().x, 0.005);
    let lines = &last.entities[0].lines;
    let link = &lines[0].points;
    assert_eq!((link.len(), link[0]), (2, Point3::default()));
    let trail = &lines[1].points;
    assert!((5..15).contains(&trail.len()), "{}", trail.len());
    assert_eq!(trail.last(), link.last());
}

#[test]
fn the_object_is_sent_once_on_topics_of_its_own() {
    let take = common::take(50, 100.0);
    let shapes = [
        Shape::Cuboid {
            edges_m: [0.04, 0.05, 0.06],
        },
        Shape::Cylinder {
            diameter_m: 0.05,
            height_m: 0.08,
        },
    ];
    for shape in shapes {
        let file = TakeFile {
            object_shape: Some(shape),
            ..common::take_file(&take, &[], &[])
        };
        let messages = messages(&written(&file, true));
        let solid = decoded::<SceneUpdate>(&messages["/view/object"]);
        let entity = &solid[0].entities[0];
        assert_eq!((solid.len(), entity.frame_id.as_str()), (1, "object"));
        assert!(entity.frame_locked);
        match shape {
            Shape::Cuboid { edges_m: [x, y, z] } => {
                let size = entity.cubes[0].size.unwrap();
                assert_eq!([size.x, size.y, size.z], [x, y, z]);
            }
            Shape::Cylinder {
                diameter_m,
                height_m,
            } => {
                let cylinder = &entity.cylinders[0];
                let size = cylinder.size.unwrap();
                assert_eq!([size.x, size.y, size.z], [diameter_m, diameter_m, height_m]);
                assert_eq!((cylinder.bottom_scale, cylinder.top_scale), (1.0, 1.0));
            }
        }
    }
}

#[test]
fn an_object_of_unknown_shape_shows_its_axes() {
    let take = common::take(50, 100.0);
    let file = TakeFile {
        object_shape: None,
        ..common::take_file(&take, &[], &[])
    };
    let bytes = written(&file, true);
    assert_connected(&bytes, &["hand", "object", "world"]);
    let messages = messages(&bytes);
    let axes = &decoded::<SceneUpdate>(&messages["/view/object"])[0].entities[0];
    for (axis, line) in axes.lines.iter().enumerate() {
        let [from, to] = line.points[..] else {
            panic!("an axis has two ends");
        };
        assert_eq!(from, Point3::default());
        let along = [to.x, to.y, to.z];
        assert!(along[axis] > 0.0 && along.iter().sum::<f64>() == along[axis]);
    }
    assert_eq!(axes.lines.len(), 3);
    assert!(messages.contains_key("/view/object_edges"));
}

#[test]
fn views_are_decimated_and_stay_small() {
    for (rate_hz, view_hz) in [(30.0, 15.0), (100.0, 25.0), (120.0, 20.0), (360.0, 22.5)] {
        let take = common::take(1500, rate_hz);
        let file = common::take_file(&take, &[], &[]);
        let (with, without) = (written(&file, true), written(&file, false));
        let views = with.len() - without.len();
        assert!(views < 2 * without.len(), "{views} {}", without.len());
        let info = info(&with, "take.mcap").unwrap();
        for channel in info.channels.iter().filter(|c| c.messages > 1) {
            let found = channel.rate_hz().unwrap_or(0.0);
            if channel.topic == "/view/markers" {
                assert!((found - view_hz).abs() < 0.1, "{found}");
            }
            if channel.topic.starts_with("/view/") || channel.topic == "/tf" {
                assert!(found < 50.1, "{} {found}", channel.topic);
            }
        }
        let plain = inhand_channels::info(&without, "take.mcap").unwrap();
        let drawn = |topic: &str| topic.starts_with("/view") || topic.starts_with("/tf");
        assert!(!plain.channels.iter().any(|channel| drawn(&channel.topic)));
    }
}

#[test]
fn every_method_is_drawn_in_a_colour_of_its_own_and_the_first_with_trails() {
    let take = common::take(250, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(&["prior", "hold", "line"], &segments);
    let messages = messages(&written(&common::take_file(&take, &generated, &[]), true));
    for (place, name) in ["prior", "hold", "line"].into_iter().enumerate() {
        let clouds =
            decoded::<PointCloud>(&messages[&format!("/view/generated/{name}/fingertips")]);
        let colours: BTreeSet<[u8; 4]> = (clouds.iter().flat_map(points))
            .map(|(_, _, rgba)| rgba)
            .collect();
        let [red, green, blue] = method_colour(place);
        assert_eq!(colours, BTreeSet::from([[red, green, blue, 255]]));
        let scene = format!("/view/generated/{name}/fingertips_scene");
        assert_eq!(messages.contains_key(&scene), place == 0);
        // Nothing is judged here, so nothing is known of contacts.
        assert!(!messages.contains_key(&format!("/view/generated/{name}/contacts")));
    }
}

#[test]
fn hulls_are_outlined_once_each_edge_once() {
    let take = common::take(50, 100.0);
    let dictionary = common::dictionary(3, 10, 10.0);
    let hulls = &dictionary.demonstrated.hulls;
    let file = TakeFile {
        hulls: Some(hulls),
        ..common::take_file(&take, &[], &[])
    };
    let updates = decoded::<SceneUpdate>(&messages(&written(&file, true))["/view/hulls"]);
    assert_eq!(updates.len(), 1);
    for ((finger, hull), entity) in hulls.iter().zip(&updates[0].entities) {
        assert_eq!(entity.id, finger.name());
        let line = &entity.lines[0];
        assert_eq!(line.points.len(), hull.vertices_m.len());
        // Euler's formula, and two indices an edge.
        assert_eq!(line.indices.len(), 2 * (hull.triangles.len() * 3 / 2));
    }
}

#[test]
fn a_plan_alone_has_stars_and_its_whole_path_as_points() {
    let take = common::take(250, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(&["prior"], &segments);
    let (clock, source) = (take.recording.clock, take.recording.source.clone());
    let nothing = Recording::new("plan".into(), clock, source, 250, vec![], vec![]).unwrap();
    let planned = TakeFile {
        generated: &generated,
        ..TakeFile::new(&nothing)
    };
    let alone = messages(&written(&planned, true));
    let clouds =
        |leaf: &str| decoded::<PointCloud>(&alone[&format!("/view/generated/prior/{leaf}")]);
    // The path is the planned points of all instants at once, a finger after the other.
    let paths = clouds("path_points");
    assert_eq!(paths.len(), 1);
    let path = points(&paths[0]);
    let tips: Vec<_> = clouds("fingertips").iter().flat_map(points).collect();
    // Six points a fingertip, on opposite sides of it.
    let centres: Vec<_> = (tips.chunks_exact(6))
        .map(|star| {
            let sum = |axis: usize| star.iter().map(|(tip, ..)| tip[axis]).sum::<f32>();
            ([0, 1, 2].map(|axis| sum(axis) / 6.0), star[0].1)
        })
        .collect();
    // Every second instant of the path.
    assert_eq!(path.len(), 2 * centres.len());
    for (tip, finger) in &centres {
        let near = |point: &[f32; 3]| (0..3).all(|axis| (tip[axis] - point[axis]).abs() < 4e-6);
        let on_path = path.iter().find(|(point, f, _)| near(point) && f == finger);
        let (.., colour) = on_path.unwrap_or_else(|| panic!("{tip:?} of finger {finger}"));
        assert_eq!(colour[..3], FINGER_COLOURS[Finger::ALL[*finger as usize]]);
    }
    // Beside a recording the plan is drawn around it.
    let beside = messages(&written(&common::take_file(&take, &generated, &[]), true));
    assert!(!beside.contains_key("/view/generated/prior/path_points"));
}

#[test]
fn plans_without_a_motion_are_told_where_it_would_be() {
    let take = common::take(250, 100.0);
    let plan = common::infeasible(&take);
    let unsolved = [GeneratedSegment {
        start_sample: 100,
        samples: 100,
        trajectory: None,
        plan: Some(&plan),
    }];
    let generated = [GeneratedMethod {
        name: "prior",
        plans: true,
        segments: &unsolved,
    }];
    let messages = messages(&written(&common::take_file(&take, &generated, &[]), true));
    let (at, _) = messages["/view/log"][0];
    assert_eq!(at, take.recording.clock.unix_nanos(100));
    let log = &decoded::<Log>(&messages["/view/log"])[0];
    assert_eq!(log.name, "prior");
    assert!(log.message.starts_with("no trajectory"), "{}", log.message);
}

#[test]
fn a_dictionary_plays_with_the_path_and_profile_of_each_primitive() {
    let dictionary = common::dictionary(3, 30, 30.0);
    let mut out = Vec::new();
    write_dictionary(&mut out, &dictionary, &[]).unwrap();
    assert_connected(&out, &["hand"]);
    let messages = messages(&out);
    let second = 1_000_000_000;
    for topic in ["/view/dictionary/paths", "/view/dictionary/path_points"] {
        let times: Vec<u64> = messages[topic].iter().map(|(at, _)| *at).collect();
        assert_eq!(times, [0, second, 2 * second], "{topic}");
    }
    // Hulls as points: every corner is one of them, in its finger's place.
    let hull_points = decoded::<PointCloud>(&messages["/view/dictionary/hull_points"]);
    assert_eq!(hull_points.len(), 1);
    let hull_points = points(&hull_points[0]);
    for (finger, hull) in dictionary.demonstrated.hulls.iter() {
        for corner_m in &hull.vertices_m {
            let near =
                |at: &[f32; 3]| (0..3).all(|a| (f64::from(at[a]) - corner_m[a]).abs() < 1e-6);
            let shown = |(at, f, _): &(_, u32, _)| *f as usize == finger.index() && near(at);
            assert!(hull_points.iter().any(shown), "{finger} {corner_m:?}");
        }
    }
    let paths = decoded::<SceneUpdate>(&messages["/view/dictionary/paths"]);
    let scenes = decoded::<SceneUpdate>(&messages["/view/dictionary/primitives_scene"]);
    assert_eq!(paths[2].entities[0].texts[0].text, "primitive 2");
    for finger in Finger::ALL {
        let lines = &paths[0].entities[0].lines;
        let (mean, played) = (&lines[2 * finger.index()], &lines[2 * finger.index() + 1]);
        assert_eq!((mean.points.len(), played.points.len()), (15, 15));
        // The path begins where the fingertip does.
        let start = played.points[0];
        let tip = scenes[0].entities[0].spheres[finger.index()].pose.unwrap();
        let tip = tip.position.unwrap();
        assert_eq!([start.x, start.y, start.z], [tip.x, tip.y, tip.z]);
    }
    // The profile is the distance between the two paths.
    let profile = &messages["/dictionary/profile"];
    assert_eq!(profile.len(), 3 * 15);
    let thumb_m = profile_thumb_m(&profile[15 + 7].1);
    let lines = &paths[1].entities[0].lines;
    let (a, b) = (lines[0].points[7], lines[1].points[7]);
    let expected = ((a.x - b.x).powi(2) + (a.y - b.y).powi(2) + (a.z - b.z).powi(2)).sqrt();
    assert!(expected > 1e-5 && (thumb_m - expected).abs() < 3e-6);
}

/// Field 3 of an `inhand.Profile`, by the wire format: key 0x19, eight bytes, little end first.
fn profile_thumb_m(message: &[u8]) -> f64 {
    let at = message.iter().position(|&byte| byte == 0x19).unwrap();
    f64::from_le_bytes(message[at + 1..at + 9].try_into().unwrap())
}
