//! One factorisation of segments from a file, timed: the half of `compare.py` that is ours.
//!
//!     cargo bench -p inhand-dictionary --bench compare -- write segments.f64 595
//!     cargo bench -p inhand-dictionary --bench compare -- learn segments.f64 0.55 [iterations] [repeats]
//!
//! A file holds segments of 100 samples one after the other, 1500 numbers each, metres, little
//! endian. `write` makes up smooth motion, for those without recordings at hand. `learn` stops at
//! the given error, mm rms, and prints a line of JSON for each repeat.

use std::error::Error;
use std::time::Instant;

use inhand_dictionary::{NmfSettings, learn_nmf};
use nalgebra::DMatrix;

#[path = "../tests/segments.rs"]
mod segments;

const SAMPLES: usize = 100;

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["write", path, count] => write(path, count.parse()?),
        ["learn", path, rms_mm] => learn(path, rms_mm.parse()?, 200, 1),
        ["learn", path, rms_mm, iterations] => learn(path, rms_mm.parse()?, iterations.parse()?, 1),
        ["learn", path, rms_mm, iterations, repeats] => {
            learn(path, rms_mm.parse()?, iterations.parse()?, repeats.parse()?)
        }
        // As when all benches of the crate are run.
        [] => Ok(()),
        _ => Err("write FILE COUNT, or learn FILE RMS_MM [ITERATIONS [REPEATS]]".into()),
    }
}

fn write(path: &str, count: usize) -> Result<(), Box<dyn Error>> {
    let bytes: Vec<u8> = segments::motion(SAMPLES, count)
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    Ok(std::fs::write(path, bytes)?)
}

#[expect(
    clippy::print_stdout,
    reason = "the result, read by the script beside this file"
)]
fn learn(
    path: &str,
    rms_mm: f64,
    max_iterations: usize,
    repeats: usize,
) -> Result<(), Box<dyn Error>> {
    let numbers: Vec<f64> = std::fs::read(path)?
        .as_chunks::<8>()
        .0
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect();
    let columns = DMatrix::from_vec(15 * SAMPLES, numbers.len() / (15 * SAMPLES), numbers);
    let data = segments::segments(columns);
    let settings = NmfSettings {
        rank: 200,
        max_iterations,
        relative_change: 0.0,
        stop_rms_m: (rms_mm > 0.0).then_some(1e-3 * rms_mm),
        ..NmfSettings::default()
    };
    for _ in 0..repeats {
        let start = Instant::now();
        let dictionary = learn_nmf(&data, segments::demonstrated(), &settings)?;
        let seconds = start.elapsed().as_secs_f64();
        let learning = dictionary.learning;
        println!(
            "{{\"seconds\": {seconds:.4}, \"rms_mm\": {:.4}, \"iterations\": {}, \"segments\": {}}}",
            1e3 * learning.rms_m,
            learning.iterations,
            learning.segments
        );
    }
    Ok(())
}
