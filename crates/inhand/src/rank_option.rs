//! `--rank`: a number of primitives, or a range to choose from.

use std::str::FromStr;

/// Ranks that a range without a step is cut into, about.
const RANKS: usize = 12;
/// Most ranks of a range: a dictionary is learned for each, several times over.
const MOST_RANKS: usize = 500;

/// Value of `--rank`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum RankOption {
    /// This many primitives.
    One(usize),
    /// The best of these, in rising order.
    Choose(Vec<usize>),
}

impl FromStr for RankOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((from, rest)) = text.split_once("..") else {
            return Ok(Self::One(number(text)?));
        };
        let (to, step) = match rest.split_once(':') {
            Some((to, step)) => (number(to)?, Some(number(step)?)),
            None => (number(rest)?, None),
        };
        ranks(number(from)?, to, step).map(Self::Choose)
    }
}

fn number(text: &str) -> Result<usize, String> {
    text.trim().parse().map_err(|_| {
        format!("expected a number, FROM..TO or FROM..TO:STEP, such as 20..240, found \"{text}\"")
    })
}

/// From the first to the last rank: every `step`-th, or a dozen in even steps and the last.
fn ranks(from: usize, to: usize, step: Option<usize>) -> Result<Vec<usize>, String> {
    if from == 0 {
        return Err("a range of ranks starts at 1 at least, found 0".to_owned());
    }
    if from > to {
        return Err(format!(
            "a range of ranks rises, found {from} before {to}: did you mean {to}..{from}?"
        ));
    }
    let step_or_even = match step {
        Some(0) => return Err("the step of a range is 1 at least, found 0".to_owned()),
        Some(step) => step,
        None => (to - from).div_ceil(RANKS - 1).max(1),
    };
    if (to - from) / step_or_even >= MOST_RANKS {
        return Err(format!(
            "expected {MOST_RANKS} ranks at most, found {}: take a larger step",
            (to - from) / step_or_even + 1
        ));
    }
    let mut ranks: Vec<usize> = (from..=to).step_by(step_or_even).collect();
    if step.is_none() && ranks.last() != Some(&to) {
        ranks.push(to);
    }
    Ok(ranks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_ranges() {
        let dozen: Vec<usize> = (1..=12).map(|i| 20 * i).collect();
        for (text, expected) in [
            ("200", RankOption::One(200)),
            ("0", RankOption::One(0)),
            ("20..240", RankOption::Choose(dozen)),
            ("5..8", RankOption::Choose(vec![5, 6, 7, 8])),
            ("7..7", RankOption::Choose(vec![7])),
            ("20..100:50", RankOption::Choose(vec![20, 70])),
            ("20..120:50", RankOption::Choose(vec![20, 70, 120])),
            ("1..2:9", RankOption::Choose(vec![1])),
            (" 3 .. 4 : 1 ", RankOption::Choose(vec![3, 4])),
        ] {
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
    }

    #[test]
    fn even_steps_end_at_the_last_rank() {
        for (from, to) in [(20, 241), (1, 13), (3, 1000), (1, usize::MAX)] {
            let ranks = ranks(from, to, None).unwrap();
            assert_eq!((ranks[0], ranks[ranks.len() - 1]), (from, to));
            assert!(ranks.len() <= RANKS + 1, "{ranks:?}");
            assert!(ranks.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn ranges_that_make_no_sense() {
        for (text, word) in [
            ("240..20", "20..240"),
            ("0..20", "starts at 1"),
            ("1..20:0", "step"),
            ("1..1000000:1", "larger step"),
            ("..20", "FROM..TO"),
            ("20..", "FROM..TO"),
            ("20..40:", "FROM..TO"),
            ("-3..4", "FROM..TO"),
            ("many", "FROM..TO"),
            ("1..2..3", "FROM..TO"),
        ] {
            let error = text.parse::<RankOption>().unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
