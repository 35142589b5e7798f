//! `docs/cli.md` and `docs/settings.md` are what the program says of itself.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use clap::{Arg, Command, CommandFactory};
use inhand_session::Settings;
use serde_json::json;

use crate::Cli;
use crate::describe::{Description, commented, descriptions, header};
use crate::examples::with_examples;

/// Set this to write the pages instead of checking them.
const WRITE: &str = "INHAND_WRITE_DOCS";

fn check(name: &str, generated: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../docs")
        .join(name);
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&path, generated).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == generated,
        "docs/{name} is not what the program says; run: {WRITE}=1 cargo test -p inhand --bin inhand"
    );
}

const CLI: &str = "# Command line

Made from the program (`inhand COMMAND --help` prints the same): do not edit.

## Exit codes

The same fault has the same code in every command.

| code | meaning |
| ---: | --- |
| 0 | Done. |
| 1 | Failed: there is no result. |
| 2 | The call or a setting is wrong, or an output exists. Nothing was replaced. |
| 3 | Finished, but data was lost, a target was missed or a check did not pass. |
| 130, 143 | Ended by Ctrl-C or by SIGTERM, as a shell counts signals. |

| fault | code |
| --- | ---: |
| an input is missing | 1 |
| an input cannot be read | 1 |
| a finding of level fail is not accepted | 1 |
| a role (hand, object, finger) is not identified | 1 |
| unknown option or value | 2 |
| a settings file cannot be used | 2 |
| the output exists | 2 |
| the output is an input | 2 |
| the output has another ending | 2 |
| an event or label that a file does not have | 2 |
| a plan misses its targets | 3 |
| nothing was selected | 3 |
| data was lost | 3 |
| a check did not pass | 3 |

`check` reports an input that cannot be read as a finding of level fail (exit code 3); `batch` skips sessions that fail
and ends with 3.

## Outputs

An output appears whole or not at all, in a folder that is created where it is missing. It has the mode of the file that
it replaces, else the one that the umask leaves.

* A device, a FIFO or `/dev/stdout` is written to and never replaced. A table or a dictionary has no files beside it then.
* A symbolic link is followed, and stays. One to a file that is not there is refused.
* An output that is a file which the command reads is refused, also by a link: inputs, the settings file, events, the
  vocabulary, the dictionary, takes of a session, rows beside an evaluation.
* One process at a time writes into the folder of `run`, `batch`, `demo`, `simulate` and `learn --work`. Another is
  refused with the number and the command of the first.
* A process that is killed leaves files `.inhand-unfinished-*`. The next command that writes into the folder removes
  them; those of processes that still run are locked and stay.

## Long work

On a terminal, work of more than two seconds has a line with an estimate of the time left; with `--quiet`, in files and
in pipes it has none. Ctrl-C and SIGTERM end a command at once: unfinished files are removed, and the last line says
what is kept and how to go on. A second signal ends it without these words.

| command | kept | the same command again |
| --- | --- | --- |
| `run`, `demo` | from step `generate` on the dictionary | goes on from the dictionary |
| `batch` | finished sessions | runs the others |
| `learn --work FOLDER` | finished rounds | goes on with the next round |
| `learn stats` | what other calls wrote | does the shard again |
| `learn`, also with `--rank FROM..TO` | nothing | starts over; a range from the next rank on tries the other ranks alone |
| others | finished files | writes the same files and the others |

`play` closes its connections and ends with 0.

";

const SETTINGS: &str = "# Settings

Made from the program (`inhand settings` prints the same): do not edit.

A session has an `inhand.toml` in its folder; `--settings FILE` names another one. Options win over the file. Every key
may be left out. `inhand settings > inhand.toml` writes a file with all of them, `inhand settings SESSION` prints
those of a session. Takes are those in the folders `train/` and `test/`, or are listed:

```toml
name = \"cube\"

[fingers]
little = \"Marker 005\"

[object]
shape = \"cube:0.05\"

# One recording for both: the first 40 s are for training, the rest is for testing.
[[takes]]
path = \"take.csv\"
role = \"train\"
to_s = 40.0

[[takes]]
path = \"take.csv\"
role = \"test\"
from_s = 40.0
```
";

/// A cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;")
}

#[test]
fn page_of_settings() {
    let defaults = defaults();
    let mut page = SETTINGS.to_owned();
    for description in descriptions() {
        let key = description.key;
        let first = key == "name";
        if key.starts_with('[') || first {
            let (title, about) = match first {
                true => ("The session", "Keys before the first header.".to_owned()),
                false => (key, cell(&description.meaning)),
            };
            page += &format!("\n## {title}\n\n{about}");
            if let (Some(option), false) = (description.option, first) {
                page += &format!(" Each entry is `name = value`. Option: `{option}`.\n");
                continue;
            }
            page += "\n\n| key | default | unit | meaning | option |\n| --- | --- | --- | --- | --- |\n";
        }
        if !key.starts_with('[') {
            page += &row(&description, defaults.get(key));
        }
    }
    check("settings.md", &page);
}

fn row(description: &Description, default: Option<&String>) -> String {
    let name = description.key.rsplit('.').next().unwrap_or_default();
    let default = default.map(|value| format!("`{value}`"));
    let default = default
        .or_else(|| description.default.clone())
        .unwrap_or_else(|| "-".to_owned());
    let option = description
        .option
        .map_or_else(String::new, |option| format!("`{option}`"));
    let meaning = cell(&description.meaning);
    format!(
        "| `{name}` | {default} | {} | {meaning} | {option} |\n",
        unit(name)
    )
}

/// Unit of a key: names end in it.
fn unit(name: &str) -> &'static str {
    let units = [
        ("_m_s2", "m/s²"),
        ("_m_s", "m/s"),
        ("_mm", "mm"),
        ("_m", "m"),
        ("_hz", "Hz"),
        ("_deg", "degrees"),
        ("_s", "s"),
        ("window", "samples"),
        ("stride", "samples"),
    ];
    let found = units.into_iter().find(|(ending, _)| name.ends_with(ending));
    found.map_or("", |(_, unit)| unit)
}

/// Defaults by full key, as TOML.
fn defaults() -> BTreeMap<String, String> {
    let toml = Settings::default().to_toml().unwrap();
    let (mut section, mut defaults) = (String::new(), BTreeMap::new());
    for line in toml.lines() {
        if let Some((name, value)) = line.split_once(" = ") {
            defaults.insert(format!("{section}{name}"), value.to_owned());
        } else if line.starts_with('[') {
            section = format!("{}.", line.trim_matches(['[', ']']));
        }
    }
    defaults
}

#[test]
fn options_have_the_default_of_their_setting() {
    let defaults = defaults();
    for description in descriptions() {
        let key = description.key;
        assert!(!description.meaning.is_empty(), "{key}: no such option");
        let (Some(set), Some(said)) = (defaults.get(key), &description.default) else {
            continue;
        };
        let (set, said) = (set.trim_matches('"'), said.as_str());
        let same = match (set.parse::<f64>(), said.parse::<f64>()) {
            (Ok(set), Ok(said)) => set.to_bits() == said.to_bits(),
            _ => set == said,
        };
        assert!(same, "{key} is {set} by default, its help says {said}");
    }
}

/// Names of a table's keys: what a wrong one is answered with.
fn keys(header: &str) -> BTreeSet<String> {
    let wrong = json!({"?": 0});
    let wrong = match header {
        "" => wrong,
        "[[takes]]" => json!({ "takes": [wrong] }),
        _ => json!({ header.trim_matches(['[', ']']): wrong }),
    };
    let error = Settings::from_json(&wrong).unwrap_err();
    let names = error.split('`').skip(3).step_by(2);
    names.map(ToOwned::to_owned).collect()
}

#[test]
fn every_setting_has_a_meaning() {
    let known: BTreeSet<_> = descriptions().iter().map(|d| d.key).collect();
    assert!(
        keys("").contains("learn") && keys("[learn]").contains("rank"),
        "{:?}",
        keys("")
    );
    for name in keys("") {
        let header = if name == "takes" {
            "[[takes]]".to_owned()
        } else {
            format!("[{name}]")
        };
        let is_map = ["fingers", "topics"].contains(&name.as_str());
        if !known.contains(header.as_str()) {
            assert!(
                known.contains(name.as_str()),
                "{name} has no meaning in describe.rs"
            );
        } else if !is_map {
            for key in keys(&header) {
                let key = format!("{name}.{key}");
                let there =
                    known.contains(key.as_str()) || known.contains(format!("[{key}]").as_str());
                assert!(there, "{key} has no meaning in describe.rs");
            }
        }
    }
    for key in &known {
        let header = header(key);
        let name = key.rsplit('.').next().unwrap_or_default();
        let there = key.starts_with('[') || keys(&header).contains(name);
        assert!(there, "{key} is no setting");
    }
}

fn read(toml: &str) -> Settings {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), toml).unwrap();
    Settings::read(file.path()).unwrap()
}

#[test]
fn comments_change_no_setting() {
    let text = r#"
        participant = "a = [b] # c"
        [fingers]
        thumb = "Marker 1"
        [look]
        accept = ["units"]
        [clean.pad_mm]
        index = [0.0, 0.0, 8.0]
        [[takes]]
        path = "a.csv"
        role = "train"
        to_s = 3.0
        [[takes]]
        path = "b.csv"
        role = "test"
    "#;
    for toml in [text, "", "name = '''a\n[b]\nc = 1'''"] {
        let settings = read(toml);
        let shown = commented(&settings.to_toml().unwrap());
        assert_eq!(read(&shown), settings, "{shown}");
    }
}

#[test]
fn page_of_commands() {
    let mut cli = with_examples(Cli::command().disable_help_subcommand(true), false);
    cli.build();
    let (mut page, mut seen) = (CLI.to_owned(), BTreeMap::new());
    page += &format!(
        "## inhand\n\n{}\n\nOptions of every command:\n\n",
        long_about(&cli)
    );
    for argument in cli
        .get_arguments()
        .filter(|argument| argument.is_global_set())
    {
        page += &item(argument);
    }
    for command in cli.get_subcommands_mut() {
        describe(command, "inhand", &mut seen, &mut page);
    }
    check("cli.md", &page);
}

fn long_about(command: &Command) -> String {
    let about = command.get_long_about().or(command.get_about());
    about.map_or_else(String::new, |about| cell(about.to_string().trim()))
}

/// Options of a heading that an earlier command has are only named.
fn describe(
    command: &mut Command,
    parent: &str,
    seen: &mut BTreeMap<String, String>,
    page: &mut String,
) {
    let name = format!("{parent} {}", command.get_name());
    let usage = command.render_usage().to_string().replace("Usage: ", "");
    *page += &format!(
        "\n## {name}\n\n{}\n\n```text\n{usage}\n```\n",
        long_about(command)
    );
    let own = |argument: &&Arg| !argument.is_global_set() && argument.get_id() != "help";
    let mut headings: Vec<Option<&str>> = Vec::new();
    for argument in command.get_arguments().filter(own) {
        if !headings.contains(&argument.get_help_heading()) {
            headings.push(argument.get_help_heading());
        }
    }
    headings.sort_by_key(Option::is_some);
    for heading in headings {
        let arguments = command.get_arguments().filter(own);
        let arguments = arguments.filter(|argument| argument.get_help_heading() == heading);
        let items: String = arguments.map(item).collect();
        *page += &match (heading, seen.get(&items)) {
            (None, _) => format!("\n{items}"),
            (Some(heading), Some(first)) => format!("\n**{heading}**: as for `{first}`.\n"),
            (Some(heading), None) => format!("\n**{heading}**\n\n{items}"),
        };
        seen.entry(items).or_insert_with(|| name.clone());
    }
    if let Some(examples) = command.get_after_help() {
        let examples = examples
            .to_string()
            .replace("Examples:\n  ", "")
            .replace("\n  ", "\n");
        *page += &format!("\n```sh\n{examples}\n```\n");
    }
    for command in command.get_subcommands_mut() {
        describe(command, &name, seen, page);
    }
}

/// An argument as an item of a list.
fn item(argument: &Arg) -> String {
    let help = argument.get_long_help().or(argument.get_help());
    let help = help.map_or_else(String::new, ToString::to_string);
    let mut help = cell(&help.split_whitespace().collect::<Vec<_>>().join(" "));
    let values: Vec<_> = argument.get_possible_values();
    let values: Vec<_> = values.iter().filter(|value| !value.is_hide_set()).collect();
    if argument.get_action().takes_values() && !values.is_empty() {
        let names: Vec<_> = values.iter().map(|value| value.get_name()).collect();
        let end = if help.ends_with('.') { "" } else { "." };
        help += &format!("{end} One of {}.", names.join(", "));
    }
    let default = argument.get_default_values().first();
    if let Some(default) = default.filter(|_| argument.get_action().takes_values()) {
        help += &format!(" [default: {}]", default.to_string_lossy());
    }
    let required = argument.is_required_set() && !argument.is_positional();
    let required = if required { " (required)" } else { "" };
    let short = argument
        .get_short()
        .map_or_else(String::new, |short| format!("-{short}, "));
    format!("* `{short}{argument}`{required}: {help}\n")
}
