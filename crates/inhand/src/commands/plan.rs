//! `inhand plan --dictionary D --from STATE --to STATE -o PLAN`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_model::{ConstraintFamily, Finger, PerFinger, Plan, PlanStatus, Trajectory};
use inhand_session::tables::{TableFormat, write_plan_table};
use inhand_session::{
    MetTarget, Method, PlanRequest, Planned, StateRole, plan_motion, provenance, read_state,
    state_file, steps, write_plan,
};
use serde_json::json;

use crate::console::{Console, by_finger, print};
use crate::exit::Exit;
use crate::options::{
    EvaluateOptions, Format, OutputOptions, PlanOptions, ProcessOptions, SourceOptions, word,
};
use crate::output::{check_outputs, ending, write_output};

/// Largest distance from a target that counts as met, metres.
const MET_M: f64 = 1e-3;

/// Distance of a target outside the training hull from which a warning is printed, metres.
const OUTSIDE_M: f64 = 10e-3;

/// Plan one motion from a start to a goal, each from a JSON file or from a take at a time.
///
/// The exit code is 3 where the motion misses a target by more than 1 mm.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Dictionary that `learn` or `run` wrote.
    #[arg(short, long, value_name = "FILE")]
    dictionary: PathBuf,
    /// Start of the motion: FILE.json, or TAKE@SECONDS.
    ///
    /// The file is {"fingertips_m": {"thumb": [x, y, z], ...}, "velocity_m_s": {...}, "object": {"position_m":
    /// [...], "quaternion_xyzw": [...]}} in the frame of the hand; any part may be left out. fixtures/start.json and
    /// fixtures/goal.json are two. `inhand process TAKE -o t.mcap`, then `inhand export t.mcap --what processed -o
    /// hand.csv`, gives numbers in that frame.
    #[arg(long, value_name = "STATE")]
    from: String,
    /// End of the motion: a state as --from.
    #[arg(long, value_name = "STATE")]
    to: String,
    /// State to pass at a time since the start; repeat for more.
    ///
    /// Of a take only positions are used, of a file velocities too.
    #[arg(long, value_name = "SECONDS=STATE", allow_hyphen_values = true, value_parser = via)]
    via: Vec<(f64, String)>,
    /// Duration, seconds [default: one segment of the dictionary].
    ///
    /// Motion of another length is a chain of segments, which meets all targets exactly, as with --ends hard.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Method: residual, prior, paper, or auto (the best by a comparison stored in the dictionary).
    #[arg(long, default_value = "residual", value_parser = word::<Method>)]
    method: Method,
    /// Fingers that must reach their targets; the others follow [default: all].
    #[arg(long, value_name = "FINGER,...", value_delimiter = ',')]
    fingers: Vec<Finger>,
    /// Output file: .mcap, or a table of times, positions and velocities as .csv or .parquet.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    /// Exit with 0 although a target is missed.
    #[arg(long)]
    allow_miss: bool,
    /// Print the outcome as text, or as json with the trajectory.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    #[command(flatten, next_help_heading = "Processing")]
    process: ProcessOptions,
    #[command(flatten, next_help_heading = "Generation")]
    plan: PlanOptions,
    #[command(flatten, next_help_heading = "Contact")]
    evaluate: EvaluateOptions,
    #[command(flatten)]
    writing: OutputOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let via = args.via.iter().map(|(_, state)| state);
    let files: Vec<_> = [&args.from, &args.to]
        .into_iter()
        .chain(via)
        .map(|text| state_file(text))
        .collect();
    let settings = args.source.for_all(console, &files, &[], &|settings| {
        args.process.apply(settings);
        args.plan.apply(settings);
        args.evaluate.apply(settings);
        settings.plan.methods = vec![args.method];
    })?;
    ending(&args.output, &["mcap", "csv", "parquet"])?;
    let dictionary = inhand_session::read_dictionary(&args.dictionary)?;
    let mut methods = steps::settled_methods(&dictionary.dictionary, &settings)?;
    let method = methods.remove(0);
    let request = PlanRequest {
        method,
        start: read_state(&args.from, StateRole::Start, &settings)?,
        goal: read_state(&args.to, StateRole::Goal, &settings)?,
        via: (args.via.iter())
            .map(|(time_s, text)| Ok((*time_s, read_state(text, StateRole::Goal, &settings)?)))
            .collect::<Result<_>>()?,
        duration_s: args.duration,
        fingers: match args.fingers.is_empty() {
            true => Finger::ALL.to_vec(),
            false => args.fingers.clone(),
        },
    };
    let via = request.via.iter().map(|(_, state)| state);
    let states = [&request.start, &request.goal].into_iter().chain(via);
    let read: Vec<_> = states.clone().map(|state| &state.path).collect();
    let read = [&read[..], &[&args.dictionary]].concat();
    check_outputs([&args.output], &read)?;

    let planned = plan_motion(&dictionary.dictionary, &request, &settings)?;
    let text = || format!("{}\n", in_words(&planned));
    warn_outside(console, &planned.targets);
    if planned.trajectory.is_none() {
        print(args.format, text, || as_json(&planned))?;
        console.say("no motion, nothing written");
        return Ok(Exit::Failed);
    }
    let hashes = states.map(|state| state.source.clone());
    let made = provenance("plan", &settings, hashes.chain([dictionary.hash.clone()]));
    let mut steps = dictionary.provenance;
    steps.push(made);
    let views = args.writing.views;
    write_output(
        &args.output,
        args.writing.force,
        |path| match TableFormat::from_path(&args.output) {
            Some(form) => write_plan_table(path, &planned, form),
            None => write_plan(path, &planned, &settings, &steps, views),
        },
    )?;
    // An output that is refused leaves no outcome on stdout.
    print(args.format, text, || as_json(&planned))?;
    console.wrote(&args.output);
    Ok(Exit::done_unless(is_missed(&planned) && !args.allow_miss))
}

/// Whether the motion misses a target.
fn is_missed(planned: &Planned) -> bool {
    worst_miss(planned).is_some_and(|target| target.miss_m > MET_M)
}

fn worst_miss(planned: &Planned) -> Option<&MetTarget> {
    (planned.targets.iter()).max_by(|a, b| a.miss_m.total_cmp(&b.miss_m))
}

/// How planning ended: as the worst of the plans, or with a target missed.
fn status(planned: &Planned) -> &'static str {
    let mut worst = planned.plans.iter().map(|plan| plan.status);
    match worst.find(|status| *status != PlanStatus::Solved) {
        _ if is_missed(planned) => "missed",
        worst => worst.unwrap_or(PlanStatus::Solved).name(),
    }
}

fn warn_outside(console: &Console, targets: &[MetTarget]) {
    let outside = (targets.iter()).filter(|target| target.hull_distance_m > OUTSIDE_M);
    for target in outside {
        let outside_mm = target.hull_distance_m * 1000.0;
        let (finger, time_s) = (target.finger, target.time_s);
        console.say(&format!(
            "warning  target of {finger} at {time_s:.2} s is {outside_mm:.1} mm outside its training hull"
        ));
    }
}

fn via(text: &str) -> Result<(f64, String), &'static str> {
    let parsed = text
        .split_once('=')
        .and_then(|(time_s, state)| Some((time_s.trim().parse().ok()?, state.to_owned())));
    parsed.ok_or("expected SECONDS=STATE, such as 0.5=touch.json")
}

/// The outcome: one line, or a few where there is no motion.
fn in_words(planned: &Planned) -> String {
    let ms = planned.time.as_secs_f64() * 1000.0;
    if let Some(plan) = planned.plans.iter().find(|plan| plan.trajectory.is_none()) {
        return without_motion(planned, plan);
    }
    let plans = planned.plans.iter();
    let active: Vec<_> = (ConstraintFamily::ALL.into_iter())
        .filter(|&family| family != ConstraintFamily::Activations)
        .filter_map(|family| {
            let count: usize = plans.clone().map(|plan| plan.checks.active[family]).sum();
            (count > 0).then(|| format!("{count} {} bounds", family.name().replace('_', " ")))
        })
        .collect();
    let active = match active.is_empty() {
        true => "no bound active".to_owned(),
        false => format!("{} active", active.join(", ")),
    };
    let outside_m = plans.clone().filter_map(|plan| plan.checks.hull_distance_m);
    let hull = match outside_m.reduce(f64::max) {
        Some(outside_m) if outside_m > 0.0 => {
            let outside_mm = outside_m * 1000.0;
            format!(" · up to {outside_mm:.1} mm outside the demonstrated hull")
        }
        Some(_) => " · inside the demonstrated hull".to_owned(),
        None => String::new(),
    };
    let worst = plans.map(|plan| plan.certificate.worst());
    let segments = match planned.plans.len() {
        1 => String::new(),
        n => format!("{n} segments · "),
    };
    let whole = planned.trajectory.as_ref().map(Trajectory::layout);
    let seconds = whole.map_or(0.0, |layout| layout.duration_s());
    let met = worst_miss(planned).map_or_else(String::new, |worst| {
        let miss_mm = worst.miss_m * 1000.0;
        match is_missed(planned) {
            true => format!(
                " by {miss_mm:.1} mm ({} at {:.2} s)",
                worst.finger, worst.time_s
            ),
            false => format!(" · targets met within {miss_mm:.2} mm"),
        }
    });
    format!(
        "{seconds:.2} s · {} · {segments}{}{met} · {ms:.1} ms · {active}{hull} · certified {:.0e}",
        planned.method,
        status(planned).replace('_', " "),
        worst.fold(0.0, f64::max),
    )
}

fn without_motion(planned: &Planned, plan: &Plan) -> String {
    let place = match planned.plans.len() {
        1 => String::new(),
        n => format!(" in segment {n}"),
    };
    let mut text = match plan.status {
        PlanStatus::Infeasible => format!("no motion satisfies all constraints{place}"),
        _ => format!("the solver failed{place}"),
    };
    for relaxation in &plan.relaxations {
        let (family, by) = (relaxation.family, relaxation.by);
        let (name, unit) = (family.name().replace('_', " "), family.unit());
        let alone = ["alone", "together with the others"][usize::from(relaxation.joint)];
        text += &format!("\n  {name} would have to be relaxed by {by:.4} {unit} {alone}");
    }
    text
}

fn as_json(planned: &Planned) -> serde_json::Value {
    let plans: Vec<_> = planned.plans.iter().map(plan_json).collect();
    let tips = |values: &[f64]| {
        let tips = PerFinger::from_fn(|finger| &values[3 * finger.index()..][..3]);
        by_finger(&tips, |tip| json!(tip))
    };
    let trajectory = planned.trajectory.as_ref().map(|trajectory| {
        let configurations = trajectory.values_m().chunks_exact(3 * Finger::COUNT);
        configurations.map(tips).collect::<Vec<_>>()
    });
    let targets = planned.targets.iter().map(|target| {
        let (finger, miss_m) = (target.finger.name(), target.miss_m);
        let (time_s, outside_m) = (target.time_s, target.hull_distance_m);
        json!({ "time_s": time_s, "finger": finger, "miss_m": miss_m, "hull_distance_m": outside_m })
    });
    json!({
        "method": planned.method.name(),
        "status": status(planned),
        "rate_hz": planned.layout.rate_hz,
        "worst_miss_m": worst_miss(planned).map(|worst| worst.miss_m),
        "targets": targets.collect::<Vec<_>>(),
        "plan_ms": planned.time.as_secs_f64() * 1000.0,
        "plans": plans,
        "trajectory_m": trajectory,
    })
}

fn plan_json(plan: &Plan) -> serde_json::Value {
    let families = plan
        .checks
        .violation
        .iter()
        .filter_map(|(family, violation)| {
            let (name, unit) = (family.name(), family.unit());
            let active = plan.checks.active[family];
            let violation = (*violation)?;
            Some(json!({ "family": name, "unit": unit, "active": active, "violation": violation }))
        });
    let relaxations = plan.relaxations.iter().map(|r| {
        let (name, unit) = (r.family.name(), r.family.unit());
        json!({ "family": name, "unit": unit, "by": r.by, "joint": r.joint })
    });
    let object = plan.object.iter().map(|pose| {
        let (position_m, rotation) = (pose.origin().to_array(), pose.quaternion_xyzw());
        json!({ "position_m": position_m, "quaternion_xyzw": rotation })
    });
    json!({
        "status": plan.status.name(),
        "objective": plan.objective,
        "certificate": plan.certificate,
        "rows": plan.checks.rows,
        "constraints": families.collect::<Vec<_>>(),
        "hull_distance_m": plan.checks.hull_distance_m,
        "relaxations": relaxations.collect::<Vec<_>>(),
        "object": object.collect::<Vec<_>>(),
    })
}
