//! The committed Rust code and descriptors are what `schemas/` says.

use std::path::{Path, PathBuf};

use prost::Message;
use prost_build::Module;

/// Set this to write the generated files instead of checking them.
const WRITE: &str = "INHAND_WRITE_SCHEMAS";

const COMMAND: &str = "INHAND_WRITE_SCHEMAS=1 cargo test -p inhand-channels schemas";

fn crate_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn schemas_folder() -> PathBuf {
    crate_folder().join("../../schemas")
}

/// Names such as `inhand/plan.proto`, in order.
fn proto_files() -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(schemas_folder().join("inhand"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".proto"))
        .map(|name| format!("inhand/{name}"))
        .collect();
    names.sort();
    names
}

fn check(name: &str, generated: &[u8]) {
    let path = crate_folder().join("src/generated").join(name);
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&path, generated).unwrap();
        return;
    }
    let committed = std::fs::read(&path).unwrap_or_default();
    assert!(
        committed == generated,
        "{} is not what schemas/inhand says; run: {COMMAND}",
        path.display()
    );
}

#[test]
fn generated_code_is_up_to_date() {
    let files = proto_files();
    assert!(files.len() > 5, "found {files:?}");
    let mut descriptors = protox::compile(&files, [schemas_folder()]).unwrap();
    let code = prost_build::Config::new()
        // Written by hand, for the reason given there.
        .extern_path(".inhand.Point", "crate::wire::Point")
        .extern_path(".inhand.Quaternion", "crate::wire::Quaternion")
        .extern_path(".google.protobuf.Timestamp", "crate::wire::Timestamp")
        .generate(
            descriptors
                .file
                .iter()
                .map(|file| {
                    (
                        Module::from_protobuf_package_name(file.package()),
                        file.clone(),
                    )
                })
                .collect(),
        )
        .unwrap();
    let code = &code[&Module::from_protobuf_package_name("inhand")];
    check("inhand.rs", code.as_bytes());

    // Comments stay out of the descriptors that every file carries.
    for file in &mut descriptors.file {
        file.source_code_info = None;
    }
    check("inhand.binpb", &descriptors.encode_to_vec());
}
