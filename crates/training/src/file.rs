//! Files of a learning folder: a value under the label of its run, with a checksum.
//!
//! Layout: eight bytes `INHAND\0\2`, label and value as `postcard` writes them, and the SHA-256 of everything
//! before.

use std::fs::File;
use std::io::{BufRead as _, BufReader, BufWriter, Read as _, Write as _};
use std::path::Path;

use inhand_session::{SessionError, write_whole};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

const MAGIC: &[u8; 8] = b"INHAND\0\x02";
const CHECKSUM_BYTES: usize = 32;

/// Kind of a file and the round it belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Label {
    pub(crate) kind: String,
    /// Id of the run.
    pub(crate) id: String,
    pub(crate) start: usize,
    pub(crate) round: usize,
}

/// Writes a value whole or not at all. With `durable` it outlasts a crash of the machine.
pub(crate) fn write(
    path: &Path,
    label: &Label,
    value: &impl Serialize,
    durable: bool,
) -> Result<(), SessionError> {
    let bytes = record(path, label, value)?;
    write_bytes(path, |out| out.write_all(&bytes), durable)
}

/// Writes values one after the other, each as a file of its own would be, after its length.
pub(crate) fn write_parts(
    path: &Path,
    parts: impl Iterator<Item = (Label, impl Serialize)>,
) -> Result<(), SessionError> {
    write_bytes(
        path,
        |out| {
            for (label, value) in parts {
                let bytes = record(path, &label, &value).map_err(std::io::Error::other)?;
                out.write_all(&(bytes.len() as u64).to_le_bytes())?;
                out.write_all(&bytes)?;
            }
            Ok(())
        },
        false,
    )
}

fn record(path: &Path, label: &Label, value: &impl Serialize) -> Result<Vec<u8>, SessionError> {
    let bytes = postcard::to_extend(&(label, value), MAGIC.to_vec());
    let mut bytes = bytes.map_err(|error| SessionError::data(path, error.to_string()))?;
    bytes.extend(Sha256::digest(&bytes));
    Ok(bytes)
}

fn write_bytes(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
    durable: bool,
) -> Result<(), SessionError> {
    write_whole(
        path,
        |out| write(out).map_err(SessionError::io("write", path)),
        durable,
    )
}

/// Reads the value of a file that has to carry this label.
///
/// # Errors
///
/// [`SessionError::Data`] with what was found instead.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, expected: &Label) -> Result<T, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    parse(&bytes, expected).map_err(|message| SessionError::data(path, message))
}

/// Reads values that were written one after the other; each has to carry the label of its number.
///
/// # Errors
///
/// As [`read`]. A file that ends after some of its values is not noticed.
pub(crate) fn read_parts<T: DeserializeOwned>(
    path: &Path,
    expected: impl Fn(usize) -> Label,
    mut each: impl FnMut(T),
) -> Result<(), SessionError> {
    let io = |error| SessionError::io("read", path)(error);
    let mut file = BufReader::new(File::open(path).map_err(io)?);
    for part in 0.. {
        if file.fill_buf().map_err(io)?.is_empty() {
            break;
        }
        let mut len = [0; 8];
        let whole = (file.read_exact(&mut len).ok()).map(|()| u64::from_le_bytes(len));
        let mut bytes = Vec::new();
        // A wrong length reads what there is, which then fits no checksum.
        let limit = whole.unwrap_or_default();
        file.by_ref()
            .take(limit)
            .read_to_end(&mut bytes)
            .map_err(io)?;
        let value = parse(&bytes, &expected(part));
        each(value.map_err(|message| SessionError::data(path, message))?);
    }
    Ok(())
}

fn damaged() -> String {
    "the file is damaged or cut off (its checksum does not fit): sums are written again by \
     `inhand learn stats` once they are removed; anything else means to begin the run again"
        .to_owned()
}

fn parse<T: DeserializeOwned>(bytes: &[u8], expected: &Label) -> Result<T, String> {
    postcard::from_bytes(value_of(bytes, expected)?).map_err(|_| damaged())
}

fn value_of<'a>(bytes: &'a [u8], expected: &Label) -> Result<&'a [u8], String> {
    if bytes.first_chunk() != Some(MAGIC) {
        return Err("expected a file of a learning folder, found something else".to_owned());
    }
    let (content, checksum) = bytes
        .split_last_chunk::<CHECKSUM_BYTES>()
        .ok_or_else(damaged)?;
    if Sha256::digest(content).as_slice() != checksum {
        return Err(damaged());
    }
    let (found, value) =
        postcard::take_from_bytes::<Label>(&content[MAGIC.len()..]).map_err(|_| damaged())?;
    if found.kind != expected.kind {
        return Err(format!("expected {}, found {}", expected.kind, found.kind));
    }
    if found.id != expected.id {
        return Err(format!(
            "the file belongs to another run ({:.12}..., this one is {:.12}...): remove it, or name the \
             folder it came from",
            found.id, expected.id
        ));
    }
    if found != *expected {
        return Err(format!(
            "the file is of start {}, round {}: expected start {}, round {}",
            found.start, found.round, expected.start, expected.round
        ));
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::{Label, parse, read, write};

    type Value = (Vec<f64>, Vec<f32>, Vec<usize>);

    fn label() -> Label {
        Label {
            kind: "sums".to_owned(),
            id: "0123456789abcdef".repeat(4),
            start: 1,
            round: 7,
        }
    }

    fn written() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.sums");
        let value = (
            vec![1.5, f64::NAN, -0.0],
            vec![0.25_f32; 3],
            vec![1, 2, usize::MAX],
        );
        write(&path, &label(), &value, true).unwrap();
        assert!(read::<Value>(&path, &label()).is_ok());
        std::fs::read(&path).unwrap()
    }

    #[test]
    fn what_is_written_comes_back() {
        let (a, b, c) = parse::<Value>(&written(), &label()).unwrap();
        assert_eq!((a[0], a[2].to_bits()), (1.5, (-0.0_f64).to_bits()));
        assert!(a[1].is_nan());
        assert_eq!((b, c), (vec![0.25; 3], vec![1, 2, usize::MAX]));
    }

    #[test]
    fn files_of_another_run_round_or_kind_are_told_apart() {
        let bytes = written();
        let other = |label: Label| parse::<Value>(&bytes, &label).unwrap_err();
        let round = other(Label {
            round: 8,
            ..label()
        });
        assert_eq!(
            round,
            "the file is of start 1, round 7: expected start 1, round 8"
        );
        let kind = "state".to_owned();
        assert!(other(Label { kind, ..label() }).contains("expected state, found sums"));
        let id = "f".repeat(64);
        assert!(other(Label { id, ..label() }).contains("another run (0123456789ab..."));
    }

    #[test]
    fn damage_is_found_wherever_it_is() {
        let bytes = written();
        for cut in 0..bytes.len() {
            assert!(
                parse::<Value>(&bytes[..cut], &label()).is_err(),
                "cut at {cut}"
            );
            let mut flipped = bytes.clone();
            flipped[cut] ^= 0x10;
            assert!(
                parse::<Value>(&flipped, &label()).is_err(),
                "flipped at {cut}"
            );
        }
    }
}
