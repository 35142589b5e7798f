//! Loads a dictionary, plans to a target, on through a chain, and anew after a push.
//!
//! ```text
//! cargo run --release -p inhand-planner --example plan -- out/dictionary.mcap
//! ```

use std::error::Error;
use std::process::ExitCode;

use inhand_model::{Finger, PerFinger, Plan, Trajectory};
use inhand_planner::{Knot, Planner, PlannerSettings, Target, Tips, plan_chain, replan, widened};

#[expect(clippy::print_stderr, reason = "an example says what went wrong")]
fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn run() -> Result<(), Box<dyn Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("which dictionary? give the path of a dictionary.mcap")?;
    let (dictionary, _) = inhand_channels::read_dictionary(&std::fs::read(&path)?, &path)?;

    // Velocity bounds are what the training takes show and a tenth more.
    let shown = &dictionary.demonstrated.velocity;
    let settings = PlannerSettings::new(widened(shown, PlannerSettings::VELOCITY_FACTOR));
    let residual = (dictionary.residual.as_ref())
        .ok_or("the dictionary has no smooth curve with a deviation: learn it anew")?;
    let planner = Planner::residual(residual, &settings)?;
    let layout = planner.layout();

    // Targets from the mean of the demonstrations: start there, and end with thumb and index 5 mm
    // farther along y. Positions are in the hand's frame, metres; the other fingers follow.
    let start: [f64; 15] = std::array::from_fn(|c| residual.ends_mean[c]);
    let mut goal = PerFinger::from_fn(|_| None);
    for finger in [Finger::Thumb, Finger::Index] {
        let [x, y, z] = [0, 1, 2].map(|axis| start[3 * finger.index() + axis]);
        goal[finger] = Some([x, y + 0.005, z]);
    }
    let target = Target::new()
        .first(start)
        .first_velocity([0.0; 15])
        .last(goal);
    let plan = planner.plan(&target)?;
    let motion = solved(&plan)?;
    println!("{:?}: {:?}", plan.status, plan.certificate);
    println!(
        "{} rows, {} activated",
        plan.checks.rows, plan.checks.rows_taken_up
    );
    for sample in [0, layout.samples / 2, layout.samples - 1] {
        let time_s = sample as f64 / layout.rate_hz;
        for finger in [Finger::Index, Finger::Middle] {
            let [x, y, z] = motion.position(sample, finger).to_array().map(|v| v * 1e3);
            println!("{time_s:.2} s  {finger:<6}  {x:7.2} {y:7.2} {z:7.2} mm");
        }
    }

    // There and back again: two segments with one position and velocity where they meet.
    let knot = |time_s: f64, tips: Tips| Knot {
        time_s,
        tips,
        velocity: Tips::default(),
    };
    let turn_s = layout.duration_s();
    let knots = [
        knot(0.0, start.into()),
        knot(turn_s, goal.into()),
        knot(2.0 * turn_s, start.into()),
    ];
    let chain = plan_chain(&planner, &knots)?;
    match &chain.trajectory {
        Some(whole) => println!(
            "chain: {} segments, {} samples",
            chain.plans.len(),
            whole.layout().samples
        ),
        None => println!("chain: no motion for segment {}", chain.plans.len()),
    }

    // Half-way the index is pushed by 3 mm: from there to the same goal.
    let half = layout.samples / 2;
    let [here, next] = [half, half + 1].map(|t| motion.configuration_m(t));
    let mut pushed = here;
    pushed[3 * Finger::Index.index()] += 0.003;
    let velocity: [f64; 15] = std::array::from_fn(|c| (next[c] - here[c]) * layout.rate_hz);
    let state = Knot {
        time_s: half as f64 / layout.rate_hz,
        tips: pushed.into(),
        velocity: velocity.into(),
    };
    let again = replan(&planner, &plan, &target, &state)?;
    let last = solved(&again)?.position(layout.samples - 1, Finger::Index);
    let planned = motion.position(layout.samples - 1, Finger::Index);
    let away_mm = last.distance_m(planned) * 1e3;
    println!("after a push of 3 mm the index ends {away_mm:.4} mm from where it would have");
    Ok(())
}

/// The motion of a plan, or why there is none.
fn solved(plan: &Plan) -> Result<&Trajectory, String> {
    (plan.trajectory.as_ref())
        .ok_or_else(|| format!("{:?}; what would help: {:?}", plan.status, plan.relaxations))
}
