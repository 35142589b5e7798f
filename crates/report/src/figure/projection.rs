//! Paths and solids in space, seen along each of three axes: three panels in which a millimetre is as long
//! one way as the other, and as long in each.

use maud::{Markup, html};

use super::scale::Scale;
use super::{Frame, Panel, Px, axes};

/// Something in space.
pub(crate) struct Shape {
    /// Name, in the tooltip.
    pub(crate) label: String,
    /// Classes that colour and dash it.
    pub(crate) class: String,
    /// Drawing of its points.
    pub(crate) drawn: Drawn,
    /// Points, millimetres.
    pub(crate) points_mm: Vec<[f64; 3]>,
}

/// Drawing of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drawn {
    /// As a line from the first to the last.
    Path,
    /// The same with a dot at the first.
    Started,
    /// As the outline of their convex hull, filled.
    Outline,
}

/// Horizontal and vertical axis of each panel.
const VIEWS: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];
const AXES: [&str; 3] = ["x", "y", "z"];

const WIDTH: f64 = 380.0;
const TOP: f64 = 26.0;
const LEFT: f64 = 44.0;
const RIGHT: f64 = 12.0;
const SIDE: f64 = WIDTH - LEFT - RIGHT;
const WANTED_TICKS: usize = 6;
/// Of the widest extent, what is added around it.
const AIR: f64 = 0.06;
/// Shortest axis, mm: less would make a drama of noise.
const SHORTEST_MM: f64 = 2.0;
/// Points nearer than this to the one before are not drawn, user units.
const STEP: f64 = 0.7;

/// The three views, named after what they show; empty where there is no point to see.
pub(crate) fn panels(of: &str, shapes: &[Shape]) -> Vec<Panel> {
    let Some(bounds) = Bounds::of(shapes) else {
        return Vec::new();
    };
    VIEWS.map(|view| panel(of, shapes, &bounds, view)).into()
}

/// A cube around everything, millimetres.
struct Bounds {
    centre: [f64; 3],
    half: f64,
}

impl Bounds {
    fn of(shapes: &[Shape]) -> Option<Self> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in shapes.iter().flat_map(|shape| known(&shape.points_mm)) {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let extents = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        let extent = extents.into_iter().fold(SHORTEST_MM, f64::max);
        low[0].is_finite().then(|| Self {
            centre: [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis])),
            half: 0.5 * extent * (1.0 + AIR),
        })
    }

    fn scale(&self, axis: usize, from_px: f64, to_px: f64) -> Scale {
        let centre = self.centre[axis];
        Scale::linear(centre - self.half, centre + self.half).over(from_px, to_px)
    }
}

fn known(points: &[[f64; 3]]) -> impl Iterator<Item = &[f64; 3]> {
    points
        .iter()
        .filter(|point| point.iter().all(|v| v.is_finite()))
}

fn panel(of: &str, shapes: &[Shape], bounds: &Bounds, [across, up]: [usize; 2]) -> Panel {
    let frame = Frame::new([LEFT, LEFT + SIDE], [TOP, TOP + SIDE]);
    let x = bounds.scale(across, frame.left, frame.right);
    let y = bounds.scale(up, frame.bottom, frame.top);
    let (across, up) = ((AXES[across], across), (AXES[up], up));
    let flat = |point: &[f64; 3]| [x.at(point[across.1]), y.at(point[up.1])];
    let title = format!("{of}, {} and {}", across.0, up.0);
    let names: Vec<&str> = shapes.iter().map(|shape| shape.label.as_str()).collect();
    Panel {
        width: WIDTH,
        height: TOP + SIDE + axes::BOTTOM_ROOM,
        summary: format!("{title}, seen in this plane: {}", names.join(", ")),
        title: title.into(),
        shapes: html! {
            (axes::left(&frame, &y, WANTED_TICKS, &format!("{} (mm)", up.0)))
            (axes::bottom(&frame, &x, WANTED_TICKS, &format!("{} (mm)", across.0)))
            @for shape in shapes {
                (draw(shape, &known(&shape.points_mm).map(flat).collect::<Vec<_>>()))
            }
        },
    }
}

fn draw(shape: &Shape, points: &[[f64; 2]]) -> Markup {
    html! {
        @if let Some([x, y]) = points.first() {
            g.(shape.class) {
                title { (shape.label) }
                @match shape.drawn {
                    Drawn::Path => path.line d=(line(points)) {},
                    Drawn::Started => {
                        path.line d=(line(points)) {}
                        circle.point cx=(Px(*x)) cy=(Px(*y)) r="3.5" {}
                    }
                    Drawn::Outline => {
                        @let outline = line(&outline(points)) + "z";
                        path.pale d=(outline) {}
                        path.line d=(outline) {}
                    }
                }
            }
        }
    }
}

/// The path through points, without those too near to be seen apart.
fn line(points: &[[f64; 2]]) -> String {
    let mut path = String::new();
    let mut drawn: Option<[f64; 2]> = None;
    for (place, &[x, y]) in points.iter().enumerate() {
        let near = drawn.is_some_and(|[a, b]| (x - a).hypot(y - b) < STEP);
        if near && place + 1 < points.len() {
            continue;
        }
        path.push(if drawn.is_none() { 'M' } else { 'L' });
        path.push_str(&format!("{} {}", Px(x), Px(y)));
        drawn = Some([x, y]);
    }
    path
}

/// Corners of the convex hull in the plane (Andrew 1979, the monotone chain), one way round.
fn outline(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for c in points {
            while let [.., a, b] = chain[..] {
                let turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                if turn > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(c);
        }
        chain.pop();
        chain
    };
    let mut corners = half(&mut sorted.iter().copied());
    corners.extend(half(&mut sorted.iter().rev().copied()));
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_have_corners_alone() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let inside = [[1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [2.0, 1.0], [0.5, 1.9]];
        assert_eq!(outline(&[&square[..], &inside].concat()), square);
        assert_eq!(outline(&[[1.0, 1.0], [1.0, 1.0]]), [[1.0, 1.0]]);
        // On a line there is nothing inside.
        assert_eq!(
            outline(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]),
            [[0.0, 0.0], [2.0, 2.0]]
        );
    }

    #[test]
    fn a_millimetre_is_as_long_everywhere() {
        let shape = Shape {
            label: "path".into(),
            class: "plain".into(),
            drawn: Drawn::Path,
            points_mm: vec![[0.0, -5.0, 3.0], [40.0, 5.0, f64::NAN], [20.0, 15.0, 4.0]],
        };
        let bounds = Bounds::of(&[shape]).expect("there are points");
        // The point that is not known counts for nothing.
        assert_eq!(bounds.centre, [10.0, 5.0, 3.5]);
        let lengths = [0, 1, 2].map(|axis| {
            let scale = bounds.scale(axis, 0.0, 100.0);
            scale.at(1.0) - scale.at(0.0)
        });
        assert!((lengths[0] - lengths[1]).abs() < 1e-12);
        assert!((lengths[0] - lengths[2]).abs() < 1e-12);
        assert!(panels("nothing", &[]).is_empty());
    }

    #[test]
    fn points_on_top_of_one_another_are_drawn_once() {
        let points = [[0.0, 0.0], [0.1, 0.0], [3.0, 0.0], [3.2, 0.1]];
        assert_eq!(line(&points), "M0 0L3 0L3.2 0.1");
    }
}
