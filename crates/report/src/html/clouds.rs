//! Distances to clouds of points on the object beside exact ones.

use inhand_model::PointCloud;
use maud::html;

use super::Body;
use crate::figure::box_plot::{BOX_WORDS, MICROMETRES};
use crate::figure::row_plot::PlotRow;
use crate::figure::{Figure, FigureData, PLAIN_CLASS};
use crate::words::{count, join_words, percent, tied};

/// The figure and the effect of clouds on contacts; `None` without clouds.
pub(super) fn section(clouds: &[PointCloud]) -> Option<Body> {
    let first = clouds.first()?;
    if first.excess_m.n == 0 {
        return Some(Body::default());
    }
    let shares = clouds.iter().map(|cloud| {
        format!(
            "{} % by {}",
            percent(cloud.three_or_more),
            count(cloud.points)
        )
    });
    let shares = tied(&join_words(&shares.collect::<Vec<_>>()));
    let body = Body::from(html! {
        p {
            "Distances here are to the object's exact surface. By clouds of points on it, as in the paper, three or more recorded \
             fingertips are in contact at " (shares) " points, against " (percent(first.exact_three_or_more))
            "\u{a0}% by the surface, of the same instants."
        }
    });
    let excesses = || clouds.iter().map(|cloud| &cloud.excess_m);
    let end = MICROMETRES.shared_end(excesses());
    let names: Vec<String> = clouds
        .iter()
        .map(|c| format!("{} points", count(c.points)))
        .collect();
    let rows = names.iter().map(|label| PlotRow::new(label, PLAIN_CLASS));
    let rows = rows.zip(excesses());
    let title = "Excess of point clouds";
    Some(body.figure(Figure {
        id: "point-clouds",
        title: "Distance to a cloud of points less distance to the surface.".to_owned(),
        caption: format!(
            "Over {} distances of recorded fingertips at instants spread over the test segments ({} of them filled), points spread evenly \
             over the surface. A cloud is never nearer than the surface. {BOX_WORDS} {}",
            count(first.excess_m.n),
            count(first.excess_m.n_filled),
            MICROMETRES.cut_words(excesses(), end),
        ),
        data: FigureData::about(clouds)
            .counts("points", |cloud| cloud.points)
            .lengths(
                &["mean", "whisker_low", "p25", "p50", "p75", "p95", "whisker_high", "max"],
                |cloud| &cloud.excess_m,
            )
            .numbers("three_or_more_percent", |cloud| 100.0 * cloud.three_or_more)
            .numbers("exact_three_or_more_percent", |cloud| 100.0 * cloud.exact_three_or_more)
            .done(),
        legend: Vec::new(),
        panels: vec![MICROMETRES.boxes(title, None, "excess (µm)", end, rows)],
    }))
}
