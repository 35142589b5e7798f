//! The two kinds of floating-point numbers that learning runs in.

use std::borrow::Cow;
use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use serde::{Deserialize, Serialize};

/// Activations of a block (rank x its columns), metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Activations {
    /// In double precision.
    F64(Vec<f64>),
    /// In single precision.
    F32(Vec<f32>),
}

impl Activations {
    /// The numbers in double precision.
    pub fn to_f64(&self) -> Vec<f64> {
        match self {
            Activations::F64(values) => values.clone(),
            Activations::F32(values) => values.iter().map(|v| f64::from(*v)).collect(),
        }
    }
}

/// `f32` or `f64`: what the products and the descent need of a number.
///
/// Vector widths follow from the size of the type: a register of the same instruction set holds
/// twice as many `f32`.
pub(crate) trait Real:
    Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Sum
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;

    /// Share of the data's squared norm below which the expanded residual
    /// `|V|² - 2 <P, H> + <G, H Hᵀ>` has lost too many digits, and the differences are formed
    /// instead. Above it, cancellation leaves about 1e-10 of relative error, of single precision
    /// 1e-5.
    const DIRECT_RESIDUAL_BELOW: f64;

    /// The nearest number of this kind.
    fn of(number: f64) -> Self;

    /// Numbers of this kind, as they are or the nearest ones.
    fn all_of(numbers: &[f64]) -> Cow<'_, [Self]>;

    /// The same number in double precision.
    fn to_f64(self) -> f64;

    /// `self * b + c` with one rounding.
    fn mul_add(self, b: Self, c: Self) -> Self;

    /// `1 / self`.
    fn recip(self) -> Self;

    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// Activations of these numbers.
    fn stored(values: Vec<Self>) -> Activations;

    /// The numbers of activations, where they are of this kind.
    fn restored(activations: Activations) -> Option<Vec<Self>>;

    /// `c = alpha * a * b + beta * c` for `a` (`m` x `k`), `b` (`k` x `n`), `c` (`m` x `n`), each a
    /// pointer with the strides of rows and columns.
    ///
    /// # Safety
    ///
    /// Every element named by sizes and strides can be read, those of `c` written; elements of `c`
    /// overlap neither each other nor `a` or `b`.
    #[expect(unsafe_code, reason = "matrixmultiply takes pointers")]
    #[expect(
        clippy::too_many_arguments,
        reason = "the signature of every matrix product library"
    )]
    unsafe fn gemm(
        m: usize,
        k: usize,
        n: usize,
        alpha: Self,
        a: (*const Self, isize, isize),
        b: (*const Self, isize, isize),
        beta: Self,
        c: (*mut Self, isize, isize),
    );
}

macro_rules! real {
    ($number:ident, $stored:ident, $gemm:ident, $direct_residual_below:literal, $all_of:expr) => {
        impl Real for $number {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const DIRECT_RESIDUAL_BELOW: f64 = $direct_residual_below;

            #[inline(always)]
            fn of(number: f64) -> Self {
                number as $number
            }

            fn all_of(numbers: &[f64]) -> Cow<'_, [Self]> {
                $all_of(numbers)
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                $number::mul_add(self, b, c)
            }

            #[inline(always)]
            fn recip(self) -> Self {
                $number::recip(self)
            }

            #[inline(always)]
            fn is_finite(self) -> bool {
                $number::is_finite(self)
            }

            fn stored(values: Vec<Self>) -> Activations {
                Activations::$stored(values)
            }

            fn restored(activations: Activations) -> Option<Vec<Self>> {
                match activations {
                    Activations::$stored(values) => Some(values),
                    _ => None,
                }
            }

            #[expect(unsafe_code, reason = "matrixmultiply takes pointers")]
            unsafe fn gemm(
                m: usize,
                k: usize,
                n: usize,
                alpha: Self,
                (a, a_rows, a_columns): (*const Self, isize, isize),
                (b, b_rows, b_columns): (*const Self, isize, isize),
                beta: Self,
                (c, c_rows, c_columns): (*mut Self, isize, isize),
            ) {
                // SAFETY: the caller's promise is that of matrixmultiply.
                unsafe {
                    matrixmultiply::$gemm(
                        m, k, n, alpha, a, a_rows, a_columns, b, b_rows, b_columns, beta, c,
                        c_rows, c_columns,
                    );
                }
            }
        }
    };
}

real!(f64, F64, dgemm, 1e-6, Cow::Borrowed);
real!(f32, F32, sgemm, 3e-2, |numbers: &[f64]| {
    numbers.iter().map(|v| *v as f32).collect()
});
