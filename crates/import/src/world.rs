//! Names, frames, units and axes of a third-party recording.

use std::collections::{BTreeMap, BTreeSet};

use inhand_model::{Finding, Pose, Setting};

use crate::assemble::Entities;
use crate::pace::median;
use crate::reading::Kind;
use crate::series::Gathered;
use crate::topics::{ImportSettings, name_of_topic};
use crate::tree::links_above;

/// Things further than this from the origin, metres, suggest that lengths are no metres.
const FAR_M: f64 = 20.0;

/// Series that hold anything and are not of scans.
pub(crate) fn used(gathered: &Gathered<'_>) -> Vec<usize> {
    let usable = |&index: &usize| {
        let series = &gathered.series[index];
        let scan = gathered.topics[series.topic].points_of_a_scan.is_some();
        !series.message.is_empty() && !scan
    };
    (0..gathered.series.len()).filter(usable).collect()
}

/// Distinguishes things of one name on different topics: those on the topic of the highest priority count; where
/// several topics have the same priority, each is called by its whole topic.
pub(crate) fn distinguish(gathered: &Gathered<'_>, entities: &mut Entities) {
    let Entities {
        markers,
        bodies,
        findings,
    } = entities;
    distinguish_kind(gathered, markers, "marker", findings, |marker| {
        &mut marker.name
    });
    distinguish_kind(gathered, bodies, "body", findings, |body| &mut body.name);
}

fn distinguish_kind<T>(
    gathered: &Gathered<'_>,
    things: &mut Vec<(usize, T)>,
    kind: &str,
    findings: &mut Vec<Finding>,
    name: impl Fn(&mut T) -> &mut String,
) {
    let topic_of = |series: usize| gathered.series[series].topic;
    let mut topics: BTreeMap<String, BTreeSet<(u8, usize)>> = BTreeMap::new();
    for (series, thing) in things.iter_mut() {
        let topic = topic_of(*series);
        let entry = topics.entry(name(thing).clone()).or_default();
        entry.insert((gathered.topics[topic].rank(), topic));
    }
    topics.retain(|_, topics| topics.len() > 1);
    for (shared, topics) in &topics {
        let names = topics
            .iter()
            .map(|&(_, topic)| gathered.topics[topic].name.as_str());
        let names = names.collect::<Vec<_>>().join(", ");
        let place = format!("{kind} \"{shared}\"");
        findings.push(match first_ranked(topics)[..] {
            [_] => {
                let message = format!("it is on the topics {names}: read from the first");
                Finding::info(place, message)
            }
            _ => {
                let message = format!(
                    "it is on the topics {names}, which have the same priority: each is called by its topic; \
                     [topics] names or ignores them"
                );
                Finding::warning(place, message)
            }
        });
    }
    things.retain_mut(|(series, thing)| {
        let name = name(thing);
        let Some(topics) = topics.get(name) else {
            return true;
        };
        let best = first_ranked(topics);
        let topic = topic_of(*series);
        if best.len() > 1 {
            let whole = &gathered.topics[topic].name;
            *name = match gathered.series[*series].kind {
                Kind::Pose | Kind::Marker if *name == name_of_topic(whole) => whole.clone(),
                _ => format!("{whole}#{name}"),
            };
        }
        best.contains(&topic)
    });
}

/// The topics of the least rank, which is that of the first one.
fn first_ranked(topics: &BTreeSet<(u8, usize)>) -> Vec<usize> {
    let least = topics.first().map(|&(rank, _)| rank);
    let best = topics.iter().filter(|&&(rank, _)| Some(rank) == least);
    best.map(|&(_, topic)| topic).collect()
}

/// The frames in which coordinates are given.
pub(crate) fn top_frames(gathered: &Gathered<'_>, used: &[usize]) -> BTreeSet<String> {
    let chains = links_above(gathered, used).into_iter();
    let frames = used.iter().zip(chains).filter_map(|(&series, chain)| {
        let series = &gathered.series[series];
        match series.kind {
            Kind::Transform => chain.map(|(_, top)| top),
            _ => Some(series.frame.clone()),
        }
    });
    frames.collect()
}

/// A finding where not everything is given in one frame, as is assumed.
pub(crate) fn frames(gathered: &Gathered<'_>, used: &[usize]) -> Option<Finding> {
    let frames = top_frames(gathered, used);
    (frames.len() > 1).then(|| {
        let named = frames.iter().take(8).map(|frame| format!("\"{frame}\""));
        let message = format!(
            "coordinates are given in the frames {}: taken for one and the same world",
            named.collect::<Vec<_>>().join(", ")
        );
        Finding::warning("", message)
    })
}

/// Assumptions about the unit and the axes, and numbers that contradict them.
pub(crate) fn units_and_axes(entities: &Entities, settings: &ImportSettings) -> Vec<Finding> {
    let mut findings = Vec::new();
    if settings.length_unit.is_none() {
        let bodies = (entities.bodies.iter())
            .flat_map(|(_, body)| body.track.iter().flatten().map(Pose::origin));
        let markers = entities
            .markers
            .iter()
            .flat_map(|(_, m)| m.track.iter().flatten());
        let distances = bodies.chain(markers).map(|at| at.coords_m().norm());
        if let Some(far_m) = median(distances.collect()).filter(|&far_m| far_m > FAR_M) {
            let message = format!(
                "metres are assumed, as ROS has them, and put things {far_m:.0} m from the origin: \
                 source.units = \"mm\" if these are millimetres"
            );
            findings.push(Finding::warning("", message));
        }
    }
    if settings.up_axis.is_none() {
        findings.push(Finding::info(
            "",
            format!(
                "no topic says which axis points up: z is assumed, as ROS has it; {} sets it",
                Setting::Up
            ),
        ));
    }
    findings
}
