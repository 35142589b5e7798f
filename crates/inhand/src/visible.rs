//! Text of files, shown on a terminal.

use std::borrow::Cow;

/// Text in which what would change the terminal or turn the direction of other text is written as `\u001b`, as in JSON:
/// names come from files. Lines and tabs stay.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    let acts = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\t'))
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    match text.contains(acts) {
        false => Cow::Borrowed(text),
        true => Cow::Owned(escaped(text, acts)),
    }
}

/// A name from a file that stays on its line.
pub(crate) fn one_line(name: &str) -> String {
    escaped(name, |c| matches!(c, '\n' | '\r' | '\t'))
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match is_escaped(c) {
            true => shown.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => shown.push(c),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_files_cannot_act_on_a_terminal() {
        assert_eq!(visible("a\tb\nü→"), "a\tb\nü→");
        assert_eq!(
            visible("\u{1b}[31m\r\u{7}\u{7f}\u{9b}2J\u{202e}"),
            "\\u001b[31m\\u000d\\u0007\\u007f\\u009b2J\\u202e"
        );
        assert_eq!(one_line("a\nwrote b"), "a\\u000awrote b");
        let json = visible("\"\u{202e}\"").into_owned();
        assert_eq!(
            serde_json::from_str::<String>(&json).ok().as_deref(),
            Some("\u{202e}")
        );
    }
}
