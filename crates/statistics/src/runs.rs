//! Runs of samples.

use std::ops::Range;

/// Maximal runs of samples among `range` for which `holds` is true, in order.
///
/// ```
/// use inhand_statistics::runs;
///
/// assert_eq!(runs(0..6, |k| k != 2 && k != 3), [0..2, 4..6]);
/// ```
pub fn runs(range: Range<usize>, holds: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = None;
    for k in range.clone() {
        match (holds(k), start) {
            (true, None) => start = Some(k),
            (false, Some(from)) => {
                runs.push(from..k);
                start = None;
            }
            _ => {}
        }
    }
    runs.extend(start.map(|from| from..range.end));
    runs
}
