//! Takes with 2 % gaps and, a minute, 10 swaps, 5 flips, 20 spikes and 3 lost labels.

use inhand_cleaning::detect;
use inhand_simulation::TakeSettings;

use crate::common::{Tallies, compare, faulty, minutes, roles};

#[test]
fn show() {
    let mut sum = Tallies::default();
    let mut all = 0.0;
    for (seed, settings) in (1..7).map(|seed| {
        (seed, if seed % 2 == 0 { TakeSettings::cube("cube") } else { TakeSettings::cylinder("cylinder") })
    }) {
        let take = faulty(&settings, seed);
        let suspects = detect::all(&take.recording, &roles(true)).unwrap();
        println!("seed {seed}");
        let tallies = compare(&take, &suspects);
        all += minutes(&take.recording);
        sum.swaps.add(tallies.swaps);
        sum.flips.add(tallies.flips);
        sum.spikes.add(tallies.spikes);
        sum.unlabelled.add(tallies.unlabelled);
    }
    println!("{sum:#?} {all} min");
}
