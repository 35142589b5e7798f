//! Results as Markdown, for a pull request or an issue.

use std::fmt::Write as _;

use super::checkup::{Checkup, Level};
use super::rank::{Checked, Tally};

/// A document: a table of takes where there are several, and for each take a table of what is not all
/// right. Names from files cannot break it or call anyone.
pub fn to_markdown(takes: &[Checked]) -> String {
    let mut out = String::new();
    write(takes, &mut out).expect("writing to a string cannot fail");
    out
}

fn write(takes: &[Checked], out: &mut String) -> std::fmt::Result {
    if takes.len() != 1 {
        let tally = Tally::of(takes);
        writeln!(out, "## {} takes: {}\n", takes.len(), tally.words())?;
        writeln!(
            out,
            "| take | level | score | usable segments | fails | warnings |"
        )?;
        writeln!(out, "| --- | --- | ---: | ---: | ---: | ---: |")?;
        for take in takes {
            summary(take, out)?;
        }
        writeln!(out)?;
    }
    for take in takes
        .iter()
        .filter(|t| takes.len() == 1 || t.level() >= Level::Warn)
    {
        details(take, out)?;
    }
    Ok(())
}

fn summary(take: &Checked, out: &mut String) -> std::fmt::Result {
    let file = escaped(&take.file);
    let Ok(checkup) = &take.outcome else {
        return writeln!(out, "| {file} | cannot be read | | | | |");
    };
    let segments = checkup
        .segments
        .map_or_else(String::new, |s| format!("{} of {}", s.usable, s.possible));
    writeln!(
        out,
        "| {file} | {} | {:.0} | {segments} | {} | {} |",
        checkup.level().name(),
        checkup.score(),
        checkup.count(Level::Fail),
        checkup.count(Level::Warn),
    )
}

fn details(take: &Checked, out: &mut String) -> std::fmt::Result {
    writeln!(out, "### {}\n", escaped(&take.file))?;
    let checkup = match &take.outcome {
        Ok(checkup) => checkup,
        Err(why) => return writeln!(out, "Cannot be read: {}\n", escaped(why)),
    };
    writeln!(
        out,
        "{}, {} samples at {} Hz, {:.2} s.\n",
        escaped(&checkup.format),
        checkup.samples,
        checkup.rate_hz,
        checkup.duration_s
    )?;
    writeln!(out, "| level | check | where | found | expected | to do |")?;
    writeln!(out, "| --- | --- | --- | --- | --- | --- |")?;
    for result in checkup.results.iter().filter(|r| r.level > Level::Ok) {
        writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} |",
            result.level.name(),
            result.id,
            escaped(&result.entity),
            escaped(&result.found),
            escaped(&result.expected),
            escaped(&result.advice)
        )?;
    }
    writeln!(out)?;
    good(checkup, out)
}

fn good(checkup: &Checkup, out: &mut String) -> std::fmt::Result {
    let good: Vec<_> = (checkup.results.iter())
        .filter(|r| r.level == Level::Ok)
        .map(|r| {
            let found = escaped(&r.found);
            if r.entity.is_empty() {
                found
            } else {
                format!("{}: {found}", escaped(&r.entity))
            }
        })
        .collect();
    if good.is_empty() {
        return Ok(());
    }
    writeln!(out, "All right: {}.\n", good.join(" · "))
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
