//! Names, frames, units and axes of a third-party recording.

use std::collections::{BTreeMap, BTreeSet};

use inhand_model::{Finding, Marker, Pose, TrackedBody};

use crate::assemble::Entities;
use crate::gather::Gathered;
use crate::pace::median;
use crate::reading::Kind;
use crate::topics::ImportSettings;
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

/// Tells things of one name on different topics apart: those on the most telling topic count; where
/// several topics tell as much, each is called by its whole topic.
pub(crate) fn tell_apart(gathered: &Gathered<'_>, entities: &mut Entities) {
    let mut findings = Vec::new();
    keep_apart(
        gathered,
        &mut entities.markers,
        |marker: &mut Marker| &mut marker.name,
        "marker",
        &mut findings,
    );
    keep_apart(
        gathered,
        &mut entities.bodies,
        |body: &mut TrackedBody| &mut body.name,
        "body",
        &mut findings,
    );
    entities.findings.append(&mut findings);
}

fn keep_apart<T>(
    gathered: &Gathered<'_>,
    things: &mut Vec<(usize, T)>,
    name: impl Fn(&mut T) -> &mut String,
    kind: &str,
    findings: &mut Vec<Finding>,
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
        let names: Vec<&str> = (topics.iter())
            .map(|&(_, topic)| gathered.topics[topic].name.as_str())
            .collect();
        let best = most_telling(topics);
        findings.push(if best.len() == 1 {
            Finding::info(
                format!("{kind} \"{shared}\""),
                format!(
                    "it is on the topics {}: read from the first",
                    names.join(", ")
                ),
            )
        } else {
            Finding::warning(
                format!("{kind} \"{shared}\""),
                format!(
                    "it is on the topics {}, which tell as much: each is called by its topic; \
                     [topics] names or ignores them",
                    names.join(", ")
                ),
            )
        });
    }
    things.retain_mut(|(series, thing)| {
        let name = name(thing);
        let Some(topics) = topics.get(name) else {
            return true;
        };
        let best = most_telling(topics);
        let topic = topic_of(*series);
        if best.len() > 1 {
            let whole = &gathered.topics[topic].name;
            *name = match gathered.series[*series].kind {
                Kind::Pose | Kind::Marker if *name == crate::topics::name_of_topic(whole) => {
                    whole.clone()
                }
                _ => format!("{whole}#{name}"),
            };
        }
        best.contains(&topic)
    });
}

/// The topics of the least rank, which is that of the first one.
fn most_telling(topics: &BTreeSet<(u8, usize)>) -> Vec<usize> {
    let least = topics.first().map(|&(rank, _)| rank);
    let best = topics.iter().filter(|&&(rank, _)| Some(rank) == least);
    best.map(|&(_, topic)| topic).collect()
}

/// The frames in which coordinates stand.
pub(crate) fn top_frames(gathered: &Gathered<'_>, used: &[usize]) -> BTreeSet<String> {
    let chains = links_above(gathered, used);
    let frames: BTreeSet<&str> = (used.iter().zip(&chains))
        .filter_map(|(&series, chain)| {
            let series = &gathered.series[series];
            match (series.kind, chain) {
                (Kind::Transform, Some((_, top))) => Some(top.as_str()),
                (Kind::Transform, None) => None,
                _ => Some(series.frame.as_str()),
            }
        })
        .collect();
    frames.into_iter().map(str::to_owned).collect()
}

/// Whether everything stands in one frame, as is taken for granted.
pub(crate) fn frames(gathered: &Gathered<'_>, used: &[usize]) -> Option<Finding> {
    let frames = top_frames(gathered, used);
    (frames.len() > 1).then(|| {
        let frames: Vec<String> = (frames.iter().take(8))
            .map(|f| format!("\"{f}\""))
            .collect();
        Finding::warning(
            "",
            format!(
                "coordinates stand in the frames {}: taken for one and the same world",
                frames.join(", ")
            ),
        )
    })
}

/// What was assumed of the unit and the axes, and whether the numbers speak against it.
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
            findings.push(Finding::warning(
                "",
                format!(
                    "metres are assumed, as ROS has them, and put things {far_m:.0} m from the \
                     origin: source.units = \"mm\" if these are millimetres"
                ),
            ));
        }
    }
    if settings.up_axis.is_none() {
        findings.push(Finding::info(
            "",
            "no topic says which axis points up: z is assumed, as ROS has it; source.up sets it",
        ));
    }
    findings
}
