//! Writes the report of a made-up session to a folder, to look at: `cargo run -p inhand-report
//! --example sample_report -- FOLDER`.

#[path = "../tests/suite/sample.rs"]
mod sample;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .ok_or("expected a folder to write into")?,
    );
    let (evaluation, provenance) = (sample::evaluation(true), sample::provenance());
    fs::create_dir_all(&folder)?;
    fs::write(
        folder.join("report.html"),
        inhand_report::html(&inhand_report::Report::new(&evaluation, &provenance))?,
    )?;
    fs::write(
        folder.join("evaluation.json"),
        inhand_report::evaluation_json(&evaluation, &provenance)?,
    )?;
    fs::write(
        folder.join("summary.txt"),
        inhand_report::text_summary(&evaluation),
    )?;
    Ok(())
}
