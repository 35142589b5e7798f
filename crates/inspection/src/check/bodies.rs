//! Bodies and their markers: fit, rigidity, orientations that jump.

use inhand_model::{Body, Marker, MarkerKind, PoseTrack, Recording, Status, TrackedBody, World};
use inhand_statistics::runs;

use super::checkup::{CheckResult, Level};
use super::numbers::Sorted;
use super::parts::Parts;
use super::settings::CheckSettings;
use super::words::{count, length, times};

/// Markers of a body that are looked at, at most: pairs grow with the square.
const MAX_MARKERS: usize = 12;

/// Stretches that a take is divided into to tell drift from noise.
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
    let belongs = |marker: &&Marker| {
        marker.name.strip_prefix(&body.name).is_some_and(|rest| {
            let number = rest.strip_prefix('_').unwrap_or_default();
            rest.starts_with(':')
                || (!number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
        })
    };
    let markers = recording.markers.iter().filter(|m| m.kind == kind);
    markers.filter(belongs).take(MAX_MARKERS).collect()
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
pub(crate) fn bodies(
    recording: &Recording,
    parts: &Parts<'_>,
    settings: &CheckSettings,
) -> Vec<CheckResult> {
    let mut results = Vec::new();
    for body in &recording.bodies {
        results.extend(marker_error(recording, body, settings));
        let (markers, seen) = shape_of(recording, body);
        results.extend(rigidity(recording, &body.name, &markers, seen, settings));
        results.extend(orientation(recording, &body.name, &body.track, settings));
    }
    for (role, names) in parts.clusters() {
        let markers: Vec<_> = names
            .iter()
            .filter_map(|name| recording.marker(name))
            .collect();
        results.extend(rigidity(recording, role, &markers, true, settings));
    }
    for (role, track) in parts.bodies() {
        if recording.body(role).is_none() && parts.clusters().any(|(cluster, _)| cluster == role) {
            results.extend(orientation(recording, role, track, settings));
        }
    }
    results
}

/// The error that the capture software states for the body's fit.
fn marker_error(
    recording: &Recording,
    body: &TrackedBody,
    settings: &CheckSettings,
) -> Option<CheckResult> {
    let errors = Sorted::of(body.marker_error_m.as_ref()?.iter().copied());
    if errors.len() == 0 {
        return None;
    }
    let (median, p95) = (errors.median(), errors.quantile(0.95));
    let limit = settings.marker_error_m;
    let base = |level| {
        CheckResult::new("marker-error", level, body.name.clone())
            .expected(format!("a median of at most {}", length(limit)))
            .number("median_mm", 1e3 * median, errors.len())
            .number("p95_mm", 1e3 * p95, errors.len())
    };
    if median <= limit && p95 <= 3.0 * limit {
        return Some(
            base(Level::Ok).found(format!("marker error {} in the middle", length(median))),
        );
    }
    let high: Vec<f64> = body.marker_error_m.clone().unwrap_or_default();
    let places = runs(0..recording.len(), |k| {
        high.get(k).is_some_and(|&e| e > 3.0 * limit)
    });
    Some(
        base(Level::Warn)
            .at(&recording.clock, &places)
            .found(format!(
                "marker error {} in the middle, {} at the 95th percentile",
                length(median),
                length(p95)
            ))
            .advice(
                "the body's definition does not fit its markers: define it again, or calibrate",
            ),
    )
}

/// Whether distances among the markers of a body stay what they are.
pub(crate) fn rigidity(
    recording: &Recording,
    name: &str,
    markers: &[&Marker],
    seen: bool,
    settings: &CheckSettings,
) -> Option<CheckResult> {
    if markers.len() < MIN_MARKERS {
        return None;
    }
    let mut pairs = Vec::new();
    for (i, a) in markers.iter().enumerate() {
        for b in &markers[i + 1..] {
            pairs.extend(Pair::of(recording.len(), a, b));
        }
    }
    let worst = pairs.iter().max_by(|a, b| a.p95_m.total_cmp(&b.p95_m))?;
    let drifting = pairs
        .iter()
        .max_by(|a, b| a.drift_m.total_cmp(&b.drift_m))?;
    let n = pairs.iter().map(|pair| pair.n).sum();
    let spread = Sorted::of(pairs.iter().map(|pair| pair.p95_m)).median();
    let base = |level| {
        CheckResult::new("rigidity", level, name)
            .expected("distances among the markers of a body that stay the same")
            .number("p95_mm", 1e3 * worst.p95_m, worst.n)
            .number("typical_p95_mm", 1e3 * spread, n)
            .number("drift_mm", 1e3 * drifting.drift_m, drifting.n)
            .number("largest_distance_mm", 1e3 * largest(&pairs), n)
    };
    let moved = (settings.drift_m)
        .max(settings.rigid_share * drifting.median_m)
        .max(DRIFT_OVER_NOISE * drifting.noise_m);
    if drifting.drift_m > moved {
        let how = match drifting.jump(&recording.clock) {
            Some(at_s) => format!("jumps by {} near {at_s:.1} s", length(drifting.drift_m)),
            None => format!("drifts by {}", length(drifting.drift_m)),
        };
        return Some(
            base(Level::Warn)
                .found(format!(
                    "the distance {} of {} {how}",
                    drifting.names,
                    length(drifting.median_m)
                ))
                .advice("a marker was moved, came loose or changed its name: see it in a viewer"),
        );
    }
    let limit = settings.rigid_m.max(settings.rigid_share * worst.median_m);
    if worst.p95_m > limit {
        return Some(
            base(Level::Warn)
                .found(format!(
                    "not rigid: the distance {} of {} varies by {} (95th percentile)",
                    worst.names,
                    length(worst.median_m),
                    length(worst.p95_m)
                ))
                .advice("markers changed names, or sit on something soft: leave the worst one out"),
        );
    }
    // Markers that the fit places are rigid by construction.
    let how = if seen {
        "markers rigid"
    } else {
        "fitted markers rigid"
    };
    Some(base(Level::Ok).found(format!("{how} within {}", length(worst.p95_m))))
}

fn largest(pairs: &[Pair]) -> f64 {
    pairs.iter().map(|pair| pair.median_m).fold(0.0, f64::max)
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

/// A tenth of a take.
struct Block {
    /// Its middle sample.
    middle: usize,
    median_m: f64,
    /// 95th percentile of the deviation from the block's median.
    p95_m: f64,
}

impl Block {
    fn of(distances: &[(usize, f64)]) -> Self {
        let median_m = Sorted::of(distances.iter().map(|&(_, d)| d)).median();
        let off = distances.iter().map(|&(_, d)| (d - median_m).abs());
        Self {
            middle: distances[distances.len() / 2].0,
            median_m,
            p95_m: Sorted::of(off).quantile(0.95),
        }
    }
}

impl Pair {
    fn of(samples: usize, a: &Marker, b: &Marker) -> Option<Self> {
        let distances: Vec<(usize, f64)> = (0..samples)
            .filter_map(|k| Some((k, a.track.get(k)?.distance_m(b.track.get(k)?))))
            .collect();
        let sorted = Sorted::of(distances.iter().map(|&(_, d)| d));
        let median_m = sorted.median();
        if !median_m.is_finite() {
            return None;
        }
        let off = Sorted::of(distances.iter().map(|&(_, d)| (d - median_m).abs()));
        let per_block = distances.len().div_ceil(BLOCKS).max(1);
        // A median of a few samples is noise.
        let blocks = (distances.chunks(per_block))
            .filter(|block| 2 * block.len() >= per_block && block.len() >= 5)
            .map(Block::of);
        let blocks: Vec<_> = blocks.collect();
        let medians = || blocks.iter().map(|block| block.median_m);
        let low = medians().fold(f64::INFINITY, f64::min);
        let high = medians().fold(f64::NEG_INFINITY, f64::max);
        let noise_m = Sorted::of(blocks.iter().map(|block| block.p95_m)).median();
        Some(Self {
            names: format!("{} - {}", a.name, b.name),
            n: sorted.len(),
            median_m,
            p95_m: off.quantile(0.95),
            drift_m: if blocks.len() > 1 { high - low } else { 0.0 },
            noise_m,
            blocks,
        })
    }

    /// When most of the drift happens at once.
    fn jump(&self, clock: &inhand_model::Clock) -> Option<f64> {
        let step = |pair: &[Block]| (pair[1].median_m - pair[0].median_m).abs();
        let largest = (self.blocks.windows(2)).max_by(|a, b| step(a).total_cmp(&step(b)))?;
        let middle_s = |block: &Block| clock.time_s(block.middle);
        (step(largest) >= JUMP_SHARE * self.drift_m)
            .then(|| 0.5 * (middle_s(&largest[0]) + middle_s(&largest[1])))
    }
}

/// Orientations that turn faster than anything does, and how often the quaternion changes its sign.
fn orientation(
    recording: &Recording,
    name: &str,
    track: &PoseTrack<World, Body>,
    settings: &CheckSettings,
) -> Option<CheckResult> {
    let clock = recording.clock;
    let limit_rad = (settings.turn_rad_s / clock.rate_hz()).max(MIN_JUMP_RAD);
    let (mut jumps, mut signs, mut steps, mut worst) = (Vec::new(), 0, 0, 0.0_f64);
    for k in 1..track.len() {
        if track.status(k - 1) == Status::Missing || track.status(k) == Status::Missing {
            continue;
        }
        let (Some(before), Some(now)) = (track.get(k - 1), track.get(k)) else {
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
    let base = |level| {
        CheckResult::new("orientation", level, name)
            .expected(format!(
                "turns below {:.0} degrees a sample",
                limit_rad.to_degrees()
            ))
            .number("largest_turn_deg", worst.to_degrees(), steps)
            .number("jumps", jumps.len() as f64, steps)
            .number("sign_changes", signs as f64, steps)
    };
    if jumps.is_empty() {
        return Some(base(Level::Ok).found("orientation continuous"));
    }
    Some(
        base(Level::Warn)
            .at(&clock, &jumps)
            .found(format!(
                "the orientation jumps {} ({}), by up to {:.0} degrees",
                count(jumps.len(), ["time", "times"]),
                times(&clock, &jumps),
                worst.to_degrees()
            ))
            .advice(if worst >= FLIP_RAD {
                "the body was fitted the wrong way round: see it in a viewer"
            } else {
                "its fit jitters, as with hidden markers: see it in a viewer"
            }),
    )
}
