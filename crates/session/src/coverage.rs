//! Coverage of a take's samples.

use inhand_model::{Recording, Status};

/// How much of each marker and body of a take is there; gathered block by block.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Samples of the take.
    pub samples: usize,
    /// One entry for each marker.
    pub markers: Vec<Presence>,
    /// One entry for each body.
    pub bodies: Vec<Presence>,
}

/// How much of one track is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Presence {
    /// Measured samples.
    pub measured: usize,
    /// Missing samples.
    pub missing: usize,
    /// Longest run of missing samples.
    pub longest_gap: usize,
    /// Missing samples since the last one that was there.
    running: usize,
}

impl Coverage {
    /// The coverage of a take in memory.
    pub fn of(recording: &Recording) -> Self {
        let mut coverage = Self::default();
        coverage.add(recording);
        coverage
    }

    /// Adds the samples that follow those so far.
    pub fn add(&mut self, block: &Recording) {
        self.samples += block.len();
        self.markers
            .resize(block.markers.len(), Presence::default());
        for (presence, marker) in self.markers.iter_mut().zip(&block.markers) {
            presence.add(marker.track.statuses());
        }
        self.bodies.resize(block.bodies.len(), Presence::default());
        for (presence, body) in self.bodies.iter_mut().zip(&block.bodies) {
            presence.add(body.track.statuses());
        }
    }
}

impl Presence {
    fn add(&mut self, statuses: &[Status]) {
        for status in statuses {
            self.measured += usize::from(*status == Status::Measured);
            if status.is_present() {
                self.running = 0;
            } else {
                self.missing += 1;
                self.running += 1;
                self.longest_gap = self.longest_gap.max(self.running);
            }
        }
    }
}
