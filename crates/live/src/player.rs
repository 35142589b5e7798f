//! Playing: the one thread that reads the file, keeps the time and fills the outboxes.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use inhand_container::Timeline;

use crate::advertisement::Advertisement;
use crate::clients::Clients;
use crate::clock::Clock;
use crate::control::{Command, Control, Viewer, faster, slower};
use crate::error::LiveError;
use crate::event::{DisconnectReason, Event, Mode, Progress};
use crate::protocol::{PlaybackRequest, PlaybackState, Request, Status};
use crate::retained::Retained;
use crate::start::StartOnSubscribe;

/// Messages are sent at most so often, those due in between together.
const TICK: Duration = Duration::from_millis(4);

/// Interval at which viewers are sent the time where there are no messages.
const HEARTBEAT: Duration = Duration::from_millis(50);

/// Interval of [`Event::Progress`].
const PROGRESS: Duration = Duration::from_millis(200);

/// Time that viewers may take to close their connections.
pub(crate) const CLOSING: Duration = Duration::from_secs(1);

/// Messages that are sent before anyone else is listened to.
const BATCH: usize = 2000;

/// Behaviour at the end of the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Repeat {
    /// Playback pauses there, and viewers can go back.
    #[default]
    Stay,
    /// It goes on from the start.
    Always,
    /// The server ends, after all viewers have read everything.
    Finish,
}

/// Reason why playback ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// By the end of the file.
    Finished,
    /// On request.
    Stopped,
}

pub(crate) struct Player<'a, N> {
    pub(crate) timeline: Timeline<'a>,
    pub(crate) advertisement: Advertisement,
    pub(crate) span: (u64, u64),
    pub(crate) greeting: Vec<String>,
    pub(crate) clock: Clock,
    pub(crate) start: StartOnSubscribe,
    pub(crate) retained: Retained,
    pub(crate) repeat: Repeat,
    /// Whether time should pass as soon as a client is subscribed.
    pub(crate) wanted: bool,
    pub(crate) ended: bool,
    /// The time that viewers were sent last.
    pub(crate) shown: u64,
    pub(crate) clients: Clients,
    pub(crate) notify: N,
    pub(crate) times: Times,
}

/// Times of the last messages and the last report.
#[derive(Default)]
pub(crate) struct Times {
    sent: Duration,
    progress: Option<(Duration, Mode, f64)>,
}

impl<N: FnMut(Event)> Player<'_, N> {
    /// Plays until the end or until a stop is requested.
    pub(crate) fn play(&mut self, commands: &Receiver<Command>) -> Result<Ending, LiveError> {
        let begun = Instant::now();
        loop {
            let now = begun.elapsed();
            let Some(wait) = self.turn(now)? else {
                return Ok(Ending::Finished);
            };
            let mut next = match commands.recv_timeout(wait) {
                Ok(command) => Some(command),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return Ok(Ending::Stopped),
            };
            // Not for ever: messages must come in time however much is said.
            let mut room = BATCH;
            while let Some(command) = next {
                if matches!(command, Command::Control(Control::Stop)) {
                    return Ok(Ending::Stopped);
                }
                self.obey(command, begun.elapsed())?;
                room -= 1;
                next = (room > 0).then(|| commands.try_recv().ok()).flatten();
            }
        }
    }

    /// Disconnects all viewers. Waits until they have read what was sent, but not longer than
    /// `patience`, and then a moment for their answer.
    pub(crate) fn disconnect_all(&mut self, commands: &Receiver<Command>, patience: Duration) {
        self.clients.close();
        let mut until = Instant::now() + patience;
        let mut sent = false;
        while self.clients.len() > 0 {
            if !sent && self.clients.is_all_sent() {
                sent = true;
                until = until.min(Instant::now() + CLOSING);
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            match commands.recv_timeout(left.min(HEARTBEAT)) {
                Ok(Command::Gone(number, how)) => self.gone(number, how),
                // Too late: it is closed like the others.
                Ok(Command::Arrived(viewer)) => viewer.outbox.close(),
                Ok(Command::Control(Control::Stop)) => until = until.min(Instant::now() + CLOSING),
                Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    /// Does what is due; how long there is nothing else to do, or `None` at the end.
    fn turn(&mut self, now: Duration) -> Result<Option<Duration>, LiveError> {
        self.start.watch(now, self.clients.is_watching());
        let open = self.start.is_open(now);
        match (self.wanted && open, self.clock.is_playing()) {
            (true, false) => self.clock.play(now),
            (false, true) => self.clock.pause(now),
            _ => {}
        }
        let more = open && self.deliver(now)?;
        if open && !more && self.wanted && self.clock.is_at_end(now) {
            match self.repeat {
                // Clients that are behind catch up first, and are warned of what they missed.
                Repeat::Finish if self.clients.is_anyone_behind() => {}
                Repeat::Finish => return Ok(None),
                Repeat::Stay | Repeat::Always => self.end(now)?,
            }
        }
        self.help_up(now);
        self.report(now);
        if more {
            return Ok(Some(Duration::ZERO));
        }
        let mut wait = PROGRESS;
        if let Some(next) = self.start.opens_in(now) {
            wait = wait.min(next);
        }
        if self.clock.is_playing() {
            let due = match self.timeline.next_time()? {
                Some(time) => self.clock.until(now, time),
                None => self.clock.until(now, self.span.1),
            };
            wait = wait.min(due.unwrap_or(HEARTBEAT).max(TICK)).min(HEARTBEAT);
        } else if self.clients.is_anyone_behind() {
            wait = wait.min(HEARTBEAT);
        }
        Ok(Some(wait))
    }

    /// Sends what is due; whether there is more than goes at once.
    fn deliver(&mut self, now: Duration) -> Result<bool, LiveError> {
        let position = self.clock.at(now);
        let mut room = BATCH;
        let more = loop {
            let due = self.timeline.next_time()?;
            if due.is_none_or(|due| due > position) {
                break false;
            }
            if room == 0 {
                break true;
            }
            room -= 1;
            let Some(message) = self.timeline.next_message()? else {
                break false;
            };
            if message.log_time > self.shown {
                self.shown = message.log_time;
                self.clients.time(self.shown);
            }
            if let Some(number) = self.advertisement.number(message.channel) {
                (self.clients).message(number, message.log_time, message.data);
                self.retained.take(number, message.log_time, message.data);
            }
        };
        if room < BATCH {
            self.times.sent = now;
        } else if position > self.shown && now.saturating_sub(self.times.sent) >= HEARTBEAT {
            self.times.sent = now;
            self.shown = position;
            self.clients.time(position);
        }
        if self.times.sent == now {
            self.clients.wake();
        }
        Ok(more)
    }

    /// Repeats or pauses at the end of the file.
    fn end(&mut self, now: Duration) -> Result<(), LiveError> {
        // A recording of one instant would be sent again and again without a pause.
        if self.repeat == Repeat::Always && self.span.0 < self.span.1 {
            self.jump(now, self.span.0)?;
            self.announce(now, true, None);
        } else {
            self.wanted = false;
            self.ended = true;
            self.clock.pause(now);
            self.announce(now, false, None);
            (self.notify)(Event::Ended);
        }
        Ok(())
    }

    /// Viewers that read too slowly go on from here.
    fn help_up(&mut self, now: Duration) {
        if !self.clients.is_anyone_behind() {
            return;
        }
        self.clients.relieve();
        // What was said of a seek in the meantime may not have reached it, and it jumps in any case.
        let state = self.state(now, true);
        for (viewer, messages) in self.clients.caught_up(state) {
            (self.clients).catch_up(viewer.number, self.shown, &self.retained.all(), None);
            let viewer = viewer.address;
            (self.notify)(Event::Missed { viewer, messages });
        }
    }

    /// Obeys a command.
    fn obey(&mut self, command: Command, now: Duration) -> Result<(), LiveError> {
        match command {
            Command::Arrived(viewer) => self.arrived(now, viewer),
            Command::Asked(number, request) => self.answer(now, number, request)?,
            Command::Misunderstood(number, why) => self.clients.warn(number, &why),
            Command::Gone(number, how) => self.gone(number, how),
            Command::Strange(viewer) => (self.notify)(Event::Strange { viewer }),
            Command::Refused(viewer, why) => (self.notify)(Event::Refused { viewer, why }),
            Command::PutOut(viewer) => (self.notify)(Event::PutOut { viewer }),
            Command::Full(viewer, viewers) => (self.notify)(Event::Full { viewer, viewers }),
            Command::Control(control) => self.control(now, control)?,
        }
        Ok(())
    }

    fn arrived(&mut self, now: Duration, viewer: Viewer) {
        let address = viewer.address;
        let number = viewer.number;
        self.clients.arrive(viewer, &self.greeting);
        self.clients.introduce(number, self.state(now, false));
        self.clients.catch_up(number, self.shown, &[], None);
        (self.notify)(Event::Arrived { viewer: address });
    }

    fn gone(&mut self, number: u64, how: DisconnectReason) {
        if let Some(viewer) = self.clients.leave(number) {
            let viewer = viewer.address;
            (self.notify)(Event::Left { viewer, how });
        }
    }

    fn answer(&mut self, now: Duration, number: u64, request: Request) -> Result<(), LiveError> {
        match request {
            Request::Subscribe(wanted) => self.subscribe(number, &wanted),
            Request::Unsubscribe(subscriptions) => {
                self.clients.unsubscribe(number, &subscriptions);
            }
            Request::Playback(request) => self.playback(now, number, &request)?,
        }
        Ok(())
    }

    fn subscribe(&mut self, number: u64, wanted: &[(u32, u64)]) {
        let mut new = Vec::new();
        for &(subscription, channel) in wanted {
            let done = match self.advertisement.has(channel) {
                true => self.clients.subscribe(number, subscription, channel),
                false => Err(format!("there is no channel {channel}")),
            };
            match done {
                Ok(()) => new.push(subscription),
                Err(why) => self.clients.warn(number, &why),
            }
        }
        let messages = self.retained.all();
        (self.clients).catch_up(number, self.shown, &messages, Some(&new));
    }

    fn playback(
        &mut self,
        now: Duration,
        number: u64,
        request: &PlaybackRequest,
    ) -> Result<(), LiveError> {
        self.clients.knows_playback(number);
        if request.speed > 0.0 {
            self.clock.set_speed(now, request.speed);
        }
        let anew = (request.play && self.ended).then_some(self.span.0);
        let sought = request.seek.or(anew);
        if let Some(time) = sought {
            self.jump(now, time)?;
        }
        self.want(now, request.play);
        self.announce(now, sought.is_some(), Some((number, &request.id)));
        Ok(())
    }

    fn control(&mut self, now: Duration, control: Control) -> Result<(), LiveError> {
        let after = |from: u64, seconds: f64| {
            let nanos = seconds * 1e9;
            match nanos < 0.0 {
                true => from.saturating_sub(-nanos as u64),
                false => from.saturating_add(nanos as u64),
            }
        };
        let mut sought = None;
        match control {
            Control::Toggle => {
                sought = self.ended.then_some(self.span.0);
                self.want(now, !self.wanted);
            }
            Control::SeekTo(seconds) => sought = Some(after(self.span.0, seconds)),
            Control::SeekBy(seconds) => sought = Some(after(self.clock.at(now), seconds)),
            Control::Faster => self.clock.set_speed(now, faster(self.clock.speed())),
            Control::Slower => self.clock.set_speed(now, slower(self.clock.speed())),
            Control::Stop => {}
        }
        if let Some(time) = sought {
            // Who seeks away from the end wants to see what is there.
            self.wanted |= self.ended;
            self.jump(now, time)?;
        }
        self.announce(now, sought.is_some(), None);
        Ok(())
    }

    /// Lets time pass from now on, or pauses it.
    fn want(&mut self, now: Duration, wanted: bool) {
        self.wanted = wanted;
        if !wanted {
            self.clock.pause(now);
        }
    }

    /// Goes to a log time.
    pub(crate) fn jump(&mut self, now: Duration, log_time: u64) -> Result<(), LiveError> {
        self.clock.seek(now, log_time);
        let log_time = self.clock.at(now);
        self.timeline.seek(log_time);
        self.retained.clear();
        for message in self.timeline.latest_before(log_time)? {
            if let Some(number) = self.advertisement.number(message.channel) {
                (self.retained).take(number, message.log_time, &message.data);
            }
        }
        self.shown = log_time;
        self.ended = false;
        Ok(())
    }

    /// Sends the playback state; after a seek also the retained messages.
    fn announce(&mut self, now: Duration, did_seek: bool, asker: Option<(u64, &str)>) {
        self.clients.state(self.state(now, did_seek), asker);
        if did_seek {
            self.clients.time(self.shown);
            for (channel, log_time, data) in self.retained.all() {
                self.clients.message(channel, log_time, data);
            }
        }
        self.clients.wake();
    }

    fn state(&self, now: Duration, did_seek: bool) -> PlaybackState {
        PlaybackState {
            status: match (self.ended, self.wanted) {
                (true, _) => Status::Ended,
                (false, true) => Status::Playing,
                (false, false) => Status::Paused,
            },
            log_time: self.clock.at(now),
            speed: self.clock.speed(),
            did_seek,
        }
    }

    /// Reports the playback state, a few times a second and when it changes.
    fn report(&mut self, now: Duration) {
        let mode = match (self.ended, self.wanted) {
            (true, _) => Mode::Ended,
            (false, false) => Mode::Paused,
            (false, true) if self.start.is_open(now) => Mode::Playing,
            (false, true) => Mode::Waiting,
        };
        let speed = self.clock.speed();
        let due = self
            .times
            .progress
            .is_none_or(|(then, other, other_speed)| {
                now.saturating_sub(then) >= PROGRESS || (other, other_speed) != (mode, speed)
            });
        if due {
            self.times.progress = Some((now, mode, speed));
            let seconds = |time: u64| time.saturating_sub(self.span.0) as f64 / 1e9;
            (self.notify)(Event::Progress(Progress {
                at_s: seconds(self.clock.at(now)),
                duration_s: seconds(self.span.1),
                speed,
                mode,
                viewers: self.clients.len(),
            }));
        }
    }
}
