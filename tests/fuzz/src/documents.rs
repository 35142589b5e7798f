//! Checks of the readers of tables and documents.

use inhand_export::matrices::{self, MatrixFormat, Variable, Variables};
use inhand_export::{events, facts_json, read_wide_csv, recording_entities, wide, write_csv};
use inhand_model::{DictionaryKind, Recording, SegmentLayout};

/// Most numbers of a recording that is written and read again.
const MOST_NUMBERS: usize = 10_000;

/// Writes a recording that was read as a table, and reads that.
///
/// # Panics
///
/// Where the table cannot be read, or has another length.
pub fn check_recording(recording: &Recording) {
    let entities = recording_entities(recording);
    if entities.is_empty() || recording.len() < 2 || recording.len() * entities.len() > MOST_NUMBERS
    {
        return;
    }
    let mut csv = Vec::new();
    write_csv(&wide(&entities, recording.clock, recording.len()), &mut csv)
        .expect("memory takes all");
    let facts = facts_json(recording);
    if let Ok(again) = read_wide_csv(&csv, "take.csv", Some(facts.as_bytes()), None) {
        assert_eq!(recording.len(), again.len(), "samples of the table");
    }
}

/// Reads a wide CSV file, and what was read again; then the same bytes as a table of events.
///
/// # Panics
///
/// Where events that were read cannot be written and read again.
pub fn check_table(bytes: &[u8]) {
    // The facts follow the table.
    let end = bytes
        .iter()
        .position(|&byte| byte == b'{')
        .unwrap_or(bytes.len());
    let (table, facts) = bytes.split_at(end);
    for facts in [None, Some(facts)] {
        if let Ok(recording) = read_wide_csv(table, "take.csv", facts, None) {
            check_recording(&recording);
        }
    }
    if let Ok(read) = events::read(bytes, "events.csv", 1_700_000_000_000_000_000) {
        let mut out = Vec::new();
        events::write(&read, 1_700_000_000_000_000_000, &mut out)
            .expect("events that were read are written");
        let again = events::read(&out, "again.csv", 1_700_000_000_000_000_000).expect("own output");
        assert_eq!(
            format!("{:?}", read.events),
            format!("{:?}", again.events),
            "read again"
        );
    }
}

/// Reads a file of matrices; what was read is written and read again.
///
/// # Panics
///
/// Where that gives other matrices.
pub fn check_matrices(bytes: &[u8]) {
    let Ok(variables) = matrices::read(bytes, "w.npz") else {
        return;
    };
    let layout = SegmentLayout {
        samples: 4,
        rate_hz: 4.0,
        object: false,
    };
    for kind in DictionaryKind::ALL {
        let _ = matrices::import_primitives(&variables, layout, kind);
    }
    let numbers: Vec<(String, Variable)> = (variables.into_iter())
        .filter(|(_, variable)| variable.numbers().is_some())
        .collect();
    for form in MatrixFormat::ALL {
        // Names of NumPy need not be names of MATLAB.
        let Ok(out) = matrices::write(form, "w", &numbers) else {
            continue;
        };
        let again = matrices::read(&out, "again").expect("own output");
        assert_eq!(
            bits(numbers.iter().cloned().collect()),
            bits(again),
            "read again"
        );
    }
}

fn bits(variables: Variables) -> Vec<(String, Vec<u64>)> {
    let each = variables.into_iter().map(|(name, variable)| {
        let numbers = variable
            .numbers()
            .map(|m| m.iter().map(|n| n.to_bits()).collect());
        (name, numbers.unwrap_or_default())
    });
    each.collect()
}
