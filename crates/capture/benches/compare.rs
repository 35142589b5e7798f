//! A vendor file read in blocks, timed: the half of `compare.py` that is ours.
//!
//!     cargo bench -p inhand-capture --bench compare -- read take.csv [repeats]
//!     cargo bench -p inhand-capture --bench compare -- make take.csv SECONDS
//!
//! `read` prints a line of JSON for each repeat. `make` writes a take at 120 Hz with 60 columns:
//! frame, time, two bodies with their errors, and fourteen markers.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::time::Instant;

use inhand_capture::{Blocks, Extent, ReadSettings};

const RATE_HZ: usize = 120;
/// Bodies have eight columns, markers three.
const BODIES: usize = 2;
const MARKERS: usize = 14;

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["read", path] => read(path, 1),
        ["read", path, repeats] => read(path, repeats.parse()?),
        ["make", path, seconds] => make(path, seconds.parse()?),
        // As when all benches of the crate are run.
        [] => Ok(()),
        _ => Err("read FILE [REPEATS], or make FILE SECONDS".into()),
    }
}

#[expect(
    clippy::print_stdout,
    reason = "the result, read by the script beside this file"
)]
fn read(path: &str, repeats: usize) -> Result<(), Box<dyn Error>> {
    let mut extent = Extent::default();
    let (mut file, mut buffer) = (File::open(path)?, vec![0; 1 << 20]);
    loop {
        match file.read(&mut buffer)? {
            0 => break,
            read => extent.add(&buffer[..read]),
        }
    }
    for _ in 0..repeats {
        let start = Instant::now();
        let input = File::open(path)?;
        let mut blocks = Blocks::open(input, extent, path, &ReadSettings::default())?;
        let (mut samples, mut present) = (0, 0);
        while let Some(block) = blocks.next_block()? {
            samples += block.len();
            let tracks = block.markers.iter().map(|marker| marker.track.statuses());
            let there = tracks.flatten().filter(|status| status.is_present());
            present += there.count();
        }
        let seconds = start.elapsed().as_secs_f64();
        println!("{{\"seconds\": {seconds}, \"samples\": {samples}, \"present\": {present}}}");
    }
    Ok(())
}

fn make(path: &str, seconds: usize) -> Result<(), Box<dyn Error>> {
    let mut out = BufWriter::new(File::create(path)?);
    write!(
        out,
        "Format Version,1.23,Take Name,long,Capture Frame Rate,{RATE_HZ},Export Frame Rate,\
         {RATE_HZ},Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global\r\n\r\n"
    )?;
    let mut columns: Vec<[String; 4]> = Vec::new();
    let mut add = |of: &str, name: String, what: &str, axes: &str| {
        let column = |axis: char| {
            [
                of.to_owned(),
                name.clone(),
                what.to_owned(),
                axis.to_string(),
            ]
        };
        columns.extend(axes.chars().map(column));
    };
    for body in 0..BODIES {
        add("Rigid Body", format!("Body {body}"), "Rotation", "XYZW");
        add("Rigid Body", format!("Body {body}"), "Position", "XYZ");
        add(
            "Rigid Body",
            format!("Body {body}"),
            "Mean Marker Error",
            " ",
        );
    }
    for marker in 0..MARKERS {
        add("Marker", format!("Marker {marker}"), "Position", "XYZ");
    }
    for (place, label) in [
        (0, ",Type"),
        (1, ",Name"),
        (1, ",ID"),
        (2, ","),
        (3, "Frame,Time (Seconds)"),
    ] {
        write!(out, "{label}")?;
        for column in &columns {
            write!(out, ",{}", column[place])?;
        }
        write!(out, "\r\n")?;
    }
    for k in 0..seconds * RATE_HZ {
        let t = k as f64 / RATE_HZ as f64;
        write!(out, "{k},{t:.6}")?;
        for (c, column) in columns.iter().enumerate() {
            let gap = column[0] == "Marker" && (k / 20 + c / 3) % 50 == 0;
            let half = (0.05 * t).sin();
            match (column[2].as_str(), column[3].as_str()) {
                _ if gap => write!(out, ",")?,
                ("Mean Marker Error", _) => write!(out, ",{:.6}", 2e-4 + 1e-4 * half)?,
                ("Rotation", "W") => write!(out, ",{:.6}", half.cos())?,
                ("Rotation", _) => write!(out, ",{:.6}", half.sin() / 3_f64.sqrt())?,
                _ => write!(out, ",{:.6}", (0.3 * t + c as f64).sin())?,
            }
        }
        write!(out, "\r\n")?;
    }
    out.flush()?;
    Ok(())
}
