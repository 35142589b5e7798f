//! Reading and writing a take like those of the paper: 120 s at 100 Hz, hand, object and five
//! fingertips. Throughput is in bytes of text.

use std::fmt::Write as _;

use divan::Bencher;
use divan::counter::BytesCount;
use inhand_capture::{ReadSettings, motive};

const SAMPLES: usize = 12_000;
/// Columns of the take's entities: two bodies with error, six fitted markers, five fingertips.
const VALUES: usize = 2 * 8 + 6 * 3 + 5 * 3;

fn main() {
    divan::main();
}

/// A take with smooth numbers of six decimals, as Motive writes them, and a few gaps.
fn take() -> String {
    let mut columns: Vec<[String; 5]> = Vec::with_capacity(VALUES);
    let mut entity = |of: &str, name: &str, kinds: &[(&str, &str)]| {
        for (kind, axes) in kinds {
            let axes: Vec<&str> = axes.split(' ').collect();
            columns.extend(
                axes.iter()
                    .map(|axis| [of, name, "ID", kind, axis].map(str::to_owned)),
            );
        }
    };
    for body in ["Hand", "Object"] {
        entity(
            "Rigid Body",
            body,
            &[
                ("Rotation", "X Y Z W"),
                ("Position", "X Y Z"),
                ("Mean Marker Error", ""),
            ],
        );
        for marker in 1..=3 {
            let name = format!("{body}:Marker{marker}");
            entity("Rigid Body Marker", &name, &[("Position", "X Y Z")]);
        }
    }
    for finger in ["Thumb", "Index", "Middle", "Ring", "Little"] {
        entity("Marker", finger, &[("Position", "X Y Z")]);
    }
    assert_eq!(columns.len(), VALUES);

    let mut text =
        "Format Version,1.23,Take Name,bench,Export Frame Rate,100.000000,Rotation Type,\
                    Quaternion,Length Units,Meters,Coordinate Space,Global\r\n\r\n"
            .to_owned();
    for (place, label) in [",Type", ",Name", ",ID", ",", "Frame,Time (Seconds)"]
        .into_iter()
        .enumerate()
    {
        text.push_str(label);
        for column in &columns {
            text.push(',');
            text.push_str(&column[place]);
        }
        text.push_str("\r\n");
    }
    for k in 0..SAMPLES {
        let t = k as f64 / 100.0;
        write!(text, "{k},{t:.6}").expect("a string takes all");
        for (c, column) in columns.iter().enumerate() {
            let gap = column[0] == "Marker" && (k / 20 + c / 3) % 50 == 0;
            let number = (0.3 * t + c as f64).sin();
            match column[3].as_str() {
                _ if gap => text.push(','),
                "Rotation" => {
                    let half = 0.5 * (0.3 * t).sin();
                    let part = if column[4] == "W" {
                        half.cos()
                    } else {
                        half.sin() / 3_f64.sqrt()
                    };
                    write!(text, ",{part:.6}").expect("a string takes all");
                }
                _ => write!(text, ",{number:.6}").expect("a string takes all"),
            }
        }
        text.push_str("\r\n");
    }
    text
}

#[divan::bench]
fn read_motive(bencher: Bencher<'_, '_>) {
    let text = take();
    bencher
        .counter(BytesCount::of_str(&text))
        .bench(|| inhand_capture::read(text.as_bytes(), "bench.csv", &ReadSettings::default()));
}

/// On one thread, for comparison with readers that have no more.
#[divan::bench]
fn read_motive_on_one_thread(bencher: Bencher<'_, '_>) {
    let text = take();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool of one thread");
    bencher.counter(BytesCount::of_str(&text)).bench(|| {
        pool.install(|| {
            inhand_capture::read(text.as_bytes(), "bench.csv", &ReadSettings::default())
        })
    });
}

#[divan::bench]
fn write_motive(bencher: Bencher<'_, '_>) {
    let text = take();
    let recording = inhand_capture::read(text.as_bytes(), "bench.csv", &ReadSettings::default())
        .expect("the take reads");
    bencher.counter(BytesCount::of_str(&text)).bench(|| {
        let mut out = Vec::with_capacity(text.len());
        motive::write(&recording, &mut out).map(|()| out)
    });
}
