//! Deviations from the cubic Hermite baseline: input that cannot teach.

use inhand_dictionary::{DEVIATION_PRIMITIVES, learn_residual};
use inhand_model::{EndConditions, SegmentLayout, SegmentOrigin, Segments, SmoothCurve};
use nalgebra::DMatrix;

use crate::residual_data::{around_smooth, conditions, ends, layout, numbers};

/// Six segments in two takes, whose boundary conditions may be changed afterwards.
fn six(layout: SegmentLayout, change: impl Fn(&mut Vec<EndConditions>)) -> Segments {
    let x = conditions(layout, 0, 6);
    let mut all = (0..6).map(|i| ends(&numbers(i, layout))).collect();
    change(&mut all);
    let origins = (0..6)
        .map(|i| SegmentOrigin {
            take: i / 3,
            start: 4 + i % 3 * layout.samples,
        })
        .collect();
    Segments::new(
        layout,
        SmoothCurve::Hermite.basis(layout) * &x,
        origins,
        all,
        0,
    )
    .unwrap()
}

fn refused(segments: &Segments) -> String {
    let learned = learn_residual(segments, DEVIATION_PRIMITIVES);
    learned.unwrap_err().to_string()
}

#[test]
fn no_segments() {
    let layout = layout(10, false);
    let none = DMatrix::zeros(60, 0);
    let segments = around_smooth(layout, &none, &DMatrix::zeros(layout.rows(), 0), 1);
    assert!(refused(&segments).starts_with("no training segments (0 left out"));
}

#[test]
fn no_primitives() {
    let learned = learn_residual(&six(layout(10, false), |_| ()), 0);
    let error = learned.unwrap_err().to_string();
    assert!(error.starts_with("rank is 0"), "{error}");
}

#[test]
fn more_primitives_than_there_can_be_are_as_many_as_there_are() {
    let layout = layout(10, false);
    let x = conditions(layout, 0, 6);
    let known = crate::residual_data::deviations(layout, 6, |i, c, s| {
        1e-3 * crate::residual_data::bump(s) * (i as f64 + c as f64).sin()
    });
    let residual = learn_residual(&around_smooth(layout, &x, &known, 3), usize::MAX).unwrap();
    assert_eq!(residual.expectation.blocks(), [1; 5]);
}

#[test]
fn a_sample_that_is_no_number() {
    let layout = layout(10, false);
    let x = conditions(layout, 0, 6);
    let mut known = DMatrix::zeros(layout.rows(), 6);
    known[(15 * 4 + 7, 4)] = f64::NAN;
    let error = refused(&around_smooth(layout, &x, &known, 3));
    let place = "training segment 4 (take 1, sample 18): middle axis 1 is NaN";
    assert!(error.starts_with(place), "{error}");
}

#[test]
fn an_end_condition_that_is_no_number() {
    for value in [f64::NAN, f64::INFINITY] {
        let segments = six(layout(10, false), |ends| {
            ends[4].last_velocity_m_s[5] = value;
        });
        let error = refused(&segments);
        let expected = format!(
            "training segment 4 (take 1): the last velocity of index axis 2 is {value}, expected"
        );
        assert!(error.starts_with(&expected), "{error}");
    }
}

#[test]
fn end_conditions_of_another_segment() {
    let segments = six(layout(10, true), |ends| ends[1].last_m[14] += 2e-6);
    let error = refused(&segments);
    let place = "training segment 1 (take 0, sample 23): little axis 2 is";
    assert!(
        error.starts_with(place) && error.contains("the boundary conditions say"),
        "{error}"
    );
    // Rounding is none.
    let segments = six(layout(10, true), |ends| ends[1].last_m[14] += 1e-9);
    assert!(learn_residual(&segments, DEVIATION_PRIMITIVES).is_ok());
    // The object counts as well.
    let segments = six(layout(10, true), |ends| {
        let other = ends[5].object;
        ends[2].object = other;
    });
    let error = refused(&segments);
    assert!(
        error.starts_with("training segment 2 ") && error.contains("object position axis 0"),
        "{error}"
    );
}

#[test]
fn an_object_that_the_end_conditions_do_not_have() {
    let segments = six(layout(10, true), |ends| ends[3].object = None);
    assert!(refused(&segments).starts_with("training segment 3 has no object pose"));
    // Without the object in the layout it does not matter.
    let segments = six(layout(10, false), |ends| ends[3].object = None);
    assert!(learn_residual(&segments, DEVIATION_PRIMITIVES).is_ok());
}

#[test]
fn a_layout_without_time() {
    let x = conditions(layout(2, false), 0, 6);
    let of_layout = |samples, rate_hz| {
        let origins = vec![SegmentOrigin { take: 0, start: 4 }; 6];
        let ends = (0..6)
            .map(|i| ends(&numbers(i, layout(2, false))))
            .collect();
        let layout = SegmentLayout {
            samples,
            rate_hz,
            object: false,
        };
        let columns = DMatrix::from_fn(layout.rows(), 6, |row, i| x[(row % 15, i)]);
        Segments::new(layout, columns, origins, ends, 0).unwrap()
    };
    for (samples, rate_hz) in [(1, 100.0), (5, 0.0), (5, -100.0), (5, f64::NAN)] {
        let error = refused(&of_layout(samples, rate_hz));
        assert!(
            error.contains(" of the segments") || error.contains("of a segment"),
            "{error}"
        );
    }
}

#[test]
fn two_samples_are_nothing_but_ends() {
    let layout = layout(2, false);
    let residual = learn_residual(&six(layout, |_| ()), DEVIATION_PRIMITIVES).unwrap();
    assert_eq!(residual.primitives.ncols(), 0);
    assert_eq!(residual.expected_m(&numbers(7, layout)).len(), 0);
}

#[test]
fn a_fingertip_that_never_moves() {
    let layout = layout(10, false);
    let mut x = conditions(layout, 0, 6);
    for (row, value) in [(4, 0.02), (19, 0.02), (34, 0.0), (49, 0.0)] {
        x.row_mut(row).fill(value);
    }
    // Rounding moves it by some 1e-18; what counts is the number that is in the segment.
    let columns = (SmoothCurve::Hermite.basis(layout) * &x)
        .map_with_location(|row, _, v| if row % 15 == 4 { 0.02 } else { v });
    let origins = vec![SegmentOrigin { take: 0, start: 4 }; 6];
    let ends = x.column_iter().map(|x| ends(&x.into_owned())).collect();
    let segments = Segments::new(layout, columns, origins, ends, 0).unwrap();
    assert!(refused(&segments).starts_with("index axis 1 is"));
}
