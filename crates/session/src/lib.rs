//! The steps from session to report in order, with files; the facade for library users.
//!
//! A session is a folder with takes; [`run()`] turns it into one MCAP file per take, a dictionary,
//! `evaluation.json` and `report.html`. The same on values, without any file, is in [`steps`].
//!
//! ```no_run
//! use inhand_session::{OutputScope, RunOptions, Settings, run};
//!
//! let mut settings = Settings::default();
//! settings.object.shape = Some("cube:0.05".into());
//! let options = RunOptions {
//!     folder: "session".into(),
//!     settings,
//!     output: "results".into(),
//!     force: false,
//!     scope: OutputScope::default(),
//!     command: Vec::new(),
//! };
//! let result = run(&options, &mut |_| ())?;
//! println!("{}", result.files.report.display());
//! # Ok::<(), inhand_session::SessionError>(())
//! ```

pub mod annotate;
mod check;
mod clean;
pub mod containers;
mod demo;
mod dictionary_file;
mod error;
mod figures;
mod files;
mod found_events;
mod hand_state;
mod long_take;
mod look;
mod manifest;
pub mod matrices;
mod methods;
mod output;
pub mod overlay;
mod plan;
mod ros2;
mod run;
mod scope;
mod session;
pub mod sessions;
mod settings;
pub mod steps;
mod stored;
pub mod tables;
mod take;
mod take_file;
mod verify;
mod view;

pub use check::check_take;
pub use clean::{clean_take, write_cleaned};
pub use demo::{DEMO_SESSION, TakeFormat, simulate_session};
pub use dictionary_file::{DictionaryFile, read as read_dictionary, write as write_dictionary};
pub use error::{Located, SessionError};
pub use figures::write_figures;
pub use files::{hex_sha256, open_take, take_files, take_name};
pub use hand_state::{HandState, StateRole, read_state, state_file};
/// File of facts that makes a folder a ROS 2 bag.
pub use inhand_import::BAG_FACTS;
pub use inhand_motion::GapFill;
pub use long_take::{LongTake, TakeInput};
pub use look::look_at_training;
pub use manifest::{PlanMs, RunJson, peak_memory_bytes, plan_times_beside, results_key};
pub use methods::Method;
pub use output::{
    FolderClaim, Unfinished, already_exists, check_target, claim_folder, is_stream,
    remove_unfinished, same_file, scratch_folder, write_atomic, write_text, write_whole,
};
pub use plan::{MetTarget, PlanRequest, Planned, plan_motion, write_plan};
pub use ros2::write_ros2;
pub use run::{Event, RunFiles, RunOptions, RunResult, provenance, run};
pub use scope::OutputScope;
pub use session::{SETTINGS_FILE, Session, SessionPlace, SessionTake, is_take, list_takes, locate};
pub use settings::{
    BodySettings, CleanSection, EndsKind, EvaluateSection, FilterKind, LearnSection, LookSection,
    ObjectInSegments, ObjectSettings, PlanSection, ProcessSection, Role, SegmentSection,
    SelectSection, Settings, SourceSettings, TakeEntry,
};
pub use stored::{StoredEvaluation, StoredRows, evaluate_stored, generated_by};
pub use take::{Cleaning, Take, check_rates, hash_take, read, read_clean, read_session};
pub use take_file::{
    GeneratedMotion, MotionSource, TakeContents, TakeGenerators, write as write_take,
    write_parts as write_take_parts,
};
pub use verify::{InputFiles, Verified, verifiable, verify};
pub use view::{Viewed, ViewedKind, add_views};

/// Name and version of the tool, as written into files.
pub const TOOL: &str = concat!("inhand ", env!("CARGO_PKG_VERSION"));
