//! Facts about a whole take that are written before its first sample.

use inhand_model::{Finding, Recording};

use crate::view;

/// What has to be known of a whole take before its first sample can be written. It is gathered in
/// a first pass over the blocks of a take that is too long for memory.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Samples of the take.
    pub(crate) samples: usize,
    /// What was odd about its source.
    pub(crate) findings: Vec<Finding>,
    /// Whether each body is present at any sample that views show.
    pub(crate) shown_bodies: Vec<bool>,
}

impl Outline {
    /// The outline of a take in memory.
    pub fn of(recording: &Recording) -> Self {
        let mut outline = Self::default();
        outline.add(recording);
        outline.findings.clone_from(&recording.findings);
        outline
    }

    /// Adds the samples that follow those so far. Findings of a block are not looked at.
    pub fn add(&mut self, block: &Recording) {
        let stride = view::stride(block.clock.rate_hz());
        // The first sample of the block that views show.
        let first = self.samples.next_multiple_of(stride) - self.samples;
        self.shown_bodies.resize(block.bodies.len(), false);
        for (shown, body) in self.shown_bodies.iter_mut().zip(&block.bodies) {
            let mut samples = (first..block.len()).step_by(stride);
            *shown = *shown || samples.any(|row| body.track.status(row).is_present());
        }
        self.samples += block.len();
    }

    /// Says what was odd about the whole take's source.
    #[must_use]
    pub fn with_findings(mut self, findings: Vec<Finding>) -> Self {
        self.findings = findings;
        self
    }

    /// Samples so far.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// What was odd about the take's source.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }
}
