//! Lists and names as people read them.

/// `a`, `a and b`, `a, b and c`.
pub(crate) fn join_words(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [only] => only.clone(),
        [start @ .., last] => format!("{} and {last}", start.join(", ")),
    }
}

/// At most `letters` characters; what is cut leaves an ellipsis.
pub(crate) fn shortened(text: &str, letters: usize) -> String {
    if text.chars().count() <= letters {
        return text.to_owned();
    }
    text.chars()
        .take(letters.saturating_sub(1))
        .chain(['…'])
        .collect()
}

/// Keeps numbers and their units on one line.
pub(crate) fn tied(sentence: &str) -> String {
    const NO_BREAK: &str = "\u{a0}";
    [" mm", " %", "> ", "< "]
        .into_iter()
        .fold(sentence.to_owned(), |text, unit| {
            text.replace(unit, &unit.replace(' ', NO_BREAK))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_joined_as_people_do() {
        let words = |n: usize| join_words(&["a", "b", "c"].map(str::to_owned)[..n]);
        assert_eq!(
            [words(0), words(1), words(2), words(3)],
            ["", "a", "a and b", "a, b and c"]
        );
    }

    #[test]
    fn long_names_are_shortened_by_letters() {
        assert_eq!(shortened("minimum_jerk", 20), "minimum_jerk");
        assert_eq!(shortened(&"é".repeat(20), 20), "é".repeat(20));
        assert_eq!(
            shortened(&"é".repeat(21), 20),
            format!("{}…", "é".repeat(19))
        );
    }
}
