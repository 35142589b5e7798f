//! Phases of manipulation and steps of fingers as events of a take.

use inhand_model::{Annotations, Motion};

use crate::error::SessionError;
use crate::settings::Settings;
use crate::steps;

/// The annotations of a take with the phases and steps that its contacts show, by [`inhand_evaluation::with_found`]. As
/// given where the object's shape or pose is not known.
///
/// # Errors
///
/// [`SessionError::Settings`], [`SessionError::At`].
pub(crate) fn with_found(
    annotations: &Annotations,
    motion: &Motion,
    settings: &Settings,
) -> Result<Annotations, SessionError> {
    let rows = steps::contact_rows(motion, settings)?;
    Ok(rows.map_or_else(
        || annotations.clone(),
        |rows| inhand_evaluation::with_found(annotations, &rows, motion.clock),
    ))
}

#[cfg(test)]
mod tests {
    use inhand_model::{
        Clock, Event, Finger, Hand, PerFinger, PointTrack, Pose, PoseTrack, Position, StartTime,
    };
    use nalgebra::Isometry3;

    use super::*;

    /// All fingers 1 mm from a cube ahead, the index off for samples 40 to 60.
    fn motion() -> Motion {
        let tip = |finger: Finger, k: usize| {
            let off = finger == Finger::Index && (40..60).contains(&k);
            let y = if off { 0.05 } else { 0.026 };
            Some(Position::<Hand>::new(
                0.076 + 0.012 * finger.index() as f64,
                y,
                0.0,
            ))
        };
        let ahead = Pose::new(Isometry3::translation(0.1, 0.0, 0.0));
        Motion {
            name: "take".to_owned(),
            clock: Clock::new(1_000_000_000, StartTime::Stated, 100.0).unwrap(),
            fingertips: PerFinger::from_fn(|finger| {
                PointTrack::from_measured((0..100).map(|k| tip(finger, k)))
            }),
            object: Some(PoseTrack::from_measured([Some(ahead); 100])),
            hand: PoseTrack::from_measured([Some(Pose::identity()); 100]),
            selected: None,
        }
    }

    fn settings() -> Settings {
        let mut settings = Settings::default();
        settings.object.shape = Some("cube:0.05".to_owned());
        settings
    }

    fn given(label: (&str, &str)) -> Event {
        Event {
            start_unix_nanos: 1_200_000_000,
            end_unix_nanos: 1_300_000_000,
            labels: [(label.0.to_owned(), label.1.to_owned())].into(),
        }
    }

    #[test]
    fn phases_and_gaits_are_added_once_and_replaced() {
        let annotations = Annotations {
            // A person's word for a phase stays a person's.
            events: vec![given(("phase", "finger_gaiting"))],
            keys: vec!["phase".to_owned()],
            about: [("subject".to_owned(), "s01".to_owned())].into(),
        };
        let once = with_found(&annotations, &motion(), &settings()).unwrap();
        assert_eq!(once.given(), annotations.events);
        assert_eq!(once.about, annotations.about);
        let found: Vec<_> = once
            .events
            .iter()
            .filter(|event| event.is_found())
            .collect();
        let labels = |n: usize| {
            let labels = found[n].labels.iter();
            labels
                .map(|(key, value)| format!("{key}={value}"))
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(found.len(), 4);
        assert_eq!(
            labels(0),
            "by=inhand holding=thumb+index+middle+ring+little phase=in_grasp"
        );
        assert_eq!(
            labels(1),
            "by=inhand holding=thumb+middle+ring+little phase=finger_gaiting"
        );
        assert_eq!(
            labels(3),
            "by=inhand gait=index holding=thumb+middle+ring+little step_mm=0.00"
        );
        assert_eq!(found[1].start_unix_nanos, 1_400_000_000);
        assert_eq!(found[1].end_unix_nanos, 1_590_000_000);
        assert_eq!(once.keys, ["phase", "gait", "holding", "step_mm", "by"]);

        let twice = with_found(&once, &motion(), &settings()).unwrap();
        assert_eq!(twice, once);
        // Without a shape nothing is known, and nothing changes.
        let plain = with_found(&once, &motion(), &Settings::default()).unwrap();
        assert_eq!(plain, once);
    }
}
