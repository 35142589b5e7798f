//! `inhand generate --dictionary D TAKE... -o OUTPUT`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_model::PerProtocol;
use inhand_session::steps::Generator;
use inhand_session::{
    Method, MotionSource, Role, Settings, TakeContents, TakeGenerators, provenance, steps,
    write_take,
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
        let found = |protocol| {
            let motion = &motions[protocol][n];
            steps::found_segments(&[motion], (Role::Test, protocol), object, &settings)
        };
        let generators = |protocol| {
            let by = |&method| Generator::new(method, &dictionary.dictionary, protocol, &settings);
            methods.iter().map(by).collect::<Result<Vec<_>, _>>()
        };
        let generators = TakeGenerators {
            segments: PerProtocol::try_from_fn(found)?,
            generators: PerProtocol::try_from_fn(generators)?,
        };
        let hashes = [take.hash.clone(), dictionary.hash.clone()];
        let made = provenance("generate", &settings, hashes);
        let contents = TakeContents {
            take,
            motion,
            generated: Some(MotionSource::Generators(&generators)),
            hulls: Some(&dictionary.dictionary.demonstrated.hulls),
            made: &made,
            settings: &settings,
        };
        let lost = write_output(target, args.writing.force, |path| {
            write_take(path, &contents, args.writing.views)
        })?;
        let segments = generators.segments.published.origins().len();
        let of_method = |(method, lost): (&Method, &usize)| json!({ "name": method.name(), "without_trajectory": lost });
        files.push(json!({
            "input": take.path.display().to_string(),
            "output": target.display().to_string(),
            "segments": segments,
            "methods": methods.iter().zip(&lost).map(of_method).collect::<Vec<_>>(),
        }));
        let (methods, lost) = (methods.len(), lost.iter().sum::<usize>());
        let counts =
            format!("{segments} segments by {methods} methods, {lost} without a trajectory");
        console.wrote_with(target, &counts);
        failed += lost;
    }
    print(args.format, String::new, || json!({ "files": files }))?;
    Ok(Exit::done_unless(failed > 0))
}
