//! Dictionaries as matrices of other tools.

use crate::support::{Bench, SMALL, stderr};

fn learned() -> Bench {
    let bench = Bench::csv();
    let takes = [
        "session/train/cube_train_01.csv",
        "session/train/cube_train_02.csv",
    ];
    bench.ok(&[&["learn"], &takes[..], &["-o", "d.mcap"], &SMALL].concat());
    bench
}

#[test]
fn a_dictionary_is_written_in_both_forms_with_the_same_numbers() {
    let bench = learned();
    let mut read = Vec::new();
    for name in ["d.npz", "d.MAT"] {
        let printed = bench.ok(&["export", "d.mcap", "-o", name, "--format", "json"]);
        let printed: serde_json::Value =
            serde_json::from_str(&printed).expect("export prints JSON");
        assert_eq!(printed["matrices"]["primitives"][1], 12);
        let matrices =
            inhand_export::matrices::read(&bench.bytes(name), name).expect("the file is sound");
        for (matrix, size) in printed["matrices"].as_object().expect("sizes by name") {
            let shape = matrices[matrix]
                .numbers()
                .expect("every one is numbers")
                .shape();
            assert_eq!(size, &serde_json::json!([shape.0, shape.1]), "{matrix}");
        }
        read.push(matrices);
    }
    let [npz, mat] = &read[..] else {
        panic!("two files")
    };
    let bits = |matrices: &inhand_export::matrices::Variables| -> Vec<(String, Vec<u64>)> {
        (matrices.iter())
            .map(|(name, variable)| {
                let numbers = variable.numbers().expect("every one is numbers");
                (name.clone(), numbers.iter().map(|v| v.to_bits()).collect())
            })
            .collect()
    };
    assert_eq!(bits(npz), bits(mat));
    // And they are those of the dictionary.
    let bytes = bench.bytes("d.mcap");
    let (dictionary, _) =
        inhand_channels::read_dictionary(&bytes, "d.mcap").expect("the dictionary is sound");
    assert_eq!(npz["primitives"].numbers(), Some(&dictionary.primitives));
    let offset = npz["offset_m"].numbers().expect("numbers");
    assert_eq!(offset.as_slice(), dictionary.offset_m.as_slice());
    // The same dictionary gives the same bytes.
    let before = bench.bytes("d.npz");
    bench.ok(&["export", "d.mcap", "-o", "d.npz", "--force"]);
    assert!(bench.bytes("d.npz") == before);
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let bench = learned();
    let refused = |args: &[&str], code: i32, expected: &str| {
        let output = bench.inhand(args);
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    };
    refused(
        &["export", "d.mcap", "-o", "d.csv"],
        2,
        "is a dictionary: expected -o to end in .npz or .mat",
    );
    bench.write("d.npz", "somebody's");
    refused(&["export", "d.mcap", "-o", "d.npz"], 2, "--force");
    assert_eq!(bench.bytes("d.npz"), b"somebody's");
    refused(&["export", "d.npz", "-o", "e.npz"], 1, "not an MCAP file");
    let take = "session/train/cube_train_01.csv";
    bench.ok(&["convert", take, "-o", "take.mcap"]);
    refused(&["export", "take.mcap", "-o", "e.npz"], 1, "no dictionary");
    assert!(!bench.path("e.npz").exists());
}
