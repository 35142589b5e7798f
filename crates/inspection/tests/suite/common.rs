//! Takes with planted faults, and how findings compare with them.

use std::ops::Range;

use inhand_inspection::{CleanSettings, Suspect, SuspectKind};
use inhand_model::{BodySource, Finger, PerFinger, Recording, Roles};
use inhand_simulation::{Fault, FaultSettings, FaultyTake, TakeSettings, simulate_faulty};

/// Simulated takes name their markers after the fingers.
pub(crate) fn roles(object: bool) -> Roles {
    Roles {
        hand: BodySource::RigidBody("Hand".into()),
        object: object.then(|| BodySource::RigidBody("Object".into())),
        fingers: PerFinger::from_fn(label),
    }
}

pub(crate) fn label(finger: Finger) -> String {
    let name = finger.name();
    name[..1].to_uppercase() + &name[1..]
}

pub(crate) fn faulty(settings: &TakeSettings, seed: u64) -> FaultyTake {
    simulate_faulty(settings, &FaultSettings::bad_session(), seed).expect("the settings are valid")
}

/// How many faults there were, how many of them were found, and what was found that is none.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) planted: usize,
    pub(crate) found: usize,
    pub(crate) false_alarms: usize,
}

impl Tally {
    pub(crate) fn share(&self) -> f64 {
        self.found as f64 / self.planted as f64
    }

    pub(crate) fn add(&mut self, other: Tally) {
        self.planted += other.planted;
        self.found += other.found;
        self.false_alarms += other.false_alarms;
    }
}

/// Tallies of each kind.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tallies {
    pub(crate) swaps: Tally,
    pub(crate) flips: Tally,
    pub(crate) spikes: Tally,
    pub(crate) unlabelled: Tally,
}

/// Something found or planted: what it is about, and when.
struct Stretch {
    about: Vec<String>,
    samples: Range<usize>,
}

/// Compares findings with the faults. A swap or flip is found where a finding about the same things
/// shares at least half of all samples of the two at which something was seen; a spike where one of
/// the same marker shares a sample; a lost label where the piece is given to the right finger. Each
/// finding counts for one fault, and every other one is a false alarm.
pub(crate) fn compare(take: &FaultyTake, suspects: &[Suspect]) -> Tallies {
    let planted = |name: &str| -> Vec<Stretch> {
        let of_kind = |fault: &&Fault| fault.kind.name() == name;
        (take.faults.iter().filter(of_kind))
            .map(|fault| Stretch {
                about: fault.entities.clone(),
                samples: fault.samples.clone(),
            })
            .collect()
    };
    let recording = &take.recording;
    let tip_seen = |name: &String, k: usize| {
        recording
            .marker(name)
            .is_some_and(|marker| marker.track.get(k).is_some())
    };
    let body_seen = |name: &String, k: usize| {
        recording
            .body(name)
            .is_some_and(|body| body.track.get(k).is_some())
    };
    let found = |id: &str| -> Vec<Stretch> {
        let of_kind = suspects.iter().filter(|suspect| suspect.kind.id() == id);
        of_kind
            .map(|suspect| Stretch {
                about: match &suspect.kind {
                    SuspectKind::Swap { fingers } => fingers.iter().map(|&f| label(f)).collect(),
                    SuspectKind::Flip { name, .. } | SuspectKind::Spike { name, .. } => {
                        vec![name.clone()]
                    }
                    SuspectKind::Unlabelled { finger, name, .. } => {
                        vec![label(*finger), name.clone()]
                    }
                },
                samples: suspect.samples.clone(),
            })
            .collect()
    };
    let any = |_: &String, _: usize| true;
    Tallies {
        swaps: tally(&planted("swap"), &found("swaps"), 0.5, tip_seen),
        flips: tally(&planted("flip"), &found("flips"), 0.5, body_seen),
        spikes: tally(&planted("spike"), &found("spikes"), 0.0, any),
        unlabelled: tally(
            &planted("unlabelled"),
            &found("unlabelled-stretches"),
            0.0,
            any,
        ),
    }
}

fn tally(
    planted: &[Stretch],
    found: &[Stretch],
    least_share: f64,
    seen: impl Fn(&String, usize) -> bool,
) -> Tally {
    let mut used = vec![false; found.len()];
    let mut tally = Tally {
        planted: planted.len(),
        ..Tally::default()
    };
    for fault in planted {
        let hit = (found.iter().enumerate()).position(|(i, finding)| {
            if used[i] || finding.about != fault.about {
                return false;
            }
            let count = |samples: Range<usize>, in_other: &Range<usize>, want: bool| {
                samples
                    .filter(|k| want == in_other.contains(k))
                    .filter(|&k| fault.about.iter().any(|name| seen(name, k)))
                    .count()
            };
            let shared = count(fault.samples.clone(), &finding.samples, true);
            let all = shared
                + count(fault.samples.clone(), &finding.samples, false)
                + count(finding.samples.clone(), &fault.samples, false);
            shared > 0 && shared as f64 >= least_share * all as f64
        });
        if let Some(i) = hit {
            used[i] = true;
            tally.found += 1;
        }
    }
    tally.false_alarms = used.iter().filter(|used| !**used).count();
    tally
}

pub(crate) fn minutes(recording: &Recording) -> f64 {
    recording.clock.time_s(recording.len()) / 60.0
}

impl Tallies {
    pub(crate) fn add(&mut self, other: &Tallies) {
        self.swaps.add(other.swaps);
        self.flips.add(other.flips);
        self.spikes.add(other.spikes);
        self.unlabelled.add(other.unlabelled);
    }

    pub(crate) fn false_alarms(&self) -> usize {
        [self.swaps, self.flips, self.spikes, self.unlabelled]
            .iter()
            .map(|tally| tally.false_alarms)
            .sum()
    }
}

/// All repairs, no filling, no resampling.
pub(crate) fn repairs() -> CleanSettings {
    CleanSettings {
        flips: true,
        swaps: true,
        spikes: true,
        stitch: true,
        ..CleanSettings::default()
    }
}
