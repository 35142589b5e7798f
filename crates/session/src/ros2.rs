//! Takes as ROS 2 bags, and their views in messages of ROS 2.

use std::path::Path;

use inhand_channels::{FINGER_COLOURS, ViewsFor, method_colour};
use inhand_container::MetadataRecord;
use inhand_export::{Ros2Bag, Ros2Method, Ros2Take, write_ros2_markers};
use inhand_model::{Protocol, Shape};
use nalgebra::Isometry3;

use crate::error::{Located, SessionError};
use crate::output::write_atomic;
use crate::settings::Settings;
use crate::stored;
use crate::take::Take;

/// Topic of views in a ROS 2 bag.
pub(crate) const VIEW_MARKERS: &str = "/view/markers";

/// Frame of coordinates that come without one.
const WORLD: &str = "world";

/// Writes a take or a plan, with the motion generated in it, as a ROS 2 bag; with markers for viewers where `view`
/// says so.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write_ros2(
    path: &Path,
    take: &Take,
    settings: &Settings,
    view: bool,
) -> Result<Ros2Bag, SessionError> {
    let generated = stored::read_methods(take, Protocol::Published)?;
    let methods: Vec<_> = (generated.iter().enumerate())
        .map(|(place, method)| Ros2Method {
            name: &method.name,
            positions_m: &method.configurations_m,
            starts: method.plans.keys().copied().collect(),
            colour: method_colour(place),
        })
        .collect();
    let content = Ros2Take {
        motion: take.stored_motion.as_ref(),
        methods: &methods,
        events: &inhand_channels::events_json(&take.annotations),
        markers: view,
        ..recorded(take, settings.shape()?)
    };
    let made = crate::run::provenance("ros2", settings, [take.hash.clone()]);
    let mut records = inhand_channels::annotation_records(&take.annotations);
    for step in take.made_by(&made) {
        let step = records.next_provenance(&step);
        records.0.extend(step.0);
    }
    let records: Vec<_> = (records.0.into_iter())
        .map(|(name, facts)| MetadataRecord { name, facts })
        .collect();
    let mut written = None;
    write_atomic(path, |out| {
        written = Some(inhand_export::write_ros2(out, &content, &records).in_file(path)?);
        Ok(())
    })?;
    Ok(written.expect("what is written without an error is a bag"))
}

/// The views of a third-party take as a bag of their own, in one of the frames that the take's file has.
pub(crate) fn views(
    take: &Take,
    shape: Option<Shape>,
    views_for: &ViewsFor,
) -> Result<Vec<u8>, SessionError> {
    let root = match views_for {
        ViewsFor::ThirdParty { roots } => roots.iter().find(|(root, _)| !root.is_empty()),
        ViewsFor::Take => None,
    };
    let (frame, world_from_frame) =
        root.map_or((WORLD, Isometry3::identity()), |(root, pose)| (root, *pose));
    let mut views = Vec::new();
    let content = recorded(take, shape);
    write_ros2_markers(
        &mut views,
        &content,
        VIEW_MARKERS,
        (frame, world_from_frame),
    )
    .in_file(&take.path)?;
    Ok(views)
}

/// What was recorded of a take.
fn recorded(take: &Take, shape: Option<Shape>) -> Ros2Take<'_> {
    Ros2Take {
        recording: &take.recording,
        roles: take.roles.as_ref().ok(),
        motion: None,
        shape,
        methods: &[],
        events: &[],
        markers: true,
        finger_colours: FINGER_COLOURS,
    }
}
