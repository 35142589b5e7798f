//! Results as lines for people.

use super::checkup::{CheckResult, Checkup, Level};
use super::rank::{Checked, Tally};
use super::words::printable;

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
            let file = printable(&take.file);
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
        lines.push("look at these, worst first\n".to_owned());
        lines.push(format!("{:>7}  {:>9}  take", "score", "segments"));
    }
    for take in odd {
        ranked_lines(take, &mut lines);
    }
    if !good.is_empty() {
        let files: Vec<_> = good.iter().map(|take| printable(&take.file)).collect();
        lines.push(format!("\nnothing to look at: {}", files.join(", ")));
    }
    lines
}

/// A take among several, with the worst reasons.
fn ranked_lines(take: &Checked, lines: &mut Vec<String>) {
    let file = printable(&take.file);
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
        lines.push(format!("{:20}{more} more: inhand check {file}", ""));
    }
}

/// A message of several lines under its first.
fn indented(text: &str) -> String {
    let lines: Vec<_> = text.lines().map(printable).collect();
    lines.join("\n      ")
}
