//! A session as a library user runs it.

use inhand_model::Shape;
use inhand_session::{OutputScope, RunOptions, Settings, TakeFormat, run, simulate_session};
use inhand_simulation::SessionSettings;

#[test]
fn a_cylinder_session_runs_from_code() {
    let folder = tempfile::tempdir().unwrap();
    let shape: Shape = "cylinder:0.05x0.06".parse().unwrap();
    let mut simulated = SessionSettings::new(shape);
    (simulated.train_takes, simulated.take.duration_s) = (2, 15.0);
    let session = folder.path().join("session");
    let takes = simulate_session(&session, &simulated, 3, TakeFormat::Mcap, false).unwrap();
    assert_eq!(takes.len(), 3);

    let mut settings = Settings::read(&session.join(inhand_session::SETTINGS_FILE)).unwrap();
    settings.segments.stride = 10;
    (settings.learn.rank, settings.learn.max_iterations) = (Some(20), 20);
    let options = RunOptions {
        folder: session,
        settings,
        output: folder.path().join("out"),
        force: false,
        scope: OutputScope {
            views: inhand_channels::Views::None,
            ..OutputScope::default()
        },
        command: Vec::new(),
    };
    let mut steps = Vec::new();
    let result = run(&options, &mut |event| {
        if let inhand_session::Event::Finished(step, _) = event {
            steps.push(step.to_owned());
        }
    })
    .unwrap();
    assert!(steps.iter().any(|step| step == "learn"), "{steps:?}");
    assert!(!result.up_to_date, "the first run computes everything");
    let evaluation = result.evaluation;
    assert_eq!(
        evaluation.session.object.as_deref(),
        Some("cylinder:0.05x0.06")
    );
    let of = |name: &str| {
        let method = evaluation.methods.iter().find(|m| m.name == name);
        method.unwrap_or_else(|| panic!("no method {name}")).error
    };
    // In pauses nothing beats staying put; where there is motion, whoever knows the start does.
    assert!(of("hermite").all.p95 < of("hold").all.p95);
    // One take of 15 s has 14 segments, and every plan of them is proven.
    let plan = evaluation.methods[0]
        .plan
        .as_ref()
        .expect("the first method is learned");
    assert_eq!((plan.solved, plan.infeasible, plan.failed), (14, 0, 0));
    assert!(plan.worst_kkt_residual < 1e-6);
    let contact = evaluation.methods[0]
        .contact
        .as_ref()
        .expect("shape and object are known");
    assert!(contact.recorded_three_or_more > 0.95, "{contact:?}");
    // What a looser threshold calls contact includes what a stricter one does.
    let shares: Vec<_> = contact.by_tau.iter().map(|at| at.three_or_more).collect();
    assert!(shares.is_sorted(), "{shares:?}");
}

#[test]
fn a_killed_simulation_can_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut simulated = SessionSettings::new("cube:0.05".parse().unwrap());
    (simulated.train_takes, simulated.take.duration_s) = (1, 2.0);
    let unfinished = folder.path().join("test/.inhand-unfinished-1-2-abc");
    std::fs::create_dir(unfinished.parent().unwrap()).unwrap();
    std::fs::write(&unfinished, "").unwrap();
    // No take can be written into it.
    std::fs::write(folder.path().join("train"), "").unwrap();
    let refused = simulate_session(folder.path(), &simulated, 3, TakeFormat::Mcap, false);
    assert!(refused.is_err());
    assert!(folder.path().join(inhand_session::SETTINGS_FILE).is_file());
    assert!(!unfinished.exists(), "of a process that was killed");
}
