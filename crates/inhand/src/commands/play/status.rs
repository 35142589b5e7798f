//! Status output of `play`: lines about viewers, and a progress line on a terminal.

use indicatif::ProgressBar;
use inhand_live::{Event, Mode, Progress};

use crate::console::Console;

/// Lines on stderr.
pub(super) struct Status<'a> {
    console: &'a Console,
    bar: ProgressBar,
    keys: bool,
}

impl<'a> Status<'a> {
    /// `keys`: whether keys are read, so that the line lists them.
    pub(super) fn new(console: &'a Console, keys: bool) -> Self {
        let bar = console.bar("{msg}");
        Self { console, bar, keys }
    }

    pub(super) fn tell(&mut self, event: &Event) {
        if let Event::Progress(now) = event {
            self.bar.set_message(line(now, self.keys));
        } else if let Some(line) = words(event) {
            self.bar.suspend(|| self.console.say(&line));
        }
    }
}

impl Drop for Status<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

fn words(event: &Event) -> Option<String> {
    Some(match event {
        Event::Arrived { viewer } => format!("viewer   {viewer} connected"),
        Event::Left { viewer, how } => format!("viewer   {viewer} {how}"),
        Event::Missed { viewer, messages } => {
            format!("warning  {viewer} reads too slowly: {messages} messages were left out for it")
        }
        Event::Strange { viewer } => format!(
            "warning  {viewer} connected without the Foxglove WebSocket protocol; it got instructions"
        ),
        Event::Full { viewer, viewers } => {
            format!("warning  {viewer} was refused: there are {viewers} connections already")
        }
        Event::LeftOut { topic, why } => format!("warning  {topic} is left out: {why}"),
        Event::Ended => "end      of the recording; viewers can seek back".to_owned(),
        _ => return None,
    })
}

fn line(now: &Progress, keys: bool) -> String {
    let mode = match now.mode {
        Mode::Playing => "playing",
        Mode::Paused => "paused",
        Mode::Waiting => "waiting for a viewer",
        _ => "at the end",
    };
    let help = match keys {
        true => "  [space, arrows, 0, q]",
        false => "",
    };
    let viewers = match now.viewers {
        1 => "1 viewer".to_owned(),
        viewers => format!("{viewers} viewers"),
    };
    let (at, of) = (clock(now.at_s), clock(now.duration_s));
    format!("{at} of {of}  x{}  {viewers}  {mode}{help}", now.speed)
}

/// Minutes and seconds to the tenth, cut off.
fn clock(seconds: f64) -> String {
    let tenths = (seconds * 10.0) as u64;
    format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_minutes_and_seconds() {
        assert_eq!(clock(0.0), "0:00.0");
        assert_eq!(clock(59.99), "0:59.9");
        assert_eq!(clock(600.05), "10:00.0");
        assert_eq!(clock(6001.25), "100:01.2");
    }
}
