//! Evaluations as HTML with figures, and as JSON.
//!
//! | function | turns a [`Report`] or an `Evaluation` into |
//! | --- | --- |
//! | [`html`] | one self-contained page: verdict, data quality, figures, tables, provenance |
//! | [`figures`] | the figures of that page, each as a file for print with its numbers |
//! | [`markdown`] | a summary for a pull request |
//! | [`evaluation_json`] | `evaluation.json` for scripts, by `schemas/evaluation.schema.json` |
//! | [`session_text`] | what a run took: format, roles, segments, for a terminal |
//! | [`text_summary`] | the table a run prints on a terminal |
//!
//! [`read_evaluation_json`] turns the JSON back; [`rank_figure_svg`] draws errors of dictionaries
//! against their rank. All are pure: same evaluation, same bytes. Lengths come in metres and leave in
//! millimetres; a number that does not exist (nothing evaluated, not finite) leaves as `null` or as a
//! dash, never as zero. Text from files (names of takes, findings, settings) is escaped.
//!
//! ```
//! # use inhand_model::*;
//! # let none = PerFinger::new([1.0; 5]);
//! # let error = Statistics { n: 500, p50: 0.000_4, p75: 0.000_74, p95: 0.003_3, max: 0.021_3, ..Statistics::default() };
//! # let method = MethodEvaluation {
//! #     name: "hermite".into(), description: "cubic, no learning".into(), baseline: true,
//! #     error: HandAndFingers { all: error, by_finger: PerFinger::new([error; 5]) }, error_at_start: error, error_at_goal: error, median_error_by_sample_m: vec![0.0, 0.000_4, 0.0],
//! #     reachability: Reachability { n: 100, inside: none, worst_outside_m: PerFinger::new([0.0; 5]), distance: PerFinger::new([error; 5]), recorded_inside: none },
//! #     collision: Collision { n: 100, limit_m: 0.01, instants: 0, trajectories: 0, nearest_m: 0.02, nearest_pair: None, recorded_instants: 0, recorded_nearest_m: 0.02 },
//! #     velocity: VelocityCheck { n: 1485, outside: 0, trajectories_outside: 0, worst_ratio: 0.7 },
//! #     contact: None, distance_difference: None, object_error: None, corridors: vec![], plan: None,
//! # };
//! # let evaluation = Evaluation {
//! #     session: SessionFacts { name: "cube".into(), rate_hz: 100.0, segment_samples: 100, object: None, participant: None, task: None, train: vec![], test: vec![] },
//! #     default_method: "hermite".into(), choice: None,
//! #     dictionary: DictionaryFacts {
//! #         kind: DictionaryKind::Nmf, rank: 200, segments: 595, rms_m: 0.000_14, relative_error: 0.001,
//! #         iterations: 40, stop_reason: StopReason::IterationLimit, objective_history_m2: vec![2.0, 1.0],
//! #         velocity_bounds: VelocityBounds { min_m_s: [-0.2; 15], max_m_s: [0.2; 15] }, deviation: None,
//! #     },
//! #     methods: vec![method], held_out: None, filter_moves: None,
//! #     quality: vec![], intervals: None, movement: None, contacts: None, inspection: None, key: None,
//! # };
//! let json = inhand_report::evaluation_json(&evaluation, &[])?;
//! assert!(json.contains("\"p50\": 0.4"));
//! let page = inhand_report::html(&inhand_report::Report::new(&evaluation, &[]))?;
//! assert!(page.starts_with("<!DOCTYPE html>"));
//! assert!(inhand_report::text_summary(&evaluation).contains("0.40"));
//! # Ok::<(), inhand_report::ReportError>(())
//! ```
//!
//! In reading order: `json`, `verdict` (a method compared with the baselines, method choice,
//! deviation and prediction regions, in words), `table` (columns and rows for the page, Markdown
//! and a terminal), `text` (for a terminal and in Markdown), `words` (digits, lists), `figure` (one value is a drawing for the page and for print with
//! its numbers; scales, axes, the row plot and other plots), `html` (the page, a file a section; a section is a `Body`).

mod comparison;
mod deviation_words;
mod error;
mod figure;
mod html;
mod json;
mod rank_figure;
mod summary;
mod table;
mod text;
mod took;
mod verdict;
mod words;

use inhand_model::{
    Evaluation, EvaluationComparison, EvaluationRows, Illustrations, Provenance, Summary,
};

pub use comparison::{markdown as comparison_markdown, text as comparison_text};
pub use error::ReportError;
pub use figure::{Figure, FigureColumn, FigureData, FigureValues};
pub use rank_figure::{RankFigure, rank_figure_svg};
pub use summary::{table as summary_table, text as summary_text};
pub use text::text_summary;
pub use took::{session_text, takes_text};
pub use verdict::inspection_sentence;

/// Everything that a report is made from. Without rows or illustrations it has fewer figures.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The numbers.
    pub evaluation: &'a Evaluation,
    /// The single values behind them.
    pub rows: Option<&'a EvaluationRows>,
    /// Illustrations of takes and training.
    pub illustrations: Option<&'a Illustrations>,
    /// Times of plans, where they are known: they differ from run to run, so not for a page that has to be the same each time.
    pub plan_times: &'a [PlanTimes],
    /// The steps that led here.
    pub provenance: &'a [Provenance],
}

/// Times of single plans of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanTimes {
    /// Method.
    pub method: String,
    /// Plans.
    pub n: usize,
    /// Median, milliseconds.
    pub p50_ms: f64,
    /// 95 % quantile, milliseconds.
    pub p95_ms: f64,
    /// Longest, milliseconds.
    pub max_ms: f64,
}

impl<'a> Report<'a> {
    /// A report of an evaluation alone.
    pub fn new(evaluation: &'a Evaluation, provenance: &'a [Provenance]) -> Self {
        Self {
            evaluation,
            rows: None,
            illustrations: None,
            plan_times: &[],
            provenance,
        }
    }
}

/// `evaluation.json`: pretty-printed, keys in a fixed order, `schema_version` first, numbers that
/// are not finite as `null`, a newline at the end. Lengths under keys that end in `_mm` are
/// millimetres, angles under keys that end in `_deg` degrees. The contract is `schemas/evaluation.schema.json`.
///
/// # Errors
///
/// [`ReportError::UnknownDefaultMethod`] or [`ReportError::DuplicateMethod`] where a reader could
/// not look a method up by its name.
pub fn evaluation_json(
    evaluation: &Evaluation,
    provenance: &[Provenance],
) -> Result<String, ReportError> {
    check_names(evaluation)?;
    json::write(evaluation, provenance)
}

/// Reads what [`evaluation_json`] wrote, for a page or a comparison made later. Numbers come back
/// to within the rounding of the change of unit; `null` comes back as NaN.
///
/// # Errors
///
/// [`ReportError::NotAnEvaluation`] with line and column for text that is no such document or has an
/// unknown word, [`ReportError::Version`] for one of another version, and as [`evaluation_json`].
pub fn read_evaluation_json(text: &str) -> Result<(Evaluation, Vec<Provenance>), ReportError> {
    let (evaluation, provenance) = json::read(text)?;
    check_names(&evaluation)?;
    Ok((evaluation, provenance))
}

/// The report as one HTML file that needs no network and no other file: figures are inline SVG, colours
/// follow the reader's light or dark scheme, and it prints. A script of its own, which the page's policy knows by
/// its hash, sorts tables and shows values under the pointer; without it the page says the same.
///
/// # Errors
///
/// [`ReportError::UnknownDefaultMethod`] or [`ReportError::DuplicateMethod`], as
/// [`evaluation_json`].
pub fn html(report: &Report<'_>) -> Result<String, ReportError> {
    Ok(html_and_figures(report)?.0)
}

/// Every figure of [`html`], in the order of the page, each to be written as a file: the drawing by
/// [`Figure::print_svg`], its numbers by [`FigureData::csv`].
///
/// # Errors
///
/// As [`html`].
pub fn figures(report: &Report<'_>) -> Result<Vec<Figure>, ReportError> {
    Ok(html_and_figures(report)?.1)
}

/// [`html`] and [`figures`] at once, which takes half the time of both.
///
/// # Errors
///
/// As [`html`].
pub fn html_and_figures(report: &Report<'_>) -> Result<(String, Vec<Figure>), ReportError> {
    check_names(report.evaluation)?;
    let (page, figures) = html::page(report);
    Ok((page.into_string(), figures))
}

/// The page of many sessions together, as self-contained as [`html`].
pub fn summary_html(summary: &Summary) -> String {
    html::summary::page(summary).into_string()
}

/// Many sessions as JSON, in the style of [`evaluation_json`]. Lengths under keys that end in `_mm` are millimetres.
///
/// # Errors
///
/// [`ReportError::Json`].
pub fn summary_json(summary: &Summary) -> Result<String, ReportError> {
    json::pretty(summary, "many sessions", None)
}

/// Two evaluations side by side as JSON.
///
/// # Errors
///
/// [`ReportError::Json`].
pub fn comparison_json(comparison: &EvaluationComparison) -> Result<String, ReportError> {
    json::pretty(comparison, &comparison.after.session, None)
}

/// The report in a few lines for a pull request or an issue: verdict, what is worrying, errors by method, differences from
/// the best baseline, what the data is worth. Names from files are text in it: they neither end a cell nor
/// begin a tag, a link or a mention.
///
/// # Errors
///
/// As [`html`].
pub fn markdown(report: &Report<'_>) -> Result<String, ReportError> {
    check_names(report.evaluation)?;
    Ok(text::markdown(report))
}

fn check_names(evaluation: &Evaluation) -> Result<(), ReportError> {
    let names = || evaluation.methods.iter().map(|method| method.name.as_str());
    for name in names() {
        let times = names().filter(|other| *other == name).count();
        if times > 1 {
            return Err(ReportError::DuplicateMethod {
                session: evaluation.session.name.clone(),
                name: name.to_owned(),
                times,
            });
        }
    }
    if names().any(|name| name == evaluation.default_method) {
        Ok(())
    } else {
        Err(ReportError::UnknownDefaultMethod {
            session: evaluation.session.name.clone(),
            name: evaluation.default_method.clone(),
            known: names().map(str::to_owned).collect(),
        })
    }
}
