//! Files of named arrays that belong to one run, with a checksum.
//!
//! Layout, little-endian: eight bytes `INHAND\0\1`; kind (16 bytes, padded with zeros); id of the run
//! (64 hexadecimal digits); start and round (u32 each); number of arrays (u32); for each its name
//! (u8 length, bytes), type (u8: 0 = f64, 1 = f32, 2 = u64) and number of elements (u64), then the
//! elements; at the end the SHA-256 of everything before.

use std::io::Write as _;
use std::path::Path;

use inhand_session::{SessionError, write_atomic, write_durable};
use sha2::{Digest, Sha256};

const MAGIC: &[u8; 8] = b"INHAND\0\x01";
const KIND_BYTES: usize = 16;
const ID_BYTES: usize = 64;
const CHECKSUM_BYTES: usize = 32;

/// What a file is, and what it belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Label {
    pub(crate) kind: &'static str,
    /// Id of the run.
    pub(crate) id: String,
    pub(crate) start: usize,
    pub(crate) round: usize,
}

/// Numbers of one kind.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Array {
    F64(Vec<f64>),
    F32(Vec<f32>),
    U64(Vec<u64>),
}

/// Named arrays in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Arrays(Vec<(String, Array)>);

impl Arrays {
    pub(crate) fn push(&mut self, name: &str, array: Array) {
        self.0.push((name.to_owned(), array));
    }

    pub(crate) fn push_f64(&mut self, name: &str, values: Vec<f64>) {
        self.push(name, Array::F64(values));
    }

    pub(crate) fn push_u64(&mut self, name: &str, values: impl IntoIterator<Item = usize>) {
        let values = values.into_iter().map(|v| v as u64).collect();
        self.push(name, Array::U64(values));
    }

    /// Takes an array out.
    pub(crate) fn take(&mut self, name: &str) -> Result<Array, String> {
        let place = self.0.iter().position(|(found, _)| found == name);
        match place {
            Some(place) => Ok(self.0.swap_remove(place).1),
            None => Err(format!("there is no array `{name}`")),
        }
    }

    pub(crate) fn take_f64(&mut self, name: &str) -> Result<Vec<f64>, String> {
        match self.take(name)? {
            Array::F64(values) => Ok(values),
            _ => Err(format!("array `{name}` is not of double precision")),
        }
    }

    pub(crate) fn take_u64(&mut self, name: &str) -> Result<Vec<usize>, String> {
        match self.take(name)? {
            Array::U64(values) => Ok(values.into_iter().map(|v| v as usize).collect()),
            _ => Err(format!("array `{name}` is not of whole numbers")),
        }
    }

    /// Takes out an array of one number.
    pub(crate) fn take_number(&mut self, name: &str) -> Result<f64, String> {
        match self.take_f64(name)?.as_slice() {
            [number] => Ok(*number),
            other => Err(format!(
                "`{name}` has {} numbers, expected one",
                other.len()
            )),
        }
    }
}

/// Writes arrays whole or not at all.
pub(crate) fn write(path: &Path, label: &Label, arrays: &Arrays) -> Result<(), SessionError> {
    let mut bytes = Vec::new();
    bytes.extend_from_slice(MAGIC);
    let mut kind = [0; KIND_BYTES];
    kind[..label.kind.len()].copy_from_slice(label.kind.as_bytes());
    bytes.extend_from_slice(&kind);
    bytes.extend_from_slice(label.id.as_bytes());
    for number in [label.start, label.round, arrays.0.len()] {
        bytes.extend_from_slice(&(number as u32).to_le_bytes());
    }
    for (name, array) in &arrays.0 {
        bytes.push(name.len() as u8);
        bytes.extend_from_slice(name.as_bytes());
        match array {
            Array::F64(values) => append(&mut bytes, 0, values, f64::to_le_bytes),
            Array::F32(values) => append(&mut bytes, 1, values, f32::to_le_bytes),
            Array::U64(values) => append(&mut bytes, 2, values, u64::to_le_bytes),
        }
    }
    let checksum = Sha256::digest(&bytes);
    // Tables are written again by the next `init`; all else a run cannot do without.
    let write = |out: &mut std::io::BufWriter<std::fs::File>| {
        out.write_all(&bytes)
            .and_then(|()| out.write_all(&checksum))
            .map_err(SessionError::io("write", path))
    };
    if label.kind == "table" {
        write_atomic(path, write)
    } else {
        write_durable(path, write)
    }
}

fn append<T: Copy, const N: usize>(
    bytes: &mut Vec<u8>,
    kind: u8,
    values: &[T],
    to_bytes: fn(T) -> [u8; N],
) {
    bytes.push(kind);
    bytes.extend_from_slice(&(values.len() as u64).to_le_bytes());
    bytes.reserve(N * values.len());
    for v in values {
        bytes.extend_from_slice(&to_bytes(*v));
    }
}

/// Reads a file that has to carry this label.
///
/// # Errors
///
/// [`SessionError::Data`] with what was found instead.
pub(crate) fn read(path: &Path, expected: &Label) -> Result<Arrays, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    parse(&bytes, expected).map_err(|message| SessionError::data(path, message))
}

fn parse(bytes: &[u8], expected: &Label) -> Result<Arrays, String> {
    let damaged = || {
        "the file is damaged or cut off (its checksum does not fit): sums are written again by \
         `inhand learn stats` once they are removed; anything else means to begin the run again"
            .to_owned()
    };
    if bytes.first_chunk() != Some(MAGIC) {
        return Err("expected a file of a learning folder, found something else".to_owned());
    }
    let (content, checksum) = bytes
        .split_last_chunk::<CHECKSUM_BYTES>()
        .ok_or_else(damaged)?;
    if Sha256::digest(content).as_slice() != checksum {
        return Err(damaged());
    }
    let mut rest = &content[MAGIC.len()..];
    let kind = text(take(&mut rest, KIND_BYTES).ok_or_else(damaged)?);
    let id = text(take(&mut rest, ID_BYTES).ok_or_else(damaged)?);
    let mut small = || take(&mut rest, 4)?.try_into().ok().map(u32::from_le_bytes);
    let numbers = (small(), small(), small());
    let (Some(start), Some(round), Some(count)) = numbers else {
        return Err(damaged());
    };
    let kind = kind.trim_end_matches('\0');
    if kind != expected.kind {
        return Err(format!("expected {}, found {kind}", expected.kind));
    }
    if id != expected.id {
        return Err(format!(
            "the file belongs to another run ({}..., this one is {}...): remove it, or name the \
             folder it came from",
            &id[..id.len().min(12)],
            &expected.id[..expected.id.len().min(12)]
        ));
    }
    let found = (start as usize, round as usize);
    if found != (expected.start, expected.round) {
        return Err(format!(
            "the file is of start {}, round {}: expected start {}, round {}",
            found.0, found.1, expected.start, expected.round
        ));
    }
    let mut arrays = Arrays::default();
    for _ in 0..count {
        let (name, array) = array(&mut rest).ok_or_else(damaged)?;
        arrays.push(&name, array);
    }
    Ok(arrays)
}

fn array(rest: &mut &[u8]) -> Option<(String, Array)> {
    let [name_length] = take(rest, 1)?.try_into().ok()?;
    let name = text(take(rest, usize::from(name_length))?);
    let [kind] = take(rest, 1)?.try_into().ok()?;
    let count = u64::from_le_bytes(take(rest, 8)?.try_into().ok()?);
    let count = usize::try_from(count).ok()?;
    let array = match kind {
        0 => Array::F64(elements(rest, count, f64::from_le_bytes)?),
        1 => Array::F32(elements(rest, count, f32::from_le_bytes)?),
        2 => Array::U64(elements(rest, count, u64::from_le_bytes)?),
        _ => return None,
    };
    Some((name, array))
}

fn elements<T, const N: usize>(
    rest: &mut &[u8],
    count: usize,
    of_bytes: fn([u8; N]) -> T,
) -> Option<Vec<T>> {
    let bytes = take(rest, count.checked_mul(N)?)?;
    let (chunks, _) = bytes.as_chunks::<N>();
    Some(chunks.iter().map(|chunk| of_bytes(*chunk)).collect())
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, left) = rest.split_at_checked(count)?;
    *rest = left;
    Some(taken)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::{Array, Arrays, Label, parse, read, write};

    fn label() -> Label {
        Label {
            kind: "sums",
            id: "0123456789abcdef".repeat(4),
            start: 1,
            round: 7,
        }
    }

    fn arrays() -> Arrays {
        let mut arrays = Arrays::default();
        arrays.push_f64("a", vec![1.5, f64::NAN, -0.0]);
        arrays.push("b", Array::F32(vec![0.25; 3]));
        arrays.push_u64("c", [1, 2, usize::MAX]);
        arrays
    }

    fn written() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.sums");
        write(&path, &label(), &arrays()).unwrap();
        assert!(read(&path, &label()).is_ok());
        std::fs::read(&path).unwrap()
    }

    #[test]
    fn what_is_written_comes_back() {
        let mut back = parse(&written(), &label()).unwrap();
        let a = back.take_f64("a").unwrap();
        assert_eq!((a[0], a[2].to_bits()), (1.5, (-0.0_f64).to_bits()));
        assert!(a[1].is_nan());
        assert_eq!(back.take("b"), Ok(Array::F32(vec![0.25; 3])));
        assert_eq!(back.take_u64("c"), Ok(vec![1, 2, usize::MAX]));
        assert!(back.take("a").is_err());
    }

    #[test]
    fn files_of_another_run_round_or_kind_are_told_apart() {
        let bytes = written();
        let other = |label: Label| parse(&bytes, &label).unwrap_err();
        let round = other(Label {
            round: 8,
            ..label()
        });
        assert_eq!(
            round,
            "the file is of start 1, round 7: expected start 1, round 8"
        );
        assert!(
            other(Label {
                kind: "state",
                ..label()
            })
            .contains("expected state, found sums")
        );
        let id = "f".repeat(64);
        assert!(other(Label { id, ..label() }).contains("another run (0123456789ab..."));
    }

    #[test]
    fn damage_is_found_wherever_it_is() {
        let bytes = written();
        for cut in 0..bytes.len() {
            assert!(parse(&bytes[..cut], &label()).is_err(), "cut at {cut}");
            let mut flipped = bytes.clone();
            flipped[cut] ^= 0x10;
            assert!(parse(&flipped, &label()).is_err(), "flipped at {cut}");
        }
    }
}
