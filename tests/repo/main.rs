//! Rules of the repository: which crate may use which, and who alone may know what.

mod house;
mod source;

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

/// Folder under `crates/` and the folders it may use. Kept as the table in `docs/architecture.md`.
const EDGES: [(&str, &[&str]); 22] = [
    ("model", &[]),
    ("parallel", &[]),
    ("statistics", &["model"]),
    ("curves", &["model"]),
    ("capture", &["model"]),
    ("container", &[]),
    ("channels", &["model", "container"]),
    ("import", &["model", "container", "channels"]),
    ("export", &["model", "container"]),
    ("motion", &["model"]),
    ("inspection", &["model", "statistics", "motion"]),
    ("dictionary", &["model"]),
    ("contact", &["model"]),
    ("planner", &["model", "contact"]),
    (
        "evaluation",
        &["model", "parallel", "curves", "statistics", "contact"],
    ),
    ("report", &["model"]),
    ("simulation", &["model", "parallel", "contact"]),
    ("live", &["container"]),
    ("viewing", &["model", "channels"]),
    (
        "session",
        &[
            "model",
            "parallel",
            "curves",
            "statistics",
            "capture",
            "channels",
            "import",
            "container",
            "export",
            "motion",
            "inspection",
            "dictionary",
            "contact",
            "planner",
            "evaluation",
            "report",
            "simulation",
        ],
    ),
    (
        "training",
        &["model", "parallel", "motion", "dictionary", "session"],
    ),
    (
        "inhand",
        &[
            "model",
            "curves",
            "statistics",
            "capture",
            "channels",
            "import",
            "container",
            "export",
            "motion",
            "inspection",
            "dictionary",
            "contact",
            "planner",
            "evaluation",
            "report",
            "simulation",
            "live",
            "viewing",
            "session",
            "training",
        ],
    ),
];

/// A library and the crates that know it: one, but for the container format, which one crate copies
/// and the other fills.
const USERS: [(&str, &[&str]); 14] = [
    ("mcap", &["channels", "container"]),
    ("lz4_flex", &["container"]),
    ("zstd", &["container"]),
    ("crc32fast", &["container"]),
    ("prost", &["channels", "import"]),
    ("foxglove", &["channels", "import"]),
    ("parquet", &["export"]),
    ("flate2", &["export"]),
    ("zip", &["export"]),
    ("parry3d-f64", &["contact"]),
    ("clarabel", &["planner"]),
    ("tungstenite", &["live"]),
    ("rustix", &["inhand"]),
    ("signal-hook", &["inhand"]),
];

/// Normal dependencies of each workspace crate, by folder.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--no-deps",
            "--format-version",
            "1",
            "--offline",
        ])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs: it runs this test");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let packages = metadata["packages"]
        .as_array()
        .expect("metadata lists packages");
    packages
        .iter()
        .map(|package| {
            let used = package["dependencies"]
                .as_array()
                .expect("a package lists dependencies");
            let names = used
                .iter()
                .filter(|d| d["kind"].is_null())
                .map(|d| text(&d["name"]));
            (
                folder(&text(&package["name"])),
                names.map(|name| folder(&name)).collect(),
            )
        })
        .collect()
}

#[test]
fn the_oldest_toolchain_builds_every_crate() {
    let rustc = Command::new("rustc").arg("-vV").output();
    let rustc = String::from_utf8(rustc.expect("rustc runs").stdout).expect("text");
    let host = rustc.lines().find_map(|line| line.strip_prefix("host: "));
    // Crates of other systems need not be there.
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--offline"])
        .args(["--filter-platform", host.expect("rustc names its host")])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs: it runs this test");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let version = |package: &Value| -> Vec<u32> {
        let stated = package["rust_version"].as_str().unwrap_or("1.0");
        let parts = stated
            .split('.')
            .map(|part| part.parse().expect("a number"));
        parts.chain([0, 0]).take(3).collect()
    };
    let packages = metadata["packages"]
        .as_array()
        .expect("metadata lists packages");
    let ours = |package: &&Value| package["name"] == "inhand";
    let oldest = packages.iter().find(ours).map(version);
    let newer: Vec<_> = (packages.iter())
        .filter(|package| Some(version(package)) > oldest)
        .map(|package| (&package["name"], &package["rust_version"]))
        .collect();
    assert!(
        newer.is_empty(),
        "rust-version in Cargo.toml is older than that of {newer:?}"
    );
}

fn text(value: &Value) -> String {
    value.as_str().expect("names are strings").to_owned()
}

/// `inhand-model` is in the folder `model`; names of other packages stay.
fn folder(package: &str) -> String {
    package
        .strip_prefix("inhand-")
        .unwrap_or(package)
        .to_owned()
}

#[test]
fn crates_use_only_what_the_table_allows() {
    let found = dependencies();
    let table: BTreeMap<_, _> = EDGES.into_iter().collect();
    let names: BTreeSet<_> = found.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        table.keys().copied().collect(),
        "every crate is in the table"
    );
    for (name, used) in &found {
        let ours = used
            .iter()
            .map(String::as_str)
            .filter(|used| table.contains_key(used));
        let allowed: BTreeSet<_> = table[name.as_str()].iter().copied().collect();
        let forbidden: Vec<_> = ours.filter(|used| !allowed.contains(used)).collect();
        assert!(forbidden.is_empty(), "{name} must not use {forbidden:?}");
    }
}

#[test]
fn libraries_have_the_users_they_should() {
    let found = dependencies();
    for (library, owners) in USERS {
        let users: Vec<_> = found
            .iter()
            .filter(|(_, used)| used.contains(library))
            .map(|(name, _)| name)
            .collect();
        assert_eq!(users, owners, "{library} is known to {owners:?} alone");
    }
}

#[test]
fn the_table_stands_in_the_documentation() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/architecture.md");
    let page = std::fs::read_to_string(path).expect("docs/architecture.md is there");
    for (name, _) in EDGES {
        assert!(
            page.contains(&format!("| `{name}` |")),
            "docs/architecture.md lists {name}"
        );
    }
}
