use inhand_model::Finding;
use inhand_report::{Report, markdown};

use crate::{sample, sample_rows};

fn text(intervals: bool) -> String {
    let mut evaluation = sample::evaluation(true);
    if intervals {
        evaluation.intervals = Some(sample_rows::intervals(&evaluation));
        let held_out = (evaluation.held_out.as_mut()).expect("the sample has it");
        held_out.intervals.clone_from(&evaluation.intervals);
    }
    markdown(&Report::new(&evaluation, &[])).expect("the sample makes a summary")
}

/// Cells of the lines of every table.
fn tables(text: &str) -> Vec<Vec<Vec<String>>> {
    let mut tables: Vec<Vec<Vec<String>>> = vec![Vec::new()];
    for line in text.lines() {
        match line
            .strip_prefix("| ")
            .and_then(|line| line.strip_suffix(" |"))
        {
            Some(cells) => {
                let cells = cells.replace("\\|", "\u{1}");
                let cells = cells.split('|').map(|cell| cell.trim().to_owned());
                if let Some(table) = tables.last_mut() {
                    table.push(cells.collect::<Vec<_>>());
                }
            }
            None => tables.push(Vec::new()),
        }
    }
    tables.retain(|table| !table.is_empty());
    tables
}

#[test]
fn tables_hold_what_was_found() {
    let evaluation = sample::evaluation(true);
    let plain = text(false);
    let found = tables(&plain);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].len(), 2 + evaluation.methods.len());
    let residual = &evaluation.methods[0].error.all;
    let held_out = &evaluation.held_out.as_ref().unwrap().methods[0].error.all;
    assert_eq!(
        found[0][2],
        [
            "**residual**".to_owned(),
            format!("{:.2}", 1e3 * held_out.p50),
            format!("{:.2}", 1e3 * held_out.p75),
            format!("{:.2}", 1e3 * held_out.p95),
            format!("{:.2}", 1e3 * held_out.max),
            format!("{:.2}", 1e3 * residual.p50),
            format!("{:.2}", 1e3 * residual.p95),
            "> 99.9 → 99.2".to_owned(),
            "59\u{202f}500 (0)".to_owned(),
        ]
    );
    let with = text(true);
    let found = tables(&with);
    assert_eq!(found.len(), 2);
    let median = 1e3 * residual.p50;
    assert_eq!(
        found[0][2][1],
        format!("{median:.3} ({:.3} to {:.3})", 0.94 * median, 1.06 * median)
    );
    // Every method but the baseline itself.
    assert_eq!(found[1].len(), 2 + evaluation.methods.len() - 1);
    assert!(with.contains("2000 bootstrap draws (seed 0)"));
    for table in found {
        assert!(table.iter().all(|row| row.len() == table[0].len()));
    }
}

#[test]
fn it_stays_short_whatever_is_evaluated() {
    let mut evaluation = sample::evaluation(true);
    let method = evaluation.methods[6].clone();
    let take = evaluation.quality[1].clone();
    for k in 0..200 {
        let mut other = method.clone();
        other.name = format!("m{k}");
        evaluation.methods.push(other);
        evaluation.quality.push(take.clone());
    }
    evaluation.intervals = Some(sample_rows::intervals(&evaluation));
    let text = markdown(&Report::new(&evaluation, &[])).unwrap();
    assert!(text.lines().count() < 100, "{}", text.lines().count());
    assert!(text.contains("more methods") && text.contains("more takes"));
}

#[test]
fn names_end_no_cell_and_begin_no_tag() {
    let nasty = "<script>|`x`| @someone [l](u)\n| a |";
    let mut evaluation = sample::evaluation(true);
    evaluation.session.name = nasty.to_owned();
    evaluation.held_out = None;
    evaluation.default_method.push_str(nasty);
    for method in &mut evaluation.methods {
        method.name.push_str(nasty);
    }
    for take in &mut evaluation.quality {
        take.take = nasty.to_owned();
        take.findings.push(Finding::warning(nasty, nasty));
    }
    evaluation.intervals = Some(sample_rows::intervals(&evaluation));
    let text = markdown(&Report::new(&evaluation, &[])).unwrap();
    assert!(!text.contains("<script") && !text.contains("@someone"));
    assert_eq!(text.matches("](u)").count(), text.matches("\\](u)").count());
    let found = tables(&text);
    assert_eq!(found.len(), 2);
    for table in found {
        assert!(
            table.iter().all(|row| row.len() == table[0].len()),
            "{table:?}"
        );
    }
}
