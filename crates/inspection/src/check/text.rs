//! Results as lines for people.

use std::fmt::Write as _;

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
    let mut out = String::new();
    let written = match takes {
        [take] => one(take, &mut out),
        _ => many(takes, &mut out),
    };
    written.expect("writing to a string cannot fail");
    out
}

fn one(take: &Checked, out: &mut String) -> std::fmt::Result {
    let checkup = match &take.outcome {
        Ok(checkup) => checkup,
        Err(why) => return writeln!(out, "fail  {}: {}", printable(&take.file), indented(why)),
    };
    // The segments are said in the last line.
    let odd = (checkup.results.iter()).filter(|r| r.level > Level::Ok && r.id != "segments");
    let odd: Vec<_> = odd.collect();
    for (k, result) in odd.iter().enumerate() {
        writeln!(out, "{:<INDENT$}{}", result.level.name(), line(result))?;
        let said_next = (odd.get(k + 1)).is_some_and(|next| next.advice == result.advice);
        if !result.advice.is_empty() && !said_next {
            writeln!(out, "{:INDENT$}-> {}", "", printable(&result.advice))?;
        }
    }
    good(checkup, out)?;
    last(checkup, out)
}

/// A result in a line.
fn line(result: &CheckResult) -> String {
    let found = printable(&result.found);
    if result.entity.is_empty() {
        return found;
    }
    format!("{}: {found}", printable(&result.entity))
}

/// What is all right, one entity after the other, in as few lines as it takes.
fn good(checkup: &Checkup, out: &mut String) -> std::fmt::Result {
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for result in (checkup.results.iter()).filter(|r| r.level == Level::Ok && r.id != "segments") {
        let found = printable(&result.found);
        match groups
            .iter_mut()
            .find(|(entity, _)| *entity == result.entity)
        {
            Some((_, all)) => all.push(found),
            None => groups.push((&result.entity, vec![found])),
        }
    }
    let mut width = 0;
    for (entity, found) in groups {
        let text = if entity.is_empty() {
            found.join(" · ")
        } else {
            format!("{}: {}", printable(entity), found.join(", "))
        };
        let long = text.chars().count();
        if width == 0 {
            write!(out, "{:<INDENT$}{text}", Level::Ok.name())?;
        } else if width + long + 3 > OK_LINE {
            write!(out, "\n{:INDENT$}{text}", "")?;
            width = 0;
        } else {
            write!(out, " · {text}")?;
            width += 3;
        }
        width += long;
    }
    if width > 0 {
        writeln!(out)?;
    }
    Ok(())
}

fn last(checkup: &Checkup, out: &mut String) -> std::fmt::Result {
    let Some(segments) = checkup.segments else {
        return writeln!(
            out,
            "usable segments: none, as hand and fingers cannot be told"
        );
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
        return writeln!(
            out,
            "usable segments: none, {:.2} s are too short{mark}",
            checkup.duration_s
        );
    }
    writeln!(
        out,
        "usable segments: {} of {}{mark}",
        segments.usable, segments.possible
    )
}

fn many(takes: &[Checked], out: &mut String) -> std::fmt::Result {
    let tally = Tally::of(takes);
    writeln!(out, "{} takes: {}", takes.len(), tally.words())?;
    if tally.to_look_at() > 0 {
        writeln!(out, "look at these, worst first\n")?;
        writeln!(out, "{:>7}  {:>9}  take", "score", "segments")?;
    }
    let mut good = Vec::new();
    for take in takes {
        if take.level() <= Level::Info {
            good.push(printable(&take.file));
            continue;
        }
        listed(take, out)?;
    }
    if !good.is_empty() {
        writeln!(out, "\nnothing to look at: {}", good.join(", "))?;
    }
    Ok(())
}

fn listed(take: &Checked, out: &mut String) -> std::fmt::Result {
    let file = printable(&take.file);
    let checkup = match &take.outcome {
        Ok(checkup) => checkup,
        Err(why) => {
            writeln!(out, "{:>7}  {:>9}  {file}", "-", "-")?;
            return writeln!(out, "{:20}fail  {}", "", indented(why));
        }
    };
    let segments = checkup.segments.map_or_else(
        || "-".to_owned(),
        |s| format!("{}/{}", s.usable, s.possible),
    );
    writeln!(out, "{:>7.0}  {segments:>9}  {file}", checkup.score())?;
    // How many segments are left stands in the line above.
    let reasons = (checkup.results.iter()).filter(|r| r.level >= Level::Warn && r.id != "segments");
    let n = reasons.clone().count();
    for result in reasons.take(REASONS) {
        writeln!(
            out,
            "{:20}{:<INDENT$}{}",
            "",
            result.level.name(),
            line(result)
        )?;
    }
    if n > REASONS {
        writeln!(out, "{:20}{} more: inhand check {file}", "", n - REASONS)?;
    }
    Ok(())
}

/// A message of several lines under its first.
fn indented(text: &str) -> String {
    let lines: Vec<_> = text.lines().map(printable).collect();
    lines.join("\n      ")
}
