//! Progress and messages on stderr.

use std::cell::{Cell, RefCell};
use std::error::Error as StdError;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use inhand_inspection::is_cut_short;
use inhand_model::{Finding, PerFinger, Setting};
use inhand_session::SessionError;
use serde_json::{Value, json};

use crate::describe::option_of;
use crate::exit::Exit;
use crate::interrupt;
use crate::options::Format;
pub(crate) use crate::progress::as_it_is;
use crate::progress::{Task, suspended};
use crate::visible::visible;

/// Messages on stderr.
#[derive(Debug)]
pub(crate) struct Console {
    /// Whether only results and errors are wanted.
    pub(crate) quiet: bool,
    /// The last line of [`Console::say_once`].
    pub(crate) once: RefCell<String>,
    /// Whether an input was found to end before it should.
    pub(crate) lost: Cell<bool>,
}

impl Console {
    /// A line about what was done.
    pub(crate) fn say(&self, line: &str) {
        if !self.quiet {
            to_stderr(line);
        }
    }

    /// A line that is not repeated.
    pub(crate) fn say_once(&self, line: &str) {
        if self.once.replace(line.to_owned()) != line {
            self.say(line);
        }
    }

    /// Names a file that was written.
    pub(crate) fn wrote(&self, file: &Path) {
        interrupt::wrote();
        self.say(&format!("wrote {}", file.display()));
    }

    /// Names a file that was written, with what is in it.
    pub(crate) fn wrote_with(&self, file: &Path, content: &str) {
        interrupt::wrote();
        self.say(&format!("wrote {} ({content})", file.display()));
    }

    /// A finding about a file that is used all the same.
    pub(crate) fn finding(&self, file: &str, finding: &Finding) {
        self.lost.set(self.lost.get() || is_cut_short(finding));
        self.say(&format!("{:<8} {file}: {finding}", finding.severity.name()));
    }

    /// The one place that prints errors: the whole chain, first the outermost.
    #[expect(
        clippy::unused_self,
        reason = "errors are shown even when the console is quiet"
    )]
    pub(crate) fn error(&self, error: &anyhow::Error) {
        let mut causes = messages(error);
        let mut lines = format!("error: {}", causes.next().unwrap_or_default());
        for cause in causes {
            // A cause may span lines, such as a list of what a take contains.
            lines.push_str(&format!("\n  {}", cause.replace('\n', "\n  ")));
        }
        as_it_is(&lines);
    }

    /// Shows work of a number of units until it is dropped, on a terminal, once it has taken two seconds.
    pub(crate) fn task(&self, name: impl Display, total: f64) -> Task {
        Task::begin(name, total, self.is_shown())
    }

    /// Shows work that is done in one go.
    pub(crate) fn step(&self, name: impl Display) -> Task {
        self.task(name, 1.0)
    }

    /// Prints how long a step took.
    pub(crate) fn step_done(&self, line: &str, elapsed: Duration) {
        self.say(&format!("{line:<78} {:>5.2} s", elapsed.as_secs_f64()));
    }

    fn is_shown(&self) -> bool {
        !self.quiet && io::stderr().is_terminal()
    }

    /// A progress line of this form on a terminal; hidden elsewhere.
    pub(crate) fn bar(&self, template: &str) -> ProgressBar {
        let bar = match self.is_shown() {
            true => ProgressBar::no_length(),
            false => ProgressBar::hidden(),
        };
        let style = ProgressStyle::with_template(template);
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar
    }
}

/// Prints data; the only use of stdout.
pub(crate) fn data(text: &str) -> io::Result<()> {
    suspended(|| {
        let mut out = io::stdout().lock();
        out.write_all(visible(text).as_bytes())?;
        out.flush()
    })
}

/// Sentences broken at the width of the terminal that stdout is, if it is one. Columns stay as they are.
pub(crate) fn wrapped(text: &str) -> String {
    match terminal_width() {
        Some(width) => broken(text, width),
        None => text.to_owned(),
    }
}

fn broken(text: &str, width: usize) -> String {
    let mut lines = String::new();
    for line in text.lines() {
        let is_prose = !line.contains("  ");
        let mut length = 0;
        for (n, word) in line.split(' ').enumerate() {
            let more = word.chars().count() + usize::from(n > 0);
            let fits = length + more <= width || length == 0;
            match n {
                0 => {}
                _ if fits || !is_prose => lines.push(' '),
                _ => {
                    lines.push_str("\n  ");
                    length = 1;
                }
            }
            lines.push_str(word);
            length += more;
        }
        lines.push('\n');
    }
    lines
}

#[cfg(unix)]
fn terminal_width() -> Option<usize> {
    let size = rustix::termios::tcgetwinsize(io::stdout()).ok()?;
    (size.ws_col > 0).then(|| usize::from(size.ws_col))
}

#[cfg(not(unix))]
fn terminal_width() -> Option<usize> {
    None
}

/// Prints an outcome as text or as JSON.
pub(crate) fn print(
    format: Format,
    text: impl FnOnce() -> String,
    json: impl FnOnce() -> Value,
) -> io::Result<()> {
    data(&match format {
        Format::Text => text(),
        Format::Json => format!("{:#}\n", json()),
    })
}

/// An error as JSON: message and causes, the outermost first, exit code, and the findings that a session was refused
/// for.
pub(crate) fn error_json(error: &anyhow::Error, exit: Exit) -> Value {
    let mut causes = messages(error);
    let message = causes.next();
    let findings = error.chain().find_map(|cause| match cause.downcast_ref() {
        Some(SessionError::Refused { findings, .. }) => Some(&findings[..]),
        _ => None,
    });
    json!({ "error": {
        "message": message,
        "causes": causes.collect::<Vec<_>>(),
        "exit_code": exit as u8,
        "findings": findings.unwrap_or_default(),
    } })
}

/// The messages of an error and its causes, the outermost first, as they are shown.
pub(crate) fn messages(error: &anyhow::Error) -> impl Iterator<Item = String> {
    let typed: Vec<_> = std::env::args_os()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    error.chain().map(move |cause| message(cause, &typed))
}

/// A message with the flags of this program; a setting that cannot be used has the name by which it was typed.
fn message(cause: &(dyn StdError + 'static), typed: &[String]) -> String {
    let is_typed = |flag: &&str| {
        let is_flag = |word: &String| word.split('=').next() == Some(*flag);
        typed.iter().any(is_flag)
    };
    match cause.downcast_ref() {
        Some(SessionError::Settings {
            key,
            expected,
            found,
        }) => {
            // A topic is an entry of its table.
            let option = option_of(key.split(".\"").next().unwrap_or(key));
            let flag = option.and_then(|option| option.split(' ').next_back());
            match flag.filter(is_typed) {
                Some(flag) => format!("{flag} ({key}): expected {expected}, found {found}"),
                None => cause.to_string(),
            }
        }
        // Words of a file stay the words of the file.
        Some(SessionError::Usage { .. }) => cause.to_string(),
        _ => with_flags(&cause.to_string()),
    }
}

/// A JSON object with a value for each finger.
pub(crate) fn by_finger<T>(values: &PerFinger<T>, json: impl Fn(&T) -> Value) -> Value {
    let values = values.iter();
    Value::Object(
        values
            .map(|(finger, value)| (finger.name().to_owned(), json(value)))
            .collect(),
    )
}

/// A message of a library with the flags of this program for the settings that it names.
pub(crate) fn with_flags(message: &str) -> String {
    (Setting::ALL.into_iter()).fold(message.to_owned(), |text, setting| {
        match option_of(setting.name()) {
            Some(option) => text.replace(&setting.to_string(), option),
            None => text,
        }
    })
}

fn to_stderr(line: &str) {
    as_it_is(&with_flags(line));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_option_of_every_setting() {
        for setting in Setting::ALL {
            let shown = with_flags(&format!("say it with {setting} X"));
            assert!(shown.starts_with("say it with --"), "{shown}");
        }
    }

    #[test]
    fn sentences_are_broken_and_columns_are_not() {
        let text = "name   1.0   2.0   3.0   4.0\none two three four five\nunbreakable, both\n";
        let expected =
            "name   1.0   2.0   3.0   4.0\none two\n  three\n  four five\nunbreakable,\n  both\n";
        assert_eq!(broken(text, 11), expected);
        assert_eq!(broken(text, 40), text);
    }

    #[test]
    fn a_setting_has_the_name_by_which_it_was_typed() {
        let of = |key: &str| SessionError::Settings {
            key: key.to_owned(),
            expected: "a".to_owned(),
            found: "b".to_owned(),
        };
        for (key, typed, name) in [
            ("object.shape", "--object", "--object (object.shape)"),
            ("object.shape", "--object=c", "--object (object.shape)"),
            ("object.shape", "--object-offset", "setting object.shape"),
            ("clean.pad_mm", "--pad-mm", "--pad-mm (clean.pad_mm)"),
            ("topics.\"/a\"", "--topic", "--topic (topics.\"/a\")"),
            ("source.up", "up", "setting source.up"),
        ] {
            let typed = [typed.to_owned()];
            let shown = format!("{name}: expected a, found b");
            assert_eq!(message(&of(key), &typed), shown);
        }
    }
}
