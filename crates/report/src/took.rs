//! Facts of takes and the segments that they give: one line where all takes agree.

use inhand_model::{BodySource, Finger, RotationOrder, SessionFacts, TakeFacts, TakeSource};

use crate::words::{
    NARROW_SPACE, count, counted, decimals, join_words, percent, plain, short, tied,
};

/// A label and its lines.
pub(crate) type Fact = (&'static str, Vec<String>);

/// Columns of a terminal, and those of a label.
const WIDTH: usize = 80;
const LABEL: usize = 9;

/// Takes that are named; more are counted.
const NAMED: usize = 3;

/// Format, roles, tracking and gaps of takes in plain text, at most 80 columns; `shape` is that of the object. Lines end
/// with a newline.
pub fn takes_text(takes: &[TakeFacts], shape: Option<&str>) -> String {
    let all: Vec<_> = takes.iter().collect();
    let mut facts = source_facts(&all, shape);
    facts.insert(1, ("length", vec![length(&all)]));
    text(&facts)
}

/// The takes of a session and the segments that they give, as [`takes_text`].
pub fn session_text(session: &SessionFacts) -> String {
    text(&session_facts(session))
}

/// The same as labels with lines.
pub(crate) fn session_facts(session: &SessionFacts) -> Vec<Fact> {
    let takes: Vec<_> = session.train.iter().chain(&session.test).collect();
    let mut facts = source_facts(&takes, session.object.as_deref());
    let seconds = session.segment_samples as f64 / session.rate_hz;
    for (role, takes) in [("train", &session.train), ("test", &session.test)] {
        if !takes.is_empty() {
            facts.push((role, vec![segments(takes, seconds)]));
        }
    }
    facts
}

fn source_facts(takes: &[&TakeFacts], shape: Option<&str>) -> Vec<Fact> {
    let known: Vec<Take<'_>> = (takes.iter())
        .filter_map(|take| Some((&*take.name, take.source.as_ref()?)))
        .collect();
    if known.is_empty() {
        return Vec::new();
    }
    let mut facts = vec![("format", grouped(&known, format, |_| None))];
    let with_roles: Vec<Take<'_>> = (known.into_iter())
        .filter(|(_, source)| source.roles.is_some())
        .collect();
    if with_roles.is_empty() {
        return facts;
    }
    let has_object = |(_, source): &Take<'_>| object(source).is_some();
    facts.push(("hand", grouped(&with_roles, hand, |s| s.hand_tracked)));
    let objects = |source: &TakeSource| object(source).map_or_else(|| "none".to_owned(), body);
    facts.push((
        "object",
        grouped(&with_roles, objects, |s| s.object_tracked),
    ));
    if shape.is_some() || with_roles.iter().any(has_object) {
        facts.push(("shape", vec![shape.unwrap_or("none given").to_owned()]));
    }
    facts.push(("fingers", grouped(&with_roles, fingers, |_| None)));
    facts.push(("gaps", vec![gaps(&with_roles)]));
    facts
}

/// A take by name.
type Take<'a> = (&'a str, &'a TakeSource);

/// Different words about takes, with the takes of each where they differ, and the range of tracked shares.
fn grouped(
    takes: &[Take<'_>],
    words: impl Fn(&TakeSource) -> String,
    tracked: fn(&TakeSource) -> Option<f64>,
) -> Vec<String> {
    let mut groups: Vec<(String, Vec<Take<'_>>)> = Vec::new();
    for &(name, source) in takes {
        let own = words(source);
        match groups.iter_mut().find(|(words, _)| *words == own) {
            Some((_, members)) => members.push((name, source)),
            None => groups.push((own, vec![(name, source)])),
        }
    }
    let differ = groups.len() > 1;
    let line = |(words, members): (String, Vec<Take<'_>>)| {
        let shares = || members.iter().filter_map(|(_, source)| tracked(source));
        let least = shares().fold(f64::INFINITY, f64::min);
        let range = match shares().fold(f64::NEG_INFINITY, f64::max) {
            most if !most.is_finite() => String::new(),
            most if percent(least) == percent(most) => format!(", {} % tracked", percent(most)),
            most => format!(", {} to {} % tracked", percent(least), percent(most)),
        };
        let names: Vec<_> = members.iter().map(|(name, _)| *name).collect();
        let names = match differ {
            true => format!(": {}", listed(&names)),
            false => String::new(),
        };
        format!("{words}{range}{names}")
    };
    groups.into_iter().map(line).collect()
}

fn listed(names: &[&str]) -> String {
    let (shown, more) = names.split_at(match names.len() {
        0..=NAMED => names.len(),
        _ => NAMED - 1,
    });
    let mut items: Vec<_> = shown.iter().map(ToString::to_string).collect();
    if !more.is_empty() {
        items.push(format!("{} more", count(more.len())));
    }
    join_words(&items)
}

fn format(source: &TakeSource) -> String {
    let rotation = source
        .rotation
        .map_or_else(String::new, |order| match order {
            RotationOrder::Quaternion => ", quaternions".to_owned(),
            order => format!(", Euler angles {order}"),
        });
    format!(
        "{}, {} Hz, {}, {} up{rotation}",
        source.format,
        plain(source.rate_hz),
        source.length_unit.name(),
        source.up_axis.name().to_uppercase(),
    )
}

fn hand(source: &TakeSource) -> String {
    let roles = source.roles.as_ref();
    roles.map_or_else(String::new, |roles| body(&roles.hand))
}

fn object(source: &TakeSource) -> Option<&BodySource> {
    source.roles.as_ref()?.object.as_ref()
}

fn body(source: &BodySource) -> String {
    match source {
        BodySource::RigidBody(name) => format!("rigid body \"{name}\""),
        BodySource::Markers(names) => format!("markers {}", names.join(", ")),
    }
}

fn fingers(source: &TakeSource) -> String {
    let roles = source.roles.iter().flat_map(|roles| roles.fingers.iter());
    let names = roles.map(|(finger, marker)| format!("{finger} \"{marker}\""));
    names.collect::<Vec<_>>().join(", ")
}

/// The worst take of each finger.
fn gaps(takes: &[Take<'_>]) -> String {
    let worst = |finger: Finger| {
        let gaps = takes.iter().map(|(_, source)| source.gaps[finger]);
        gaps.fold([0.0_f64; 2], |[missing, longest_s], own| {
            [missing.max(own.missing), longest_s.max(own.longest_s)]
        })
    };
    let gaps = (Finger::ALL.into_iter())
        .map(|finger| (finger, worst(finger)))
        .filter(|(_, [missing, _])| *missing > 0.0)
        .map(|(finger, [missing, longest_s])| {
            let (share, longest) = (percent(missing), decimals(longest_s, 2));
            format!("{finger} {share} % (longest {longest} s)")
        });
    let gaps: Vec<_> = gaps.collect();
    match (gaps.len(), takes.len()) {
        (0, _) => "none in any fingertip".to_owned(),
        (_, 1) => gaps.join(", "),
        _ => format!("at most {}", gaps.join(", ")),
    }
}

/// Samples and time of takes.
fn length(takes: &[&TakeFacts]) -> String {
    let samples = takes.iter().map(|take| take.samples).sum();
    let seconds: f64 = takes.iter().map(|take| take.duration_s).sum();
    format!("{} samples, {} s", count(samples), short(seconds))
}

fn segments(takes: &[TakeFacts], segment_s: f64) -> String {
    let seconds: f64 = takes.iter().map(|take| take.duration_s).sum();
    let used = takes.iter().map(|take| take.segments).sum();
    format!(
        "{}, {} s: {} of {} s{}",
        counted(takes.len(), "take"),
        decimals(seconds, 0),
        counted(used, "segment"),
        plain(segment_s),
        left_out(takes),
    )
}

/// Segments that are left out, why, and of which takes; nothing where there are none.
fn left_out(takes: &[TakeFacts]) -> String {
    let with: Vec<_> = takes.iter().filter(|take| take.left_out > 0).collect();
    if with.is_empty() {
        return String::new();
    }
    let all: usize = with.iter().map(|take| take.left_out).sum();
    let names: Vec<_> = with.iter().map(|take| &*take.name).collect();
    let of = match with.len() < takes.len() {
        true => format!(" of {}", listed(&names)),
        false => String::new(),
    };
    match missing(&with) {
        reasons if reasons.is_empty() => format!(", {} left out{of}", count(all)),
        reasons => format!(", {} left out{of} (gaps in {reasons})", count(all)),
    }
}

/// What is missing where segments are left out, most frequent first.
pub(crate) fn missing(takes: &[&TakeFacts]) -> String {
    let fingers = Finger::ALL.map(Finger::name);
    let names = ["hand"].into_iter().chain(fingers).chain(["object"]);
    let segments = |name: &str| -> usize {
        let takes = takes.iter().filter_map(|take| take.left_out_by.get(name));
        takes.sum()
    };
    let mut counts: Vec<_> = names.map(|name| (segments(name), name)).collect();
    counts.retain(|(n, _)| *n > 0);
    counts.sort_by_key(|(n, _)| std::cmp::Reverse(*n));
    let names = counts.into_iter().map(|(_, name)| name.to_owned());
    join_words(&names.collect::<Vec<_>>())
}

fn text(facts: &[Fact]) -> String {
    let mut text = String::new();
    for (label, lines) in facts {
        let mut label = *label;
        for line in lines {
            // Narrow spaces are not in every terminal font.
            let line = tied(line).replace(NARROW_SPACE, "\u{a0}");
            for line in wrapped(&line, WIDTH - LABEL) {
                text.push_str(&format!("{label:<LABEL$}{line}\n"));
                label = "";
            }
        }
    }
    text.replace('\u{a0}', " ")
}

/// Lines of at most `width` letters, broken at spaces.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().map_or(0, |line| line.chars().count());
        match lines.last_mut() {
            Some(last) if line == 0 => last.push_str(word),
            Some(last) if line + 1 + word.chars().count() <= width => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
