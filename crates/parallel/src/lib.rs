//! Work on all threads of the current rayon pool: results in order, and of errors the first in order.
//!
//! rayon's own iterators are compiled anew for every closure, and give whichever error came first in time. Here the
//! work is behind a pointer, so that the machinery is compiled once; that costs some tens of nanoseconds an item,
//! which is nothing for a take, a segment or a figure. Loops over samples use rayon itself.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// A panic in the work goes on in the caller.
const DONE: &str = "the work is done";

/// `work` of `0..n`, in order.
///
/// ```
/// assert_eq!(inhand_parallel::up_to(3, |k| k * k), [0, 1, 4]);
/// ```
pub fn up_to<R: Send>(n: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let results: Vec<Mutex<Option<R>>> = (0..n).map(|_| Mutex::default()).collect();
    each(n, &|k| {
        let result = work(k);
        *results[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    let result = |slot: Mutex<Option<R>>| slot.into_inner().ok().flatten().expect(DONE);
    results.into_iter().map(result).collect()
}

/// `work` of each item, in order.
///
/// ```
/// assert_eq!(inhand_parallel::map(&["a", "bc"], |word| word.len()), [1, 2]);
/// ```
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    up_to(items.len(), |k| work(&items[k]))
}

/// `work` of each item, in order.
///
/// # Errors
///
/// The first in order; the other items are worked on all the same.
///
/// ```
/// let parsed = inhand_parallel::try_map(&["1", "x", ""], |text| text.parse::<u8>());
/// assert_eq!(parsed.unwrap_err(), "x".parse::<u8>().unwrap_err());
/// ```
pub fn try_map<T: Sync, R: Send, E: Send>(
    items: &[T],
    work: impl Fn(&T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    map(items, work).into_iter().collect()
}

/// `work` of `0..n`, in order.
///
/// # Errors
///
/// As [`try_map`].
pub fn try_up_to<R: Send, E: Send>(
    n: usize,
    work: impl Fn(usize) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    up_to(n, work).into_iter().collect()
}

/// Both at once.
///
/// ```
/// assert_eq!(inhand_parallel::both(|| 1, || "two"), (1, "two"));
/// ```
pub fn both<A: Send, B: Send>(
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    let (mut one, mut other) = (Some(one), Some(other));
    let (mut first, mut second) = (None, None);
    let mut one = || first = one.take().map(|work| work());
    let mut other = || second = other.take().map(|work| work());
    join(&mut one, &mut other);
    (first.expect(DONE), second.expect(DONE))
}

fn each(n: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..n).into_par_iter().for_each(work);
}

fn join(one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
    rayon::join(one, other);
}
