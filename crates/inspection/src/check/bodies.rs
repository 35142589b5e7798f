//! Bodies and their markers: fit, rigidity, orientations that jump.

use inhand_model::{
    Body, Clock, Marker, MarkerKind, PoseTrack, Recording, TrackedBody, World, runs,
};
use inhand_motion::BodyRole;

use super::checkup::{CheckResult, Level};
use super::subject::Subject;
use super::words::{count, length, times};
use crate::lookup::is_named_after;
use crate::statistics::Finite;

/// Markers of a body that are looked at, at most: pairs grow with the square.
const MAX_MARKERS: usize = 12;

/// Intervals that a take is divided into to tell drift from noise.
const BLOCKS: usize = 10;

/// A drift counts from this many times what distances vary by within a tenth of the take.
const DRIFT_OVER_NOISE: f64 = 2.0;

/// Share of a drift that one step has to make up to be called a jump.
const JUMP_SHARE: f64 = 0.7;

/// Smallest turn between two samples that counts as a jump, radians: 20 degrees.
const MIN_JUMP_RAD: f64 = 0.35;

/// Turn from which a jump is another solution of the fit and not its jitter, radians: 60 degrees.
const FLIP_RAD: f64 = 1.05;

/// Markers that a shape needs.
pub(crate) const MIN_MARKERS: usize = 3;

/// The markers of a body by their names, `Name:Marker1` or `Name_1`, of one kind.
pub(crate) fn markers_of<'a>(
    recording: &'a Recording,
    body: &TrackedBody,
    kind: MarkerKind,
) -> Vec<&'a Marker> {
    (recording.markers.iter())
        .filter(|marker| marker.kind == kind && is_named_after(&marker.name, &body.name))
        .take(MAX_MARKERS)
        .collect()
}

/// The markers that show best whether a body is rigid: as cameras saw them, else as its fit places
/// them.
fn shape_of<'a>(recording: &'a Recording, body: &TrackedBody) -> (Vec<&'a Marker>, bool) {
    let seen = markers_of(recording, body, MarkerKind::Labelled);
    if seen.len() >= MIN_MARKERS {
        return (seen, true);
    }
    (
        markers_of(recording, body, MarkerKind::RigidBodyMarker),
        false,
    )
}

/// Fit and shape of every body, and of the clusters that roles name.
pub(crate) fn bodies(subject: &Subject<'_>) -> Vec<CheckResult> {
    let recording = subject.recording;
    let mut results = Vec::new();
    for body in &recording.bodies {
        results.extend(marker_error(subject, body));
        let (markers, seen) = shape_of(recording, body);
        results.extend(rigidity(subject, &body.name, &markers, seen));
        results.extend(orientation(subject, &body.name, &body.track));
    }
    let clusters = BodyRole::ALL.map(|role| (role, subject.templates.get(role)));
    for (role, template) in clusters {
        let names = template.map_or(&[][..], |template| &template.markers);
        let markers: Vec<_> = names
            .iter()
            .filter_map(|name| recording.marker(name))
            .collect();
        results.extend(rigidity(subject, role.name(), &markers, true));
    }
    for (role, track) in subject.bodies() {
        if recording.body(role.name()).is_none() && subject.templates.get(role).is_some() {
            results.extend(orientation(subject, role.name(), track));
        }
    }
    results
}

/// The error that the capture software states for the body's fit.
fn marker_error(subject: &Subject<'_>, body: &TrackedBody) -> Option<CheckResult> {
    let errors_m = body.marker_error_m.as_ref()?;
    let mut errors = Finite::new(errors_m.iter().copied());
    if errors.len() == 0 {
        return None;
    }
    let (median, p95) = (errors.median(), errors.quantile(0.95));
    let limit = subject.settings.marker_error_m;
    let base = |level| {
        CheckResult::new("marker-error", level, body.name.clone())
            .expected(format!("a median of at most {}", length(limit)))
            .number("median_mm", 1e3 * median, errors.len())
            .number("p95_mm", 1e3 * p95, errors.len())
    };
    let (middle, high) = (length(median), length(p95));
    if median <= limit && p95 <= 3.0 * limit {
        return Some(base(Level::Ok).found(format!("marker error {middle} in the middle")));
    }
    let places = runs(0..errors_m.len(), |k| errors_m[k] > 3.0 * limit);
    Some(
        base(Level::Warn)
            .at(&subject.recording.clock, &places)
            .found(format!(
                "marker error {middle} in the middle, {high} at the 95th percentile"
            ))
            .advice(
                "the body's definition does not fit its markers: define it again, or calibrate",
            ),
    )
}

/// Whether distances among the markers of a body stay what they are.
fn rigidity(
    subject: &Subject<'_>,
    name: &str,
    markers: &[&Marker],
    seen: bool,
) -> Option<CheckResult> {
    if markers.len() < MIN_MARKERS {
        return None;
    }
    let (recording, settings) = (subject.recording, subject.settings);
    let mut pairs = Vec::new();
    for (i, a) in markers.iter().enumerate() {
        let others = markers[i + 1..].iter();
        pairs.extend(others.filter_map(|b| Pair::new(recording.len(), a, b)));
    }
    let worst = pairs.iter().max_by(|a, b| a.p95_m.total_cmp(&b.p95_m))?;
    let drifting = pairs
        .iter()
        .max_by(|a, b| a.drift_m.total_cmp(&b.drift_m))?;
    let largest_m = pairs.iter().map(|pair| pair.median_m).fold(0.0, f64::max);
    let n = pairs.iter().map(|pair| pair.n).sum();
    let spread = Finite::new(pairs.iter().map(|pair| pair.p95_m)).median();
    let base = |level| {
        CheckResult::new("rigidity", level, name)
            .expected("distances among the markers of a body that stay the same")
            .number("p95_mm", 1e3 * worst.p95_m, worst.n)
            .number("typical_p95_mm", 1e3 * spread, n)
            .number("drift_mm", 1e3 * drifting.drift_m, drifting.n)
            .number("largest_distance_mm", 1e3 * largest_m, n)
    };
    let moved = (settings.drift_m)
        .max(settings.rigid_share * drifting.median_m)
        .max(DRIFT_OVER_NOISE * drifting.noise_m);
    if drifting.drift_m > moved {
        let drift = length(drifting.drift_m);
        let how = match drifting.jump(&recording.clock) {
            Some(at_s) => format!("jumps by {drift} near {at_s:.1} s"),
            None => format!("drifts by {drift}"),
        };
        let (names, distance) = (&drifting.names, length(drifting.median_m));
        return Some(
            base(Level::Warn)
                .found(format!("the distance {names} of {distance} {how}"))
                .advice("a marker was moved, came loose or changed its name: see it in a viewer"),
        );
    }
    let variation = length(worst.p95_m);
    let limit = settings.rigid_m.max(settings.rigid_share * worst.median_m);
    if worst.p95_m > limit {
        let (names, distance) = (&worst.names, length(worst.median_m));
        return Some(
            base(Level::Warn)
                .found(format!(
                    "not rigid: the distance {names} of {distance} varies by {variation} (95th \
                     percentile)"
                ))
                .advice("markers changed names, or sit on something soft: leave the worst one out"),
        );
    }
    // Markers that the fit places are rigid by construction.
    let fitted = if seen { "" } else { "fitted " };
    Some(base(Level::Ok).found(format!("{fitted}markers rigid within {variation}")))
}

/// Two markers of a body.
struct Pair {
    names: String,
    n: usize,
    median_m: f64,
    /// 95th percentile of the deviation from the median distance.
    p95_m: f64,
    /// Range of the median distances of blocks.
    drift_m: f64,
    /// 95th percentile of the deviation within a block, in the middle of all blocks: what goes to and
    /// fro is no drift.
    noise_m: f64,
    blocks: Vec<Block>,
}

/// Distances over a tenth of a take.
struct Block {
    /// Its middle sample.
    middle: usize,
    median_m: f64,
    /// 95th percentile of the deviation from the block's median.
    p95_m: f64,
}

impl Block {
    fn new(distances: &[(usize, f64)]) -> Self {
        let median_m = Finite::new(distances.iter().map(|&(_, d)| d)).median();
        let off = distances.iter().map(|&(_, d)| (d - median_m).abs());
        Self {
            middle: distances[distances.len() / 2].0,
            median_m,
            p95_m: Finite::new(off).quantile(0.95),
        }
    }
}

impl Pair {
    fn new(samples: usize, a: &Marker, b: &Marker) -> Option<Self> {
        let distances: Vec<(usize, f64)> = (0..samples)
            .filter_map(|k| Some((k, a.track.get(k)?.distance_m(b.track.get(k)?))))
            .collect();
        if distances.is_empty() {
            return None;
        }
        let whole = Block::new(&distances);
        let per_block = distances.len().div_ceil(BLOCKS).max(1);
        // A median of a few samples is noise.
        let blocks: Vec<_> = (distances.chunks(per_block))
            .filter(|block| 2 * block.len() >= per_block && block.len() >= 5)
            .map(Block::new)
            .collect();
        let medians = || blocks.iter().map(|block| block.median_m);
        let low = medians().fold(f64::INFINITY, f64::min);
        let high = medians().fold(f64::NEG_INFINITY, f64::max);
        let noise_m = Finite::new(blocks.iter().map(|block| block.p95_m)).median();
        Some(Self {
            names: format!("{} - {}", a.name, b.name),
            n: distances.len(),
            median_m: whole.median_m,
            p95_m: whole.p95_m,
            drift_m: if blocks.len() > 1 { high - low } else { 0.0 },
            noise_m,
            blocks,
        })
    }

    /// When most of the drift happens at once.
    fn jump(&self, clock: &Clock) -> Option<f64> {
        let step = |pair: &[Block]| (pair[1].median_m - pair[0].median_m).abs();
        let largest = (self.blocks.windows(2)).max_by(|a, b| step(a).total_cmp(&step(b)))?;
        let middle_s = |block: &Block| clock.time_s(block.middle);
        (step(largest) >= JUMP_SHARE * self.drift_m)
            .then(|| 0.5 * (middle_s(&largest[0]) + middle_s(&largest[1])))
    }
}

/// Orientations that turn faster than anything does, and how often the quaternion changes its sign.
fn orientation(
    subject: &Subject<'_>,
    name: &str,
    track: &PoseTrack<World, Body>,
) -> Option<CheckResult> {
    let clock = subject.recording.clock;
    let limit_rad = (subject.settings.turn_rad_s / clock.rate_hz()).max(MIN_JUMP_RAD);
    let (mut jumps, mut signs, mut steps, mut worst) = (Vec::new(), 0, 0, 0.0_f64);
    for k in 1..track.len() {
        let Some((before, now)) = track.get(k - 1).zip(track.get(k)) else {
            continue;
        };
        let (before, now) = (before.isometry().rotation, now.isometry().rotation);
        steps += 1;
        signs += usize::from(before.coords.dot(&now.coords) < 0.0);
        let angle = before.angle_to(&now);
        worst = worst.max(angle);
        if angle > limit_rad {
            jumps.push(k..k + 1);
        }
    }
    if steps == 0 {
        return None;
    }
    let (limit_deg, worst_deg) = (limit_rad.to_degrees(), worst.to_degrees());
    let base = |level| {
        CheckResult::new("orientation", level, name)
            .expected(format!("turns below {limit_deg:.0} degrees a sample"))
            .number("largest_turn_deg", worst_deg, steps)
            .number("jumps", jumps.len() as f64, steps)
            .number("sign_changes", signs as f64, steps)
    };
    if jumps.is_empty() {
        return Some(base(Level::Ok).found("orientation continuous"));
    }
    let (often, when) = (count(jumps.len(), ["time", "times"]), times(&clock, &jumps));
    Some(
        base(Level::Warn)
            .at(&clock, &jumps)
            .found(format!(
                "the orientation jumps {often} ({when}), by up to {worst_deg:.0} degrees"
            ))
            .advice(if worst >= FLIP_RAD {
                "the body was fitted the wrong way round: see it in a viewer"
            } else {
                "its fit jitters, as with hidden markers: see it in a viewer"
            }),
    )
}
