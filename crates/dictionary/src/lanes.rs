//! Numbers side by side in vector registers, written so that the compiler keeps them there.

use crate::real::Real;

/// `V` registers of `L` numbers.
pub(crate) type Lanes<T, const L: usize, const V: usize> = [[T; L]; V];

/// Whether a register holds twice as many of these numbers as of doubles.
pub(crate) const fn single<T>() -> bool {
    size_of::<T>() == size_of::<f32>()
}

/// `a * b + c`, fused where the CPU does that in one instruction.
#[inline(always)]
pub(crate) fn multiply_add<T: Real, const FUSED: bool>(a: T, b: T, c: T) -> T {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// `c += a * b`, lane by lane.
#[inline(always)]
pub(crate) fn lanes_multiply_add<T: Real, const L: usize, const V: usize, const FUSED: bool>(
    a: T,
    b: &Lanes<T, L, V>,
    c: &mut Lanes<T, L, V>,
) {
    for v in 0..V {
        for lane in 0..L {
            c[v][lane] = multiply_add::<T, FUSED>(a, b[v][lane], c[v][lane]);
        }
    }
}

/// Bytes of a cache line: a register that is loaded across two of them takes twice as long.
const CACHE_LINE: usize = 64;

/// Zeros that start at a cache line.
#[derive(Clone, Debug)]
pub(crate) struct Aligned<T> {
    numbers: Vec<T>,
    first: usize,
    length: usize,
}

impl<T: Real> Aligned<T> {
    pub(crate) fn zeros(length: usize) -> Self {
        let spare = CACHE_LINE / size_of::<T>();
        let numbers = vec![T::ZERO; length + spare];
        // Where the allocation cannot be aligned, its start will do: alignment is speed alone.
        let offset = numbers.as_ptr().align_offset(CACHE_LINE);
        Self {
            first: if offset <= spare { offset } else { 0 },
            numbers,
            length,
        }
    }

    pub(crate) fn numbers(&self) -> &[T] {
        &self.numbers[self.first..][..self.length]
    }

    pub(crate) fn numbers_mut(&mut self) -> &mut [T] {
        &mut self.numbers[self.first..][..self.length]
    }

    /// Rows of `V` registers of `L` numbers.
    pub(crate) fn lanes<const L: usize, const V: usize>(&self) -> &[Lanes<T, L, V>] {
        self.numbers().as_chunks::<L>().0.as_chunks::<V>().0
    }

    /// Rows of `V` registers of `L` numbers.
    pub(crate) fn lanes_mut<const L: usize, const V: usize>(&mut self) -> &mut [Lanes<T, L, V>] {
        self.numbers_mut()
            .as_chunks_mut::<L>()
            .0
            .as_chunks_mut::<V>()
            .0
    }
}
