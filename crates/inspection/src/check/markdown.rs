//! Results as Markdown, for a pull request or an issue.

use super::checkup::{Checkup, Level};
use super::rank::{Checked, Tally};

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
    let file = escaped(&take.file);
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
    lines.push(format!("### {}\n", escaped(&take.file)));
    let checkup = match &take.outcome {
        Ok(checkup) => checkup,
        Err(why) => return lines.push(format!("Cannot be read: {}\n", escaped(why))),
    };
    let Checkup {
        format,
        samples,
        rate_hz,
        duration_s,
        ..
    } = checkup;
    let format = escaped(format);
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
