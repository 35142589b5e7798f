//! Ranges of log time.

/// A range of log time, nanoseconds since 1970-01-01 UTC: from `from` to just before `to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Interval {
    from: u64,
    /// `None` has no end.
    to: Option<u64>,
}

impl Interval {
    /// All of time.
    pub const ALL: Self = Self { from: 0, to: None };

    /// From `from_unix_nanos` to just before `to_unix_nanos`, or without an end.
    pub fn new(from_unix_nanos: u64, to_unix_nanos: Option<u64>) -> Self {
        Self {
            from: from_unix_nanos,
            to: to_unix_nanos,
        }
    }

    /// Where it starts, nanoseconds since 1970-01-01 UTC.
    pub fn from_unix_nanos(&self) -> u64 {
        self.from
    }

    /// Just after where it ends, nanoseconds since 1970-01-01 UTC; `None` where it has no end.
    pub fn to_unix_nanos(&self) -> Option<u64> {
        self.to
    }

    /// Whether an instant is in it.
    pub fn contains(&self, unix_nanos: u64) -> bool {
        self.from <= unix_nanos && self.to.is_none_or(|to| unix_nanos < to)
    }

    /// Whether any instant from `first` to `last`, both included, is in it.
    pub(crate) fn meets(&self, first: u64, last: u64) -> bool {
        self.from <= last && self.to.is_none_or(|to| first < to)
    }
}
