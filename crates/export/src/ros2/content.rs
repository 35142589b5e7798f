//! Content of a bag: a take or a plan.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use inhand_model::{Configuration, Motion, PerFinger, Recording, Roles, Shape};

/// An sRGB colour, red, green, blue.
pub type Colour = [u8; 3];

/// A take or a plan.
#[derive(Clone, Copy, Debug)]
pub struct Ros2Take<'a> {
    /// Markers and bodies; those of a plan are none.
    pub recording: &'a Recording,
    /// Entities that are hand, object and fingertips, where they are known.
    pub roles: Option<&'a Roles>,
    /// The take in the hand's frame, of the clock and length of the recording.
    pub motion: Option<&'a Motion>,
    /// Shape of the object.
    pub shape: Option<Shape>,
    /// Generated motion.
    pub methods: &'a [Ros2Method<'a>],
    /// Events as JSON, by the time at which they begin, nanoseconds since 1970.
    pub events: &'a [(u64, String)],
    /// Whether markers for viewers are written.
    pub markers: bool,
    /// Colours of fingertips.
    pub finger_colours: PerFinger<Colour>,
}

/// Motion that a method generated.
#[derive(Clone, Debug)]
pub struct Ros2Method<'a> {
    /// Name of the method.
    pub name: &'a str,
    /// Fingertips in the hand's frame by sample, metres.
    pub positions_m: &'a BTreeMap<usize, Configuration>,
    /// Samples at which its plans start.
    pub starts: Vec<usize>,
    /// Colour of its fingertips.
    pub colour: Colour,
}

impl Ros2Take<'_> {
    /// Whether something was tracked; else it is a plan.
    pub(super) fn is_recorded(&self) -> bool {
        !(self.recording.markers.is_empty() && self.recording.bodies.is_empty())
    }

    /// Samples at which trajectories start that follow others without a gap. Methods without plans have the segments of
    /// those with; all segments of a plan are one trajectory.
    pub(super) fn starts(&self) -> BTreeSet<usize> {
        let methods = self.methods.iter().filter(|_| self.is_recorded());
        methods
            .flat_map(|method| method.starts.iter().copied())
            .collect()
    }
}

impl Ros2Method<'_> {
    /// The samples of the trajectory that starts at sample `k`, if one does.
    pub(super) fn trajectory_from(
        &self,
        k: usize,
        starts: &BTreeSet<usize>,
    ) -> Option<Range<usize>> {
        let has = |k: &usize| self.positions_m.contains_key(k);
        let continues = k > 0 && has(&(k - 1)) && !starts.contains(&k);
        if !has(&k) || continues {
            return None;
        }
        let end = (k + 1..).find(|next| !has(next) || starts.contains(next))?;
        Some(k..end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trajectories_end_at_gaps_and_where_the_next_one_starts() {
        let samples = [0, 1, 2, 3, 7, 8];
        let method = Ros2Method {
            name: "line",
            positions_m: &samples.map(|k| (k, [k as f64; 15])).into(),
            starts: Vec::new(),
            colour: [0; 3],
        };
        let found: Vec<_> = (0..10)
            .filter_map(|k| method.trajectory_from(k, &BTreeSet::from([2])))
            .collect();
        assert_eq!(found, [0..2, 2..4, 7..9]);
    }
}
