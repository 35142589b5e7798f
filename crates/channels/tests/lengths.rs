//! Records and chunks whose lengths lie: refused with the place, nothing allocated on their word.

use inhand_channels::{ChannelError, info};
use inhand_container::ContainerError;
use mcap::records::op;

/// A file of one record that gives its length as `length`.
fn file_with(opcode: u8, length: u64, body: &[u8]) -> Vec<u8> {
    let mut bytes = mcap::MAGIC.to_vec();
    bytes.push(opcode);
    bytes.extend(length.to_le_bytes());
    bytes.extend(body);
    bytes
}

/// A chunk of `records` that claims to hold `uncompressed` bytes of checksum `crc`.
fn chunk(compression: &str, uncompressed: u64, crc: u32, records: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 16];
    body.extend(uncompressed.to_le_bytes());
    body.extend(crc.to_le_bytes());
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend((records.len() as u64).to_le_bytes());
    body.extend(records);
    body
}

fn problem(bytes: &[u8]) -> ChannelError {
    info(bytes, "x.mcap").unwrap().problem.unwrap()
}

fn is_damaged_at_8(bytes: &[u8]) {
    let problem = problem(bytes);
    assert!(
        matches!(
            problem,
            ChannelError::Container(
                ContainerError::Damaged { offset: 8, .. }
                    | ContainerError::Memory { offset: 8, .. }
            )
        ),
        "{problem}"
    );
}

#[test]
fn absurd_lengths_are_refused_before_anything_is_allocated() {
    for compression in ["zstd", "lz4", "", "brotli"] {
        for uncompressed in [u64::MAX, 1 << 40, 1 << 31] {
            for crc in [0, 1] {
                let body = chunk(compression, uncompressed, crc, &[1, 2, 3, 4]);
                is_damaged_at_8(&file_with(op::CHUNK, body.len() as u64, &body));
            }
        }
    }
    let body = chunk("zstd", 10, 0, &[1, 2, 3, 4]);
    for length in [u64::MAX, u64::MAX - 1, u64::MAX - 9, 1 << 40] {
        for opcode in [op::CHUNK, op::MESSAGE, op::DATA_END, op::FOOTER, 0x80] {
            let problem = problem(&file_with(opcode, length, &body));
            assert!(
                matches!(
                    problem,
                    ChannelError::Container(ContainerError::Truncated { offset: 8, .. })
                ),
                "{problem}"
            );
        }
    }
}

#[test]
fn records_do_not_reach_past_their_chunk() {
    // A message that claims more bytes than the chunk has, some of which follow the chunk.
    for length in [30, 60, 1 << 40, u64::MAX - 8, u64::MAX] {
        let mut records = vec![op::MESSAGE];
        records.extend(u64::to_le_bytes(length));
        records.extend([0; 22]);
        for crc in [0, crc_of(&records)] {
            let mut body = chunk("", records.len() as u64, crc, &records);
            is_damaged_at_8(&file_with(op::CHUNK, body.len() as u64, &body));
            body.extend([0; 50]);
            is_damaged_at_8(&file_with(op::CHUNK, body.len() as u64, &body));
        }
    }
}

/// The checksum that the format prescribes, as the mcap crate finds it.
fn crc_of(records: &[u8]) -> u32 {
    let body = chunk("", records.len() as u64, 1, records);
    match problem(&file_with(op::CHUNK, body.len() as u64, &body)) {
        ChannelError::Container(ContainerError::Damaged { found, .. }) => {
            u32::from_str_radix(found.strip_prefix("CRC ").unwrap(), 16).unwrap()
        }
        other => panic!("{other}"),
    }
}

#[test]
fn short_records_are_refused() {
    let name = [&[0; 16][..], &[1, 0, 0, 0, b'a', 0, 0, 0, 0], &[0; 12]].concat();
    for end in 0..name.len() {
        is_damaged_at_8(&file_with(op::ATTACHMENT, end as u64, &name[..end]));
    }
    let sound = file_with(op::ATTACHMENT, name.len() as u64, &name);
    assert_eq!(info(&sound, "x").unwrap().attachments[0].name, "a");
    for opcode in [
        op::HEADER,
        op::FOOTER,
        op::SCHEMA,
        op::CHANNEL,
        op::MESSAGE,
        op::CHUNK,
        op::METADATA,
        op::DATA_END,
    ] {
        for length in [0, 1, 3] {
            is_damaged_at_8(&file_with(opcode, length, &[9; 3][..length as usize]));
        }
    }
}
