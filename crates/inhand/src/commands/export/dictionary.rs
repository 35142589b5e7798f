//! The numbers of a dictionary as matrices.

use std::collections::BTreeMap;

use anyhow::Result;
use inhand_session::{matrices, read_dictionary};
use serde_json::json;

use super::Args;
use crate::console::{Console, print};
use crate::exit::Exit;
use crate::output::check_outputs;

pub(super) fn run(console: &Console, args: &Args) -> Result<Exit> {
    check_outputs([&args.output], &[&args.input], args.force)?;
    let matrices = matrices::export_dictionary(&read_dictionary(&args.input)?.dictionary);
    matrices::write(&args.output, &matrices)?;
    let sizes: Vec<_> = (matrices.iter())
        .filter_map(|(name, variable)| Some((name, variable.numbers()?.shape())))
        .collect();
    let line = |&(name, (rows, columns)): &(&String, (usize, usize))| {
        format!("{name:<36} {rows} x {columns}\n")
    };
    let text = || sizes.iter().map(line).collect();
    let json = || json!({ "matrices": sizes.iter().copied().collect::<BTreeMap<_, _>>() });
    print(args.format, text, json)?;
    console.wrote(&args.output);
    Ok(Exit::Done)
}
