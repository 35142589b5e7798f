//! The connected clients and their subscriptions.

use std::collections::{BTreeMap, BTreeSet};

use crate::control::Viewer;
use crate::outbox::Merit;
use crate::protocol::{Level, PlaybackState, Subprotocol, message_head, status, time};

/// Subscriptions that one viewer may have to a channel: each gets its own copy of every message.
const MOST_SUBSCRIPTIONS: usize = 8;

/// The connected clients.
#[derive(Default)]
pub(crate) struct Clients {
    clients: BTreeMap<u64, Client>,
    /// Messages that were put into outboxes.
    pub(crate) sent: u64,
    /// Messages that were not, since viewers read too slowly.
    pub(crate) missed: u64,
    /// Clients that have connected so far.
    pub(crate) came: u64,
}

struct Client {
    viewer: Viewer,
    /// Subscriptions of each channel.
    subscriptions: BTreeMap<u64, Vec<u32>>,
    /// All of them.
    ids: BTreeSet<u32>,
    /// Whether playback states mean something to it.
    controls: bool,
    /// Messages that it did not get since it was last warned.
    missed: u64,
}

impl Clients {
    pub(crate) fn len(&self) -> usize {
        self.clients.len()
    }

    /// Whether any client is subscribed.
    pub(crate) fn is_watching(&self) -> bool {
        (self.clients.values()).any(|client| !client.subscriptions.is_empty())
    }

    pub(crate) fn arrive(&mut self, viewer: Viewer, greeting: &[String]) {
        for text in greeting {
            viewer.outbox.text(text);
        }
        viewer.outbox.wake();
        let client = Client {
            controls: viewer.subprotocol == Subprotocol::Sdk,
            viewer,
            subscriptions: BTreeMap::new(),
            ids: BTreeSet::new(),
            missed: 0,
        };
        self.came += 1;
        self.clients.insert(client.viewer.number, client);
    }

    /// Removes a client.
    pub(crate) fn leave(&mut self, number: u64) -> Option<Viewer> {
        self.clients.remove(&number).map(|client| client.viewer)
    }

    /// Adds a subscription; an error is for the viewer.
    pub(crate) fn subscribe(
        &mut self,
        number: u64,
        subscription: u32,
        channel: u64,
    ) -> Result<(), String> {
        let Some(client) = self.clients.get_mut(&number) else {
            return Ok(());
        };
        if client.ids.contains(&subscription) {
            return Err(format!("subscription {subscription} is there already"));
        }
        let ids = client.subscriptions.entry(channel).or_default();
        if ids.len() >= MOST_SUBSCRIPTIONS {
            return Err(format!(
                "more than {MOST_SUBSCRIPTIONS} subscriptions to channel {channel}"
            ));
        }
        ids.push(subscription);
        client.ids.insert(subscription);
        client.rate();
        Ok(())
    }

    pub(crate) fn unsubscribe(&mut self, number: u64, subscriptions: &[u32]) {
        if let Some(client) = self.clients.get_mut(&number) {
            let gone: BTreeSet<u32> = subscriptions.iter().copied().collect();
            client.ids.retain(|id| !gone.contains(id));
            client.subscriptions.retain(|_, ids| {
                ids.retain(|id| !gone.contains(id));
                !ids.is_empty()
            });
            client.rate();
        }
    }

    /// Warns a viewer of a request that cannot be met.
    pub(crate) fn warn(&self, number: u64, what: &str) {
        if let Some(client) = self.clients.get(&number) {
            client.viewer.outbox.text(&status(Level::Warning, what));
            client.viewer.outbox.wake();
        }
    }

    /// Tells all viewers why playback ends.
    pub(crate) fn fail(&self, what: &str) {
        for client in self.clients.values() {
            client.viewer.outbox.text(&status(Level::Error, what));
        }
    }

    /// Notes that a viewer understands playback states.
    pub(crate) fn knows_playback(&mut self, number: u64) {
        if let Some(client) = self.clients.get_mut(&number) {
            client.controls = true;
        }
    }

    /// Sends the playback state; to `asker` as the answer to its request.
    pub(crate) fn state(&self, state: PlaybackState, asker: Option<(u64, &str)>) {
        let others = state.to_bytes("");
        for (&number, client) in self.clients.iter().filter(|(_, client)| client.controls) {
            match asker.filter(|&(asker, _)| asker == number) {
                Some((_, request)) => client.viewer.outbox.binary(&[&state.to_bytes(request)]),
                None => client.viewer.outbox.binary(&[&others]),
            };
        }
    }

    pub(crate) fn time(&self, log_time: u64) {
        let bytes = time(log_time);
        for client in self.clients.values().filter(|client| client.missed == 0) {
            client.viewer.outbox.binary(&[&bytes]);
        }
    }

    /// Sends a message to all who subscribed to its channel.
    pub(crate) fn message(&mut self, channel: u64, log_time: u64, data: &[u8]) {
        for client in self.clients.values_mut() {
            let (sent, missed) = client.message(channel, log_time, data, None);
            self.sent += sent;
            self.missed += missed;
        }
    }

    /// Sends the playback state to a new client.
    pub(crate) fn introduce(&self, number: u64, state: PlaybackState) {
        if let Some(client) = self.clients.get(&number).filter(|client| client.controls) {
            client.viewer.outbox.binary(&[&state.to_bytes("")]);
        }
    }

    /// Sends the time to one viewer, then messages as far as it subscribed to their channels; where
    /// `only` names subscriptions, to those alone.
    pub(crate) fn catch_up(
        &mut self,
        number: u64,
        now: u64,
        messages: &[(u64, u64, &[u8])],
        only: Option<&[u32]>,
    ) {
        let Some(client) = self.clients.get_mut(&number) else {
            return;
        };
        if client.missed == 0 {
            client.viewer.outbox.binary(&[&time(now)]);
        }
        for &(channel, log_time, data) in messages {
            let (sent, missed) = client.message(channel, log_time, data, only);
            self.sent += sent;
            self.missed += missed;
        }
        client.viewer.outbox.wake();
    }

    /// The clients that were behind and have read all that was sent since; they are warned, and go on.
    pub(crate) fn caught_up(&mut self, state: PlaybackState) -> Vec<(Viewer, u64)> {
        let mut caught_up = Vec::new();
        for client in self.clients.values_mut() {
            if client.missed > 0 && client.viewer.outbox.is_empty() {
                let missed = std::mem::take(&mut client.missed);
                client.rate();
                let what = format!("read too slowly: {missed} messages were left out");
                client.viewer.outbox.text(&status(Level::Warning, &what));
                if client.controls {
                    client.viewer.outbox.binary(&[&state.to_bytes("")]);
                }
                caught_up.push((client.viewer.clone(), missed));
            }
        }
        caught_up
    }

    /// Drops what waits for viewers that are behind and read nothing at all.
    pub(crate) fn relieve(&mut self) {
        for client in self.clients.values_mut().filter(|client| client.missed > 0) {
            let dropped = client.viewer.outbox.relieve();
            client.missed += dropped;
            self.missed += dropped;
            self.sent -= dropped;
        }
    }

    /// Whether any client is behind.
    pub(crate) fn is_anyone_behind(&self) -> bool {
        self.clients.values().any(|client| client.missed > 0)
    }

    /// Whether nothing waits in any outbox.
    pub(crate) fn is_all_sent(&self) -> bool {
        (self.clients.values()).all(|client| client.viewer.outbox.is_empty())
    }

    /// Sends what was put into outboxes.
    pub(crate) fn wake(&self) {
        for client in self.clients.values() {
            client.viewer.outbox.wake();
        }
    }

    /// Closes all connections, after what is still to be sent.
    pub(crate) fn close(&self) {
        for client in self.clients.values() {
            client.viewer.outbox.close();
        }
    }
}

impl Client {
    /// Sends a message on the subscriptions to its channel; how many were sent, and how many were not. A
    /// viewer that is behind gets nothing in between: it goes on from the playback position when it has
    /// read all.
    fn message(
        &mut self,
        channel: u64,
        log_time: u64,
        data: &[u8],
        only: Option<&[u32]>,
    ) -> (u64, u64) {
        let (mut sent, missed) = (0, self.missed);
        for &subscription in self.subscriptions.get(&channel).into_iter().flatten() {
            if only.is_some_and(|only| !only.contains(&subscription)) {
                continue;
            }
            let head = message_head(subscription, log_time);
            let outbox = &self.viewer.outbox;
            match self.missed == 0 && outbox.message(&[&head, data]) {
                true => sent += 1,
                false => self.missed += 1,
            }
        }
        if missed == 0 && self.missed > 0 {
            self.rate();
        }
        (sent, self.missed - missed)
    }

    /// Notes what the viewer does, for the choice of who goes where there are too many.
    fn rate(&self) {
        self.viewer
            .outbox
            .deserves(match (self.ids.is_empty(), self.missed) {
                (true, _) => Merit::Silent,
                (false, 0) => Merit::Reading,
                (false, _) => Merit::Behind,
            });
    }
}
