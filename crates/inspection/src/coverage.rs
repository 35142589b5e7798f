//! Coverage of a take's samples.

use std::collections::BTreeMap;

use inhand_model::{
    BodySource, FingerGaps, PerFinger, Recording, Roles, Status, TakeFacts, TakeSource,
};

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

    /// Facts of the take with this header; its segments are not counted.
    pub fn take_facts(&self, header: &Recording, roles: Option<&Roles>) -> TakeFacts {
        let samples = self.samples.max(1) as f64;
        let tracked = |body: &BodySource| {
            let BodySource::RigidBody(name) = body else {
                return None;
            };
            let place = header.bodies.iter().position(|body| body.name == *name)?;
            Some(self.bodies.get(place)?.measured as f64 / samples)
        };
        let gaps = |marker: &String| {
            let presence = self.markers.get(header.marker_index(marker)?)?;
            Some(FingerGaps {
                missing: presence.missing as f64 / samples,
                longest_s: header.clock.time_s(presence.longest_gap),
            })
        };
        let source = &header.source;
        TakeFacts {
            name: header.name.clone(),
            samples: self.samples,
            duration_s: header.clock.time_s(self.samples),
            segments: 0,
            left_out: 0,
            left_out_by: BTreeMap::new(),
            source: Some(TakeSource {
                format: source.format.clone(),
                rate_hz: header.clock.rate_hz(),
                length_unit: source.length_unit,
                up_axis: source.up_axis,
                rotation: source.rotation,
                roles: roles.cloned(),
                hand_tracked: roles.and_then(|roles| tracked(&roles.hand)),
                object_tracked: roles.and_then(|roles| tracked(roles.object.as_ref()?)),
                gaps: roles.map_or_else(PerFinger::default, |roles| {
                    PerFinger::from_fn(|finger| gaps(&roles.fingers[finger]).unwrap_or_default())
                }),
            }),
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
