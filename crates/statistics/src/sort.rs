//! Sorting of numbers by their bits.

use std::iter::zip;

use rayon::prelude::*;

/// Rows below this number are compared with each other: the tables of the buckets would cost more.
const FEW: usize = 256;

/// Bits of a pass: few enough buckets that the ends of all of them stay in the cache.
const DIGIT_BITS: u32 = 8;

/// More passes would take longer than comparing the rows that share a bucket.
const MOST_PASSES: u32 = 3;

/// Bits beyond those that number the rows: exponents that hardly occur take some.
const SPARE_BITS: u32 = 6;

/// Rows of a bucket of clusters on average, as a power of two: as few as are compared, so that they stay in the cache.
const BUCKET_ROWS_BITS: u32 = FEW.ilog2();

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

/// Sorts the rows of all clusters, in the order of [`f64::total_cmp`]; equal ones in no order. The second list is the
/// cluster of each.
///
/// Rows are put into buckets by their leading bits, and buckets are sorted on all threads: beside input and result
/// only a bucket a thread is in memory.
pub(crate) fn sort_clusters(clusters: &[&[f64]]) -> (Vec<f64>, Vec<u32>) {
    let keys = || clusters.iter().copied().flatten().map(|&value| key(value));
    let (low, high) = keys().fold((u64::MAX, 0), |(low, high), key| {
        (low.min(key), high.max(key))
    });
    let range_bits = u64::BITS - high.saturating_sub(low).leading_zeros();
    let n: usize = clusters.iter().map(|rows| rows.len()).sum();
    let bits = n.max(1).ilog2().saturating_sub(BUCKET_ROWS_BITS).max(1);
    let shift = range_bits.saturating_sub(bits);
    let bucket = |key: u64| ((key - low) >> shift) as usize;
    let mut sizes = vec![0; 1 << bits];
    keys().for_each(|key| sizes[bucket(key)] += 1);
    let mut places: Vec<usize> = (sizes.iter())
        .scan(0, |end, size| Some(std::mem::replace(end, *end + size)))
        .collect();
    let (mut values, mut cluster_of) = (vec![0.0; n], vec![0; n]);
    for (rows, cluster) in clusters.iter().zip(0..) {
        for &value in *rows {
            let place = &mut places[bucket(key(value))];
            (values[*place], cluster_of[*place]) = (value, cluster);
            *place += 1;
        }
    }
    let mut rest = (&mut values[..], &mut cluster_of[..]);
    let buckets: Vec<_> = (sizes.iter())
        .map(|&size| {
            let values = rest.0.split_off_mut(..size).unwrap_or_default();
            (values, rest.1.split_off_mut(..size).unwrap_or_default())
        })
        .collect();
    buckets.into_par_iter().for_each(|(values, cluster_of)| {
        // Of shares, all rows are 0 or 1: such a bucket may hold millions.
        if values.iter().all(|value| key(*value) == key(values[0])) {
            return;
        }
        let mut rows: Vec<(f64, u32)> =
            zip(&*values, &*cluster_of).map(|(v, c)| (*v, *c)).collect();
        sort_by_number(&mut rows, |row| row.0);
        for (place, row) in zip(zip(values, cluster_of), rows) {
            (*place.0, *place.1) = row;
        }
    });
    (values, cluster_of)
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

    #[test]
    fn clusters_are_sorted_together() {
        // Of both signs, so that the keys need all bits, with exact zeros and many equal numbers.
        let number = |k: u32| match k % 5 {
            0 => 0.0,
            1 => f64::from(k % 7) - 3.0,
            _ => ((f64::from(k) * 0.618_033_988_749_895).fract() - 0.3) * 1e-3,
        };
        for size in [0, 1, 4, 3000] {
            let clusters: Vec<Vec<f64>> = (0..3)
                .map(|c| (c * size..(c + 1) * size).map(number).collect())
                .collect();
            let mut expected: Vec<(f64, u32)> = (clusters.iter().zip(0..))
                .flat_map(|(rows, cluster)| rows.iter().map(move |&value| (value, cluster)))
                .collect();
            let slices: Vec<&[f64]> = clusters.iter().map(Vec::as_slice).collect();
            let (values, cluster) = sort_clusters(&slices);
            let mut found: Vec<(f64, u32)> = zip(values, cluster).collect();
            assert!(found.is_sorted_by(|a, b| a.0 <= b.0));
            for rows in [&mut found, &mut expected] {
                rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            }
            assert_eq!(found, expected);
        }
    }
}
