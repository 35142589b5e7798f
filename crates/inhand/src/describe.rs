//! Meaning of every setting: the help of the option that sets it, or a text where there is none.

use std::collections::BTreeSet;

use clap::{Command, CommandFactory};

use crate::Cli;

/// Keys and headers of `inhand.toml` in its order, each with the option that sets it or its meaning. An option is
/// one of `run` unless a command is named.
const SETTINGS: [(&str, &str); 92] = [
    (
        "name",
        "Name of the session [default: the name of its folder].",
    ),
    ("participant", "--participant"),
    ("task", "--task"),
    (
        "allow_shared_takes",
        "Accept a file, or a time range of one, for both training and testing.",
    ),
    (
        "[source]",
        "Facts that source files do not state. A file that states one wins.",
    ),
    ("source.units", "--units"),
    ("source.rotation_order", "--rotation-order"),
    ("source.up", "--up"),
    (
        "source.rate_hz",
        "Rate of a third-party MCAP recording, Hz, where its time stamps do not show it.",
    ),
    ("[topics]", "--topic"),
    (
        "[roles]",
        "Bodies that are the hand and the object, where their names do not show it.",
    ),
    ("roles.hand", "--hand"),
    ("roles.object", "--object-body"),
    ("[fingers]", "--finger"),
    ("[object]", "The manipulated object."),
    ("object.shape", "--object"),
    ("object.offset_m", "--object-offset"),
    ("[look]", "Inspection before learning."),
    ("look.accept", "--accept"),
    (
        "[clean]",
        "Repairs of takes before anything else; by default none.",
    ),
    ("clean.flips", "clean --flips"),
    ("clean.swaps", "clean --swaps"),
    ("clean.spikes", "clean --spikes"),
    ("clean.stitch", "clean --stitch"),
    ("clean.fill", "clean --fill"),
    ("clean.fill_limit_s", "clean --fill-limit"),
    ("clean.resample_hz", "clean --resample"),
    ("[clean.pad_mm]", "clean --pad-mm"),
    ("[process]", "Gap filling and filter."),
    ("process.max_gap_s", "--max-gap"),
    ("process.fill", "--fill"),
    ("process.filter", "--filter"),
    ("process.window", "--window"),
    ("process.order", "--filter-order"),
    ("process.cutoff_hz", "--cutoff"),
    ("[select]", "Events whose times are used."),
    ("select.with", "--event"),
    ("select.without", "--without"),
    ("[segments]", "Segments that takes are cut into."),
    ("segments.stride", "--stride"),
    ("segments.margin_s", "--margin"),
    ("segments.ends_s", "--ends-s"),
    ("segments.missing_s", "--missing"),
    ("segments.test_share", "--test-share"),
    ("[learn]", "The dictionary."),
    ("learn.kind", "--kind"),
    ("learn.rank", "--rank"),
    ("learn.deviation_primitives", "--deviation-primitives"),
    ("learn.deviation_segments", "--deviation-segments"),
    ("learn.object", "--object-in-segments"),
    ("learn.update", "--update"),
    ("learn.start", "--start"),
    ("learn.seed", "--seed"),
    ("learn.restarts", "--restarts"),
    ("learn.precision", "--precision"),
    ("learn.activation_l1", "--activation-l1"),
    ("learn.activation_l2", "--activation-l2"),
    ("learn.primitive_l1", "--primitive-l1"),
    ("learn.primitive_l2", "--primitive-l2"),
    ("learn.max_iterations", "--max-iterations"),
    ("learn.sweeps", "--sweeps"),
    ("learn.relative_change", "--relative-change"),
    ("learn.left_out_change", "--left-out-change"),
    ("learn.stop_rms_mm", "--stop-rms-mm"),
    ("[plan]", "Generation of trajectories."),
    ("plan.methods", "--methods"),
    ("plan.ends", "--ends"),
    ("plan.sigma_mm", "--sigma-mm"),
    (
        "plan.object_sigma_mm",
        "Standard deviation of the object's position at start and goal, millimetres. \
         (sigma_mm / object_sigma_mm)² is the weight alpha of the paper.",
    ),
    (
        "plan.object_sigma_deg",
        "Standard deviation of the object's rotation at start and goal, degrees.",
    ),
    ("plan.ridge", "--ridge"),
    ("plan.velocity_factor", "--velocity-factor"),
    ("plan.velocity_m_s", "--velocity-m-s"),
    ("plan.acceleration_m_s2", "--acceleration-m-s2"),
    ("plan.reachability", "--reachability"),
    (
        "plan.reachability_margin_mm",
        "Distance outside the training hulls that reachability allows, millimetres.",
    ),
    ("plan.separation_mm", "--separation-mm"),
    ("plan.holding", "--holding"),
    ("[evaluate]", "Thresholds of the evaluation."),
    ("evaluate.tau_mm", "--tau-mm"),
    ("evaluate.collision_mm", "--collision-mm"),
    ("evaluate.min_contact_s", "--min-contact-s"),
    ("evaluate.max_lift_s", "--max-lift-s"),
    ("evaluate.grasp_fingers", "--grasp-fingers"),
    ("evaluate.draws", "--draws"),
    ("evaluate.confidence", "--confidence"),
    ("[evaluate.pad_offset_mm]", "--pad-offset-mm"),
    (
        "[[takes]]",
        "A take, or a time range of one; without any, all takes in train/ and test/ are used.",
    ),
    (
        "takes.path",
        "File, or folder of a ROS 2 bag, relative to the folder of the inhand.toml; required.",
    ),
    (
        "takes.role",
        "train (the dictionary is learned from it) or test (methods are evaluated on it); without it the range is \
         split at segments.test_share.",
    ),
    (
        "takes.from_s",
        "Start of the range, seconds after the first sample of the take [default: its start].",
    ),
    (
        "takes.to_s",
        "End of the range, seconds after the first sample of the take [default: its end].",
    ),
];

/// A key, or a header in brackets, with its meaning.
pub(crate) struct Description {
    /// Full key such as `process.window`, or a header such as `[process]`.
    pub(crate) key: &'static str,
    /// Meaning, with its unit.
    pub(crate) meaning: String,
    /// Default as the help words it.
    pub(crate) default: Option<String>,
    /// Option that sets it, with its command where that is not `run`.
    pub(crate) option: Option<&'static str>,
}

/// Option that sets a key, or the map of that name.
pub(crate) fn option_of(key: &str) -> Option<&'static str> {
    let is_meant = |known: &str| known.trim_matches(['[', ']']) == key;
    let found = SETTINGS.iter().find(|(known, _)| is_meant(known));
    found
        .map(|&(_, about)| about)
        .filter(|about| is_option(about))
}

/// An option is a word or two, a meaning is a sentence.
fn is_option(about: &str) -> bool {
    about.contains("--")
}

/// Header that a key is under; empty for keys of the whole session.
pub(crate) fn header(key: &str) -> String {
    match key.split_once('.') {
        _ if key.starts_with('[') => key.to_owned(),
        Some(("takes", _)) => "[[takes]]".to_owned(),
        Some((section, _)) => format!("[{section}]"),
        None => String::new(),
    }
}

/// Every setting in the order of the file.
pub(crate) fn descriptions() -> Vec<Description> {
    let cli = Cli::command();
    let describe = |(key, about): (&'static str, &'static str)| {
        let option = is_option(about).then_some(about);
        let help = option.map_or_else(|| about.to_owned(), |option| help(&cli, option));
        let (meaning, default) = match help.split_once(" [default: ") {
            Some((meaning, rest)) => (meaning, Some(rest.trim_end_matches(['.', ']']).to_owned())),
            None => (help.as_str(), None),
        };
        let meaning = format!("{}.", meaning.trim_end_matches('.'));
        Description {
            key,
            meaning,
            default,
            option,
        }
    };
    SETTINGS.into_iter().map(describe).collect()
}

/// First line of an option's help.
fn help(cli: &Command, option: &str) -> String {
    let (command, flag) = option.split_once("--").unwrap_or_default();
    let command = if command.is_empty() {
        "run"
    } else {
        command.trim()
    };
    let command = cli.find_subcommand(command);
    let mut arguments = command.into_iter().flat_map(Command::get_arguments);
    let found = arguments.find(|argument| argument.get_long() == Some(flag));
    found
        .and_then(|argument| argument.get_help())
        .map_or_else(String::new, ToString::to_string)
}

/// Column of comments.
const COMMENTS: usize = 32;

/// A settings file with the meaning of each key behind it, and with the keys that are not set as comments.
pub(crate) fn commented(toml: &str) -> String {
    // A text over several lines leaves no room for comments.
    if toml.contains("'''") || toml.contains("\"\"\"") {
        return toml.to_owned();
    }
    let descriptions = descriptions();
    let comment = |line: &str, key: &str| match descriptions.iter().find(|d| d.key == key) {
        Some(description) => format!("{line:<COMMENTS$} # {}\n", remark(description)),
        None => format!("{line}\n"),
    };
    let (mut text, mut set, mut under) = (String::new(), BTreeSet::new(), String::new());
    let unset = |under: &str, set: &mut BTreeSet<String>| -> String {
        let missing = descriptions.iter().filter(|d| header(d.key) == under);
        let missing = missing.filter(|d| set.insert(d.key.to_owned()));
        missing
            .map(|d| {
                let name = match d.key.strip_prefix('[') {
                    Some(_) => d.key.to_owned(),
                    None => format!("{} =", d.key.rsplit('.').next().unwrap_or(d.key)),
                };
                comment(&format!("# {name}"), d.key)
            })
            .collect()
    };
    for line in toml.lines() {
        if line.starts_with('[') {
            text += &unset(&under, &mut set);
            under = line.to_owned();
            text += &format!("\n{}", comment(line, line));
            set.insert(line.to_owned());
        } else if let Some((name, _)) = line.split_once(" = ") {
            let section = under.trim_matches(['[', ']']);
            let key = [section, name].into_iter().filter(|part| !part.is_empty());
            let key = key.collect::<Vec<_>>().join(".");
            text += &comment(line, &key);
            set.insert(key);
        }
    }
    text += &unset(&under, &mut set);
    for absent in descriptions.iter().filter(|d| d.key.starts_with('[')) {
        let lines = unset(absent.key, &mut set);
        if !lines.is_empty() {
            text += &format!("\n{lines}");
        }
    }
    text
}

/// What a comment says.
fn remark(description: &Description) -> String {
    let default = description
        .default
        .iter()
        .map(|d| format!(" Default: {d}."));
    let option = description.option.iter().map(|o| format!(" ({o})"));
    let rest: String = default.chain(option).collect();
    format!("{}{rest}", description.meaning)
}
