//! Numbers side by side in vector registers, written so that the compiler keeps them there.

use crate::real::Real;

/// `V` registers of `L` numbers.
pub(crate) type Lanes<T, const L: usize, const V: usize> = [[T; L]; V];

/// Whether a register holds twice as many of these numbers as of doubles.
const fn single<T>() -> bool {
    size_of::<T>() == size_of::<f32>()
}

/// A computation on `V` registers of `L` numbers side by side.
pub(crate) trait Kernel {
    /// Runs it; always inlined, so that it is compiled for the instruction set of its caller.
    fn run<const L: usize, const V: usize, const FUSED: bool>(self);
}

/// Instruction set that a kernel is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InstructionSet {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Fma,
    Base,
}

impl InstructionSet {
    pub(crate) fn of_this_cpu() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if std::arch::is_x86_feature_detected!("avx512f") {
                return InstructionSet::Avx512;
            }
            if std::arch::is_x86_feature_detected!("avx2")
                && std::arch::is_x86_feature_detected!("fma")
            {
                return InstructionSet::Fma;
            }
        }
        InstructionSet::Base
    }

    /// Bytes of a register, and how many registers `run` uses side by side of the `wide` it may.
    pub(crate) const fn registers(self, wide: usize) -> (usize, usize) {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => (64, wide),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Fma => (32, 1),
            InstructionSet::Base => (16, 1),
        }
    }

    /// Runs a kernel for numbers `T` on one register side by side, with AVX-512 on `WIDE` of them. The CPU
    /// has this instruction set.
    pub(crate) fn run<T: Real, const WIDE: usize, K: Kernel>(self, kernel: K) {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => {
                #[expect(
                    unsafe_code,
                    reason = "a function compiled for a CPU feature; the feature was found"
                )]
                // SAFETY: this value is made where the CPU has AVX-512F.
                unsafe {
                    run_avx512::<T, WIDE, K>(kernel);
                }
            }
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Fma => {
                #[expect(
                    unsafe_code,
                    reason = "a function compiled for a CPU feature; the feature was found"
                )]
                // SAFETY: this value is made where the CPU has AVX2 and FMA (every CPU with AVX-512F
                // does).
                unsafe {
                    run_fma::<T, K>(kernel);
                }
            }
            InstructionSet::Base => {
                // Fused multiply-add belongs to the base instruction set of 64-bit ARM.
                const FUSED: bool = cfg!(target_arch = "aarch64");
                if single::<T>() {
                    kernel.run::<4, 1, FUSED>();
                } else {
                    kernel.run::<2, 1, FUSED>();
                }
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn run_avx512<T: Real, const WIDE: usize, K: Kernel>(kernel: K) {
    if single::<T>() {
        kernel.run::<16, WIDE, true>();
    } else {
        kernel.run::<8, WIDE, true>();
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_fma<T: Real, K: Kernel>(kernel: K) {
    if single::<T>() {
        kernel.run::<8, 1, true>();
    } else {
        kernel.run::<4, 1, true>();
    }
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

/// Numbers that start at a cache line.
#[derive(Clone, Debug)]
pub(crate) struct Aligned<T> {
    numbers: Vec<T>,
    first: usize,
    length: usize,
}

impl<T: Real> Aligned<T> {
    pub(crate) fn zeros(length: usize) -> Self {
        Self::filled(length, |numbers| {
            numbers.resize(numbers.len() + length, T::ZERO);
        })
    }

    /// Numbers from a cache line on: `append` appends `length` of them.
    pub(crate) fn filled(length: usize, append: impl FnOnce(&mut Vec<T>)) -> Self {
        let spare = CACHE_LINE / size_of::<T>();
        let mut numbers = Vec::<T>::with_capacity(length + spare);
        // Where the allocation cannot be aligned, its start will do: alignment is speed alone.
        let offset = numbers.as_ptr().align_offset(CACHE_LINE);
        let first = if offset <= spare { offset } else { 0 };
        numbers.resize(first, T::ZERO);
        append(&mut numbers);
        Self {
            numbers,
            first,
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
