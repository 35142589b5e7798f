//! Changes that a cut makes to the file of a take.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use inhand_channels::{Metadata, TakeCut, cut_take};
use inhand_container::Interval;
use inhand_model::{InputHash, Provenance};
use serde_json::json;
use sha2::{Digest, Sha256};

use super::name_of;
use crate::error::{Located, SessionError};
use crate::run::TOOL;

/// `None` for a file without a take.
pub(super) fn cut(
    input: &Path,
    metadata: &Metadata,
    stretches: &[Interval],
) -> Result<Option<TakeCut>, SessionError> {
    if !metadata.0.contains_key(super::RECORDING) {
        return Ok(None);
    }
    let settings: Vec<_> = (stretches.iter())
        .map(|stretch| {
            json!({
                "from_unix_nanos": stretch.from_unix_nanos(),
                "to_unix_nanos": stretch.to_unix_nanos(),
            })
        })
        .collect();
    let made = Provenance {
        tool: TOOL.to_owned(),
        step: "cut".to_owned(),
        settings_json: json!({ "keep": settings }).to_string(),
        inputs: vec![InputHash {
            name: name_of(input),
            sha256: sha256(input)?,
        }],
    };
    cut_take(metadata, &name_of(input), stretches, &made).in_file(input)
}

/// Of a file of any size.
pub(crate) fn sha256(path: &Path) -> Result<String, SessionError> {
    let unreadable = |error| SessionError::io("read", path)(error);
    let mut file = File::open(path).map_err(unreadable)?;
    let (mut hash, mut piece) = (Sha256::new(), vec![0; 1 << 20]);
    loop {
        let read = file.read(&mut piece).map_err(unreadable)?;
        if read == 0 {
            break;
        }
        hash.update(&piece[..read]);
    }
    Ok(hash
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect())
}
