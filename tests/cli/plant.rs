//! Faults planted in the text of takes: Motive CSV and Qualisys TSV.

use std::collections::BTreeMap;
use std::ops::Range;

/// All samples.
pub(crate) const ALL: Range<usize> = 0..usize::MAX;

/// Takes by their paths below the session.
pub(crate) type Takes = BTreeMap<String, Table>;

/// A fault: its name, options of `run`, the plant, the findings of which one is required, the exit code.
pub(crate) type Fault<'a> = (&'a str, &'a str, fn(&mut Takes), &'a [&'a str], i32);

/// The text of a take as cells.
#[derive(Clone)]
pub(crate) struct Table {
    pub(crate) separator: &'static str,
    pub(crate) head: Vec<String>,
    /// Entity and quantity of each column, such as `Hand Rotation`.
    pub(crate) columns: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(text: &str) -> Self {
        let lines: Vec<&str> = text.lines().collect();
        let is_csv = text.starts_with("Format Version");
        let (separator, first) = match is_csv {
            true => (",", 7),
            false => (
                "\t",
                1 + (lines.iter().position(|l| l.starts_with("Frame")))
                    .expect("columns have names"),
            ),
        };
        let cells = |line: &str| line.split(separator).map(str::to_owned).collect::<Vec<_>>();
        let columns = match is_csv {
            true => (cells(lines[3]).iter().zip(cells(lines[5])))
                .map(|(name, quantity)| format!("{name} {quantity}"))
                .collect(),
            false => (cells(lines[first - 1]).iter())
                .map(|name| match name.rsplit_once(' ') {
                    Some((name, _)) => format!("{name} Position"),
                    None => name.clone(),
                })
                .collect(),
        };
        Self {
            separator,
            head: lines[..first].iter().map(|&line| line.to_owned()).collect(),
            columns,
            rows: lines[first..].iter().map(|line| cells(line)).collect(),
        }
    }

    pub(crate) fn text(&self) -> String {
        let rows = self.rows.iter().map(|row| row.join(self.separator));
        let lines: Vec<_> = self.head.iter().cloned().chain(rows).collect();
        lines.join("\r\n") + "\r\n"
    }

    /// Replaces words of the header.
    pub(crate) fn state(&mut self, from: &str, to: &str) {
        let all = self.head.join("\n");
        assert!(all.contains(from), "{from}");
        self.head = all
            .replacen(from, to, 1)
            .split('\n')
            .map(str::to_owned)
            .collect();
    }

    /// Changes what ends with `quantity` ("Position" of everything, "Hand Rotation" of one), its numbers at a
    /// time; missing samples stay missing.
    pub(crate) fn change(
        &mut self,
        quantity: &str,
        samples: Range<usize>,
        mut change: impl FnMut(&mut [f64]),
    ) {
        let wanted: Vec<_> = (0..self.columns.len())
            .filter(|&column| self.columns[column].ends_with(quantity))
            .collect();
        assert!(!wanted.is_empty(), "{quantity}");
        let groups: Vec<&[usize]> = wanted
            .chunk_by(|&a, &b| self.columns[a] == self.columns[b])
            .collect();
        for row in self.rows.iter_mut().take(samples.end).skip(samples.start) {
            for group in &groups {
                let numbers: Result<Vec<f64>, _> =
                    group.iter().map(|&column| row[column].parse()).collect();
                // Missing: empty cells of Motive, zeros of Qualisys.
                let Ok(mut numbers) = numbers else { continue };
                if numbers.iter().all(|&number| number == 0.0) {
                    continue;
                }
                change(&mut numbers);
                for (&column, number) in group.iter().zip(numbers) {
                    row[column] = number.to_string();
                }
            }
        }
    }

    /// The cells of an entity's positions.
    fn cells(&self, entity: &str) -> Vec<usize> {
        let column = format!("{entity} Position");
        let found: Vec<_> = (0..self.columns.len())
            .filter(|&at| self.columns[at] == column)
            .collect();
        assert_eq!(found.len(), 3, "{column}");
        found
    }

    /// Exchanges the positions of two markers.
    pub(crate) fn exchange(&mut self, a: &str, b: &str, samples: Range<usize>) {
        let (a, b) = (self.cells(a), self.cells(b));
        for row in self.rows.iter_mut().take(samples.end).skip(samples.start) {
            for (&a, &b) in a.iter().zip(&b) {
                row.swap(a, b);
            }
        }
    }

    /// Writes a marker's positions over those of another.
    pub(crate) fn copy(&mut self, from: &str, to: &str) {
        let (from, to) = (self.cells(from), self.cells(to));
        for row in &mut self.rows {
            for (&from, &to) in from.iter().zip(&to) {
                row[to] = row[from].clone();
            }
        }
    }

    /// Keeps a marker where it is at the first of these samples.
    pub(crate) fn freeze(&mut self, marker: &str, samples: Range<usize>) {
        let cells = self.cells(marker);
        let held = self.rows[samples.start].clone();
        for row in &mut self.rows[samples] {
            for &cell in &cells {
                row[cell].clone_from(&held[cell]);
            }
        }
    }

    /// Removes the label of a marker.
    pub(crate) fn lose(&mut self, marker: &str, samples: Range<usize>) {
        let cells = self.cells(marker);
        for row in &mut self.rows[samples] {
            for &cell in &cells {
                row[cell] = if self.separator == "," { "" } else { "0" }.to_owned();
            }
        }
    }

    /// Adds uniform noise to everything's position.
    pub(crate) fn shake(&mut self, quantity: &str, size: f64) {
        let mut state = 1_u64;
        self.change(quantity, ALL, |numbers| {
            for number in numbers {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                *number += size * ((state >> 33) as f64 / f64::from(1 << 31) * 2.0 - 1.0);
            }
        });
    }

    /// Numbers the samples anew, as if recorded without interruption at 100 Hz.
    pub(crate) fn renumber(&mut self, first: usize) {
        for (n, row) in self.rows.iter_mut().enumerate() {
            row[0] = (first + n).to_string();
            row[1] = format!("{:.6}", n as f64 / 100.0);
        }
    }

    /// Removes every 20th sample.
    pub(crate) fn drop_samples(&mut self) {
        let mut n = 0;
        self.rows.retain(|_| {
            n += 1;
            n % 20 != 0
        });
    }

    /// Writes every fifth sample over the next one.
    pub(crate) fn repeat_samples(&mut self) {
        for k in (0..self.rows.len() - 1).step_by(5) {
            let [frame, time] = [0, 1].map(|cell| self.rows[k + 1][cell].clone());
            self.rows[k + 1] = self.rows[k].clone();
            self.rows[k + 1][0] = frame;
            self.rows[k + 1][1] = time;
        }
    }

    /// Adds seconds to the times of these samples.
    pub(crate) fn jump(&mut self, samples: Range<usize>, by_s: f64) {
        for row in &mut self.rows[samples] {
            row[1] = format!(
                "{:.6}",
                row[1].parse::<f64>().expect("times are numbers") + by_s
            );
        }
    }
}

/// Compares a run's exit code and its findings, on stderr and in `evaluation.json`, with those expected of a fault;
/// returns in words what is wrong.
pub(crate) fn judge(
    (name, _, _, expected, code): &Fault<'_>,
    exit: Option<i32>,
    stderr: &str,
    evaluation: Option<&serde_json::Value>,
) -> Option<String> {
    let lines = stderr.lines();
    let said: Vec<_> = match code {
        1 => lines
            .filter(|line| expected.iter().any(|id| line.starts_with(id)))
            .collect(),
        _ => (lines.filter_map(|line| line.strip_prefix("warn     ")))
            .filter(|line| expected.iter().any(|id| line.starts_with(id)))
            .collect(),
    };
    let findings = evaluation.and_then(|e| e["inspection"]["findings"].as_array());
    let stored = |id: &&&str| {
        findings.is_some_and(|all| all.iter().any(|f| f["id"] == **id && f["level"] == "warn"))
    };
    let is_stored = *code == 1 || expected.iter().any(|id| stored(&id));
    (exit != Some(*code) || said.is_empty() || !is_stored).then(|| {
        format!("{name}: exit {exit:?}, expected {code} and one of {expected:?}\n{stderr}")
    })
}
