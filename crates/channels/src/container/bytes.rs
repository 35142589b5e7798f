//! Fields and records as bytes, and a writer that keeps place and checksum.

use std::collections::BTreeMap;
use std::io::{self, Write};

/// Appends a record; `fill` appends its body.
pub(super) fn record(out: &mut Vec<u8>, opcode: u8, fill: impl FnOnce(&mut Vec<u8>)) {
    out.push(opcode);
    let length_at = out.len();
    out.extend([0; 8]);
    let body_at = out.len();
    fill(out);
    let length = (out.len() - body_at) as u64;
    out[length_at..body_at].copy_from_slice(&length.to_le_bytes());
}

/// Bytes after their length in 32 bits. Longer ones than that are no text and no schema of ours.
pub(super) fn put_bytes(out: &mut Vec<u8>, bytes: &[u8]) {
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend_from_slice(bytes);
}

/// Text after its length in 32 bits.
pub(super) fn put_string(out: &mut Vec<u8>, text: &str) {
    put_bytes(out, text.as_bytes());
}

/// Pairs of texts after their length together in 32 bits.
pub(super) fn put_map(out: &mut Vec<u8>, map: &BTreeMap<String, String>) {
    let mut pairs = Vec::new();
    for (key, value) in map {
        put_string(&mut pairs, key);
        put_string(&mut pairs, value);
    }
    put_bytes(out, &pairs);
}

/// A writer that knows how many bytes went through it, and their CRC.
pub(super) struct Checked<W> {
    inner: W,
    position: u64,
    hasher: crc32fast::Hasher,
}

impl<W: Write> Checked<W> {
    pub(super) fn new(inner: W) -> Self {
        Self {
            inner,
            position: 0,
            hasher: crc32fast::Hasher::new(),
        }
    }

    pub(super) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.inner.write_all(bytes)?;
        self.hasher.update(bytes);
        self.position += bytes.len() as u64;
        Ok(())
    }

    pub(super) fn position(&self) -> u64 {
        self.position
    }

    pub(super) fn crc(&self) -> u32 {
        self.hasher.clone().finalize()
    }

    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
