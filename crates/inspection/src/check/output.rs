//! Results of many takes, the worst first: as lines for people, Markdown and JSON.

use serde_json::{Value, json};

use super::checkup::{CheckResult, Checkup, Level};
use super::words::printable;

/// A file that was checked, or the reason why it could not be.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The file, as its user named it.
    pub file: String,
    /// What the take is for in its session; `None` for one that was named alone.
    pub role: Option<&'static str>,
    /// What is used of the take, from and to, seconds after its first sample; `None` where that is all of it.
    pub range_s: Option<[f64; 2]>,
    /// What was found, or why the file cannot be read.
    pub outcome: Result<Checkup, String>,
}

impl Checked {
    /// The worst level; a file that cannot be read fails.
    pub fn level(&self) -> Level {
        self.outcome.as_ref().map_or(Level::Fail, Checkup::level)
    }

    /// [`Checkup::score`], `None` for a file that cannot be read.
    pub fn score(&self) -> Option<f64> {
        self.outcome.as_ref().ok().map(Checkup::score)
    }

    /// The file with what is used of it, for people.
    fn title(&self) -> String {
        let milliseconds = |s: f64| (1e3 * s).round() / 1e3;
        match self.range_s.map(|range| range.map(milliseconds)) {
            Some([from_s, to_s]) => format!("{} ({from_s} s to {to_s} s)", self.file),
            None => self.file.clone(),
        }
    }
}

/// Files in the order in which a person should look at them: those that cannot be read, then by
/// score, the highest first; equal ones stay in order.
pub fn ranked(mut takes: Vec<Checked>) -> Vec<Checked> {
    // No score counts as more than any.
    let place = |take: &Checked| take.score().unwrap_or(f64::INFINITY);
    takes.sort_by(|a, b| place(b).total_cmp(&place(a)));
    takes
}

/// How many takes have which level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    unreadable: usize,
    fail: usize,
    warn: usize,
    ok: usize,
}

impl Tally {
    fn count(takes: &[Checked]) -> Self {
        let mut tally = Self::default();
        for take in takes {
            let counter = match (&take.outcome, take.level()) {
                (Err(_), _) => &mut tally.unreadable,
                (Ok(_), Level::Fail) => &mut tally.fail,
                (Ok(_), Level::Warn) => &mut tally.warn,
                (Ok(_), Level::Ok | Level::Info) => &mut tally.ok,
            };
            *counter += 1;
        }
        tally
    }

    /// `2 cannot be read, 3 fail, 1 with warnings, 12 OK`; `both OK` and `all OK` where nothing is odd.
    fn words(self) -> String {
        match (self.unreadable + self.fail + self.warn, self.ok) {
            (0, 2) => return "both OK".to_owned(),
            (0, 3..) => return "all OK".to_owned(),
            _ => {}
        }
        let parts = [
            (self.unreadable, "cannot be read"),
            (self.fail, if self.fail == 1 { "fails" } else { "fail" }),
            (self.warn, "with warnings"),
            (self.ok, "OK"),
        ];
        let there = parts.iter().filter(|(n, _)| *n > 0);
        there
            .map(|(n, words)| format!("{n} {words}"))
            .collect::<Vec<_>>()
            .join(", ")
    }
}

/// Reasons listed for a take among several.
const REASONS: usize = 4;

/// Room for the level before each line.
const INDENT: usize = 6;

/// Longest line of things that are all right, in characters.
const OK_LINE: usize = 96;

/// The results of one take, or the ranked list of several. Ends with a line break.
pub fn to_text(takes: &[Checked]) -> String {
    let lines = match takes {
        [take] => one(take),
        _ => many(takes),
    };
    lines.join("\n") + "\n"
}

fn one(take: &Checked) -> Vec<String> {
    let checkup = match &take.outcome {
        Ok(checkup) => checkup,
        Err(why) => {
            let file = printable(&take.title());
            return vec![format!("fail  {file}: {}", indented(why))];
        }
    };
    let mut lines = Vec::new();
    let odd: Vec<_> = listed(checkup)
        .filter(|result| result.level > Level::Ok)
        .collect();
    for (k, result) in odd.iter().enumerate() {
        lines.push(line(result));
        let said_next = (odd.get(k + 1)).is_some_and(|next| next.advice == result.advice);
        if !result.advice.is_empty() && !said_next {
            lines.push(format!("{:INDENT$}-> {}", "", printable(&result.advice)));
        }
    }
    lines.extend(good(checkup));
    lines.push(usable_segments(checkup));
    lines
}

/// Results without that of the segments, which have a line of their own.
fn listed(checkup: &Checkup) -> impl Iterator<Item = &CheckResult> + Clone {
    checkup
        .results
        .iter()
        .filter(|result| result.id != "segments")
}

/// A result in a line.
fn line(result: &CheckResult) -> String {
    let (level, found) = (result.level.name(), printable(&result.found));
    if result.entity.is_empty() {
        return format!("{level:<INDENT$}{found}");
    }
    format!("{level:<INDENT$}{}: {found}", printable(&result.entity))
}

/// What is all right, one entity after the other, in as few lines as it takes.
fn good(checkup: &Checkup) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for result in listed(checkup).filter(|result| result.level == Level::Ok) {
        let found = printable(&result.found);
        match groups
            .iter_mut()
            .find(|(entity, _)| *entity == result.entity)
        {
            Some((_, all)) => all.push(found),
            None => groups.push((&result.entity, vec![found])),
        }
    }
    let mut lines: Vec<String> = Vec::new();
    for (entity, found) in groups {
        let text = if entity.is_empty() {
            found.join(" · ")
        } else {
            format!("{}: {}", printable(entity), found.join(", "))
        };
        let long = text.chars().count() + 3;
        match lines.last_mut() {
            Some(line) if line.chars().count() + long <= INDENT + OK_LINE => {
                line.push_str(" · ");
                line.push_str(&text);
            }
            Some(_) => lines.push(format!("{:INDENT$}{text}", "")),
            None => lines.push(format!("{:<INDENT$}{text}", Level::Ok.name())),
        }
    }
    lines
}

fn usable_segments(checkup: &Checkup) -> String {
    let Some(segments) = checkup.segments else {
        return "usable segments: none, as hand and fingers are not known".to_owned();
    };
    let level = checkup
        .result("segments")
        .map_or(Level::Ok, |result| result.level);
    let mark = if level > Level::Ok {
        format!("  ({})", level.name())
    } else {
        String::new()
    };
    if segments.possible == 0 {
        let duration_s = checkup.duration_s;
        return format!("usable segments: none, {duration_s:.2} s are too short{mark}");
    }
    format!(
        "usable segments: {} of {}{mark}",
        segments.usable, segments.possible
    )
}

fn many(takes: &[Checked]) -> Vec<String> {
    let tally = Tally::count(takes);
    let mut lines = vec![format!("{} takes: {}", takes.len(), tally.words())];
    let (good, odd): (Vec<_>, Vec<_>) = takes.iter().partition(|take| take.level() <= Level::Info);
    if !odd.is_empty() {
        let title = "takes needing attention, worst first (a higher score means more problems)\n";
        lines.push(title.to_owned());
        lines.push(format!("{:>7}  {:>9}  take", "score", "segments"));
    }
    for take in &odd {
        ranked_lines(take, &mut lines);
    }
    if odd.iter().any(|take| take.outcome.is_ok()) {
        let more = "\n`inhand check TAKE` prints all findings of a take with what to do about them";
        lines.push(more.to_owned());
    }
    if !good.is_empty() {
        let files: Vec<_> = good.iter().map(|take| printable(&take.title())).collect();
        lines.push(format!("\nOK: {}", files.join(", ")));
    }
    lines
}

/// A take among several, with the worst reasons.
fn ranked_lines(take: &Checked, lines: &mut Vec<String>) {
    let file = printable(&take.title());
    let checkup = match &take.outcome {
        Ok(checkup) => checkup,
        Err(why) => {
            lines.push(format!("{:>7}  {:>9}  {file}", "-", "-"));
            lines.push(format!("{:20}fail  {}", "", indented(why)));
            return;
        }
    };
    let segments = (checkup.segments).map_or_else(
        || "-".to_owned(),
        |s| format!("{}/{}", s.usable, s.possible),
    );
    lines.push(format!("{:>7.0}  {segments:>9}  {file}", checkup.score()));
    let reasons = listed(checkup).filter(|result| result.level >= Level::Warn);
    let more = reasons.clone().count().saturating_sub(REASONS);
    lines.extend(
        reasons
            .take(REASONS)
            .map(|result| format!("{:20}{}", "", line(result))),
    );
    if more > 0 {
        let file = printable(&take.file);
        lines.push(format!("{:20}{more} more: inhand check {file}", ""));
    }
}

/// A message of several lines under its first.
fn indented(text: &str) -> String {
    let lines: Vec<_> = text.lines().map(printable).collect();
    lines.join("\n      ")
}

/// A document: a table of takes where there are several, and for each take a table of what is not all
/// right. Names from files cannot break it or call anyone.
pub fn to_markdown(takes: &[Checked]) -> String {
    let mut lines = Vec::new();
    if takes.len() != 1 {
        let words = Tally::count(takes).words();
        lines.push(format!("## {} takes: {words}\n", takes.len()));
        lines.push("| take | level | score | usable segments | fails | warnings |".to_owned());
        lines.push("| --- | --- | ---: | ---: | ---: | ---: |".to_owned());
        lines.extend(takes.iter().map(summary));
        lines.push(String::new());
    }
    let shown = |take: &&Checked| takes.len() == 1 || take.level() >= Level::Warn;
    for take in takes.iter().filter(shown) {
        details(take, &mut lines);
    }
    lines.into_iter().map(|line| line + "\n").collect()
}

fn row(cells: &[String]) -> String {
    format!("| {} |", cells.join(" | "))
}

fn summary(take: &Checked) -> String {
    let file = escaped(&take.title());
    let Ok(checkup) = &take.outcome else {
        return format!("| {file} | cannot be read | | | | |");
    };
    row(&[
        file,
        checkup.level().name().to_owned(),
        format!("{:.0}", checkup.score()),
        (checkup.segments).map_or_else(String::new, |s| format!("{} of {}", s.usable, s.possible)),
        checkup.count(Level::Fail).to_string(),
        checkup.count(Level::Warn).to_string(),
    ])
}

fn details(take: &Checked, lines: &mut Vec<String>) {
    lines.push(format!("### {}\n", escaped(&take.title())));
    let checkup = match &take.outcome {
        Ok(checkup) => checkup,
        Err(why) => return lines.push(format!("Cannot be read: {}\n", escaped(why))),
    };
    let (format, samples) = (escaped(&checkup.format), checkup.samples);
    let (rate_hz, duration_s) = (checkup.rate_hz, checkup.duration_s);
    lines.push(format!(
        "{format}, {samples} samples at {rate_hz} Hz, {duration_s:.2} s.\n"
    ));
    lines.push("| level | check | where | found | expected | to do |".to_owned());
    lines.push("| --- | --- | --- | --- | --- | --- |".to_owned());
    let (good, odd): (Vec<_>, Vec<_>) = checkup
        .results
        .iter()
        .partition(|result| result.level == Level::Ok);
    lines.extend(odd.into_iter().map(|result| {
        row(&[
            result.level.name().to_owned(),
            result.id.to_owned(),
            escaped(&result.entity),
            escaped(&result.found),
            escaped(&result.expected),
            escaped(&result.advice),
        ])
    }));
    lines.push(String::new());
    let good = good.into_iter().map(|result| {
        let colon = if result.entity.is_empty() { "" } else { ": " };
        escaped(&result.entity) + colon + &escaped(&result.found)
    });
    let good: Vec<_> = good.collect();
    if !good.is_empty() {
        lines.push(format!("All right: {}.\n", good.join(" · ")));
    }
}

/// Text that means nothing to Markdown or HTML, in a line.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '{' | '}' | '[' | ']' | '(' | ')' | '#' | '|' | '~' | '!' => {
                out.push('\\');
                out.push(c);
            }
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            // An at sign before a name would call its owner.
            '@' => out.push_str("&#64;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Version of the JSON document, raised when a key changes its meaning or goes away.
const SCHEMA_VERSION: u32 = 1;

/// The results for programs, as `schemas/check.schema.json` states: JSON with two spaces of indent and a line break at the end.
pub fn to_json(takes: &[Checked]) -> String {
    let tally = Tally::count(takes);
    let document = json!({
        "schema_version": SCHEMA_VERSION,
        "summary": {
            "takes": takes.len(),
            "unreadable": tally.unreadable,
            "fail": tally.fail,
            "warn": tally.warn,
            "ok": tally.ok,
        },
        "takes": takes.iter().map(take_json).collect::<Vec<_>>(),
    });
    format!("{document:#}\n")
}

fn take_json(take: &Checked) -> Value {
    let (checkup, error) = match &take.outcome {
        Ok(checkup) => (checkup_json(checkup), Value::Null),
        Err(why) => (Value::Null, json!(why)),
    };
    json!({
        "file": take.file,
        "role": take.role,
        "from_s": take.range_s.map(|[from_s, _]| from_s),
        "to_s": take.range_s.map(|[_, to_s]| to_s),
        "level": take.level(),
        "score": take.score(),
        "error": error,
        "checkup": checkup,
    })
}

fn checkup_json(checkup: &Checkup) -> Value {
    json!({
        "take": checkup.take,
        "format": checkup.format,
        "samples": checkup.samples,
        "rate_hz": checkup.rate_hz,
        "duration_s": checkup.duration_s,
        "segments": checkup.segments.map(|segments| json!({
            "usable": segments.usable,
            "possible": segments.possible,
            "share": segments.share(),
        })),
        // A number that does not exist is null.
        "results": checkup.results,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_break_a_table() {
        assert_eq!(
            escaped("a|b\n<img> @me [x](y) `c` #1"),
            "a\\|b &lt;img&gt; &#64;me \\[x\\]\\(y\\) \\`c\\` \\#1"
        );
    }
}
