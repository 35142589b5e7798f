//! `inhand generate --dictionary D TAKE... -o OUTPUT`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_model::{PerProtocol, Protocol};
use inhand_session::{
    GeneratedMotion, Role, Settings, TakeContents, provenance, steps, write_take,
};
use serde_json::json;

use crate::commands::{file_part, files_task, say_held_out, say_used, takes_and_targets};
use crate::console::{Console, print};
use crate::exit::Exit;
use crate::options::{Format, MethodOptions, OutputOptions, PlanOptions, TakeOptions};
use crate::output::write_output;

/// Generate a trajectory for each segment of takes by every method; add the generated channels.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Dictionary that `learn` or `run` wrote.
    #[arg(short, long, value_name = "FILE")]
    dictionary: PathBuf,
    /// Output file; a folder for several inputs.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    #[command(flatten)]
    takes: TakeOptions,
    #[command(flatten, next_help_heading = "Generation")]
    method: MethodOptions,
    #[command(flatten)]
    plan: PlanOptions,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    writing: OutputOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let typed = |settings: &mut Settings| {
        args.method.apply(settings);
        args.plan.apply(settings);
    };
    let settings = args.takes.for_all(console, &args.inputs, &[], &typed)?;
    let (mut takes, targets) = takes_and_targets(
        console,
        (&args.inputs, Some(&args.dictionary)),
        &args.output,
        &settings,
    )?;
    let dictionary = inhand_session::read_dictionary(&args.dictionary)?;
    let methods = steps::settled_methods(&dictionary.dictionary, &settings)?;
    say_used(console, &takes, &settings)?;
    let motions = steps::motions(&mut takes, &settings)?;
    let (mut failed, mut files) = (0, Vec::with_capacity(takes.len()));
    say_held_out(console, &dictionary.dictionary);
    let task = files_task(console, "generating", &args.inputs, 1.0);
    for (n, (take, target)) in takes.iter().zip(&targets).enumerate() {
        file_part(&task, &take.path, 1.0);
        let motion = &motions.published[n];
        let object = steps::segments_object(&dictionary.dictionary, &[motion], &settings)?;
        let segments = |protocol| {
            let motion = &motions[protocol][n];
            steps::segments(&[motion], (Role::Test, protocol), object, &settings)
        };
        let segments = PerProtocol {
            published: segments(Protocol::Published)?,
            held_out: segments(Protocol::HeldOut)?,
        };
        let generated = |protocol| {
            let segments = &segments[protocol];
            let by = |&method| steps::generate(method, &dictionary.dictionary, segments, &settings);
            methods.iter().map(by).collect::<Result<Vec<_>, _>>()
        };
        let generated = PerProtocol {
            published: generated(Protocol::Published)?,
            held_out: generated(Protocol::HeldOut)?,
        };
        let hashes = [take.hash.clone(), dictionary.hash.clone()];
        let made = provenance("generate", &settings, hashes);
        let contents = TakeContents {
            take,
            motion,
            generated: Some(GeneratedMotion {
                segments: segments.as_ref(),
                take: 0,
                generated: generated.as_ref().map(Vec::as_slice),
                rows: &[],
                written: None,
                hulls: &dictionary.dictionary.demonstrated.hulls,
            }),
            made: &made,
            settings: &settings,
        };
        write_output(target, args.writing.force, |path| {
            write_take(path, &contents, args.writing.views)
        })?;
        let trajectories = generated.published.iter().flat_map(|g| &g.trajectories);
        let lost = trajectories.filter(|t| t.is_none()).count();
        let of_method = |g: &steps::Generated| {
            let lost = g.trajectories.iter().filter(|t| t.is_none()).count();
            json!({ "name": g.method.name(), "without_trajectory": lost })
        };
        files.push(json!({
            "input": take.path.display().to_string(),
            "output": target.display().to_string(),
            "segments": segments.published.len(),
            "methods": generated.published.iter().map(of_method).collect::<Vec<_>>(),
        }));
        let (segments, methods) = (segments.published.len(), methods.len());
        let counts =
            format!("{segments} segments by {methods} methods, {lost} without a trajectory");
        console.wrote_with(target, &counts);
        failed += lost;
    }
    print(args.format, String::new, || json!({ "files": files }))?;
    Ok(Exit::done_unless(failed > 0))
}
