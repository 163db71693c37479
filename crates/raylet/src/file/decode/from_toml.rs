//! From TOML text to Rust values, through serde, without losing the address of anything.
//!
//! The `toml` crate's own deserializer loses lines inside enums chosen by a `kind` key, because serde has
//! to buffer them. This one walks the parsed tree, so it can look at `kind` first and then read the rest
//! of the same table in place. It also takes the keys in the order of the file, so the first fault told
//! is the first in the text, refuses numbers that are not finite unless a field asks for them, and holds every number
//! to the magnitude of what its key measures.

use std::ops::Range;

use serde::de::value::{BorrowedStrDeserializer, StrDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer,
    MapAccess, SeqAccess, Unexpected, VariantAccess, Visitor,
};
use toml::Spanned;
use toml::de::{DeArray, DeString, DeTable, DeValue};

use crate::file::decode::decode_error::{Misfit, one_of};
use crate::file::decode::fault::{Fault, shortened};
use crate::file::decode::origin::Origin;
use crate::file::decode::quantity::Quantity;

/// The name under which an enum asks to be chosen by the `kind` key of its table; see [`tagged!`].
pub(crate) const BY_KIND: &str = "an enum chosen by kind";

/// The key that chooses.
const KIND: &str = "kind";

/// Reads a whole document whose `version` key must be `version`.
///
/// # Errors
/// Text that is not TOML, another version, or the first value that does not fit.
pub(crate) fn decode<T: DeserializeOwned>(origin: &Origin, version: i64) -> Result<T, Fault> {
    let document = DeTable::parse(&origin.text).map_err(|error| {
        let found = error.message().trim().replace('\n', "; ");
        Fault::at(
            origin.address(String::new(), error.span()),
            found,
            "valid TOML",
        )
    })?;
    check_version(origin, document.get_ref(), version)?;
    let root = Table {
        table: document.get_ref(),
        span: 0..1,
        skip: None,
    };
    T::deserialize(root).map_err(|misfit| misfit.into_fault(origin))
}

/// Looks at the version before anything else: a newer file may have keys that would confuse the reader.
fn check_version(origin: &Origin, table: &DeTable<'_>, version: i64) -> Result<(), Fault> {
    let given = match table.get("version").map(Spanned::get_ref) {
        Some(DeValue::Integer(given)) => i64::from_str_radix(given.as_str(), given.radix()).ok(),
        _ => return Ok(()),
    };
    match given {
        Some(given) if given == version => Ok(()),
        Some(given) if given > version => Err(origin
            .fault("version", given.to_string(), version.to_string())
            .hint("the file was written for a newer program")),
        _ => Err(origin.fault("version", "another version", version.to_string())),
    }
}

/// A table, or one without its `kind` key.
struct Table<'t> {
    table: &'t DeTable<'t>,
    span: Range<usize>,
    skip: Option<&'static str>,
}

/// Any value with its place, and what numbers in it measure.
struct Value<'t> {
    value: &'t Spanned<DeValue<'t>>,
    quantity: Quantity,
}

impl<'de> Table<'de> {
    /// The entries in the order of the text.
    fn entries(&self) -> Entries<'de> {
        let mut entries: Vec<Entry<'de>> = self
            .table
            .iter()
            .filter(|(key, _)| Some(key.get_ref().as_ref()) != self.skip)
            .collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        Entries {
            entries: entries.into_iter(),
            value: None,
        }
    }
}

impl<'de> Deserializer<'de> for Table<'de> {
    type Error = Misfit;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        let span = self.span.clone();
        visitor
            .visit_map(self.entries())
            .map_err(|misfit| misfit.at(span))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

/// A key and its value.
type Entry<'t> = (&'t Spanned<DeString<'t>>, &'t Spanned<DeValue<'t>>);

/// The entries of a table, one after the other.
struct Entries<'t> {
    entries: std::vec::IntoIter<Entry<'t>>,
    value: Option<Entry<'t>>,
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Misfit;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Misfit> {
        let Some(entry) = self.entries.next() else {
            return Ok(None);
        };
        self.value = Some(entry);
        // An unknown key is refused by the seed: the fault lies at the key itself.
        let (key, _) = entry;
        seed.deserialize(BorrowedStrDeserializer::new(key.get_ref()))
            .map(Some)
            .map_err(|misfit: Misfit| misfit.at(key.span()).below_key(key.get_ref()))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Misfit> {
        let (key, value) = self
            .value
            .take()
            .ok_or_else(|| Misfit::custom("a value without a key"))?;
        let quantity = Quantity::of_key(key.get_ref());
        seed.deserialize(Value { value, quantity })
            .map_err(|misfit| misfit.at(value.span()).below_key(key.get_ref()))
    }
}

/// The items of a list, one after the other.
struct Items<'t> {
    array: &'t DeArray<'t>,
    quantity: Quantity,
    next: usize,
}

impl<'de> SeqAccess<'de> for Items<'de> {
    type Error = Misfit;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Misfit> {
        let Some(value) = self.array.get(self.next) else {
            return Ok(None);
        };
        self.next += 1;
        let quantity = self.quantity;
        seed.deserialize(Value { value, quantity })
            .map(Some)
            .map_err(|misfit| misfit.at(value.span()).below_index(self.next - 1))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.array.len() - self.next)
    }
}

/// A value as serde sees what it did not expect.
fn unexpected<'t>(value: &'t DeValue<'t>) -> Unexpected<'t> {
    match value {
        DeValue::Table(_) => Unexpected::Map,
        DeValue::Array(_) => Unexpected::Seq,
        DeValue::String(text) => Unexpected::Str(text),
        DeValue::Boolean(value) => Unexpected::Bool(*value),
        DeValue::Datetime(_) => Unexpected::Other("a date"),
        DeValue::Integer(digits) => Unexpected::Other(digits.as_str()),
        DeValue::Float(digits) => Unexpected::Other(digits.as_str()),
    }
}

impl<'de> Value<'de> {
    /// The value as serde sees what it did not expect.
    fn unexpected(&self) -> Unexpected<'de> {
        unexpected(self.value.get_ref())
    }

    /// Refuses a number beyond the magnitude of what it measures.
    fn check_magnitude(&self, value: f64, digits: &str) -> Result<(), Misfit> {
        match self.quantity.admits(value) {
            true => Ok(()),
            false => Err(Misfit::new(shortened(digits), self.quantity.to_string())),
        }
    }

    /// Refuses a text that is longer than names are, or paths of files.
    fn check_length(&self, text: &str) -> Result<(), Misfit> {
        let longest = self.quantity.longest;
        match text.len() <= longest {
            true => Ok(()),
            false => Err(Misfit::new(
                format!("a text of {} bytes", text.len()),
                format!("at most {longest} bytes"),
            )),
        }
    }

    /// Hands a list over and refuses what is left of it: a fixed length is exact.
    fn list<V: Visitor<'de>>(
        array: &'de DeArray<'de>,
        quantity: Quantity,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        let mut items = Items {
            array,
            quantity,
            next: 0,
        };
        let value = visitor.visit_seq(&mut items)?;
        if items.next < array.len() {
            let length = format!("an array of length {}", items.next);
            return Err(Misfit::invalid_length(array.len(), &length.as_str()));
        }
        Ok(value)
    }

    /// The whole value as a table without a key.
    fn table(
        table: &'de DeTable<'de>,
        span: Range<usize>,
        skip: Option<&'static str>,
    ) -> Table<'de> {
        Table { table, span, skip }
    }
}

impl<'de> Deserializer<'de> for Value<'de> {
    type Error = Misfit;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.value.get_ref() {
            DeValue::String(text) => {
                self.check_length(text)?;
                visitor.visit_borrowed_str(text)
            }
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Datetime(_) => Err(Misfit::invalid_type(self.unexpected(), &visitor)),
            DeValue::Integer(digits) => {
                match i64::from_str_radix(digits.as_str(), digits.radix()) {
                    Ok(value) => {
                        self.check_magnitude(value as f64, &value.to_string())?;
                        visitor.visit_i64(value)
                    }
                    Err(_) => Err(Misfit::new(
                        "a whole number beyond 64 bits",
                        "a smaller one",
                    )),
                }
            }
            DeValue::Float(digits) => match digits.as_str().parse() {
                Ok(value) => {
                    self.check_magnitude(value, digits.as_str())?;
                    visitor.visit_f64(value)
                }
                Err(_) => Err(Misfit::invalid_type(self.unexpected(), &visitor)),
            },
            DeValue::Array(array) => Self::list(array, self.quantity, visitor),
            DeValue::Table(table) => {
                Self::table(table, self.value.span(), None).deserialize_any(visitor)
            }
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        // Only a field that asks for any value may be infinite, and none may be NaN.
        if let DeValue::Float(digits) = self.value.get_ref() {
            let finite = digits.as_str().parse().is_ok_and(f64::is_finite);
            if !finite {
                return Err(Misfit::new(shortened(digits.as_str()), "a finite number"));
            }
        }
        self.deserialize_any(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        // A derived struct would also take a list for its fields; a scene file must name them.
        match self.value.get_ref() {
            DeValue::Table(_) => self.deserialize_any(visitor),
            _ => Err(Misfit::invalid_type(self.unexpected(), &"a table")),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match self.value.get_ref() {
            DeValue::Table(table) if name == BY_KIND => {
                visitor.visit_enum(by_kind(table, self.value.span(), variants)?)
            }
            DeValue::Table(table) => {
                visitor.visit_enum(by_only_key(table, self.value.span(), variants)?)
            }
            DeValue::String(tag) if name != BY_KIND => {
                if !variants.contains(&tag.as_ref()) {
                    return Err(Misfit::unknown_variant(tag, variants));
                }
                visitor.visit_enum(StrDeserializer::<Misfit>::new(tag))
            }
            _ if name == BY_KIND => Err(Misfit::invalid_type(
                self.unexpected(),
                &"a table with a `kind`",
            )),
            // Told by its names, not by the name that Rust has for it.
            _ => Err(Misfit::invalid_type(
                self.unexpected(),
                &one_of(variants).as_str(),
            )),
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
    /// The place of the content, where the tag is a step of the path to it.
    below: Option<Range<usize>>,
}

/// The variant a table's `kind` names, with the rest of the table as content.
fn by_kind<'t>(
    table: &'t DeTable<'t>,
    span: Range<usize>,
    variants: &'static [&'static str],
) -> Result<Choice<'t, Table<'t>>, Misfit> {
    let Some(kind) = table.get(KIND) else {
        return Err(Misfit::missing_field(KIND).at(span));
    };
    let misfit = match kind.get_ref() {
        DeValue::String(tag) if variants.contains(&tag.as_ref()) => {
            let content = Value::table(table, span, Some(KIND));
            return Ok(Choice {
                tag,
                content,
                below: None,
            });
        }
        DeValue::String(tag) => Misfit::unknown_variant(tag, variants),
        other => Misfit::invalid_type(unexpected(other), &"a string"),
    };
    Err(misfit.at(kind.span()).below_key(KIND))
}

/// The variant named by the only key of a table, with its value as content.
fn by_only_key<'t>(
    table: &'t DeTable<'t>,
    span: Range<usize>,
    variants: &'static [&'static str],
) -> Result<Choice<'t, Value<'t>>, Misfit> {
    // An unknown key is told before a wrong number of keys.
    for (key, _) in table.iter() {
        if !variants.contains(&key.get_ref().as_ref()) {
            return Err(Misfit::unknown_field(key.get_ref(), variants)
                .at(key.span())
                .below_key(key.get_ref()));
        }
    }
    let mut entries = table.iter();
    match (entries.next(), entries.next()) {
        (Some((key, value)), None) => Ok(Choice {
            tag: key.get_ref(),
            content: Value {
                value,
                quantity: Quantity::of_key(key.get_ref()),
            },
            below: Some(value.span()),
        }),
        (None, _) => Err(Misfit::new("an empty table", "one key").at(span)),
        _ => Err(Misfit::new("several keys", "one key").at(span)),
    }
}

impl<'de, C: Deserializer<'de, Error = Misfit>> EnumAccess<'de> for Choice<'de, C> {
    type Error = Misfit;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Misfit> {
        let tag = seed.deserialize(IntoDeserializer::<Misfit>::into_deserializer(self.tag))?;
        Ok((tag, self))
    }
}

impl<'de, C: Deserializer<'de, Error = Misfit>> VariantAccess<'de> for Choice<'de, C> {
    type Error = Misfit;

    fn unit_variant(self) -> Result<(), Misfit> {
        Err(Misfit::new("a table", "a string"))
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Misfit> {
        seed.deserialize(self.content)
            .map_err(|misfit| match self.below {
                Some(span) => misfit.at(span).below_key(self.tag),
                None => misfit,
            })
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Misfit> {
        self.content.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        self.content.deserialize_any(visitor)
    }
}

/// Declares an enum whose variant is chosen by the `kind` key of its table.
///
/// Writing and the JSON Schema use serde's `tag = "kind"`; reading asks [`decode`] for the choice.
macro_rules! tagged {
    (
        $(#[$meta:meta])*
        pub enum $name:ident {
            $($(#[$variant_meta:meta])* $variant:ident($content:ty) = $tag:literal),+ $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
        #[serde(tag = "kind")]
        pub enum $name {
            $($(#[$variant_meta])* #[serde(rename = $tag)] $variant($content)),+
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                use serde::de::{EnumAccess, Error, VariantAccess, Visitor};
                const KINDS: &[&str] = &[$($tag),+];
                struct Chooser;
                impl<'de> Visitor<'de> for Chooser {
                    type Value = $name;
                    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                        write!(f, "a table with a `kind`")
                    }
                    fn visit_enum<A: EnumAccess<'de>>(self, access: A) -> Result<$name, A::Error> {
                        let (tag, content) = access.variant::<String>()?;
                        match tag.as_str() {
                            $($tag => content.newtype_variant().map($name::$variant),)+
                            other => Err(A::Error::unknown_variant(other, KINDS)),
                        }
                    }
                }
                deserializer.deserialize_enum(crate::file::decode::from_toml::BY_KIND, KINDS, Chooser)
            }
        }
    };
}
pub(crate) use tagged;
