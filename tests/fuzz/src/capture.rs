//! Checks of the readers of vendor files.

use inhand_capture::{Blocks, CaptureError, Extent, ReadSettings, has_even_rows, read};
use inhand_model::{LengthUnit, Recording, RotationOrder, UpAxis};

/// Facts for files that do not state them.
const FACTS: ReadSettings = ReadSettings {
    length_unit: Some(LengthUnit::Millimetres),
    rotation_order: Some(RotationOrder::Quaternion),
    up_axis: Some(UpAxis::Z),
};

/// Reads a file whole and in blocks, and compares.
///
/// # Panics
///
/// Where the two ways differ.
pub fn check(bytes: &[u8]) {
    let none = ReadSettings::default();
    for settings in [none, FACTS] {
        let whole = read(bytes, "take.csv", &settings);
        if has_even_rows(bytes) {
            let blocks = in_blocks(bytes, &settings);
            match (&whole, &blocks) {
                (Ok(whole), Ok((samples, bits))) => {
                    assert_eq!(whole.len(), *samples, "samples");
                    assert_eq!(&bits_of(whole), bits, "numbers");
                }
                (Err(whole), Err(blocks)) => assert_eq!(whole.to_string(), blocks.to_string()),
                _ => panic!("whole {whole:?}, in blocks {blocks:?}"),
            }
        }
        if whole.is_ok() {
            return;
        }
    }
}

fn in_blocks(
    bytes: &[u8],
    settings: &ReadSettings,
) -> Result<(usize, Vec<Vec<u64>>), CaptureError> {
    let mut extent = Extent::default();
    extent.add(bytes);
    let mut blocks = Blocks::open(bytes, extent, "take.csv", settings)?;
    let (mut samples, mut bits) = (0, bits_of(blocks.header()));
    while let Some(block) = blocks.next_block()? {
        samples += block.len();
        for (all, more) in bits.iter_mut().zip(bits_of(&block)) {
            all.extend(more);
        }
    }
    Ok((samples, bits))
}

/// Coordinates of each marker and body, bit by bit.
fn bits_of(recording: &Recording) -> Vec<Vec<u64>> {
    let markers = recording.markers.iter().map(|marker| {
        let samples = marker.track.iter().flatten();
        samples
            .flat_map(|at| at.to_array().map(f64::to_bits))
            .collect()
    });
    let bodies = recording.bodies.iter().map(|body| {
        let samples = body.track.iter().flatten();
        samples
            .flat_map(|pose| pose.origin().to_array().map(f64::to_bits))
            .collect()
    });
    markers.chain(bodies).collect()
}
