//! `inhand verify FILE...`.

use std::path::PathBuf;

use anyhow::{Error, Result};
use inhand_container::Difference;
use inhand_session::{InputFiles, Verified, verifiable, verify};
use serde_json::{Value, json};

use crate::console::{Console, error_json, print};
use crate::exit::{Exit, usage};
use crate::options::Format;
use crate::visible::one_line;

/// Compare files with their indexes, checksums, schemas, inputs and derived values
///
/// MCAP files of any origin: checksums, indexes, statistics and the summary against the data. Files of this program
/// too: every message decodes, errors and the processed motion of the first 20 s are computed again. Of
/// evaluation.json the means are computed again from the rows beside it, of run.json the hashes of all results. Inputs
/// that a file names are compared by their hash where they are beside it, in the same FOLDER or in --inputs. What a file does not have,
/// such as an index, is noted. The exit code is 3 on any difference, 1 where a file cannot be read.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// MCAP files, evaluation.json, run.json, or folders with them.
    #[arg(required = true, value_name = "FILE|FOLDER")]
    files: Vec<PathBuf>,
    /// Folder with inputs that the files were made from; with the folders in it.
    #[arg(long, value_name = "FOLDER")]
    inputs: Vec<PathBuf>,
    /// Print as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let (mut files, mut folders) = (Vec::new(), args.inputs.clone());
    for path in &args.files {
        if path.is_dir() {
            files.extend(verifiable(path)?);
            folders.push(path.clone());
        } else {
            files.push(path.clone());
        }
    }
    if files.is_empty() {
        return usage("there is no MCAP file, evaluation.json or run.json in it");
    }
    let mut inputs = InputFiles::new(&folders)?;
    let (mut texts, mut documents, mut exit) = (String::new(), Vec::new(), Exit::Done);
    let task = console.task("verifying", files.len() as f64);
    for file in &files {
        let shown = file.display().to_string();
        task.part(&shown, 1.0);
        let verified = match verify(file, &mut inputs) {
            Ok(verified) => verified,
            Err(error) if files.len() == 1 => return Err(error.into()),
            Err(error) => {
                let error = Error::new(error);
                documents.push(json!({ "file": shown, "error": error_json(&error, Exit::Failed) }));
                texts += &format!("{shown}\n  cannot be read: {error:#}\n");
                exit = Exit::Failed;
                continue;
            }
        };
        if exit == Exit::Done {
            exit = Exit::done_unless(!is_equal(&verified));
        }
        texts += &text(&shown, &verified);
        documents.push(to_json(&shown, &verified));
    }
    drop(task);
    print(args.format, || texts, || json!({ "files": documents }))?;
    Ok(exit)
}

fn is_equal(verified: &Verified) -> bool {
    let structure = verified.container.as_ref();
    verified.differences.is_empty() && structure.is_none_or(|own| own.audit.differences.is_empty())
}

fn differences(verified: &Verified) -> impl Iterator<Item = &Difference> {
    let structure = verified.container.iter();
    let structure = structure.flat_map(|own| own.audit.differences.listed());
    structure.chain(verified.differences.listed())
}

fn unlisted(verified: &Verified) -> u64 {
    let structure = verified.container.as_ref();
    let structure = structure.map_or(0, |own| own.audit.differences.unlisted());
    structure + verified.differences.unlisted()
}

fn notes(verified: &Verified) -> impl Iterator<Item = &String> {
    let structure = verified.container.iter().flat_map(|own| &own.audit.notes);
    structure.chain(&verified.notes)
}

fn text(shown: &str, verified: &Verified) -> String {
    let mut text = format!("{}\n", one_line(shown));
    let mut line = |name: &str, content: String| {
        text += &format!("  {name:<10} {}\n", one_line(&content));
    };
    if let Some(own) = &verified.container {
        let audit = &own.audit;
        line(
            "structure",
            format!(
                "{} messages in {} channels, {} chunks, {} attachments, {} metadata records",
                audit.messages, audit.channels, audit.chunks, audit.attachments, audit.metadata
            ),
        );
        if own.decoded > 0 {
            line("schemas", format!("{} messages decoded", own.decoded));
        }
        if own.errors > 0 {
            line("computed", format!("{} errors of fingertips", own.errors));
        }
    }
    for (what, number) in &verified.recomputed {
        line("computed", format!("{number} {what}"));
    }
    if verified.inputs > 0 {
        let absent = &verified.absent_inputs;
        let at_hand = verified.inputs - absent.len();
        let mut inputs = format!("{at_hand} of {} at hand", verified.inputs);
        if !absent.is_empty() {
            inputs += &format!("; not at hand: {} (--inputs)", absent.join(", "));
        }
        line("inputs", inputs);
    }
    for note in notes(verified) {
        line("note", note.clone());
    }
    for Difference {
        place,
        expected,
        found,
    } in differences(verified)
    {
        line(
            "DIFFERENT",
            format!("{place}: expected {expected}, found {found}"),
        );
    }
    if unlisted(verified) > 0 {
        line("DIFFERENT", format!("{} more places", unlisted(verified)));
    }
    if is_equal(verified) {
        line("equal", "no difference".to_owned());
    }
    text
}

fn to_json(shown: &str, verified: &Verified) -> Value {
    let differences: Vec<_> = differences(verified)
        .map(|own| json!({ "place": own.place, "expected": own.expected, "found": own.found }))
        .collect();
    let computed: Vec<_> = (verified.recomputed.iter())
        .map(|(what, number)| json!({ "what": what, "number": number }))
        .collect();
    let structure = verified.container.as_ref().map(|own| {
        let audit = &own.audit;
        json!({
            "messages": audit.messages,
            "channels": audit.channels,
            "chunks": audit.chunks,
            "attachments": audit.attachments,
            "metadata": audit.metadata,
            "decoded": own.decoded,
            "errors": own.errors,
        })
    });
    json!({
        "file": shown,
        "equal": is_equal(verified),
        "structure": structure,
        "computed": computed,
        "inputs": verified.inputs,
        "absent_inputs": verified.absent_inputs,
        "notes": notes(verified).collect::<Vec<_>>(),
        "differences": differences,
        "differences_unlisted": unlisted(verified),
    })
}
