#![no_main]

use std::io::{Cursor, Write};

use flate2::{Compression, write::ZlibEncoder};
use inhand_fuzz::documents::check_matrices;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

// The first byte says what follows: a whole file, an array that is to be a member of an archive, or a variable that is
// to be packed, so that changes get past checksums and packing.
libfuzzer_sys::fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    match kind {
        0 => check_matrices(bytes),
        1 => check_matrices(&npz(bytes)),
        _ => check_matrices(&mat(bytes)),
    }
});

fn npz(array: &[u8]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for name in ["primitives.npy", "b.npy"] {
        zip.start_file(name, stored).expect("a member");
        zip.write_all(array).expect("memory takes all");
    }
    zip.finish().expect("an archive").into_inner()
}

fn mat(variable: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(variable).expect("memory takes all");
    let packed = encoder.finish().expect("memory takes all");
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    file.extend(15_u32.to_le_bytes());
    file.extend((packed.len() as u32).to_le_bytes());
    file.extend(packed);
    file
}
