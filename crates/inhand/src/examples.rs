//! Examples shown under the help of every command.

use clap::Command;

/// Two calls of each command, in the order of a first session with the tool.
const EXAMPLES: &str = r#"
inhand run session -o out
inhand run session -o out --object cube:0.05 --finger little="Marker 005"
inhand batch sessions/* -o results
inhand batch s01 s02 -o results --object cube:0.05
inhand demo
inhand demo -o /tmp/demo
inhand info out/take.mcap
inhand info bag.mcap --format json
inhand check take.csv
inhand check takes/*.csv --fail-on warn
inhand convert take.csv -o take.mcap
inhand convert a.csv b.csv -o recordings
inhand clean take.csv
inhand clean take.csv --repair --fill cubic -o clean.mcap
inhand process take.csv -o processed.mcap
inhand process take.csv -o processed.mcap --object cube:0.05
inhand annotate list take.mcap
inhand annotate import take.mcap labels.csv -o labelled.mcap
inhand learn train/*.csv -o dictionary.mcap
inhand learn train/*.csv --rank 20..240 -o dictionary.mcap
inhand generate take.csv --dictionary dictionary.mcap -o generated.mcap
inhand generate take.csv --dictionary dictionary.mcap --methods residual,hermite -o generated.mcap
inhand plan --dictionary dictionary.mcap --from take.mcap@2.0 --to take.mcap@4.5 -o plan.mcap
inhand plan --dictionary dictionary.mcap --from take.mcap@2.0 --to goal.json -o plan.mcap
inhand evaluate generated.mcap --dictionary dictionary.mcap -o evaluation.json
inhand evaluate generated.mcap --dictionary dictionary.mcap -o evaluation.json --rows rows.csv
inhand report out/evaluation.json -o report.html
inhand report merge results/*/evaluation.json -o summary.html
inhand compare before/out out
inhand compare before/out out --fail-if "p75 > 5%"
inhand export out/take.mcap -o take.csv
inhand export dictionary.mcap -o dictionary.npz
inhand view bag.mcap -o with-views.mcap
inhand view take.mcap -o with-views.mcap --object cube:0.05
inhand overlay a.mcap b.mcap -o overlay.mcap
inhand overlay out/take.mcap --methods residual,hermite -o overlay.mcap
inhand cut bag.mcap --from 12 --to 20.5 -o part.mcap
inhand cut take.mcap --event task=rotate -o parts
inhand filter bag.mcap --include-topic-regex "/recording/.*" -o recording.mcap
inhand filter bag.mcap --exclude-topic-regex "/view/.*" -o small.mcap
inhand merge take.mcap robot.mcap -o both.mcap
inhand merge a.mcap b.mcap --keep-both -o both.mcap
inhand recover broken.mcap -o saved.mcap
inhand recover broken.mcap -o saved.mcap --force
inhand verify out --inputs session
inhand verify bag.mcap --format json
inhand play out/take.mcap
inhand play out/take.mcap --speed 0.5 --start 12 --loop
inhand layout out/take.mcap -o layout.json
inhand layout out/take.mcap out/dictionary.mcap -o layout.json
inhand simulate -o session
inhand simulate -o session --takes 3 --duration 30
inhand settings > inhand.toml
inhand settings session
"#;

/// The examples of a command.
fn examples(command: &str) -> impl Iterator<Item = &'static str> {
    EXAMPLES
        .lines()
        .filter(move |line| line.split(' ').nth(1) == Some(command))
}

/// Headings of settings that `-h` leaves to `--help`.
const SETTINGS: [&str; 8] = [
    "Session",
    "Source",
    "Events",
    "Processing",
    "Learning",
    "Generation",
    "Contact",
    "Evaluation",
];

/// Options outside of these headings, wherever commands have them.
const COMMON: [&str; 8] = [
    "settings", "object", "rank", "methods", "output", "format", "force", "views",
];

/// The command line with examples under the help of each command, which has the common options, or all of them.
pub(crate) fn with_examples(cli: Command, all_options: bool) -> Command {
    cli.mut_subcommands(|command| {
        let lines: Vec<_> = examples(command.get_name()).collect();
        let command = command.after_help(format!("Examples:\n  {}", lines.join("\n  ")));
        match all_options {
            true => complete(short(command)),
            false => short(command),
        }
    })
}

/// A command whose help has everything: in the form of `-h`, which has two lines an option at most where that of clap's
/// long help has four.
fn complete(command: Command) -> Command {
    let about = command.get_long_about().or(command.get_about()).cloned();
    let command = command.about(about.unwrap_or_default());
    let command = command.mut_args(|arg| {
        let help = arg.get_long_help().or(arg.get_help());
        let help = help.map(|help| help.to_string().replace("\n\n", " "));
        arg.help(help.unwrap_or_default()).hide_short_help(false)
    });
    command.mut_subcommands(complete)
}

fn short(command: Command) -> Command {
    let command = command.mut_args(|arg| {
        // The help of --format names the values.
        let hidden = arg.is_hide_possible_values_set() || arg.get_id() == "format";
        let arg = arg.hide_possible_values(hidden);
        if COMMON.contains(&arg.get_id().as_str()) {
            return arg.help_heading(None);
        }
        let is_setting = SETTINGS.contains(&arg.get_help_heading().unwrap_or_default());
        let is_hidden = is_setting || arg.is_hide_short_help_set();
        arg.hide_short_help(is_hidden)
    });
    command.mut_subcommands(short)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::{EXAMPLES, examples, with_examples};
    use crate::Cli;

    /// Words of a shell's line: quotes keep blanks together, a redirection ends it.
    fn words(line: &str) -> Vec<String> {
        let (mut words, mut quoted) = (vec![String::new()], false);
        for letter in line.chars() {
            match letter {
                '"' => quoted = !quoted,
                '>' if !quoted => break,
                ' ' if !quoted => words.push(String::new()),
                _ => words
                    .iter_mut()
                    .last()
                    .expect("there is a word")
                    .push(letter),
            }
        }
        words.retain(|word| !word.is_empty());
        words
    }

    #[test]
    fn every_command_has_examples_that_parse() {
        let mut count = 0;
        for command in Cli::command().get_subcommands() {
            for example in examples(command.get_name()) {
                let parsed = Cli::command().try_get_matches_from(words(example));
                assert!(
                    parsed.is_ok(),
                    "{example}: {}",
                    parsed.err().map_or_else(String::new, |e| e.to_string())
                );
                count += 1;
            }
        }
        assert_eq!(count, EXAMPLES.trim().lines().count(), "no other command");
    }

    #[test]
    fn help_fits_one_screen_or_a_few() {
        for (all_options, most) in [(false, 30), (true, 150)] {
            for command in with_examples(Cli::command(), all_options).get_subcommands_mut() {
                let help = command.render_help().to_string();
                let lines = help.lines().map(|line| line.len().div_ceil(100).max(1));
                let count: usize = lines.sum();
                assert!(count <= most, "{count} lines:\n{help}");
            }
        }
    }

    #[test]
    fn help_begins_with_a_verb() {
        let nouns = ["a", "an", "the", "events", "what", "how", "one", "many"];
        for command in with_examples(Cli::command(), false).get_subcommands() {
            let about = command
                .get_about()
                .map(ToString::to_string)
                .unwrap_or_default();
            let first = about.split_whitespace().next().unwrap_or("").to_lowercase();
            assert!(
                !first.is_empty() && !nouns.contains(&first.as_str()),
                "{}: {about}",
                command.get_name()
            );
            let help = command
                .get_after_help()
                .map(ToString::to_string)
                .unwrap_or_default();
            assert_eq!(
                help.matches(&format!("inhand {}", command.get_name()))
                    .count(),
                2
            );
        }
    }
}
