//! Runs of samples without a gap.

use std::ops::Range;

/// Maximal runs of samples among `0..len` that are all `present`, in order.
pub(crate) fn runs(len: usize, present: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = None;
    for k in 0..len {
        match (present(k), start) {
            (true, None) => start = Some(k),
            (false, Some(from)) => {
                runs.push(from..k);
                start = None;
            }
            _ => {}
        }
    }
    runs.extend(start.map(|from| from..len));
    runs
}
