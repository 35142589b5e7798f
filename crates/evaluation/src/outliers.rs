//! Sessions that are far from the others.

use inhand_model::{Outlier, OutlierSession, SessionSummary};
use inhand_statistics::quantiles::quantile;

/// Fewer sessions do not show what is usual.
const FEWEST: usize = 5;
/// Modified z-scores above are far off (Iglewicz and Hoaglin 1993).
const FAR: f64 = 3.5;
/// Median absolute deviation of a normal distribution over its standard deviation.
const MEDIAN_DEVIATION: f64 = 0.6745;
/// Mean absolute deviation of a normal distribution over its standard deviation: the root of 2 / pi.
const MEAN_DEVIATION: f64 = 0.797_884_560_802_865_4;
/// Differences of shares below are of no interest, however regular the others are, points.
const LEAST_POINTS: f64 = 5.0;
/// A session that loses or fills more than this share is listed, however many others do, percent.
const MUCH: f64 = 20.0;

/// A number of each session that may be far off: what it is, its unit, whether it is a share that is lost, and where
/// to find it. NaN where a session does not have it.
type Looked<'a> = (
    String,
    &'static str,
    bool,
    Box<dyn Fn(&SessionSummary) -> f64 + 'a>,
);

/// What is far off in which session, farthest first. `default` is the place of the method to look at.
pub fn outliers(sessions: &[SessionSummary], default: usize, name: &str) -> Vec<Outlier> {
    let share = |part: usize, rest: usize| 100.0 * part as f64 / (part as f64 + rest as f64);
    let error = move |session: &SessionSummary| session.methods[default].headline().all;
    let contacts = move |session: &SessionSummary| session.methods[default].contacts;
    let looked: [Looked<'_>; 5] = [
        (
            format!("median error of {name}"),
            "mm",
            false,
            Box::new(move |s| 1e3 * error(s).p50),
        ),
        (
            format!("third quartile of the error of {name}"),
            "mm",
            false,
            Box::new(move |s| 1e3 * error(s).p75),
        ),
        (
            "segments lost to gaps".to_owned(),
            "%",
            true,
            Box::new(move |s| share(s.left_out, s.segments)),
        ),
        (
            "filled instants".to_owned(),
            "%",
            true,
            Box::new(move |s| {
                share(
                    error(s).n_filled,
                    error(s).n.saturating_sub(error(s).n_filled),
                )
            }),
        ),
        (
            "recorded time with three or more contacts".to_owned(),
            "%",
            false,
            Box::new(move |s| {
                contacts(s).map_or(f64::NAN, |c| {
                    share(
                        c.recorded_three_or_more,
                        c.n.saturating_sub(c.recorded_three_or_more),
                    )
                })
            }),
        ),
    ];
    let mut found: Vec<Outlier> = (looked.iter())
        .flat_map(|(what, unit, is_loss, value)| far(sessions, what, unit, *is_loss, value))
        .collect();
    found.sort_by(|a, b| {
        b.score
            .abs()
            .total_cmp(&a.score.abs())
            .then(a.session.place.cmp(&b.session.place))
    });
    found
}

fn far(
    sessions: &[SessionSummary],
    what: &str,
    unit: &'static str,
    is_loss: bool,
    value: impl Fn(&SessionSummary) -> f64,
) -> Vec<Outlier> {
    let values: Vec<f64> = sessions.iter().map(value).collect();
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let Some(median) = median(&known).filter(|_| known.len() >= FEWEST) else {
        return Vec::new();
    };
    let deviations: Vec<f64> = known.iter().map(|value| (value - median).abs()).collect();
    let Some(spread) = spread(&deviations) else {
        return Vec::new();
    };
    let is_share = unit == "%";
    (values.iter().enumerate())
        .map(|(session, &value)| (session, value, (value - median) / spread))
        .filter(|(_, value, score)| {
            let difference = value - median;
            let much = is_loss && *value > MUCH;
            let matters = !is_share || difference.abs() >= LEAST_POINTS;
            matters && (score.abs() > FAR || much)
        })
        .map(|(session, value, score)| Outlier {
            session: OutlierSession {
                place: session,
                name: sessions[session].name.clone(),
                file: sessions[session].file.clone(),
            },
            what: what.to_owned(),
            unit,
            value,
            median,
            score,
        })
        .collect()
}

/// The standard deviation that usual sessions suggest: from the median absolute deviation, or, where more than
/// half of the sessions agree to the last digit, from the mean one. `None` where all agree.
fn spread(deviations: &[f64]) -> Option<f64> {
    let middle = median(deviations)? / MEDIAN_DEVIATION;
    if middle > 0.0 {
        return Some(middle);
    }
    let mean = deviations.iter().sum::<f64>() / deviations.len() as f64;
    Some(mean / MEAN_DEVIATION).filter(|spread| *spread > 0.0)
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    quantile(&sorted, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use inhand_model::{HandAndFingers, PerFinger, SessionMethod, Statistics};

    fn session(p50_mm: f64, left_out: usize) -> SessionSummary {
        let error = Statistics {
            n: 100,
            p50: p50_mm / 1e3,
            p75: p50_mm / 1e3,
            ..Statistics::default()
        };
        SessionSummary {
            name: String::new(),
            file: String::new(),
            participant: None,
            object: None,
            task: None,
            takes: 1,
            duration_s: 10.0,
            segments: 10,
            left_out,
            warnings: 0,
            methods: vec![SessionMethod {
                name: String::new(),
                error: HandAndFingers {
                    all: error,
                    by_finger: PerFinger::new([error; 5]),
                },
                held_out: None,
                contacts: None,
            }],
        }
    }

    #[test]
    fn a_session_far_off_is_found_with_its_score() {
        // Median 1.0, deviations 0.1 0.05 0 0.05 2: their median is 0.05.
        let sessions = [0.9, 0.95, 1.0, 1.05, 3.0].map(|mm| session(mm, 0));
        let found = outliers(&sessions, 0, "prior");
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].session.place, found[0].unit), (4, "mm"));
        assert!((found[0].score - 0.6745 * 2.0 / 0.05).abs() < 1e-9);
        assert!((found[0].median - 1.0).abs() < 1e-12);
    }

    #[test]
    fn where_most_sessions_agree_the_mean_deviation_counts() {
        let mut sessions = [1.0; 6].map(|mm| session(mm, 0));
        sessions[2].left_out = 10;
        let found = outliers(&sessions, 0, "prior");
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].session.place, found[0].unit), (2, "%"));
        // 50 % against 0 % in five others: a mean deviation of 50 / 6.
        assert!((found[0].score - 50.0 * MEAN_DEVIATION / (50.0 / 6.0)).abs() < 1e-9);
    }

    #[test]
    fn few_sessions_and_equal_ones_have_no_outliers() {
        let few = [1.0, 1.0, 1.1, 9.0].map(|mm| session(mm, 0));
        assert!(outliers(&few, 0, "prior").is_empty());
        let equal = [1.0; 7].map(|mm| session(mm, 3));
        assert!(outliers(&equal, 0, "prior").is_empty());
    }
}
