//! From a tree of values to Rust values, through serde, without losing the address of anything.
//!
//! The `toml` crate's own deserializer loses lines inside enums chosen by a `kind` key, because serde has
//! to buffer them. This one walks the tree, so it can look at `kind` first and then read the rest
//! of the same table in place. It also takes the keys in the order of the file, so the first fault reported
//! is the first in the text, refuses numbers that are not finite unless a field allows them, and holds every number
//! to the magnitude of what its key measures.

use std::ops::Range;

use serde::de::value::{BorrowedStrDeserializer, StrDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer,
    MapAccess, SeqAccess, Unexpected, VariantAccess, Visitor,
};
use toml::de::DeTable;

use crate::file::decode::decode_error::{DecodeError, one_of};
use crate::file::decode::fault::{Fault, shortened};
use crate::file::decode::origin::Origin;
use crate::file::decode::quantity::Quantity;
use crate::file::decode::tree::{Entry, Node, Value, parsed};

/// The name of an enum that is chosen by the `kind` key of its table; see [`crate::file::decode::tagged`].
pub(crate) const BY_KIND: &str = "an enum chosen by kind";

/// The key that chooses.
const KIND: &str = "kind";

/// The tree of a text.
///
/// # Errors
/// Text that is not TOML.
pub(crate) fn parse(origin: &Origin) -> Result<Node, Fault> {
    let document = DeTable::parse(&origin.text).map_err(|error| {
        let found = error.message().trim().replace('\n', "; ");
        Fault::at(
            origin.address(String::new(), error.span()),
            found,
            "valid TOML",
        )
    })?;
    Ok(Node {
        value: parsed(document.into_inner()),
        // The error of a missing key points at the start of the document.
        span: Some(0..1),
    })
}

/// Reads a whole document whose `version` key must be `version`.
///
/// # Errors
/// Another version, or the first value that does not fit.
pub(crate) fn decode<T: DeserializeOwned>(
    tree: &Node,
    origin: &Origin,
    version: i64,
) -> Result<T, Fault> {
    check_version(origin, &tree.value, version)?;
    let root = At {
        node: tree,
        quantity: Quantity::of_key(""),
    };
    T::deserialize(root).map_err(|error| error.into_fault(origin))
}

/// Looks at the version before anything else: a newer file may have keys that would confuse the reader.
fn check_version(origin: &Origin, document: &Value, version: i64) -> Result<(), Fault> {
    match document.get("version").map(|node| &node.value) {
        Some(Value::Integer(given)) if *given == version => Ok(()),
        Some(Value::Integer(given)) if *given > version => Err(origin
            .fault("version", given.to_string(), version.to_string())
            .hint("the file was written for a newer program")),
        Some(Value::Integer(_) | Value::LongInteger(_)) => {
            Err(origin.fault("version", "another version", version.to_string()))
        }
        _ => Ok(()),
    }
}

/// A table, or one without its `kind` key.
struct Table<'t> {
    entries: &'t [Entry],
    span: Option<Range<usize>>,
    skip: Option<&'static str>,
}

/// A value of the tree, and what numbers in it measure.
struct At<'t> {
    node: &'t Node,
    quantity: Quantity,
}

impl<'de> Deserializer<'de> for Table<'de> {
    type Error = DecodeError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        let entries = Entries {
            entries: self.entries.iter(),
            skip: self.skip,
            value: None,
        };
        visitor
            .visit_map(entries)
            .map_err(|error| error.at(&self.span))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

/// The entries of a table, one after the other.
struct Entries<'t> {
    entries: std::slice::Iter<'t, Entry>,
    skip: Option<&'static str>,
    value: Option<&'t Entry>,
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = DecodeError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, DecodeError> {
        let skip = self.skip;
        let others = self.entries.by_ref();
        let Some(entry) = others.find(|entry| Some(entry.key.as_str()) != skip) else {
            return Ok(None);
        };
        self.value = Some(entry);
        // An unknown key is refused by the seed: the fault lies at the key itself.
        seed.deserialize(BorrowedStrDeserializer::new(&entry.key))
            .map(Some)
            .map_err(|error: DecodeError| error.at(&entry.span).below_key(&entry.key))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<S::Value, DecodeError> {
        let Entry { key, node, .. } = self
            .value
            .take()
            .ok_or_else(|| DecodeError::custom("a value without a key"))?;
        let quantity = Quantity::of_key(key);
        seed.deserialize(At { node, quantity })
            .map_err(|error| error.at(&node.span).below_key(key))
    }
}

/// The items of a list, one after the other.
struct Items<'t> {
    list: &'t [Node],
    quantity: Quantity,
    next: usize,
}

impl<'de> SeqAccess<'de> for Items<'de> {
    type Error = DecodeError;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, DecodeError> {
        let Some(node) = self.list.get(self.next) else {
            return Ok(None);
        };
        self.next += 1;
        let quantity = self.quantity;
        seed.deserialize(At { node, quantity })
            .map(Some)
            .map_err(|error| error.at(&node.span).below_index(self.next - 1))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.list.len() - self.next)
    }
}

/// A float as it was written, or else as TOML has it.
fn float_digits(value: f64, digits: Option<&String>) -> String {
    match digits {
        Some(digits) => digits.clone(),
        None if value.is_nan() => String::from("nan"),
        None => format!("{value:?}"),
    }
}

/// The refusal of a value of another type.
fn wrong_type(value: &Value, expected: &str) -> DecodeError {
    let float;
    let unexpected = match value {
        Value::Table(_) => Unexpected::Map,
        Value::List(_) => Unexpected::Seq,
        Value::Text(text) => Unexpected::Str(text),
        Value::Truth(truth) => Unexpected::Bool(*truth),
        Value::Date => Unexpected::Other("a date"),
        Value::Integer(number) => Unexpected::Signed(*number),
        Value::LongInteger(digits) => Unexpected::Other(digits),
        Value::Float { value, digits } => {
            float = float_digits(*value, digits.as_ref());
            Unexpected::Other(&float)
        }
    };
    DecodeError::invalid_type(unexpected, &expected)
}

impl<'de> At<'de> {
    /// Refuses a number beyond the magnitude of what it measures.
    fn check_magnitude(
        &self,
        value: f64,
        digits: impl FnOnce() -> String,
    ) -> Result<(), DecodeError> {
        match self.quantity.admits(value) {
            true => Ok(()),
            false => Err(DecodeError::new(
                shortened(&digits()),
                self.quantity.to_string(),
            )),
        }
    }

    /// Refuses a text that is longer than names are, or paths of files.
    fn check_length(&self, text: &str) -> Result<(), DecodeError> {
        let longest = self.quantity.longest;
        match text.len() <= longest {
            true => Ok(()),
            false => Err(DecodeError::new(
                format!("a text of {} bytes", text.len()),
                format!("at most {longest} bytes"),
            )),
        }
    }

    /// Hands a list over and refuses what is left of it: a fixed length is exact.
    fn list<V: Visitor<'de>>(
        &self,
        list: &'de [Node],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        let mut items = Items {
            list,
            quantity: self.quantity,
            next: 0,
        };
        let value = visitor.visit_seq(&mut items)?;
        if items.next < list.len() {
            let length = format!("an array of length {}", items.next);
            return Err(DecodeError::invalid_length(list.len(), &length.as_str()));
        }
        Ok(value)
    }

    /// A table of the tree, without its key `skip` where there is one.
    fn table(&self, entries: &'de [Entry], skip: Option<&'static str>) -> Table<'de> {
        Table {
            entries,
            span: self.node.span.clone(),
            skip,
        }
    }

    /// The variant that a table's `kind` names, with the rest of the table as content.
    fn by_kind(
        &self,
        entries: &'de [Entry],
        variants: &'static [&'static str],
    ) -> Result<Choice<'de, Table<'de>>, DecodeError> {
        let Some(kind) = self.node.value.get(KIND) else {
            return Err(DecodeError::missing_field(KIND).at(&self.node.span));
        };
        let error = match &kind.value {
            Value::Text(tag) if variants.contains(&tag.as_str()) => {
                return Ok(Choice {
                    tag,
                    content: self.table(entries, Some(KIND)),
                    below: None,
                });
            }
            Value::Text(tag) => DecodeError::unknown_variant(tag, variants),
            other => wrong_type(other, "a string"),
        };
        Err(error.at(&kind.span).below_key(KIND))
    }

    /// The variant named by the only key of a table, with its value as content.
    fn by_only_key(
        &self,
        entries: &'de [Entry],
        variants: &'static [&'static str],
    ) -> Result<Choice<'de, At<'de>>, DecodeError> {
        // The error of an unknown key comes before that of a wrong number of keys.
        for Entry { key, span, .. } in entries {
            if !variants.contains(&key.as_str()) {
                return Err(DecodeError::unknown_field(key, variants)
                    .at(span)
                    .below_key(key));
            }
        }
        match entries {
            [Entry { key, node, .. }] => Ok(Choice {
                tag: key,
                content: At {
                    node,
                    quantity: Quantity::of_key(key),
                },
                below: Some(node),
            }),
            [] => Err(DecodeError::new("an empty table", "one key").at(&self.node.span)),
            _ => Err(DecodeError::new("several keys", "one key").at(&self.node.span)),
        }
    }
}

impl<'de> Deserializer<'de> for At<'de> {
    type Error = DecodeError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        match &self.node.value {
            Value::Text(text) => {
                self.check_length(text)?;
                visitor.visit_borrowed_str(text)
            }
            Value::Truth(truth) => visitor.visit_bool(*truth),
            Value::Date => Err(DecodeError::invalid_type(
                Unexpected::Other("a date"),
                &visitor,
            )),
            Value::Integer(number) => {
                self.check_magnitude(*number as f64, || number.to_string())?;
                visitor.visit_i64(*number)
            }
            Value::LongInteger(_) => Err(DecodeError::new(
                "a whole number beyond 64 bits",
                "a smaller one",
            )),
            Value::Float { value, digits } => {
                self.check_magnitude(*value, || float_digits(*value, digits.as_ref()))?;
                visitor.visit_f64(*value)
            }
            Value::List(list) => self.list(list, visitor),
            Value::Table(entries) => self.table(entries, None).deserialize_any(visitor),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        // Only a field that allows any value may be infinite, and none may be NaN.
        if let Value::Float { value, digits } = &self.node.value
            && !value.is_finite()
        {
            let found = float_digits(*value, digits.as_ref());
            return Err(DecodeError::new(shortened(&found), "a finite number"));
        }
        self.deserialize_any(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        // A derived struct would also take a list for its fields; a scene file must name them.
        match &self.node.value {
            Value::Table(_) => self.deserialize_any(visitor),
            other => Err(wrong_type(other, "a table")),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        match &self.node.value {
            Value::Table(entries) if name == BY_KIND => {
                visitor.visit_enum(self.by_kind(entries, variants)?)
            }
            Value::Table(entries) => visitor.visit_enum(self.by_only_key(entries, variants)?),
            Value::Text(tag) if name != BY_KIND => {
                if !variants.contains(&tag.as_str()) {
                    return Err(DecodeError::unknown_variant(tag, variants));
                }
                visitor.visit_enum(StrDeserializer::<DecodeError>::new(tag))
            }
            other if name == BY_KIND => Err(wrong_type(other, "a table with a `kind`")),
            // The error lists the names that are possible, not the name of the Rust type.
            other => Err(wrong_type(other, &one_of(variants))),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 char str string bytes byte_buf unit
        unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}

/// A chosen variant: its tag and what it holds.
struct Choice<'t, C> {
    tag: &'t str,
    content: C,
    /// The content, where the tag is a step of the path to it.
    below: Option<&'t Node>,
}

impl<'de, C: Deserializer<'de, Error = DecodeError>> EnumAccess<'de> for Choice<'de, C> {
    type Error = DecodeError;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(
        self,
        seed: S,
    ) -> Result<(S::Value, Self), DecodeError> {
        let tag = seed.deserialize(IntoDeserializer::<DecodeError>::into_deserializer(self.tag))?;
        Ok((tag, self))
    }
}

impl<'de, C: Deserializer<'de, Error = DecodeError>> VariantAccess<'de> for Choice<'de, C> {
    type Error = DecodeError;

    fn unit_variant(self) -> Result<(), DecodeError> {
        Err(DecodeError::new("a table", "a string"))
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(
        self,
        seed: S,
    ) -> Result<S::Value, DecodeError> {
        seed.deserialize(self.content)
            .map_err(|error| match self.below {
                Some(node) => error.at(&node.span).below_key(self.tag),
                None => error,
            })
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, DecodeError> {
        self.content.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        self.content.deserialize_any(visitor)
    }
}
