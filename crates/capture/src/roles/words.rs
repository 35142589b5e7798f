//! Names of markers and bodies as words.

use inhand_model::Finger;

/// Words that say which finger.
const FINGERS: [(&str, Finger); 8] = [
    ("thumb", Finger::Thumb),
    ("index", Finger::Index),
    ("middle", Finger::Middle),
    ("ring", Finger::Ring),
    ("little", Finger::Little),
    ("pinky", Finger::Little),
    ("pinkie", Finger::Little),
    ("small", Finger::Little),
];

/// Words in a fingertip's name that do not matter.
const TIP_WORDS: [&str; 14] = [
    "tip",
    "fingertip",
    "finger",
    "nail",
    "end",
    "hand",
    "right",
    "left",
    "r",
    "l",
    "rh",
    "lh",
    "marker",
    "m",
];

/// Words in the name of a hand that do not matter.
const HAND_WORDS: [&str; 13] = [
    "right", "left", "r", "l", "rh", "lh", "back", "of", "dorsum", "rigid", "body", "rb", "marker",
];

/// Words that are plainly an object.
const OBJECTS: [&str; 10] = [
    "object", "obj", "cube", "cylinder", "box", "ball", "sphere", "block", "prism", "cuboid",
];

/// Words in the name of an object that do not matter.
const OBJECT_WORDS: [&str; 7] = ["rigid", "body", "rb", "the", "marker", "mm", "cm"];

/// The words of a name in lower case: split at everything that is no letter or digit, between a
/// small and a capital letter, before the last of several capitals (`RHand`) and between letters and
/// digits; words written together are split where they consist of known ones (`thumbtip`,
/// `righthand`).
pub(super) fn words(name: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut word = String::new();
    let mut previous: Option<char> = None;
    let mut chars = name.chars().peekable();
    while let Some(c) = chars.next() {
        let next_is_small = chars.peek().is_some_and(|next| next.is_lowercase());
        let boundary = match previous {
            _ if !c.is_alphanumeric() => true,
            Some(p) => {
                (c.is_uppercase() && (p.is_lowercase() || (p.is_uppercase() && next_is_small)))
                    || p.is_numeric() != c.is_numeric()
            }
            None => false,
        };
        if boundary && !word.is_empty() {
            parts.push(std::mem::take(&mut word));
        }
        previous = c.is_alphanumeric().then_some(c);
        if c.is_alphanumeric() {
            word.extend(c.to_lowercase());
        }
    }
    if !word.is_empty() {
        parts.push(word);
    }
    parts
        .into_iter()
        .flat_map(|part| known_parts(&part).unwrap_or_else(|| vec![part]))
        .collect()
}

/// A word as a sequence of known words of three letters and more, longest first.
fn known_parts(word: &str) -> Option<Vec<String>> {
    if word.is_empty() {
        return Some(Vec::new());
    }
    let mut known: Vec<&str> = FINGERS
        .iter()
        .map(|(word, _)| *word)
        .chain(TIP_WORDS)
        .chain(HAND_WORDS)
        .chain(OBJECTS)
        .filter(|known| known.len() >= 3 && word.starts_with(known))
        .collect();
    known.sort_by_key(|known| std::cmp::Reverse(known.len()));
    known.into_iter().find_map(|known| {
        let mut parts = known_parts(&word[known.len()..])?;
        parts.insert(0, known.to_owned());
        Some(parts)
    })
}

/// The finger whose tip a name means.
pub(super) fn fingertip(name: &str) -> Option<Finger> {
    // `Hand:Index`: the name of the asset does not matter.
    let own = name.rsplit(':').next().unwrap_or(name);
    let mut finger = None;
    for word in words(own) {
        match FINGERS.iter().find(|(name, _)| *name == word) {
            // A second finger word is a joint: thumb_middle, middle_middle.
            Some(_) if finger.is_some() => return None,
            Some(&(_, named)) => finger = Some(named),
            None if TIP_WORDS.contains(&word.as_str()) || is_number(&word) => {}
            None => return None,
        }
    }
    finger
}

/// Whether any word of a name is a finger's, whichever part of the finger is meant.
pub(super) fn speaks_of_a_finger(name: &str) -> bool {
    words(name)
        .iter()
        .any(|word| word == "finger" || FINGERS.iter().any(|(name, _)| name == word))
}

/// Whether a name plainly means the hand.
pub(super) fn is_hand(name: &str) -> bool {
    plainly(name, &["hand"], &HAND_WORDS)
}

/// Whether a name plainly means a manipulated object.
pub(super) fn is_object(name: &str) -> bool {
    plainly(name, &OBJECTS, &OBJECT_WORDS)
}

fn plainly(name: &str, needed: &[&str], allowed: &[&str]) -> bool {
    // `Skeleton 1:RHand`: the name of the asset does not matter.
    let own = name.rsplit(':').next().unwrap_or(name);
    let words = words(own);
    words.iter().any(|word| needed.contains(&word.as_str()))
        && words.iter().all(|word| {
            let word = word.as_str();
            needed.contains(&word) || allowed.contains(&word) || is_number(word)
        })
}

fn is_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// The part of a name that the markers of one cluster share: the name without its last word (`hand_top`, `hand_left`
/// share `hand`; `Hand:Marker1` shares `Hand`). Empty where there is only one word.
pub(super) fn cluster(name: &str) -> &str {
    let own = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let separator = |c: char| !c.is_alphanumeric();
    let head = match own.rfind(separator) {
        // `hand 1` and `hand_1`: the digits were the last word.
        Some(at) if at + 1 == own.len() => own,
        Some(at) => &own[..at],
        // `hand1`.
        None if own.len() < name.len() => own,
        None => "",
    };
    // `Hand:Marker 001` is no cluster "Hand:Marker".
    let head = head.trim_end_matches(separator);
    match head.rsplit_once(separator) {
        Some((asset, last)) if last.eq_ignore_ascii_case("marker") => asset,
        _ => head,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_fingertips() {
        use Finger::{Index, Little, Middle, Ring, Thumb};
        for (name, finger) in [
            ("Thumb", Some(Thumb)),
            ("thumb_tip", Some(Thumb)),
            ("THUMB TIP", Some(Thumb)),
            ("thumbtip", Some(Thumb)),
            ("Hand:Index", Some(Index)),
            ("RightHand:IndexTip1", Some(Index)),
            ("index_finger", Some(Index)),
            ("IndexFinger", Some(Index)),
            ("R.Index", Some(Index)),
            ("RIndex", Some(Index)),
            ("LTHUMB", None), // one word for all we know
            ("middle_tip", Some(Middle)),
            ("middlefinger", Some(Middle)),
            ("middle", Some(Middle)),
            ("Ring", Some(Ring)),
            ("ring-finger-nail", Some(Ring)),
            ("Pinky", Some(Little)),
            ("pinkie_tip", Some(Little)),
            ("Little", Some(Little)),
            ("thumb_middle", None),
            ("middle_middle", None),
            ("index_middle", None),
            ("index_knuckle", None),
            ("thumb_base", None),
            ("hand_top", None),
            ("string", None),
            ("earring", None),
            ("Marker 005", None),
            ("", None),
        ] {
            assert_eq!(fingertip(name), finger, "{name}");
        }
    }

    #[test]
    fn names_of_hands_and_objects() {
        for name in [
            "Hand",
            "RightHand",
            "righthand",
            "hand_back",
            "Back of Hand",
            "R_Hand",
            "RHand",
            "Hand 01",
            "Skeleton 1:LeftHand",
        ] {
            assert!(is_hand(name), "{name}");
        }
        for name in [
            "handle",
            "Hand Tool",
            "shorthand",
            "Body",
            "RigidBody 01",
            "",
        ] {
            assert!(!is_hand(name), "{name}");
        }
        for name in [
            "Object",
            "cube5",
            "Cylinder",
            "object_1",
            "Cube 50mm",
            "Box",
        ] {
            assert!(is_object(name), "{name}");
        }
        for name in [
            "pillow",
            "Hand",
            "objective",
            "RigidBody 02",
            "Box Hand",
            "",
        ] {
            assert!(!is_object(name), "{name}");
        }
    }

    #[test]
    fn clusters_share_what_stands_before_the_last_word() {
        for (name, shared) in [
            ("hand_top", "hand"),
            ("hand_left", "hand"),
            ("Hand:Marker1", "Hand"),
            ("Hand:Marker 001", "Hand"),
            ("right_hand_1", "right_hand"),
            ("hand1", "hand"),
            ("hand 1", "hand"),
            ("Hand_1", "Hand"),
            ("Thumb", ""),
            ("pillow_left", "pillow"),
            ("1", ""),
            ("上_1", "上"),
        ] {
            assert_eq!(cluster(name), shared, "{name}");
        }
    }
}
