//! Fingertips of takes against the hand's rotations, against noise and against the other takes.

use inhand_model::{BodySource, Finger, LengthUnit, Level, SessionFinding};
use nalgebra::{Matrix3, Vector3};

use super::{SessionMotion, TakeLook, finding, of_take};
use crate::check::rotation_by_fingertips;
use crate::check::words::length;
use crate::statistics::{Finite, median_and_deviation};

/// Noise of a coordinate of a fingertip above which its motion is doubtful, metres: captures have 0.1 mm.
const NOISE_M: f64 = 1e-3;

/// Distance of a take's median fingertips from those of the other takes that needs an explanation, metres. Parts
/// of one recording are up to 11 mm apart; the least exchange of two labels gives 8.5 mm.
const DISAGREE_M: f64 = 6e-3;

/// The same distance from which it is another hand or another body on it, whatever the explanation, metres.
const OTHER_HAND_M: f64 = 0.02;

/// An explanation has to leave at most this share of the distance.
const EXPLAINED: f64 = 1.0 / 3.0;

/// Change of a hand's size between takes that is worth knowing.
const SIZE_SHARE: f64 = 0.1;

/// Median places of the fingertips in the hand's frame, metres.
pub(super) type Tips = [Vector3<f64>; 5];

/// Median places of the fingertips; `None` where one is never seen.
pub(super) fn median_tips(take: &SessionMotion<'_>) -> Option<Tips> {
    let tips = Finger::ALL.map(|finger| {
        let track = &take.motion.fingertips[finger];
        Vector3::from_fn(|axis, _| {
            let places = track.iter().flatten();
            Finite::new(places.map(|tip| tip.coords_m()[axis])).median()
        })
    });
    let is_seen = tips.iter().flatten().all(|number| number.is_finite());
    is_seen.then_some(tips)
}

/// Readings of the hand's rotations under which its fingertips stay where a hand has them. `None` for a hand that is
/// fitted to markers or hardly turns: there is no evidence.
pub(super) fn hand_rotation(take: &SessionMotion<'_>) -> Option<Vec<SessionFinding>> {
    let BodySource::RigidBody(hand) = &take.roles.hand else {
        return None;
    };
    let found = rotation_by_fingertips(take.recording, hand, take.roles)?;
    let found = found.map(|result| SessionFinding {
        entity: result.entity,
        ..of_take(
            take,
            finding("hand-rotation", Level::Fail, result.found, result.advice),
        )
    });
    Some(found.into_iter().collect())
}

/// Fingertips whose second differences are those of noise.
pub(super) fn noise(take: &SessionMotion<'_>) -> Vec<SessionFinding> {
    let noisy = Finger::ALL.into_iter().filter_map(|finger| {
        let tips: Vec<_> = take.motion.fingertips[finger].iter().collect();
        let second: Vec<Vector3<f64>> = (tips.windows(3))
            .filter_map(|w| Some(w[0]?.coords_m() - 2.0 * w[1]?.coords_m() + w[2]?.coords_m()))
            .collect();
        let axes = (0..3).map(|axis| median_and_deviation(second.iter().map(|d| d[axis])).1);
        // Second differences of white noise have six times its variance.
        let noise_m = axes.fold(0.0, f64::max) / 6.0_f64.sqrt();
        (noise_m > NOISE_M).then(|| {
            let found = format!(
                "noise of {} in a coordinate, more than {}",
                length(noise_m),
                length(NOISE_M)
            );
            let advice = "see the capture's calibration and which marker it is";
            SessionFinding {
                entity: finger.name().to_owned(),
                ..of_take(take, finding("noise", Level::Warn, found, advice))
            }
        })
    });
    noisy.collect()
}

/// Takes whose fingertips are elsewhere in the hand than those of the take that agrees best with all, with the
/// exchange of labels, mirrored or turned axes, or unit that explains it.
pub(super) fn takes_disagree(looks: &[TakeLook]) -> Vec<SessionFinding> {
    let places: Vec<_> = looks
        .iter()
        .filter_map(|look| Some((look, look.tips?)))
        .collect();
    let sum = |tips: &Tips| -> f64 { places.iter().map(|(_, other)| apart_m(tips, other)).sum() };
    let Some((best, reference)) = places.iter().min_by(|a, b| sum(&a.1).total_cmp(&sum(&b.1)))
    else {
        return Vec::new();
    };
    let disagree = places.iter().filter_map(|(look, tips)| {
        let off_m = apart_m(tips, reference);
        if off_m <= DISAGREE_M {
            return None;
        }
        let (left_m, words) = explanations(tips)
            .map(|(tips, words)| (apart_m(&tips, reference), words))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let away = format!(
            "fingertips are {} from those of {}",
            length(off_m),
            best.name
        );
        let (level, found) = match left_m <= EXPLAINED * off_m {
            true => (
                Level::Fail,
                format!("{away}, but {} if {words}", length(left_m)),
            ),
            false if off_m > OTHER_HAND_M => (
                Level::Warn,
                format!("{away} in the hand's frame: another hand, or another body on it"),
            ),
            false => (Level::Info, format!("{away} in the hand's frame")),
        };
        // Of two takes none is known to be right.
        let takes = match places.len() {
            2 => places.iter().map(|(look, _)| look.name.clone()).collect(),
            _ => vec![look.name.clone()],
        };
        let advice = "export both takes alike, or put them into sessions of their own";
        Some(SessionFinding {
            takes,
            ..finding("takes-disagree", level, found, advice)
        })
    });
    disagree.collect()
}

/// Mean distance of the fingertips of two takes, metres.
fn apart_m(a: &Tips, b: &Tips) -> f64 {
    let distances = a.iter().zip(b).map(|(a, b)| (a - b).norm());
    distances.sum::<f64>() / a.len() as f64
}

/// Fingertips with labels exchanged, axes negated or in another unit, with words for it.
fn explanations(tips: &Tips) -> impl Iterator<Item = (Tips, String)> + use<> {
    let tips = *tips;
    let orders = (0..3125_usize).map(|n| [n / 625, n / 125 % 5, n / 25 % 5, n / 5 % 5, n % 5]);
    let distinct = orders.filter(|order| (1..5).all(|n| !order[..n].contains(&order[n])));
    let labels = distinct.map(move |order| {
        let moved = Finger::ALL
            .into_iter()
            .filter(|&f| order[f.index()] != f.index());
        let names: Vec<_> = moved.map(Finger::name).collect();
        let words = format!("the labels of {} are exchanged", names.join(", "));
        (order.map(|at| tips[at]), words)
    });
    let axes = (1..8_u8).map(move |signs| {
        let sign = |axis: u8| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let matrix = Matrix3::from_diagonal(&Vector3::new(sign(0), sign(1), sign(2)));
        let names = [(0, "x"), (1, "y"), (2, "z")].into_iter();
        let names: Vec<_> = names
            .filter(|(axis, _)| sign(*axis) < 0.0)
            .map(|(_, name)| name)
            .collect();
        let change = if names.len() == 2 {
            "turned"
        } else {
            "mirrored"
        };
        let words = format!("its hand is {change} ({} negated)", names.join(", "));
        (tips.map(|tip| matrix * tip), words)
    });
    let pairs = LengthUnit::ALL.map(|to| LengthUnit::ALL.map(|from| (from, to)));
    let units = pairs.into_iter().flatten().map(move |(from, to)| {
        let ratio = to.metres() / from.metres();
        let words = format!("{} are read as {}", to.name(), from.name());
        (tips.map(|tip| ratio * tip), words)
    });
    labels.chain(axes).chain(units)
}

/// Hands of different size in takes of one session.
pub(super) fn hand_size(looks: &[TakeLook]) -> Option<SessionFinding> {
    let reach = looks.iter().filter_map(|look| {
        let reach_m = look.tips?.iter().map(Vector3::norm).fold(0.0, f64::max);
        Some((reach_m, &look.name))
    });
    let mut reach: Vec<_> = reach.collect();
    reach.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ((least_m, least), (most_m, most)) = (reach.first()?, reach.last()?);
    (*most_m > (1.0 + SIZE_SHARE) * least_m).then(|| {
        let (least_m, most_m) = (length(*least_m), length(*most_m));
        let found = format!("the hand reaches {least_m} in {least} and {most_m} in {most}");
        let advice = "hands of two people belong into two sessions";
        finding("hand-size", Level::Info, found, advice)
    })
}
