//! Mean error of predictions on segments left out of learning, and its standard error.

/// Mean distance between points, three coordinates each, metres.
pub fn mean_distance_m(wanted_m: &[f64], predicted_m: &[f64]) -> f64 {
    let wanted_m = wanted_m.as_chunks::<3>().0;
    let pairs = wanted_m.iter().zip(predicted_m.as_chunks::<3>().0);
    let distances = pairs.map(|([x, y, z], [a, b, c])| {
        let (x, y, z) = (x - a, y - b, z - c);
        (x * x + y * y + z * z).sqrt()
    });
    distances.sum::<f64>() / wanted_m.len().max(1) as f64
}

/// Mean of some values; 0 for none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Standard error of their mean; 0 for fewer than two.
pub fn standard_error(values: &[f64]) -> f64 {
    let count = values.len();
    if count < 2 {
        return 0.0;
    }
    let mean = mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares / (count - 1) as f64 / count as f64).sqrt()
}
