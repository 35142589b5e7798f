//! Recordings and motions as tables: a wide one with columns for each entity, a tidy one with rows.

use std::collections::{BTreeMap, BTreeSet};

use inhand_model::{
    Clock, Finger, Frame, Motion, Pose, Position, Recording, Sample, Status, Track,
};

use crate::table::{Table, TableBuilder};

/// Components of a position and a rotation in the order of columns, with the unit of each.
const COMPONENTS: [(&str, &str); 7] = [
    ("x_m", "m"),
    ("y_m", "m"),
    ("z_m", "m"),
    ("qx", "1"),
    ("qy", "1"),
    ("qz", "1"),
    ("qw", "1"),
];

/// One tracked thing with its values at every sample: a marker, a body, a fingertip.
pub struct Entity<'a> {
    /// Its name, not always unique.
    pub(crate) name: String,
    /// Kind: `labelled`, `rigid_body_marker`, `unlabelled`, `rigid_body`, `bone`,
    /// `fingertip`, `object`, `hand`.
    pub(crate) kind: &'static str,
    /// Frame of its coordinates.
    pub(crate) frame: &'static str,
    /// A number of the source for each sample, NaN where missing: its name with unit, and unit.
    extra: Option<(&'static str, &'static str, &'a [f64])>,
    /// Numbers of a sample: 3 of a position, then 4 of a rotation.
    pub(crate) components: usize,
    /// Position, metres, and rotation, a unit quaternion (x, y, z, w); NaN where missing.
    numbers: Box<dyn Fn(usize) -> [f64; 7] + Sync + 'a>,
    pub(crate) status: Box<dyn Fn(usize) -> Status + Sync + 'a>,
}

impl<'a> Entity<'a> {
    fn new<T: Sample + Sync>(
        name: &str,
        kind: &'static str,
        frame: &'static str,
        track: &'a Track<T>,
        (components, numbers): (usize, fn(T) -> [f64; 7]),
    ) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            frame,
            extra: None,
            components,
            numbers: Box::new(move |k| track.get(k).map_or([f64::NAN; 7], numbers)),
            status: Box::new(move |k| track.status(k)),
        }
    }

    /// A component of a sample, NaN where missing.
    pub(crate) fn number(&self, sample: usize, component: usize) -> f64 {
        (self.numbers)(sample)[component]
    }
}

fn position<F: Frame>(position: Position<F>) -> [f64; 7] {
    let [x, y, z] = position.to_array();
    [x, y, z, f64::NAN, f64::NAN, f64::NAN, f64::NAN]
}

fn pose<To: Frame, From: Frame>(pose: Pose<To, From>) -> [f64; 7] {
    let ([x, y, z], [a, b, c, w]) = (pose.origin().to_array(), pose.quaternion_xyzw());
    [x, y, z, a, b, c, w]
}

/// Bodies, then markers of a recording, in `world`.
pub fn recording_entities(recording: &Recording) -> Vec<Entity<'_>> {
    let bodies = recording.bodies.iter().map(|body| Entity {
        extra: (body.marker_error_m.as_deref()).map(|series| ("marker_error_m", "m", series)),
        ..Entity::new(
            &body.name,
            body.kind.name(),
            "world",
            &body.track,
            (7, pose),
        )
    });
    let markers = recording.markers.iter().map(|marker| Entity {
        extra: (marker.quality.as_deref()).map(|series| ("quality", "1", series)),
        ..Entity::new(
            &marker.name,
            marker.kind.name(),
            "world",
            &marker.track,
            (3, position),
        )
    });
    bodies.chain(markers).collect()
}

/// Fingertips and object of a motion in `hand`, and the hand itself in `world`.
pub fn motion_entities(motion: &Motion) -> Vec<Entity<'_>> {
    let fingertip = |finger: Finger| {
        let track = &motion.fingertips[finger];
        Entity::new(finger.name(), "fingertip", "hand", track, (3, position))
    };
    let object = (motion.object.as_ref())
        .map(|track| Entity::new("object", "object", "hand", track, (7, pose)));
    let hand = Entity::new("hand", "hand", "world", &motion.hand, (7, pose));
    let fingertips = Finger::ALL.into_iter().map(fingertip);
    fingertips.chain(object).chain([hand]).collect()
}

/// Names of entities that differ: the second of a name is `name#2`.
pub(crate) fn unique_names(entities: &[Entity<'_>]) -> Vec<String> {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let (mut taken, mut names) = (BTreeSet::new(), Vec::with_capacity(entities.len()));
    for entity in entities {
        let name = loop {
            let count = seen.entry(&entity.name).or_insert(0);
            *count += 1;
            let name = match *count {
                1 => entity.name.clone(),
                n => format!("{}#{n}", entity.name),
            };
            // A source may itself name something `a#2`.
            if taken.insert(name.clone()) {
                break name;
            }
        };
        names.push(name);
    }
    names
}

/// One row for each sample, and for each entity its columns: `NAME.x_m`, `.y_m`, `.z_m`, with a
/// rotation `.qx`, `.qy`, `.qz`, `.qw`, then `.status`, and `.quality` or `.marker_error_m` of the source.
pub fn wide<'a>(entities: &'a [Entity<'a>], clock: Clock, samples: usize) -> Table<'a> {
    let mut table = TableBuilder::new(samples, |sample| sample);
    table.numbers("time_s", "s", move |k| clock.time_s(k));
    for (entity, name) in entities.iter().zip(unique_names(entities)) {
        for (component, (suffix, unit)) in COMPONENTS[..entity.components].iter().enumerate() {
            let number = move |k| entity.number(k, component);
            let column = table.numbers(format!("{name}.{suffix}"), unit, number);
            column.frame = entity.frame;
        }
        table.words(format!("{name}.status"), move |k| (entity.status)(k).name());
        if let Some((suffix, unit, series)) = entity.extra {
            table.numbers(format!("{name}.{suffix}"), unit, move |k| series[k]);
        }
    }
    table.finish()
}

/// One row for each sample of each entity, all entities of a sample after one another.
pub fn tidy<'a>(entities: &'a [Entity<'a>], clock: Clock, samples: usize) -> Table<'a> {
    let count = entities.len();
    // Without entities there are no rows, so that nothing is divided by zero.
    let row = move |row: usize| (row / count, &entities[row % count]);
    let mut table = TableBuilder::new(samples * count, row);
    table.numbers("time_s", "s", move |(k, _)| clock.time_s(k));
    table.counts("sample", |(k, _)| k);
    table.words("entity", |(_, entity)| &entity.name);
    table.words("kind", |(_, entity)| entity.kind);
    table.words("frame", |(_, entity)| entity.frame);
    for (component, (name, unit)) in COMPONENTS.into_iter().enumerate() {
        table.numbers(name, unit, move |(k, entity)| entity.number(k, component));
    }
    table.words("status", |(k, entity)| (entity.status)(k).name());
    for (name, unit) in [("marker_error_m", "m"), ("quality", "1")] {
        table.numbers(name, unit, move |(k, entity)| match entity.extra {
            Some((extra, _, series)) if extra == name => series[k],
            _ => f64::NAN,
        });
    }
    table.finish()
}
