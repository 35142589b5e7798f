//! Log channel for viewers: changes made by cleaning, and plans without a solution.

use foxglove::messages::{Log, log};
use inhand_model::{Clock, PlanStatus};

use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::take::{CleanedTake, GeneratedMethod, TakeFile};
use crate::topic;
use crate::wire::viewer_time;
use crate::write::{Instant, Stream, Streams};

/// Adds the log, if there is anything to say.
pub(crate) fn add<'a>(
    file: &TakeFile<'a>,
    measured: Clock,
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let used = file.recording.clock;
    let changes = (file.cleaned.iter()).flat_map(|cleaned| changes(cleaned, measured, used));
    let plans = file.generated.iter().flat_map(unsolved);
    let mut entries: Vec<(usize, Log)> = changes.chain(plans).collect();
    if entries.is_empty() {
        return Ok(());
    }
    // The order of those at one sample stays.
    entries.sort_by_key(|(sample, _)| *sample);
    streams.push(Box::new(Entries {
        channel: output.channel::<Log>(topic::VIEW_LOG, None)?,
        entries,
        next: 0,
    }));
    Ok(())
}

/// What cleaning changed, at the first sample of the cleaned recording that it concerns.
fn changes(
    cleaned: &CleanedTake<'_>,
    measured: Clock,
    used: Clock,
) -> impl Iterator<Item = (usize, Log)> {
    let last = cleaned.recording.len().saturating_sub(1);
    (cleaned.changes.iter()).map(move |change| {
        let time_s = change.samples.start as f64 / measured.rate_hz();
        let sample = used.nearest_sample(time_s).min(last);
        (sample, entry(log::Level::Info, "clean", change.to_string()))
    })
}

/// Plans without a motion, where it would start.
fn unsolved(method: &GeneratedMethod<'_>) -> Vec<(usize, Log)> {
    (method.unsolved.iter())
        .map(|unsolved| {
            let how = match unsolved.plan.status {
                PlanStatus::Infeasible => "no motion keeps to all constraints",
                _ => "the solver found no motion",
            };
            let message = format!("no trajectory: {how}");
            let entry = entry(log::Level::Warning, method.name, message);
            (unsolved.start_sample, entry)
        })
        .collect()
}

fn entry(level: log::Level, name: &str, message: String) -> Log {
    Log {
        level: level.into(),
        name: name.to_owned(),
        message,
        ..Log::default()
    }
}

struct Entries {
    channel: ChannelId,
    entries: Vec<(usize, Log)>,
    next: usize,
}

impl Stream for Entries {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        while let Some((sample, entry)) = self.entries.get_mut(self.next)
            && *sample == k
        {
            self.next += 1;
            entry.timestamp = Some(viewer_time(unix_nanos));
            output.message(self.channel, k, unix_nanos, entry)?;
        }
        Ok(())
    }
}
