use inhand_export::matrices::read;
use proptest::prelude::*;

use crate::files::{BIG_ENDIAN_MAT, PACKED_MAT, PACKED_NPZ, STORED_MAT, STORED_NPZ};

const FILES: [&[u8]; 5] = [
    STORED_NPZ,
    PACKED_NPZ,
    STORED_MAT,
    PACKED_MAT,
    BIG_ENDIAN_MAT,
];

fn refused(bytes: &[u8]) -> String {
    read(bytes, "a.mat").unwrap_err().to_string()
}

#[test]
fn other_files_are_refused_with_what_to_do() {
    for (bytes, expected) in [
        (&b""[..], "found nothing"),
        (b"Format Version,1.23", "found \"Format Versi\""),
        (include_bytes!("reference/single.npy"), "numpy.savez"),
        (include_bytes!("reference/level_4.mat"), "save -v7"),
        (b"\x89HDF\r\n\x1a\n...", "save -v7"),
    ] {
        let error = refused(bytes);
        assert!(
            error.starts_with("a.mat: ") && error.contains(expected),
            "{error}"
        );
    }
    // MATLAB puts a text of its own and padding in front of HDF5.
    let mut newest = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".to_vec();
    newest.resize(124, b' ');
    newest.extend(b"\x00\x02IM");
    newest.resize(512, 0);
    newest.extend(b"\x89HDF\r\n\x1a\n");
    let error = refused(&newest);
    assert!(error.contains("MATLAB 7.3"), "{error}");
}

#[test]
fn errors_name_the_variable() {
    // The numbers of the first variable are cut.
    let error = refused(&STORED_MAT[..190]);
    assert!(error.contains("variable at byte 128"), "{error}");
    // Sizes that are not those of the numbers: 2 x 3 becomes 2 x 4.
    let mut bytes = STORED_MAT.to_vec();
    let sizes = [2, 0, 0, 0, 3, 0, 0, 0];
    let at = bytes.windows(8).position(|window| window == sizes).unwrap();
    bytes[at + 4] = 4;
    let error = refused(&bytes);
    assert!(
        error.contains("variable w: expected 8 numbers of 8 bytes, found 48 bytes"),
        "{error}"
    );
    // One bit of the packed numbers.
    let mut bytes = PACKED_NPZ.to_vec();
    bytes[150] ^= 1;
    let error = read(&bytes, "a.npz").unwrap_err().to_string();
    assert!(error.contains("variable c_order"), "{error}");
}

#[test]
fn sizes_that_no_memory_has_are_refused() {
    let (start, end) = (
        b"'shape': (2, 3), }",
        b"'shape': (9223372036854775807, 3), }",
    );
    let at = (STORED_NPZ.windows(start.len())).position(|window| window == start);
    let at = at.unwrap();
    // The archive is not right any more, but the header is what is looked at first.
    let mut bytes = STORED_NPZ.to_vec();
    bytes[at..at + end.len()].copy_from_slice(end);
    assert!(read(&bytes, "a.npz").is_err());
    let mut bytes = STORED_MAT.to_vec();
    let at = bytes
        .windows(8)
        .position(|window| window == [2, 0, 0, 0, 3, 0, 0, 0]);
    bytes[at.unwrap()..][..8].copy_from_slice(&[0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF, 0x7F]);
    assert!(refused(&bytes).contains("variable w"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn changed_and_cut_files_never_panic(
        which in 0..FILES.len(),
        changes in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 0..5),
        end in 0.0..1.5_f64,
    ) {
        let mut bytes = FILES[which].to_vec();
        for (share, value) in changes {
            let place = (share * bytes.len() as f64) as usize;
            bytes[place] = value;
        }
        bytes.truncate((end * bytes.len() as f64) as usize);
        let _ = read(&bytes, "changed");
    }

    #[test]
    fn one_changed_bit_of_packed_numbers_never_goes_unnoticed(share in 0.0..1.0_f64) {
        // The archive's first array, behind the header of its entry.
        let first = 30 + "c_order.npy".len() + 20;
        let mut bytes = PACKED_NPZ.to_vec();
        bytes[first + (share * 80.0) as usize] ^= 0x10;
        prop_assert!(read(&bytes, "changed").is_err());
    }

    #[test]
    fn any_bytes_never_panic(tail in prop::collection::vec(any::<u8>(), 0..300)) {
        for start in [&STORED_MAT[..128], &BIG_ENDIAN_MAT[..128], b"PK\x03\x04"] {
            let _ = read(&[start, &tail].concat(), "any");
        }
    }
}
