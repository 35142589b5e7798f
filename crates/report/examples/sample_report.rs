//! Writes the report of a made-up session to a folder, to look at: `cargo run -p inhand-report
//! --example sample_report -- FOLDER`.

#[path = "../tests/suite/sample.rs"]
mod sample;
#[path = "../tests/suite/sample_rows.rs"]
mod sample_rows;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .ok_or("expected a folder to write into")?,
    );
    let (mut evaluation, provenance) = (sample::evaluation(true), sample::provenance());
    evaluation.intervals = Some(sample_rows::intervals(&evaluation));
    let rows = sample_rows::rows(&evaluation, true);
    let report = inhand_report::Report {
        rows: Some(&rows),
        ..inhand_report::Report::new(&evaluation, &provenance)
    };
    fs::create_dir_all(folder.join("figures"))?;
    fs::write(folder.join("report.html"), inhand_report::html(&report)?)?;
    fs::write(folder.join("report.md"), inhand_report::markdown(&report)?)?;
    for figure in inhand_report::figures(&report)? {
        let path = folder.join("figures").join(figure.id);
        fs::write(path.with_extension("svg"), figure.print_svg())?;
        fs::write(path.with_extension("csv"), figure.data.csv())?;
    }
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
