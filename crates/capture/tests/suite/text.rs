//! Vendor files made of a few columns.

use inhand_capture::{CaptureError, ReadSettings};
use inhand_model::Recording;

/// A column of a Motive file: type, name, ID, kind, axis.
pub(crate) type Column = [String; 5];

/// A Motive file as its parts, each open to change before it becomes text.
#[derive(Clone)]
pub(crate) struct Motive {
    pub(crate) facts: Vec<(String, String)>,
    pub(crate) columns: Vec<Column>,
    /// Cells of each row, frame and time included.
    pub(crate) rows: Vec<String>,
    /// Whether the label rows say what they are, as from 1.23 on.
    pub(crate) labelled: bool,
    pub(crate) line_end: &'static str,
}

impl Motive {
    pub(crate) fn new(columns: Vec<Column>, rows: &[&str]) -> Self {
        let facts = [
            ("Format Version", "1.23"),
            ("Take Name", "take"),
            ("Take Notes", ""),
            ("Capture Frame Rate", "100.000000"),
            ("Export Frame Rate", "100.000000"),
            ("Capture Start Time", "2023-11-28 10.27.58.765 AM"),
            ("Rotation Type", "Quaternion"),
            ("Length Units", "Meters"),
            ("Coordinate Space", "Global"),
        ];
        Self {
            facts: facts.map(|(k, v)| (k.to_owned(), v.to_owned())).to_vec(),
            columns,
            rows: rows.iter().map(|&row| row.to_owned()).collect(),
            labelled: true,
            line_end: "\r\n",
        }
    }

    /// Sets a fact of the header.
    pub(crate) fn with(mut self, key: &str, value: &str) -> Self {
        match self.facts.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = value.to_owned(),
            None => self.facts.push((key.to_owned(), value.to_owned())),
        }
        self
    }

    /// Takes a fact out of the header.
    pub(crate) fn without(mut self, key: &str) -> Self {
        self.facts.retain(|(known, _)| known != key);
        self
    }

    pub(crate) fn text(&self) -> String {
        let facts: Vec<String> = self.facts.iter().map(|(k, v)| format!("{k},{v}")).collect();
        let mut lines = vec![facts.join(","), String::new()];
        for (place, label) in ["Type", "Name", "ID", "", ""].into_iter().enumerate() {
            let mut row = match (place, self.labelled) {
                (4, _) => "Frame,Time (Seconds)".to_owned(),
                (_, true) => format!(",{label}"),
                (_, false) => ",".to_owned(),
            };
            for column in &self.columns {
                row.push(',');
                row.push_str(&column[place]);
            }
            lines.push(row);
        }
        lines.extend(self.rows.iter().cloned());
        lines.push(String::new());
        lines.join(self.line_end)
    }

    pub(crate) fn read(&self) -> Result<Recording, CaptureError> {
        self.read_with(&ReadSettings::default())
    }

    pub(crate) fn read_with(&self, settings: &ReadSettings) -> Result<Recording, CaptureError> {
        inhand_capture::read(self.text().as_bytes(), "take.csv", settings)
    }

    /// The message of the error that reading gives.
    pub(crate) fn refusal(&self) -> String {
        self.read().expect_err("must be refused").to_string()
    }
}

fn columns(of: &str, name: &str, id: &str, kinds: &[(&str, &str)]) -> Vec<Column> {
    kinds
        .iter()
        .map(|(kind, axis)| [of, name, id, kind, axis].map(str::to_owned))
        .collect()
}

/// Columns of a rigid body with a quaternion.
pub(crate) fn body(name: &str) -> Vec<Column> {
    let kinds = [
        ("Rotation", "X"),
        ("Rotation", "Y"),
        ("Rotation", "Z"),
        ("Rotation", "W"),
        ("Position", "X"),
        ("Position", "Y"),
        ("Position", "Z"),
    ];
    columns("Rigid Body", name, "B0", &kinds)
}

/// Columns of a rigid body with Euler angles.
pub(crate) fn euler_body(name: &str) -> Vec<Column> {
    let mut columns = body(name);
    columns.remove(3);
    columns
}

/// Columns of a marker of any type.
pub(crate) fn marker_of(of: &str, name: &str, id: &str) -> Vec<Column> {
    let kinds = [("Position", "X"), ("Position", "Y"), ("Position", "Z")];
    columns(of, name, id, &kinds)
}

/// Columns of a labelled marker.
pub(crate) fn marker(name: &str) -> Vec<Column> {
    marker_of("Marker", name, "M0")
}

/// A column with a quality.
pub(crate) fn quality(of: &str, name: &str, id: &str, kind: &str) -> Vec<Column> {
    columns(of, name, id, &[(kind, "")])
}

/// A Motive file of one marker called `Ring`.
pub(crate) fn ring(rows: &[&str]) -> Motive {
    Motive::new(marker("Ring"), rows)
}

/// Messages of all findings.
pub(crate) fn findings(recording: &Recording) -> Vec<String> {
    recording.findings.iter().map(ToString::to_string).collect()
}
