//! Number of fingers in contact at once.

use inhand_model::{EvaluationRows, Finger, PerFinger, in_contact};

use super::Method;
use crate::figure::bars::{self, BarSeries, Bars};
use crate::figure::palette::RECORDED_CLASS;
use crate::figure::{Figure, FigureColumn, FigureData, Key};
use crate::number::{NARROW_SPACE, count, plain, to_mm};

/// Instants at which 0, 1, .. 5 fingers are in contact.
type Counts = [usize; Finger::COUNT + 1];

/// `None` without an object.
pub(super) fn figure(rows: &EvaluationRows, methods: &[Method<'_>], tau_m: f64) -> Option<Figure> {
    let recorded = rows.recorded_distance_m.as_deref()?;
    let mut counted: Vec<(&str, &str, Counts)> = Vec::new();
    for method in methods {
        let own = rows
            .methods
            .iter()
            .find(|own| own.name == method.evaluation.name);
        let Some(planned) = own.and_then(|own| own.distance_m.as_deref()) else {
            continue;
        };
        let counts = counts(planned, recorded, tau_m, |planned, _| planned);
        if method.default {
            let counts = self::counts(planned, recorded, tau_m, |_, recorded| recorded);
            counted.insert(0, ("recorded", RECORDED_CLASS, counts));
        }
        counted.push((&method.evaluation.name, &method.class, counts));
    }
    counted.retain(|(.., counts)| counts.iter().sum::<usize>() > 0);
    let (.., first) = counted.first()?;
    let n = first.iter().sum::<usize>();
    let groups: Vec<String> = (0..=Finger::COUNT)
        .map(|fingers| fingers.to_string())
        .collect();
    let series = counted.iter().map(|(label, class, counts)| BarSeries {
        label,
        class,
        shares: shares(counts),
    });
    Some(Figure {
        id: "contact-count",
        title: "Fingers in contact at once.".to_owned(),
        caption: format!(
            "Share of instants at which so many fingertips are within {} mm of the object's surface, n = {} instants at which \
             planned and recorded distances of all five fingers are known. A bar that stands for anything at all is drawn; one that is not there \
             stands for never.",
            plain(to_mm(tau_m)),
            count(n, NARROW_SPACE)
        ),
        data: data(&counted),
        legend: counted
            .iter()
            .map(|(label, class, _)| Key::area(*label, *class))
            .collect(),
        panels: vec![bars::draw(&Bars {
            title: "Fingers in contact at once",
            x_name: "fingers in contact",
            y_name: "share of instants (%)",
            groups,
            series: series.collect(),
        })],
    })
}

/// Counts of one of both motions, over instants at which both are known.
fn counts(
    planned: &[PerFinger<f64>],
    recorded: &[PerFinger<f64>],
    tau_m: f64,
    choose: for<'a> fn(&'a PerFinger<f64>, &'a PerFinger<f64>) -> &'a PerFinger<f64>,
) -> Counts {
    let known = |fingers: &PerFinger<f64>| fingers.as_array().iter().all(|d| !d.is_nan());
    let mut counts = Counts::default();
    for (planned, recorded) in planned.iter().zip(recorded) {
        if known(planned) && known(recorded) {
            let distances = choose(planned, recorded).as_array();
            counts[distances.iter().filter(|&&d| in_contact(d, tau_m)).count()] += 1;
        }
    }
    counts
}

fn shares(counts: &Counts) -> Vec<f64> {
    let n = counts.iter().sum::<usize>() as f64;
    counts.iter().map(|&own| own as f64 / n).collect()
}

fn data(counted: &[(&str, &str, Counts)]) -> FigureData {
    let cells = || {
        (counted.iter()).flat_map(|(label, _, counts)| {
            let shares = shares(counts);
            (0..counts.len())
                .map(move |fingers| (*label, fingers, counts[fingers], shares[fingers]))
        })
    };
    FigureData::new([
        FigureColumn::words("motion", cells().map(|cell| cell.0)),
        FigureColumn::counts("fingers", cells().map(|cell| cell.1)),
        FigureColumn::counts("instants", cells().map(|cell| cell.2)),
        FigureColumn::numbers("share_percent", cells().map(|cell| 100.0 * cell.3)),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingers_are_counted_where_both_motions_are_known() {
        let at = |distances: [f64; 5]| PerFinger::new(distances);
        let planned = [
            at([0.0, 0.001, -0.002, 0.006, 0.1]),
            at([0.0; 5]),
            at([f64::NAN, 0.0, 0.0, 0.0, 0.0]),
            at([1.0; 5]),
        ];
        let recorded = [
            at([0.0; 5]),
            at([0.005, 0.0051, -0.0051, -0.005, 0.0]),
            at([0.0; 5]),
            at([0.0, f64::NAN, 0.0, 0.0, 0.0]),
        ];
        assert_eq!(
            counts(&planned, &recorded, 0.005, |planned, _| planned),
            [0, 0, 0, 1, 0, 1]
        );
        assert_eq!(
            counts(&planned, &recorded, 0.005, |_, recorded| recorded),
            [0, 0, 0, 1, 0, 1]
        );
        assert_eq!(
            shares(&[1, 0, 0, 0, 0, 3]),
            [0.25, 0.0, 0.0, 0.0, 0.0, 0.75]
        );
    }
}
