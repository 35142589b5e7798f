//! Motion of methods with velocities.

use std::collections::{BTreeMap, BTreeSet};

use inhand_export::{TableLayout, motion_table, trajectory_table, write_csv};
use inhand_model::{Clock, SegmentLayout, StartTime, Trajectory};

/// A fingertip coordinate that moves by the square of the sample, millimetres.
fn configuration(sample: usize) -> [f64; 15] {
    let mut configuration = [0.5; 15];
    configuration[0] = (sample * sample) as f64 * 1e-3;
    configuration
}

/// `sample`, `thumb.x_m` and `thumb.vx_m_s` of a wide table.
fn cells(csv: &[u8]) -> Vec<[String; 3]> {
    let text = str::from_utf8(csv).unwrap();
    let rows = text.lines().map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        [1, 3, 6].map(|column| cells[column].to_owned())
    });
    rows.collect()
}

#[test]
fn differences_stay_within_a_trajectory() {
    let samples = [3, 4, 5, 6, 7, 9];
    let configurations_m: BTreeMap<_, _> = samples.map(|k| (k, configuration(k))).into();
    let clock = Clock::new(0, StartTime::Unknown, 100.0).unwrap();
    let written = |starts: Option<&BTreeSet<usize>>| {
        let methods = [("line", &configurations_m)];
        let mut csv = Vec::new();
        let table = motion_table(methods, starts, clock, TableLayout::Wide);
        write_csv(&table, &mut csv).unwrap();
        cells(&csv)
    };
    let known = written(Some(&BTreeSet::from([3, 6])));
    assert_eq!(known[0], ["sample", "thumb.x_m", "thumb.vx_m_s"]);
    // Forward, central, backward; forward, backward; alone.
    let expected = [Some(0.7), Some(0.8), Some(0.9), Some(1.3), Some(1.3), None];
    for ((row, expected), sample) in known[1..].iter().zip(expected).zip(samples) {
        assert_eq!(row[0], sample.to_string());
        match expected {
            None => assert_eq!(row[2], ""),
            Some(v) => assert!(
                (row[2].parse::<f64>().unwrap() - v).abs() < 1e-12,
                "{row:?}"
            ),
        }
    }
    // Where starts are not known, no difference is.
    assert!(written(None)[1..].iter().all(|row| row[2].is_empty()));
}

#[test]
fn a_trajectory_starts_at_zero() {
    let layout = SegmentLayout {
        samples: 3,
        rate_hz: 50.0,
        object: false,
    };
    let values_m = (0..3).flat_map(configuration).collect();
    let trajectory = Trajectory::new(layout, values_m).unwrap();
    let mut csv = Vec::new();
    write_csv(&trajectory_table("prior", &trajectory).unwrap(), &mut csv).unwrap();
    let text = String::from_utf8(csv.clone()).unwrap();
    assert!(
        text.lines()
            .nth(2)
            .unwrap()
            .starts_with("prior,1,0.02,0.001,")
    );
    let velocities = cells(&csv)[1..]
        .iter()
        .map(|row| row[2].parse::<f64>().unwrap())
        .collect::<Vec<_>>();
    for (found, expected) in velocities.iter().zip([0.05, 0.1, 0.15]) {
        assert!((found - expected).abs() < 1e-12, "{velocities:?}");
    }
}
