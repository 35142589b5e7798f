//! Classes of the style sheet, by what they colour. Fingers have the same colour in every figure;
//! methods have a scheme of their own, distinguished by dashes as well as by colour, learned methods
//! solid and baselines dashed.

use inhand_model::Finger;

/// Learned methods that get a colour of their own before colours repeat.
const LEARNED: usize = 4;
/// Baselines that get a colour and dash of their own before they repeat.
const BASELINES: usize = 5;

/// Class of a finger's colour.
pub(crate) const fn finger_class(finger: Finger) -> &'static str {
    match finger {
        Finger::Thumb => "f-thumb",
        Finger::Index => "f-index",
        Finger::Middle => "f-middle",
        Finger::Ring => "f-ring",
        Finger::Little => "f-little",
    }
}

/// Class of a line that is neither a finger's nor a method's.
pub(crate) const PLAIN_CLASS: &str = "plain";

/// Class of recorded motion, which is no method.
pub(crate) const RECORDED_CLASS: &str = "recorded";

/// Class of each method, by its place among the learned ones or the baselines, from whether it is a baseline.
pub(crate) fn classes(baselines: impl IntoIterator<Item = bool>) -> Vec<String> {
    let (mut learned, mut known) = (0, 0);
    baselines
        .into_iter()
        .map(|baseline| {
            let (letter, place, available) = if baseline {
                ("b", &mut known, BASELINES)
            } else {
                ("l", &mut learned, LEARNED)
            };
            let class = format!("{letter}{}", *place % available);
            *place += 1;
            class
        })
        .collect()
}
