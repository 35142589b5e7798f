//! Sorting of numbers by their bits.

/// Rows below this number are compared with each other: the tables of the buckets would cost more.
const FEW: usize = 256;

/// Bits of a pass: few enough buckets that the ends of all of them stay in the cache.
const DIGIT_BITS: u32 = 8;

/// More passes would take longer than comparing the rows that share a bucket.
const MOST_PASSES: u32 = 3;

/// Bits beyond those that number the rows: exponents that hardly occur take some.
const SPARE_BITS: u32 = 6;

/// An integer in the order of [`f64::total_cmp`].
fn key(value: f64) -> u64 {
    let bits = value.to_bits();
    let sign = 1 << 63;
    if bits & sign == 0 { bits | sign } else { !bits }
}

/// Sorts rows by a number of theirs, in the order of [`f64::total_cmp`]; equal ones in no order.
///
/// The leading bits that differ among the numbers put rows into buckets, in up to three passes; what is left to
/// compare are the few rows of a bucket. Whatever the numbers, this takes no longer than comparing them all.
pub(crate) fn sort_by_number<T: Copy>(rows: &mut Vec<T>, number: impl Fn(&T) -> f64) {
    let key = |row: &T| key(number(row));
    if rows.len() < FEW {
        rows.sort_unstable_by_key(key);
        return;
    }
    let (low, high) = (rows.iter()).fold((u64::MAX, 0), |(low, high), row| {
        (low.min(key(row)), high.max(key(row)))
    });
    let range_bits = u64::BITS - (high - low).leading_zeros();
    let bits = (rows.len().ilog2() + SPARE_BITS).min(MOST_PASSES * DIGIT_BITS);
    let bits = bits.min(range_bits);
    let shift = range_bits - bits;
    let passes = bits.div_ceil(DIGIT_BITS);
    let mut other = rows.clone();
    for pass in 0..passes {
        let width = bits.div_ceil(passes);
        let bucket =
            |row: &T| (((key(row) - low) >> (shift + pass * width)) & ((1 << width) - 1)) as usize;
        let mut starts = vec![0_usize; 1 << width];
        rows.iter().for_each(|row| starts[bucket(row)] += 1);
        let mut start = 0;
        for count in &mut starts {
            start += std::mem::replace(count, start);
        }
        for row in &*rows {
            let place = &mut starts[bucket(row)];
            other[*place] = *row;
            *place += 1;
        }
        std::mem::swap(rows, &mut other);
    }
    if shift > 0 {
        let leading = |row: &T| (key(row) - low) >> shift;
        for bucket in rows.chunk_by_mut(|a, b| leading(a) == leading(b)) {
            if bucket.len() > 1 {
                bucket.sort_unstable_by_key(key);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_kind_are_in_total_order() {
        let spread = |k: u32| (f64::from(k) * 0.618_033_988_749_895).fract();
        let many = |number: &dyn Fn(u32) -> f64| (0..3000).map(number).collect::<Vec<f64>>();
        let special = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            0.0,
            -0.0,
            5e-324,
        ];
        let cases = [
            many(&spread),
            many(&|k| spread(k) - 0.5),
            many(&|k| (spread(k) * 200.0 - 100.0).exp2()),
            many(&|k| f64::from(k % 3)),
            many(&|_| 0.25),
            // Nearly all rows in one bucket.
            many(&|k| {
                if k == 7 {
                    1e300
                } else {
                    1.0 + spread(k) * 1e-12
                }
            }),
            many(&|k| special.get(k as usize / 9).copied().unwrap_or(-spread(k))),
        ];
        for mut numbers in cases {
            let mut expected = numbers.clone();
            expected.sort_by(f64::total_cmp);
            sort_by_number(&mut numbers, |&number| number);
            let bits = |numbers: &[f64]| numbers.iter().map(|n| n.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&numbers), bits(&expected));
        }
    }
}
