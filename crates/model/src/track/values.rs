//! Values of a track: pages that copies share, in memory or, beyond a bound, in a temporary file.
//!
//! The bound is one for all tracks of a process, so that memory grows neither with the length of a take nor with the
//! number of takes. What is stored and read again is the same bit by bit.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};

/// Values of a page.
const PAGE: usize = 1024;

/// Bytes of pages that all tracks together keep in memory.
const IN_MEMORY: usize = 64 << 20;

/// Stored pages that a thread keeps at hand: some for each of the tracks that are read side by side.
const AT_HAND: usize = 64;

/// What is behind a value of a track, without its frames.
pub trait Number: Copy {
    /// Numbers that it consists of.
    const WIDTH: usize;
    /// The stand-in for a missing value: NaN, so that it cannot pass for a number.
    fn missing() -> Self;
    /// Whether every component is a finite number.
    fn is_finite(self) -> bool;
    /// Its components, as many as its width, written to a slice.
    fn write(self, components: &mut [f64]);
    /// The value of so many components.
    fn read(components: &[f64]) -> Self;
}

impl Number for Point3<f64> {
    const WIDTH: usize = 3;

    fn missing() -> Self {
        Point3::new(f64::NAN, f64::NAN, f64::NAN)
    }

    fn is_finite(self) -> bool {
        self.iter().all(|c| c.is_finite())
    }

    fn write(self, components: &mut [f64]) {
        components.copy_from_slice(self.coords.as_slice());
    }

    fn read(components: &[f64]) -> Self {
        Point3::from_slice(components)
    }
}

impl Number for Isometry3<f64> {
    const WIDTH: usize = 7;

    fn missing() -> Self {
        Self::read(&[f64::NAN; 7])
    }

    fn is_finite(self) -> bool {
        let (place, rotation) = (self.translation.vector, self.rotation.coords);
        place.iter().chain(rotation.iter()).all(|c| c.is_finite())
    }

    fn write(self, components: &mut [f64]) {
        let (place, rotation) = components.split_at_mut(3);
        place.copy_from_slice(self.translation.vector.as_slice());
        rotation.copy_from_slice(self.rotation.coords.as_slice());
    }

    fn read(components: &[f64]) -> Self {
        let (place, rotation) = components.split_at(3);
        // Normalising again would change the last bits.
        Isometry3::from_parts(
            Translation3::new(place[0], place[1], place[2]),
            UnitQuaternion::new_unchecked(Quaternion::new(
                rotation[3],
                rotation[0],
                rotation[1],
                rotation[2],
            )),
        )
    }
}

/// Values in order. Copies share them, and what is changed in a copy is its own.
#[derive(Clone, Debug, Default)]
pub(super) struct Values {
    pages: Vec<Arc<Page>>,
    /// The values after the last whole page.
    rest: Vec<f64>,
    /// The page that was changed last, in memory whatever the bound.
    changed: Option<usize>,
}

impl Values {
    /// Appends a value.
    pub(super) fn push<N: Number>(&mut self, value: N) {
        let end = self.rest.len();
        self.rest.resize(end + N::WIDTH, 0.0);
        value.write(&mut self.rest[end..]);
        if self.rest.len() == PAGE * N::WIDTH {
            let page = Page::new(std::mem::take(&mut self.rest).into());
            self.pages.push(Arc::new(page));
        }
    }

    /// The value in place `k`.
    pub(super) fn get<N: Number>(&self, k: usize) -> N {
        let place = k % PAGE * N::WIDTH..(k % PAGE + 1) * N::WIDTH;
        match self.pages.get(k / PAGE).map(|page| &**page) {
            Some(Page::Memory(numbers)) => N::read(&numbers[place]),
            Some(Page::Stored(stored)) => stored.with(|numbers| N::read(&numbers[place])),
            None => N::read(&self.rest[place]),
        }
    }

    /// Replaces the value in place `k`.
    pub(super) fn set<N: Number>(&mut self, k: usize, value: N) {
        let place = k % PAGE * N::WIDTH..(k % PAGE + 1) * N::WIDTH;
        let number = k / PAGE;
        if number == self.pages.len() {
            return value.write(&mut self.rest[place]);
        }
        if self.changed != Some(number) {
            self.keep_changed();
            self.changed = Some(number);
        }
        let page = &mut self.pages[number];
        if let Some(Page::Memory(numbers)) = Arc::get_mut(page) {
            return value.write(&mut numbers[place]);
        }
        let mut numbers = page.numbers();
        value.write(&mut numbers[place]);
        *page = Arc::new(Page::in_memory(numbers));
    }

    /// Puts the page that was changed last where it belongs.
    fn keep_changed(&mut self) {
        let page = self.changed.take().map(|number| &mut self.pages[number]);
        if let Some(page) = page
            && let Page::Memory(numbers) = &**page
            && Page::beyond_memory(0)
            && let Some(stored) = Stored::new(numbers)
        {
            *page = Arc::new(Page::Stored(stored));
        }
    }
}

/// Some values, component by component.
#[derive(Debug)]
enum Page {
    Memory(Box<[f64]>),
    Stored(Stored),
}

/// Bytes of pages in memory.
static HELD: AtomicUsize = AtomicUsize::new(0);

impl Page {
    fn new(numbers: Box<[f64]>) -> Self {
        if Self::beyond_memory(size_of_val(&*numbers))
            && let Some(stored) = Stored::new(&numbers)
        {
            return Page::Stored(stored);
        }
        Self::in_memory(numbers)
    }

    fn in_memory(numbers: Box<[f64]>) -> Self {
        HELD.fetch_add(size_of_val(&*numbers), Ordering::Relaxed);
        Page::Memory(numbers)
    }

    fn beyond_memory(more: usize) -> bool {
        HELD.load(Ordering::Relaxed) + more > IN_MEMORY
    }

    fn numbers(&self) -> Box<[f64]> {
        match self {
            Page::Memory(numbers) => numbers.clone(),
            Page::Stored(stored) => stored.with(|numbers| numbers.into()),
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        if let Page::Memory(numbers) = self {
            HELD.fetch_sub(size_of_val(&**numbers), Ordering::Relaxed);
        }
    }
}

/// A page in the temporary file.
#[derive(Debug)]
struct Stored {
    /// Never given twice, unlike places in the file.
    id: usize,
    at: u64,
    /// Numbers of the page.
    len: usize,
}

thread_local! {
    /// Pages that this thread has read, the oldest first, by their id.
    static RECENT: RefCell<VecDeque<(usize, Box<[f64]>)>> = const { RefCell::new(VecDeque::new()) };
}

impl Stored {
    /// `None` where nothing can be stored: the page then stays in memory.
    fn new(numbers: &[f64]) -> Option<Self> {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        Some(Self {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            at: Store::lock().write(&bytes).ok()?,
            len: numbers.len(),
        })
    }

    fn with<T>(&self, look: impl FnOnce(&[f64]) -> T) -> T {
        RECENT.with_borrow_mut(|recent| {
            if let Some((_, numbers)) = recent.iter().rev().find(|(id, _)| *id == self.id) {
                return look(numbers);
            }
            let numbers = self.load();
            let found = look(&numbers);
            if recent.len() == AT_HAND {
                recent.pop_front();
            }
            recent.push_back((self.id, numbers));
            found
        })
    }

    fn load(&self) -> Box<[f64]> {
        let mut bytes = vec![0; 8 * self.len];
        // As when memory fails: nothing that was computed from here on would be right.
        Store::lock()
            .read(self.at, &mut bytes)
            .expect("the temporary file of samples can be read: see that its disk works");
        let numbers = bytes.as_chunks().0.iter();
        numbers.map(|&bytes| f64::from_le_bytes(bytes)).collect()
    }
}

impl Drop for Stored {
    fn drop(&mut self) {
        let mut store = Store::lock();
        store.free.entry(8 * self.len).or_default().push(self.at);
    }
}

/// The temporary file, which has no name and goes with the process, however that ends.
#[derive(Debug)]
struct Store {
    file: Option<File>,
    end: u64,
    /// Places that are free again, by their size in bytes.
    free: BTreeMap<usize, Vec<u64>>,
}

/// Where large temporary files belong: the usual folder is in memory on some systems.
fn folder() -> PathBuf {
    let large = Path::new("/var/tmp");
    match std::env::var_os("TMPDIR") {
        None if large.is_dir() => large.to_owned(),
        _ => std::env::temp_dir(),
    }
}

impl Store {
    fn lock() -> MutexGuard<'static, Self> {
        static STORE: Mutex<Store> = Mutex::new(Store {
            file: None,
            end: 0,
            free: BTreeMap::new(),
        });
        STORE.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where the bytes are from now on.
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<u64> {
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(tempfile::tempfile_in(folder())?),
        };
        let again = self.free.get_mut(&bytes.len()).and_then(Vec::pop);
        let at = again.unwrap_or(self.end);
        file.seek(SeekFrom::Start(at))?;
        file.write_all(bytes)?;
        self.end = self.end.max(at + bytes.len() as u64);
        Ok(at)
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> std::io::Result<()> {
        if let Some(file) = &mut self.file {
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(bytes)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Not one value like another, and all bits of them in use.
    fn point(track: usize, k: usize) -> Point3<f64> {
        Point3::new(track as f64, k as f64, 1.0).map(|c| (c + 0.1).sqrt())
    }

    #[test]
    fn values_beyond_the_bound_are_stored_and_copies_go_their_own_way() {
        const TRACKS: usize = 5;
        // The first tracks fill the memory.
        const LEN: usize = IN_MEMORY / (TRACKS - 1) / 24 + PAGE;
        let track = |n: usize| {
            let mut values = Values::default();
            (0..LEN).for_each(|k| values.push(point(n, k)));
            values
        };
        let tracks: Vec<Values> = (0..TRACKS).map(track).collect();
        let is_stored = |page: &Arc<Page>| matches!(**page, Page::Stored(_));
        assert!(tracks[TRACKS - 1].pages.iter().all(is_stored));
        assert!(HELD.load(Ordering::Relaxed) <= IN_MEMORY);

        // Every page, its ends, and the values after the last whole one; none beside another.
        let places = || (0..LEN).step_by(31);
        let copies: Vec<Values> = (tracks.iter().enumerate())
            .map(|(n, values)| {
                let mut copy = values.clone();
                places().for_each(|k| copy.set(k, -point(n, k)));
                copy
            })
            .collect();
        for (n, (values, copy)) in tracks.iter().zip(&copies).enumerate() {
            for k in places() {
                assert_eq!(values.get::<Point3<f64>>(k), point(n, k));
                assert_eq!(copy.get::<Point3<f64>>(k), -point(n, k));
                let beside = if k + 1 < LEN { k + 1 } else { k - 1 };
                assert_eq!(copy.get::<Point3<f64>>(beside), point(n, beside));
            }
        }
    }

    #[test]
    fn places_in_the_file_are_used_again() {
        let numbers = vec![1.5; 3 * PAGE];
        let first = Stored::new(&numbers).expect("a disk");
        let at = first.at;
        drop(first);
        let second = Stored::new(&vec![2.5; 3 * PAGE]).expect("a disk");
        assert!(second.at <= at);
        assert_eq!(second.with(|numbers| numbers[7]), 2.5);
    }
}
