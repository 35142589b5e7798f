//! Third-party MCAP recordings as takes, by closed forms: what goes in by hand comes out in its place.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at what cannot fail"
)]

mod bag;
#[path = "../../channels/tests/common/mod.rs"]
mod common;
mod hostile;
mod messages;
mod times;
mod topics;

use inhand_import::{ImportSettings, read_recording};
use inhand_model::{Marker, Position, Recording, TrackedBody};

/// Start of the takes here, nanoseconds since 1970.
const START: u64 = 1_700_000_000_000_000_000;

/// A stamp of sample `k` at 100 Hz.
fn stamp(k: u64) -> u64 {
    START + 10_000_000 * k
}

/// A pose with a rotation: half a turn about z.
fn turned(x: f64, y: f64, z: f64) -> bag::Seven {
    [x, y, z, 0.0, 0.0, 1.0, 0.0]
}

/// A pose without one.
fn straight(x: f64, y: f64, z: f64) -> bag::Seven {
    [x, y, z, 0.0, 0.0, 0.0, 1.0]
}

fn read(bytes: &[u8]) -> Recording {
    read_with(bytes, &ImportSettings::default())
}

fn read_with(bytes: &[u8], settings: &ImportSettings) -> Recording {
    read_recording(bytes, "bag.mcap", settings).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(bytes: &[u8], settings: &ImportSettings) -> String {
    read_recording(bytes, "bag.mcap", settings)
        .unwrap_err()
        .to_string()
}

/// Settings with `[topics]`.
fn topics(uses: &[(&str, &str)]) -> ImportSettings {
    let parsed = uses
        .iter()
        .map(|(topic, word)| ((*topic).to_owned(), word.parse().unwrap()));
    ImportSettings {
        topics: parsed.collect(),
        ..ImportSettings::default()
    }
}

fn marker<'a>(recording: &'a Recording, name: &str) -> &'a Marker {
    let names: Vec<_> = recording.markers.iter().map(|m| &m.name).collect();
    recording
        .marker(name)
        .unwrap_or_else(|| panic!("{name} is not in {names:?}"))
}

fn body<'a>(recording: &'a Recording, name: &str) -> &'a TrackedBody {
    let names: Vec<_> = recording.bodies.iter().map(|b| &b.name).collect();
    recording
        .body(name)
        .unwrap_or_else(|| panic!("{name} is not in {names:?}"))
}

fn at(marker: &Marker, k: usize) -> Option<[f64; 3]> {
    marker.track.get(k).map(Position::to_array)
}

/// The findings, one a line.
fn findings(recording: &Recording) -> String {
    let lines = recording
        .findings
        .iter()
        .map(|f| format!("{}: {f}\n", f.severity.name()));
    lines.collect()
}

#[track_caller]
fn assert_found(recording: &Recording, words: &str) {
    let findings = findings(recording);
    assert!(
        findings.contains(words),
        "\"{words}\" is not in\n{findings}"
    );
}
