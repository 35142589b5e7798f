//! Fingertips as point clouds, and as spheres with short trails, tied to the hand.

use std::collections::VecDeque;
use std::rc::Rc;

use foxglove::messages::Point3;
use inhand_model::{Finger, PerFinger};

use super::draw::{Dot, SPHERE_M, TRAIL_M, add_cloud, entity, point, scene, sphere, strip};
use crate::colour::{FINGER_COLOURS, Rgb};
use crate::error::ChannelError;
use crate::streams::{Instant, Sampling, Streams};
use crate::take::scene_stride;

/// Diameter and opacity of a fingertip that is drawn as a shell, metres.
const SHELL_M: f64 = 0.007;
const SHELL_ALPHA: f64 = 0.25;
/// Diameter of the light around a fingertip that touches the object, metres.
const CONTACT_SPHERE_M: f64 = 0.012;
/// How bright it is: in the fingertip's own colour, which stays to be seen.
const CONTACT_ALPHA: f64 = 0.35;
/// Opacity of a trail.
const TRAIL_ALPHA: f64 = 0.8;
/// Length of a trail, seconds.
const TRAIL_S: f64 = 0.4;
/// Time between the points of a trail, seconds.
const TRAIL_STEP_S: f64 = 0.04;
/// Thickness and opacity of the line from the hand to a fingertip.
const LINK_M: f64 = 0.0006;
const LINK_ALPHA: f64 = 0.5;
/// Fingertips in contact, as points: brighter than any finger.
const TOUCHING: Rgb = [0xFF, 0xFF, 0xFF];

/// Position of a fingertip, metres.
type PositionAt<'a> = dyn Fn(&Instant<'_>, Finger) -> Option<[f64; 3]> + 'a;

/// Fingertips of one motion and how they look.
#[derive(Clone)]
pub(crate) struct Tips<'a> {
    pub(crate) frame: &'static str,
    pub(crate) position_m: Rc<PositionAt<'a>>,
    /// Place among the evaluated methods, where contacts are known.
    pub(crate) contacts: Option<usize>,
    /// Colour of a planned motion, whose fingertips are shells that show what they are around: often within
    /// a fraction of a millimetre of the recorded ones. Without, each finger has its own.
    pub(crate) shells: Option<Rgb>,
    /// Whether lines tie fingertips to the origin of the frame, which is then that of the hand.
    pub(crate) links: bool,
}

/// Topics for the views of one set of fingertips.
pub(crate) struct TipTopics<'t> {
    pub(crate) cloud: &'t str,
    pub(crate) scene: Option<&'t str>,
    pub(crate) contacts: Option<&'t str>,
}

impl<'a> Tips<'a> {
    /// Adds a cloud, a scene, and a cloud of those in contact where that is known.
    pub(crate) fn add(
        &self,
        topics: &TipTopics<'_>,
        samples: Sampling,
        streams: &mut Streams<'a>,
    ) -> Result<(), ChannelError> {
        let rate_hz = samples.clock.rate_hz();
        let scenes = samples.every(scene_stride(rate_hz));
        self.add_cloud(topics.cloud, scenes, streams)?;
        if let Some(topic) = topics.contacts.filter(|_| self.contacts.is_some()) {
            let tips = self.clone();
            let touching = Dot::Star(CONTACT_SPHERE_M);
            add_cloud(
                streams,
                (topic, self.frame),
                &["finger"],
                scenes,
                move |at, cloud| {
                    for finger in Finger::ALL.into_iter().filter(|&f| tips.touches(at, f)) {
                        if let Some(position_m) = (tips.position_m)(at, finger) {
                            cloud.push_dot(touching, position_m, &[finger.index()], TOUCHING);
                        }
                    }
                },
            )?;
        }
        match topics.scene {
            Some(topic) => self.clone().add_scene(topic, scenes, streams),
            None => Ok(()),
        }
    }

    /// Fingertips numbered from the thumb: as stars, which viewers without scenes draw in their size; planned ones, which
    /// may lie on recorded ones, as points.
    fn add_cloud(
        &self,
        topic: &str,
        sampling: Sampling,
        streams: &mut Streams<'a>,
    ) -> Result<(), ChannelError> {
        let tips = self.clone();
        let dot = match self.shells {
            Some(_) => Dot::Point,
            None => Dot::Star(SPHERE_M),
        };
        add_cloud(
            streams,
            (topic, self.frame),
            &["finger"],
            sampling,
            move |at, cloud| {
                for finger in Finger::ALL {
                    if let Some(position_m) = (tips.position_m)(at, finger) {
                        cloud.push_dot(dot, position_m, &[finger.index()], tips.colour(finger));
                    }
                }
            },
        )
    }

    fn add_scene(
        self,
        topic: &str,
        sampling: Sampling,
        streams: &mut Streams<'a>,
    ) -> Result<(), ChannelError> {
        let (rate_hz, stride) = (sampling.clock.rate_hz(), sampling.stride);
        let step = ((TRAIL_STEP_S * rate_hz / stride as f64).round() as usize).max(1) * stride;
        let trail_points = (TRAIL_S * rate_hz / step as f64).round() as usize;
        let mut trails = PerFinger::<VecDeque<Point3>>::default();
        streams.sampled(topic, Some(self.frame), sampling, move |at| {
            let mut tips = entity(self.frame, "fingertips", at.unix_nanos);
            let mut lights = entity(self.frame, "contacts", at.unix_nanos);
            for finger in Finger::ALL {
                let Some(position_m) = (self.position_m)(at, finger) else {
                    // A trail never bridges a gap.
                    trails[finger].clear();
                    continue;
                };
                let rgb = self.colour(finger);
                let (diameter_m, alpha) = match self.shells {
                    Some(_) => (SHELL_M, SHELL_ALPHA),
                    None => (SPHERE_M, 1.0),
                };
                tips.spheres
                    .push(sphere(position_m, diameter_m, (rgb, alpha)));
                // Lights of a plan would outshine what was recorded.
                if self.shells.is_none() && self.touches(at, finger) {
                    let light = sphere(position_m, CONTACT_SPHERE_M, (rgb, CONTACT_ALPHA));
                    lights.spheres.push(light);
                }
                let tip = point(position_m);
                if self.links {
                    let ends = vec![Point3::default(), tip];
                    tips.lines.push(strip(ends, LINK_M, (rgb, LINK_ALPHA)));
                }
                let trail = &mut trails[finger];
                let points: Vec<_> = trail.iter().copied().chain([tip]).collect();
                if points.len() > 1 {
                    tips.lines.push(strip(points, TRAIL_M, (rgb, TRAIL_ALPHA)));
                }
                if at.k.is_multiple_of(step) {
                    if trail.len() >= trail_points {
                        trail.pop_front();
                    }
                    trail.push_back(tip);
                }
            }
            Some(scene(vec![tips, lights]))
        })
    }

    /// Whether the finger is known to touch the object.
    fn touches(&self, at: &Instant<'_>, finger: Finger) -> bool {
        let made = at.made().zip(self.contacts);
        let judged = made.map_or(&[][..], |(made, place)| made.evaluated(place, at.k));
        let contact = judged
            .iter()
            .rev()
            .find_map(|judged| judged.contact.as_ref());
        contact.is_some_and(|contact| contact.in_contact[finger])
    }

    fn colour(&self, finger: Finger) -> Rgb {
        self.shells.unwrap_or(FINGER_COLOURS[finger])
    }
}
