//! Fields of a record, one after the other, none past its end.

use std::collections::BTreeMap;

use crate::error::ChannelError;

/// What is left of a record's body.
pub(super) struct Fields<'a, 'f> {
    file: &'f str,
    record: &'static str,
    offset: u64,
    rest: &'a [u8],
}

impl<'a, 'f> Fields<'a, 'f> {
    pub(super) fn new(file: &'f str, record: &'static str, offset: u64, body: &'a [u8]) -> Self {
        Self {
            file,
            record,
            offset,
            rest: body,
        }
    }

    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub(super) fn error(&self, expected: String, found: String) -> ChannelError {
        ChannelError::Damaged {
            file: self.file.to_owned(),
            offset: self.offset,
            record: self.record.to_owned(),
            expected,
            found,
        }
    }

    fn take(&mut self, length: u64, what: &str) -> Result<&'a [u8], ChannelError> {
        let split = usize::try_from(length).ok();
        let split = split.and_then(|length| self.rest.split_at_checked(length));
        let Some((field, rest)) = split else {
            return Err(self.error(
                format!("{length} bytes of {what}"),
                format!("{} left in the record", self.rest.len()),
            ));
        };
        self.rest = rest;
        Ok(field)
    }

    fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], ChannelError> {
        let field = self.take(N as u64, what)?;
        Ok(field
            .try_into()
            .expect("take gives as many bytes as asked for"))
    }

    pub(super) fn u16(&mut self, what: &str) -> Result<u16, ChannelError> {
        self.array(what).map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self, what: &str) -> Result<u32, ChannelError> {
        self.array(what).map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self, what: &str) -> Result<u64, ChannelError> {
        self.array(what).map(u64::from_le_bytes)
    }

    pub(super) fn skip(&mut self, length: u64, what: &str) -> Result<(), ChannelError> {
        self.take(length, what).map(|_| ())
    }

    /// Bytes after their length in 64 bits.
    pub(super) fn bytes(&mut self, what: &str) -> Result<&'a [u8], ChannelError> {
        let length = self.u64(what)?;
        self.take(length, what)
    }

    /// Text after its length in 32 bits.
    pub(super) fn string(&mut self, what: &str) -> Result<String, ChannelError> {
        let length = self.u32(what)?;
        let text = self.take(length.into(), what)?;
        String::from_utf8(text.to_vec())
            .map_err(|error| self.error(format!("{what} in UTF-8"), error.to_string()))
    }

    /// Pairs of texts after their length together in 32 bits.
    pub(super) fn string_map(
        &mut self,
        what: &str,
    ) -> Result<BTreeMap<String, String>, ChannelError> {
        let length = self.u32(what)?;
        let pairs = self.take(length.into(), what)?;
        let mut pairs = Fields::new(self.file, self.record, self.offset, pairs);
        let mut map = BTreeMap::new();
        while !pairs.rest.is_empty() {
            let key = pairs.string(what)?;
            map.insert(key, pairs.string(what)?);
        }
        Ok(map)
    }
}
