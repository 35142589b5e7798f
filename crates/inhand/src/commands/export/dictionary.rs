//! The numbers of a dictionary as matrices.

use anyhow::Result;
use inhand_session::{check_target, matrices, read_dictionary};
use serde_json::json;

use super::Args;
use crate::console::{Console, data};
use crate::exit::Exit;
use crate::options::Format;

pub(super) fn run(console: &Console, args: &Args) -> Result<Exit> {
    check_target(&args.output, &[&args.input], || args.force)?;
    let matrices = matrices::export_dictionary(&read_dictionary(&args.input)?.dictionary);
    matrices::write(&args.output, &matrices)?;
    let shapes: Vec<_> = (matrices.iter())
        .filter_map(|(name, variable)| Some((name, variable.numbers()?.shape())))
        .collect();
    match args.format {
        Format::Json => {
            let sizes: serde_json::Map<_, _> = (shapes.iter())
                .map(|&(name, (rows, columns))| (name.clone(), json!([rows, columns])))
                .collect();
            data(&format!("{:#}\n", json!({ "matrices": sizes })))?;
        }
        Format::Text => {
            let lines: String = (shapes.iter())
                .map(|(name, (rows, columns))| format!("{name:<36} {rows} x {columns}\n"))
                .collect();
            data(&lines)?;
        }
    }
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}
