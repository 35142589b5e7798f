//! Content of files that a layout can show.

use std::collections::{BTreeMap, BTreeSet};

use inhand_channels::{PointExtent, Preview, TopicRole, TopicSource};

/// A channel, as far as layouts need it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// The schema of its messages, where it is known.
    pub schema: Option<String>,
}

/// What one or several files have to show.
#[derive(Clone, Debug, Default)]
pub struct Content {
    pub(crate) topics: Vec<Topic>,
    pub(crate) frames: BTreeSet<String>,
    pub(crate) seen: BTreeMap<String, PointExtent>,
}

impl Content {
    /// Topics with the frame that each is in, where one is known.
    pub fn of_topics<'a>(topics: impl IntoIterator<Item = (String, Option<&'a str>)>) -> Self {
        let mut content = Self::default();
        for (name, frame) in topics {
            content.add_topic(Topic { name, schema: None });
            content.frames.extend(frame.map(str::to_owned));
        }
        content
    }

    /// Adds what a file has. Of what several files have, such as the place of a hand, that of the
    /// first holds.
    pub fn add(&mut self, preview: Preview) {
        for channel in preview.channels {
            self.add_topic(Topic {
                name: channel.topic,
                schema: channel.schema.map(|schema| schema.name),
            });
        }
        self.frames.extend(preview.frames);
        for (frame, seen) in preview.seen {
            self.seen.entry(frame).or_insert(seen);
        }
    }

    fn add_topic(&mut self, topic: Topic) {
        if self.topics.iter().all(|known| known.name != topic.name) {
            self.topics.push(topic);
        }
    }

    /// Whether any topic is one that inhand writes.
    pub fn is_ours(&self) -> bool {
        self.shown().next().is_some()
    }

    /// Our topics and what they show.
    pub(crate) fn shown(&self) -> impl Iterator<Item = (&str, TopicRole<'_>)> {
        (self.topics.iter())
            .filter_map(|topic| Some((topic.name.as_str(), TopicRole::from_topic(&topic.name)?)))
    }

    /// The first topic that shows this.
    pub(crate) fn find(&self, wanted: TopicRole<'_>) -> Option<&str> {
        self.find_map(|shown| (shown == wanted).then_some(()))
            .map(|(topic, ())| topic)
    }

    /// The first topic of which `choose` makes something.
    pub(crate) fn find_map<'a, T>(
        &'a self,
        choose: impl Fn(TopicRole<'a>) -> Option<T>,
    ) -> Option<(&'a str, T)> {
        self.shown()
            .find_map(|(topic, shown)| Some((topic, choose(shown)?)))
    }

    /// The method whose motion is shown beside the recorded one: the first.
    pub(crate) fn method(&self) -> Option<&str> {
        let of = |shown| match shown {
            TopicRole::Tips(TopicSource::Method(name))
            | TopicRole::TipScene(TopicSource::Method(name))
            | TopicRole::Positions(TopicSource::Method(name))
            | TopicRole::Error(name) => Some(name),
            _ => None,
        };
        self.find_map(of).map(|(_, name)| name)
    }

    /// What there is, in words, for errors.
    pub(crate) fn describe(&self) -> String {
        const MOST: usize = 5;
        if self.topics.is_empty() {
            return "no channel at all".to_owned();
        }
        let names: Vec<_> = (self.topics.iter().take(MOST))
            .map(|topic| topic.name.as_str())
            .collect();
        let more = self.topics.len() - names.len();
        let and = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        format!("only {}{and}", names.join(", "))
    }
}
