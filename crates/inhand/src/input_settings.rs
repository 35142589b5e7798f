//! Settings for inputs: typed options, over the settings file that is named or of their session, over what they store.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_session::{Role, SETTINGS_FILE, Settings, is_take};

use crate::console::Console;
use crate::exit::usage;
use crate::options::{SourceOptions, TakeOptions};
use crate::output::reads;

impl SourceOptions {
    /// The settings file for inputs: the one that is named, else that of their session, which is printed.
    pub(crate) fn file(&self, console: &Console, inputs: &[&Path]) -> Result<Option<PathBuf>> {
        if self.settings.is_some() {
            let named = self.named().map(Path::to_owned);
            reads(named.as_slice());
            return Ok(named);
        }
        let found = settings_beside(inputs)?;
        reads(found.as_slice());
        if let Some(file) = &found {
            console.say_once(&format!("settings  {}", file.display()));
        }
        Ok(found)
    }

    /// Settings for inputs together: those that they store, under a settings file, under these options and what
    /// `typed` sets.
    pub(crate) fn layered(
        &self,
        (inputs, file): (&[&Path], Option<&Path>),
        unused: &[&str],
        typed: &dyn Fn(&mut Settings),
    ) -> Result<Settings> {
        let inputs = match self.settings.is_some() && self.named().is_none() {
            true => &[],
            false => inputs,
        };
        Ok(Settings::layered(inputs, file, unused, &|settings| {
            // The session's name and takes are not those of the inputs.
            if self.settings.is_none() {
                settings.name = None;
                settings.takes.clear();
            }
            self.apply(settings);
            typed(settings);
        })?)
    }

    /// Settings for inputs that are used together. What they store of the keys in `unused` does not count.
    pub(crate) fn for_all(
        &self,
        console: &Console,
        inputs: &[impl AsRef<Path>],
        unused: &[&str],
        typed: &dyn Fn(&mut Settings),
    ) -> Result<Settings> {
        let inputs: Vec<&Path> = inputs.iter().map(AsRef::as_ref).collect();
        let file = self.file(console, &inputs)?;
        self.layered((&inputs, file.as_deref()), unused, typed)
    }

    /// Settings for inputs that are used one at a time.
    pub(crate) fn for_each(
        &self,
        console: &Console,
        inputs: &[PathBuf],
        typed: &dyn Fn(&mut Settings),
    ) -> Result<Vec<Settings>> {
        let inputs = inputs.chunks(1);
        inputs
            .map(|input| self.for_all(console, input, &[], typed))
            .collect()
    }
}

impl TakeOptions {
    /// The settings of [`SourceOptions::for_all`] with all of these options on top.
    pub(crate) fn for_all(
        &self,
        console: &Console,
        inputs: &[PathBuf],
        unused: &[&str],
        typed: &dyn Fn(&mut Settings),
    ) -> Result<Settings> {
        self.source.for_all(console, inputs, unused, &|settings| {
            self.apply(settings);
            typed(settings);
        })
    }
}

/// The settings file of the session that these files are in. Sessions of other settings are refused.
fn settings_beside(inputs: &[&Path]) -> Result<Option<PathBuf>> {
    let mut files = inputs
        .iter()
        .filter_map(|input| Some((input, settings_of(input)?)));
    let Some((_, first)) = files.next() else {
        return Ok(None);
    };
    // A file that cannot be read is reported where it is used.
    let text = std::fs::read(&first).unwrap_or_default();
    match files.find(|(_, file)| std::fs::read(file).unwrap_or_default() != text) {
        None => Ok(Some(first)),
        Some((input, other)) => usage(format!(
            "{}: its settings are {}, but those of other inputs are {}: name a file with --settings, or none",
            input.display(),
            other.display(),
            first.display()
        )),
    }
}

/// The settings file of the session that a file is in, or is itself: in its folder, or in the folder above `train/` or
/// `test/`.
fn settings_of(input: &Path) -> Option<PathBuf> {
    if is_settings(input) {
        return Some(input.to_owned());
    }
    let folder = match input.is_dir() && !is_take(input) {
        true => input,
        false => input.parent()?,
    };
    let absolute = std::path::absolute(Path::new(".").join(folder)).ok()?;
    let is_role = |role: Role| absolute.file_name().is_some_and(|name| name == role.name());
    let above = match folder.file_name() {
        Some(_) => folder.parent(),
        None => absolute.parent(),
    };
    let above = above.filter(|_| is_role(Role::Train) || is_role(Role::Test));
    let folders = [Some(folder), above].into_iter().flatten();
    let mut files = folders.map(|folder| folder.join(SETTINGS_FILE));
    files.find(|file| file.is_file())
}

/// Whether an input is a session by its settings file.
pub(crate) fn is_settings(input: &Path) -> bool {
    (input.extension()).is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}
