//! The part of `inhand learn` that chooses a rank: `--rank FROM..TO`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, Result};
use inhand_dictionary::{RankCurve, RankGroups, RankSuggestion};
use inhand_model::{HeldOut, Protocol, Provenance, RankPoint, Segments};
use inhand_report::{RankFigure, rank_figure_svg};
use inhand_session::{Role, Settings, is_stream, steps, write_text};
use serde_json::{Value, json};

use crate::console::Console;
use crate::interrupt;
use crate::progress::rounded;

/// A rank that was chosen, and why.
#[derive(Debug)]
pub(crate) struct RankChoice {
    curve: RankCurve,
    suggestion: RankSuggestion,
}

/// The figure beside a dictionary: `D.rank.svg` for `D.mcap`. None is beside a device or a FIFO.
pub(crate) fn figure_path(dictionary: &Path) -> Option<PathBuf> {
    (!is_stream(dictionary)).then(|| dictionary.with_extension("rank.svg"))
}

/// The training segments, all in memory.
pub(crate) fn segments(takes: &[PathBuf], settings: &Settings) -> Result<Segments> {
    let mut takes = (takes.iter())
        .map(|take| inhand_session::read(take, settings))
        .collect::<Result<Vec<_>, _>>()?;
    steps::used(&takes, settings)?;
    let motions = steps::motions(&mut takes, settings)?.published;
    let motions: Vec<_> = motions.iter().collect();
    let object = steps::carries_object(&motions, settings)?;
    Ok(steps::segments(
        &motions,
        (Role::Train, Protocol::Published),
        object,
        settings,
    )?)
}

/// Evaluates the ranks on training takes left out of learning and puts the suggested one into the
/// settings.
pub(crate) fn choose(
    console: &Console,
    segments: &Segments,
    ranks: &[usize],
    settings: &mut Settings,
) -> Result<RankChoice> {
    let begin = Instant::now();
    // The time that a rank takes grows with it.
    let total: usize = ranks.iter().sum();
    let task = console.task("evaluating ranks", total as f64);
    let begin_rank = |done: usize| {
        let Some(rank) = ranks.get(done) else { return };
        task.part(
            format!("{rank} ({} of {})", done + 1, ranks.len()),
            *rank as f64,
        );
        interrupt::keeps(match done {
            0 => "nothing was written; run the same command again".to_owned(),
            _ => format!(
                "no dictionary was written, the ranks printed are lost; run the same command again, or with a range \
                 from {rank} for the other ranks alone"
            ),
        });
    };
    begin_rank(0);
    let (mut done, mut sum) = (0, 0);
    let curve = steps::judge_ranks(segments, settings, ranks, &mut |point| {
        done += 1;
        sum += point.rank;
        let left_s = begin.elapsed().as_secs_f64() * (total as f64 / sum as f64 - 1.0);
        console.say(&format!(
            "rank {:>4} ({done} of {}): {} mm predicted, about {} left",
            point.rank,
            ranks.len(),
            mm(point.predicted.rms_m),
            rounded(left_s),
        ));
        begin_rank(done);
    })?;
    drop(task);
    if !curve.too_large.is_empty() {
        let left_out: Vec<_> = curve.too_large.iter().map(usize::to_string).collect();
        console.say(&format!(
            "left out: rank {}; without the {} left out in turn the segments support {} at most",
            left_out.join(", "),
            groups(&curve),
            curve.largest,
        ));
    }
    let suggestion = curve.suggestion().context("no rank could be evaluated")?;
    settings.learn.rank = Some(suggestion.rank);
    Ok(RankChoice { curve, suggestion })
}

impl RankChoice {
    /// The curve as a table, then the suggestion.
    pub(crate) fn text(&self) -> String {
        let curve = &self.curve;
        let groups = groups(curve);
        let mut text = format!(
            "{} training segments; {} of {} {groups} left out in turn, errors in mm rms ± standard error over {groups}\n\n\
             rank  explained %  training         held out        predicted\n",
            curve.segments, curve.left_out, curve.groups,
        );
        for point in &curve.points {
            text += &format!(
                "{:>4}  {:>11.3}  {:>8}  {:>15}  {:>15}{}\n",
                point.rank,
                100.0 * point.explained_variance,
                mm(point.training_rms_m),
                with_error(point.reconstructed),
                with_error(point.predicted),
                ["", "  <- suggested"][usize::from(point.rank == self.suggestion.rank)],
            );
        }
        let hidden_s = curve.hidden.len() as f64 / curve.rate_hz;
        let reason = self.reason();
        text + &format!(
            "\npredicted: the middle {hidden_s:.2} s of each left-out segment from the rest of it\n{reason}\n"
        )
    }

    /// Why this rank, in words.
    pub(crate) fn reason(&self) -> String {
        let (s, curve) = (&self.suggestion, &self.curve);
        let (count, groups) = (curve.groups, groups(curve));
        let mut reason = format!("Rank {} is suggested: ", s.rank);
        let error_m = (curve.points.iter())
            .find(|point| point.rank == s.best_rank)
            .and_then(|point| point.predicted.standard_error_m);
        let (best, predicted) = (mm(s.best_m), mm(s.predicted_m));
        let error = error_m.map(|error_m| format!("{} mm, over {count} {groups}", mm(error_m)));
        reason += &match error {
            _ if curve.points.len() == 1 => "no other rank was evaluated.".to_owned(),
            None => format!(
                "its prediction error is the lowest, {best} mm; a single group of segments gives no standard \
                 error."
            ),
            Some(error) if s.rank == s.best_rank => format!(
                "its prediction error is the lowest, {best} mm, and that of every smaller one higher by more \
                 than one standard error ({error})."
            ),
            Some(error) => format!(
                "the smallest whose prediction error ({predicted} mm) is within one standard error ({error}) of \
                 the lowest ({best} mm at rank {}). More primitives gain less than other {groups} would change.",
                s.best_rank
            ),
        };
        if s.still_falling {
            reason += " The error is lowest at the largest rank evaluated: larger ones may predict better.";
        }
        if count < 4 {
            reason += &format!(" {count} {groups} are few for a standard error: add takes.");
        }
        reason
    }

    /// The same as JSON, lengths in millimetres.
    pub(crate) fn json(&self) -> Value {
        let curve = &self.curve;
        let millimetres = |m: f64| 1000.0 * m;
        let point = |point: &RankPoint| {
            json!({
                "rank": point.rank,
                "explained_variance": point.explained_variance,
                "training_mm": millimetres(point.training_rms_m),
                "held_out_mm": millimetres(point.reconstructed.rms_m),
                "held_out_standard_error_mm": point.reconstructed.standard_error_m.map(millimetres),
                "predicted_mm": millimetres(point.predicted.rms_m),
                "predicted_standard_error_mm": point.predicted.standard_error_m.map(millimetres),
            })
        };
        json!({
            "suggested": self.suggestion.rank,
            "best": self.suggestion.best_rank,
            "limit_mm": millimetres(self.suggestion.limit_m),
            "still_falling": self.suggestion.still_falling,
            "reason": self.reason(),
            "left_out_by": groups(curve),
            "groups": curve.groups,
            "segments": curve.segments,
            "left_out_segments": curve.left_out,
            "hidden_s": curve.hidden.len() as f64 / curve.rate_hz,
            "too_large": curve.too_large,
            "largest": curve.largest,
            "points": curve.points.iter().map(point).collect::<Vec<_>>(),
        })
    }

    /// Puts ranks and reason among the settings that a dictionary was made with.
    pub(crate) fn note(&self, made: &mut Provenance) {
        let Ok(Value::Object(mut settings)) = serde_json::from_str(&made.settings_json) else {
            return;
        };
        let ranks: Vec<_> = self.curve.points.iter().map(|point| point.rank).collect();
        let choice = json!({ "ranks": ranks, "reason": self.reason() });
        settings.insert("rank_choice".to_owned(), choice);
        made.settings_json = Value::Object(settings).to_string();
    }

    /// Draws the curve that a dictionary's rank was chosen by.
    pub(crate) fn write_figure(&self, path: &Path, dictionary: &Path) -> Result<()> {
        let name = dictionary.file_stem().unwrap_or_default();
        let figure = RankFigure {
            title: format!("{}, {}", name.to_string_lossy(), self.curve.kind.name()),
            points: self.curve.points.clone(),
            suggested: self.suggestion.rank,
            limit_m: self.suggestion.limit_m,
            reason: self.reason(),
        };
        Ok(write_text(path, &rank_figure_svg(&figure))?)
    }
}

const fn groups(curve: &RankCurve) -> &'static str {
    match curve.by {
        RankGroups::Takes => "takes",
        RankGroups::Intervals => "ranges of one take",
    }
}

/// Millimetres with three decimals: ranks differ by hundredths.
fn mm(metres: f64) -> String {
    format!("{:.3}", 1000.0 * metres)
}

fn with_error(held_out: HeldOut) -> String {
    match held_out.standard_error_m {
        Some(error_m) => format!("{} ± {}", mm(held_out.rms_m), mm(error_m)),
        None => mm(held_out.rms_m),
    }
}
