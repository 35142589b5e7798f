//! Facts about a whole take that are written before its first sample.

use inhand_model::{Finding, Recording};

/// Views show at most this many instants a second: more than a screen needs only costs space.
const MAX_RATE_HZ: f64 = 50.0;

/// Scenes show at most this many instants a second: a scene is ten times the size of a cloud.
const MAX_SCENE_RATE_HZ: f64 = 25.0;

/// Every how many samples views show one.
pub(crate) fn stride(rate_hz: f64) -> usize {
    // The quotient of a rate and 50 is far below the largest integer; a tiny slack keeps 100.0001
    // Hz at two.
    ((rate_hz / MAX_RATE_HZ - 1e-3).ceil() as usize).max(1)
}

/// Every how many samples scenes show one: a multiple of [`stride`], so that all views show the same
/// instants.
pub(crate) fn scene_stride(rate_hz: f64) -> usize {
    let stride = stride(rate_hz);
    let view_hz = rate_hz / stride as f64;
    stride * ((view_hz / MAX_SCENE_RATE_HZ - 1e-3).ceil() as usize).max(1)
}

/// Facts of a whole take that its first sample depends on. They are gathered in
/// a first pass over the blocks of a take that is too long for memory.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Samples of the take.
    pub(crate) samples: usize,
    /// Findings about its source.
    pub(crate) findings: Vec<Finding>,
    /// Whether each body is present at any sample that views show.
    pub(crate) shown_bodies: Vec<bool>,
}

impl Outline {
    /// The outline of a take in memory.
    pub fn new(recording: &Recording) -> Self {
        let mut outline = Self::default();
        outline.add(recording);
        outline.findings.clone_from(&recording.findings);
        outline
    }

    /// Adds the samples that follow those so far. Findings of a block are not looked at.
    pub fn add(&mut self, block: &Recording) {
        let stride = stride(block.clock.rate_hz());
        // The first sample of the block that views show.
        let first = self.samples.next_multiple_of(stride) - self.samples;
        self.shown_bodies.resize(block.bodies.len(), false);
        for (shown, body) in self.shown_bodies.iter_mut().zip(&block.bodies) {
            let mut samples = (first..block.len()).step_by(stride);
            *shown = *shown || samples.any(|row| body.track.status(row).is_present());
        }
        self.samples += block.len();
    }

    /// Adds findings about the whole take's source.
    #[must_use]
    pub fn with_findings(mut self, findings: Vec<Finding>) -> Self {
        self.findings = findings;
        self
    }

    /// Samples so far.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Findings about the take's source.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }
}
