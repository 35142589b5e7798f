//! The worst errors, and where to look at them.

use inhand_model::{Finger, WorstCase};
use maud::{Markup, html};

use super::Body;
use crate::figure::scale::{Scale, nice_end};
use crate::figure::{Figure, FigureData, Frame, Key, Panel, Px, axes, finger_class, line_chart};
use crate::table::Table;
use crate::words::{decimals, millimetres, plain, shortened, to_mm};

const WIDTH: f64 = 380.0;
const FRAME: Frame = Frame::new([34.0, WIDTH - 12.0], [42.0, 112.0]);
const HEIGHT: f64 = 116.0 + axes::BOTTOM_ROOM;
const TITLE_LETTERS: usize = 46;
/// Time before and after the worst instant in a cut, seconds.
const AROUND_S: f64 = 2.0;

/// The gallery and its table; a sentence where nothing was planned.
pub(super) fn part(cases: &[WorstCase], rate_hz: f64) -> Body {
    let Some(first) = cases.first() else {
        return html! { p { "No segment was planned, so there is no worst error." } }.into();
    };
    let highest = cases
        .iter()
        .map(|case| to_mm(case.error_m))
        .fold(0.0, f64::max);
    let end_mm = nice_end(highest, 4);
    let mut fingers: Vec<Finger> = cases.iter().map(|case| case.finger).collect();
    fingers.sort_unstable();
    fingers.dedup();
    let keys = fingers
        .into_iter()
        .map(|finger| Key::line(finger.name(), finger_class(finger)));
    let panels =
        (cases.iter().enumerate()).map(|(place, case)| panel(place + 1, case, rate_hz, end_mm));
    let figure = Figure {
        id: "worst-errors",
        title: format!("The {} segments with the largest errors of {}.", cases.len(), first.method),
        caption: "Error of the finger that is farthest off over the segment, one a segment, largest first; the dot is \
            the worst instant. All axes end at the same height."
            .to_owned(),
        data: data(cases, rate_hz),
        legend: keys.collect(),
        panels: panels.collect(),
    };
    Body::default().figure(figure).prose(where_to_look(cases))
}

fn panel(place: usize, case: &WorstCase, rate_hz: f64, end_mm: f64) -> Panel {
    let last_s = case.errors_m.len().saturating_sub(1) as f64 / rate_hz;
    let x = Scale::linear(0.0, last_s).over(FRAME.left, FRAME.right);
    let y = Scale::linear(0.0, end_mm).over(FRAME.bottom, FRAME.top);
    let points: Vec<(f64, f64)> = (case.errors_m.iter().enumerate())
        .filter(|(_, error_m)| error_m.is_finite())
        .map(|(t, error_m)| (x.at(t as f64 / rate_hz), y.at(to_mm(*error_m))))
        .collect();
    let worst = points.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
    let line = line_chart::path(points.iter().copied());
    let title = format!("{place}. {} mm, {}", millimetres(case.error_m), case.finger);
    let below = format!("{}, {} s", case.take, decimals(case.time_s, 2));
    Panel {
        width: WIDTH,
        height: HEIGHT,
        summary: format!("{title}, {below}"),
        shapes: html! {
            text.title x="0" y="12.5" { (shortened(&title, TITLE_LETTERS)) }
            text.faint x="0" y="29" { (shortened(&below, TITLE_LETTERS)) }
            @for tick in y.ticks(3) {
                @let at = y.at(tick.value);
                line.grid x1=(Px(FRAME.left)) y1=(Px(at)) x2=(Px(FRAME.right)) y2=(Px(at)) {}
                text.tick x=(Px(FRAME.left - 6.0)) y=(Px(at + 4.0)) text-anchor="end" { (tick.label) }
            }
            (axes::bottom(&FRAME, &x, 5, "time in the segment (s); error in mm"))
            g.(finger_class(case.finger)) {
                title { (title) ", " (below) }
                path.line d=(line) {}
                @if let Some((x, y)) = worst { circle.point cx=(Px(x)) cy=(Px(y)) r="3.5" {} }
            }
        },
    }
}

fn data(cases: &[WorstCase], rate_hz: f64) -> FigureData {
    let rows: Vec<(usize, &WorstCase, usize)> = (cases.iter().enumerate())
        .flat_map(|(place, case)| (0..case.errors_m.len()).map(move |t| (place + 1, case, t)))
        .collect();
    FigureData::about(&rows)
        .counts("place", |row| row.0)
        .words("method", |row| &*row.1.method)
        .words("take", |row| &*row.1.take)
        .words("file", |row| &*row.1.file)
        .words("topic", |row| &*row.1.topic)
        .counts("segment", |row| row.1.segment)
        .words("finger", |row| row.1.finger.name())
        .numbers("worst_time_s", |row| row.1.time_s)
        .numbers("time_in_segment_s", |row| row.2 as f64 / rate_hz)
        .numbers("error_mm", |row| to_mm(row.1.errors_m[row.2]))
        .done()
}

fn where_to_look(cases: &[WorstCase]) -> Markup {
    let rows = cases.iter().enumerate();
    let caption = "Where the worst errors are";
    let table = Table::new(caption, rows, "place", |(place, _)| (place + 1).to_string())
        .lengths("error", |(_, case)| case.error_m)
        .words("finger", |(_, case)| case.finger.name().to_owned())
        .words("file", |(_, case)| case.file.clone())
        .decimals("time", "s", 2, |(_, case)| case.time_s)
        .numbers("segment", "", |(_, case)| case.segment.to_string())
        .words("topic", |(_, case)| case.topic.clone());
    html! {
        (table)
        p.note {
            "Files are beside this report; times count from the take's first sample, segments over all test takes from 0. \
             A few seconds around each, to open in a viewer:"
        }
        details {
            summary { "Commands" }
            pre { @for (place, case) in cases.iter().enumerate() { (command(place + 1, case)) "\n" } }
        }
    }
}

fn command(place: usize, case: &WorstCase) -> String {
    let start_s = (case.time_s - AROUND_S).max(0.0);
    let hundredths = |seconds: f64| plain((seconds * 100.0).round() / 100.0);
    format!(
        "inhand cut {} --from {} --to {} -o worst-{place}.mcap",
        shell_word(&case.file),
        hundredths(start_s),
        hundredths(case.time_s + AROUND_S),
    )
}

/// A name as a shell reads it back.
fn shell_word(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./".contains(c);
    if !name.is_empty() && name.chars().all(plain) && !name.starts_with('-') {
        name.to_owned()
    } else {
        format!("'./{}'", name.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_survive_a_shell() {
        assert_eq!(shell_word("cube_test_01.mcap"), "cube_test_01.mcap");
        assert_eq!(shell_word("my take.mcap"), "'./my take.mcap'");
        assert_eq!(shell_word("it's.mcap"), "'./it'\\''s.mcap'");
        assert_eq!(shell_word("-o.mcap"), "'./-o.mcap'");
    }
}
