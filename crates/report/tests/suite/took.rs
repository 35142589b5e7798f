use inhand_model::{RotationOrder, SessionFacts};
use inhand_report::{session_text, takes_text};

use crate::sample;

fn session() -> SessionFacts {
    sample::evaluation(true).session
}

#[test]
fn takes_that_agree_have_one_line_for_each_property() {
    let expected = "\
format   Motive CSV 1.23, 100 Hz, millimetres, Y up, quaternions
hand     rigid body \"RightHand\", 99.8 to 100.0 % tracked
object   rigid body \"cube 5\", 100.0 % tracked
shape    cube:0.05
fingers  thumb \"RightHand:thumb\", index \"RightHand:index\", middle
         \"RightHand:middle\", ring \"RightHand:ring\", little \"RightHand:little\"
gaps     at most ring 2.1 % (longest 0.31 s)
train    5 takes, 600 s: 590 segments of 1 s, 5 left out of cube_01 (gaps in
         ring)
test     1 take, 120 s: 119 segments of 1 s
";
    assert_eq!(session_text(&session()), expected);
}

#[test]
fn takes_are_named_where_they_differ() {
    let mut session = session();
    for take in &mut session.train {
        let source = take.source.as_mut().unwrap();
        source.rotation = Some(RotationOrder::Euler([0, 1, 2]));
        source.roles.as_mut().unwrap().object = None;
        source.object_tracked = None;
    }
    session.object = None;
    let text = session_text(&session);
    for line in [
        "format   Motive CSV 1.23, 100 Hz, millimetres, Y up, Euler angles XYZ: cube_00, ",
        "object   none: cube_00, cube_01 and 3 more",
        "         rigid body \"cube 5\", 100.0 % tracked: cube_05",
        "shape    none given",
    ] {
        let found = text.lines().any(|own| own == line.trim_end());
        assert!(found, "{line}: {text}");
    }
    let widest = text.lines().map(|line| line.chars().count()).max();
    assert!(widest <= Some(80), "{text}");
}

#[test]
fn a_take_alone_has_its_length_and_one_without_roles_only_its_format() {
    let mut take = session().train.remove(1);
    let text = takes_text(std::slice::from_ref(&take), None);
    let length = "length   12 000 samples, 120 s\n";
    assert!(text.contains(length), "{text}");
    assert!(
        text.contains("gaps     ring 2.1 % (longest 0.31 s)\n"),
        "{text}"
    );
    take.source.as_mut().unwrap().roles = None;
    let text = takes_text(std::slice::from_ref(&take), None);
    assert_eq!(text.lines().count(), 2, "{text}");
    // Evaluations of older versions know only segments.
    let mut older = session();
    for take in older.train.iter_mut().chain(&mut older.test) {
        take.source = None;
    }
    assert_eq!(session_text(&older).lines().count(), 3);
}
