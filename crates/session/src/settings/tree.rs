//! Settings read from TOML and JSON by one deserializer.
//!
//! Read by those of `toml` and `serde_json`, each section was compiled four times over, a tenth of the code
//! of this crate.

use std::fmt;

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{DeserializeOwned, Deserializer, Error as _, IntoDeserializer, Visitor};
use serde_json::Value;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue, Error, ValueDeserializer};

/// A value with its place in the document.
struct Tree<'i>(Spanned<DeValue<'i>>);

/// Reads a TOML document. Errors show the place in it.
pub(super) fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, Error> {
    let root = DeTable::parse(text)?;
    let root = Spanned::new(root.span(), DeValue::Table(root.into_inner()));
    T::deserialize(Tree(root)).map_err(|mut error| {
        error.set_input(Some(text));
        error
    })
}

/// Reads a JSON object. Errors have no place.
pub(super) fn from_json<T: DeserializeOwned>(value: &Value) -> Result<T, String> {
    let text = toml::to_string(value).map_err(|error| error.to_string())?;
    from_toml(&text).map_err(|error| error.message().to_owned())
}

/// The error at a place, which `toml` gives to those of its own deserializers alone.
fn at(span: std::ops::Range<usize>, error: Error) -> Error {
    struct Refusal;
    impl Visitor<'_> for Refusal {
        type Value = Error;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a message")
        }
        fn visit_str<E: serde::de::Error>(self, message: &str) -> Result<Error, E> {
            Err(E::custom(message))
        }
    }
    if error.span().is_some() {
        return error;
    }
    let message = Spanned::new(span, DeValue::String(error.message().into()));
    let refused = ValueDeserializer::from(message).deserialize_any(Refusal);
    refused.unwrap_or_else(|placed| placed)
}

fn entry<'i>((key, value): (Spanned<DeString<'i>>, Spanned<DeValue<'i>>)) -> (Tree<'i>, Tree<'i>) {
    let key = Spanned::new(key.span(), DeValue::String(key.into_inner()));
    (Tree(key), Tree(value))
}

impl<'de> IntoDeserializer<'de, Error> for Tree<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Tree<'de> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let span = self.0.span();
        let read = match self.0.into_inner() {
            DeValue::Boolean(flag) => visitor.visit_bool(flag),
            DeValue::Integer(digits) => {
                let (text, radix) = (digits.as_str(), digits.radix());
                if let Ok(whole) = i64::from_str_radix(text, radix) {
                    visitor.visit_i64(whole)
                } else if let Ok(natural) = u64::from_str_radix(text, radix) {
                    visitor.visit_u64(natural)
                } else {
                    Err(Error::custom("integer number overflowed"))
                }
            }
            DeValue::Float(digits) => match digits.as_str().parse::<f64>() {
                Ok(number) if !number.is_infinite() || digits.as_str().contains("inf") => {
                    visitor.visit_f64(number)
                }
                _ => Err(Error::custom("floating-point number overflowed")),
            },
            DeValue::String(text) => visitor.visit_str(&text),
            DeValue::Datetime(_) => Err(Error::custom("expected no date")),
            DeValue::Array(values) => {
                visitor.visit_seq(SeqDeserializer::new(values.into_iter().map(Tree)))
            }
            DeValue::Table(entries) => {
                visitor.visit_map(MapDeserializer::new(entries.into_iter().map(entry)))
            }
        };
        read.map_err(|error| at(span, error))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let span = self.0.span();
        let read = match self.0.into_inner() {
            DeValue::String(name) => visitor.visit_enum(name.into_deserializer()),
            _ => Err(Error::custom("wanted string or table")),
        };
        read.map_err(|error| at(span, error))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::{from_json, from_toml};
    use crate::settings::Settings;

    const FULL: &str = r#"
name = "a"
allow_shared_takes = true
clean = { fill = "cluster", pad_mm = { thumb = [1, 2.5, -3e-1] } }
[topics]
"/a b" = "ignore"
[process]
filter = "savitzky-golay"
window = 0x1f
cutoff_hz = 6
[learn]
rank = 12
seed = 18446744073709551615
relative_change = 1e-300
[plan]
methods = ["minimum_jerk", "line"]
velocity_m_s = inf
[[takes]]
path = "a.csv"
role = "test"
from_s = 0.1
[[takes]]
path = 'b\c.csv'
role = "train"
"#;

    #[test]
    fn settings_are_those_that_toml_reads() {
        let settings: Settings = from_toml(FULL).unwrap();
        assert_eq!(settings, toml::from_str(FULL).unwrap());
        let again: Settings = from_toml(&settings.to_toml().unwrap()).unwrap();
        assert_eq!(settings, again);
    }

    #[test]
    fn json_keeps_every_number() {
        let mut settings: Settings = from_toml(FULL).unwrap();
        let directly = serde_json::to_value(&settings).unwrap();
        assert_eq!(settings.json(), directly.to_string());
        settings.plan.velocity_m_s = Some(0.1 + 0.2);
        assert_eq!(from_json(&settings.to_json()), Ok(settings));
    }

    #[test]
    fn errors_are_those_of_toml() {
        for wrong in [
            "nane = 1",
            "name = 1",
            "name = \"a\"\nname = \"b\"",
            "name = ",
            "allow_shared_takes = \"yes\"",
            "learn = 3",
            "learn = [3]",
            "learn = -1.5",
            "learn = \"nmf\"",
            "[learn]\nseeds = 1",
            "[learn]\nrank = -1",
            "[learn]\nrank = 2.5",
            "[learn]\nkind = \"nfm\"",
            "[learn]\nkind = 3",
            "[learn]\nstop_rms_mm = [1]",
            "[learn]\nrelative_change = 1e999",
            "[plan]\nmethods = [\"line\", \"lime\"]",
            "[plan]\nmethods = \"line\"",
            "[object]\noffset_m = [1.0, 2.0]",
            "[object]\noffset_m = [1.0, 2.0, \"3\"]",
            "[fingers]\nthumb = 1",
            "[[takes]]\npath = \"ä.csv\"\n",
            "[[takes]]\npath = \"ä.csv\"\nrole = \"tast\"",
            "takes = [{ path = \"ä.csv\", role = \"test\", roll = 1 }]",
        ] {
            let expected = toml::from_str::<Settings>(wrong).unwrap_err();
            let found = from_toml::<Settings>(wrong).unwrap_err();
            assert_eq!(found.to_string(), expected.to_string(), "{wrong}");
            assert!(expected.to_string().contains("line"), "{expected}");
        }
        for stricter in ["name = 1979-05-27", "learn = 1979-05-27"] {
            assert!(from_toml::<Settings>(stricter).is_err());
        }
    }
}
