//! Parquet, read with the crate's own reader. That other tools read it is seen from the command
//! line's tests and from pyarrow (`docs/formats.md`).

use inhand_export::{TableBuilder, recording_entities, wide, write_parquet};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;

use crate::common::recording;

#[test]
fn cells_units_and_facts_come_back() {
    let take = recording(300, 120.0);
    let entities = recording_entities(&take);
    let mut bytes = Vec::new();
    let about = [("inhand.recording", "facts".to_owned())];
    let table = wide(&entities, take.clock, take.len());
    write_parquet(&table, table.rows, &about, &mut bytes).unwrap();
    let again = {
        let mut bytes = Vec::new();
        write_parquet(&table, table.rows, &about, &mut bytes).unwrap();
        bytes
    };
    assert_eq!(again, bytes, "the same table gives the same bytes");

    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
    let metadata = reader.metadata().file_metadata();
    let facts = metadata.key_value_metadata().unwrap();
    let fact = |key: &str| {
        facts
            .iter()
            .find(|f| f.key == key)
            .unwrap()
            .value
            .clone()
            .unwrap()
    };
    assert_eq!(fact("inhand.recording"), "facts");
    let columns: serde_json::Value = serde_json::from_str(&fact("inhand.columns")).unwrap();
    assert_eq!(
        columns["Thumb.x_m"],
        serde_json::json!({"unit": "m", "frame": "world"})
    );
    assert_eq!(columns["time_s"], serde_json::json!({"unit": "s"}));

    let names: Vec<&str> = (metadata.schema_descr().columns().iter())
        .map(|column| column.name())
        .collect();
    let x = names.iter().position(|name| *name == "Thumb.x_m").unwrap();
    let status = names
        .iter()
        .position(|name| *name == "Thumb.status")
        .unwrap();
    let mut rows = 0;
    for (k, row) in reader.get_row_iter(None).unwrap().enumerate() {
        let row = row.unwrap();
        let track = &take.markers[0].track;
        assert_eq!(row.get_double(0).unwrap(), take.clock.time_s(k));
        // A missing value is null, which has no number.
        assert_eq!(
            row.get_double(x).ok(),
            track.get(k).map(|p| p.to_array()[0])
        );
        assert_eq!(row.get_string(status).unwrap(), track.status(k).name());
        rows += 1;
    }
    assert_eq!(rows, 300);
}

#[test]
fn more_rows_than_a_group_holds() {
    let rows = (1 << 20) + 5;
    let mut table = TableBuilder::new(rows, |row| row);
    table.counts("row", |row| row);
    let (table, mut bytes) = (table.finish(), Vec::new());
    write_parquet(&table, table.rows, &[], &mut bytes).unwrap();
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
    assert_eq!(reader.metadata().file_metadata().num_rows(), rows as i64);
    assert_eq!(reader.num_row_groups(), 2);
}
