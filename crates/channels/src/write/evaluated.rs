//! Errors and contacts of each method, instant by instant.

use inhand_model::Finger;

use super::{Instant, Stream, Streams};
use crate::error::ChannelError;
use crate::messages;
use crate::output::{ChannelId, Output};
use crate::take::{EvaluatedMethod, EvaluatedSample};
use crate::topic::MethodTopics;
use crate::wire::Timestamp;

pub(super) fn add<'a>(
    methods: &'a [EvaluatedMethod<'a>],
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    for method in methods {
        let topics = MethodTopics::new(method.name)?;
        let errors = if method.samples.iter().any(|judged| judged.error_m.is_some()) {
            Some(output.channel::<messages::FingerErrors>(&topics.error, Some("hand"))?)
        } else {
            None
        };
        let contacts = if method.samples.iter().any(|judged| judged.contact.is_some()) {
            Some(output.channel::<messages::Contacts>(&topics.contact, Some("hand"))?)
        } else {
            None
        };
        let mut samples: Vec<_> = method.samples.iter().collect();
        samples.sort_by_key(|judged| judged.sample);
        streams.push(Box::new(Judged {
            errors,
            contacts,
            samples,
            next: 0,
        }));
    }
    Ok(())
}

struct Judged<'a> {
    errors: Option<ChannelId>,
    contacts: Option<ChannelId>,
    samples: Vec<&'a EvaluatedSample>,
    next: usize,
}

impl Stream for Judged<'_> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        let timestamp = Some(Timestamp::from_unix_nanos(unix_nanos));
        while let Some(judged) = self.samples.get(self.next)
            && judged.sample == k
        {
            self.next += 1;
            if let (Some(channel), Some(error_m)) = (self.errors, &judged.error_m) {
                let message = messages::FingerErrors {
                    timestamp,
                    thumb_m: error_m[Finger::Thumb],
                    index_m: error_m[Finger::Index],
                    middle_m: error_m[Finger::Middle],
                    ring_m: error_m[Finger::Ring],
                    little_m: error_m[Finger::Little],
                };
                output.message(channel, k, unix_nanos, &message)?;
            }
            if let (Some(channel), Some(contact)) = (self.contacts, &judged.contact) {
                let message = messages::Contacts {
                    timestamp,
                    thumb_distance_m: contact.distance_m[Finger::Thumb],
                    index_distance_m: contact.distance_m[Finger::Index],
                    middle_distance_m: contact.distance_m[Finger::Middle],
                    ring_distance_m: contact.distance_m[Finger::Ring],
                    little_distance_m: contact.distance_m[Finger::Little],
                    thumb_in_contact: contact.in_contact[Finger::Thumb],
                    index_in_contact: contact.in_contact[Finger::Index],
                    middle_in_contact: contact.in_contact[Finger::Middle],
                    ring_in_contact: contact.in_contact[Finger::Ring],
                    little_in_contact: contact.in_contact[Finger::Little],
                    // At most the number of fingers.
                    count: contact.count as u32,
                };
                output.message(channel, k, unix_nanos, &message)?;
            }
        }
        Ok(())
    }
}
