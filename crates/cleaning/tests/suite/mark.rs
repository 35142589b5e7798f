//! Takes with 2 % gaps and, a minute, 10 swaps, 5 flips, 20 spikes and 3 lost labels.

use inhand_cleaning::*;
use inhand_model::*;
use inhand_simulation::TakeSettings;

use crate::common::{Tallies, compare, faulty, label, minutes, roles};

#[test]
fn show() {
    let mut sum = Tallies::default();
    let mut all = 0.0;
    let mut errors: Vec<Vec<f64>> = vec![vec![]; 3];
    let range: Vec<u64> = std::env::var("SEEDS").unwrap_or("1-7".into()).split('-').map(|s| s.parse().unwrap()).collect();
    for (seed, settings) in (range[0]..range[1]).map(|seed| {
        (seed, if seed % 2 == 0 { TakeSettings::cube("cube") } else { TakeSettings::cylinder("cylinder") })
    }) {
        let take = faulty(&settings, seed);
        let suspects = detect::all(&take.recording, &roles(true)).unwrap();
        println!("seed {seed}");
        let tallies = compare(&take, &suspects);
        for (about, samples) in crate::common::SHOW.with(|s| std::mem::take(&mut *s.borrow_mut())) {
            println!("  -> {about:?} {samples:?}");
            for f in crate::common::near(&take, &samples) { if f.entities.iter().any(|e| about.contains(e)) { println!("       {} {:?} {:?} {}", f.kind.name(), f.entities, f.samples, if let inhand_simulation::FaultKind::Spike{off_m,..}=f.kind {off_m*1e3} else {0.0}); } }
            if about.len() == 2 { let t = |i: usize, k: usize| { let fi = Finger::ALL.into_iter().find(|&f| label(f) == about[i]).unwrap(); take.clean.truth.fingertips[fi][k] }; println!("       apart {:.1} {:.1}", t(0, samples.start).distance_m(t(1, samples.start))*1e3, t(0, samples.end).distance_m(t(1, samples.end))*1e3); }
            for s in suspects.swaps.iter().filter(|s| s.samples.start < samples.end + 10 && samples.start < s.samples.end+10) { println!("       found {s} {:?} {}", s.samples, s.score); }
        }
        all += minutes(&take.recording);
        sum.swaps.add(tallies.swaps);
        sum.flips.add(tallies.flips);
        sum.spikes.add(tallies.spikes);
        sum.unlabelled.add(tallies.unlabelled);
        for (i, method) in [FillMethod::Linear, FillMethod::Cubic, FillMethod::Neighbours].into_iter().enumerate() {
            let mut s = CleanSettings::repairs();
            s.fill = Some(FillSettings { method, limit_s: 0.1 });
            let c = clean(&take.recording, &roles(true), &s).unwrap();
            for f in Finger::ALL {
                let t = &c.recording.marker(&label(f)).unwrap().track;
                for k in 0..t.len() {
                    if t.status(k) == Status::Filled {
                        errors[i].push(t.get(k).unwrap().distance_m(take.clean.truth.fingertips[f][k]));
                    }
                }
            }
        }
    }
    println!("{sum:?} {all} min");
    for e in &mut errors {
        e.sort_by(f64::total_cmp);
        println!("n {} median {:.3} p95 {:.3} max {:.3}", e.len(), e[e.len() / 2] * 1e3, e[e.len() * 95 / 100] * 1e3, e[e.len() - 1] * 1e3);
    }
}
