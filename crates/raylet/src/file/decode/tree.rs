//! A document as a tree of values before it is decoded, from TOML text, from Python or from a scene whose numbers change.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// A value with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Its bytes in the text, if it was read from one.
    pub(crate) span: Option<Range<usize>>,
}

/// A value of a document.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Entries in the order in which they are decoded. No key is there twice.
    Table(Vec<Entry>),
    /// A list of values.
    List(Vec<Node>),
    /// A text.
    Text(String),
    /// True or false.
    Truth(bool),
    /// A whole number.
    Integer(i64),
    /// The digits of a whole number beyond 64 bits.
    LongInteger(String),
    /// Any other number.
    Float {
        /// The number, maybe infinite or NaN.
        value: f64,
        /// How it was written in the text, if it was read from one.
        digits: Option<String>,
    },
    /// A date or a time, which no scene has.
    Date,
}

/// A key of a table with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// The value.
    pub node: Node,
    /// The bytes of the key in the text, if it was read from one.
    pub(crate) span: Option<Range<usize>>,
}

impl From<Value> for Node {
    /// A value that was read from no text.
    fn from(value: Value) -> Self {
        Self { value, span: None }
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Float {
            value,
            digits: None,
        }
    }
}

impl Entry {
    /// A key and a value that were read from no text.
    pub fn new(key: impl Into<String>, node: impl Into<Node>) -> Self {
        Self {
            key: key.into(),
            node: node.into(),
            span: None,
        }
    }
}

impl Value {
    /// The value of a table's key.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        let Self::Table(entries) = self else {
            return None;
        };
        let entry = entries.iter().find(|entry| entry.key == key);
        entry.map(|entry| &entry.node)
    }

    /// The value of a table's key, to be changed.
    pub(crate) fn get_mut(&mut self, key: &str) -> Option<&mut Node> {
        let Self::Table(entries) = self else {
            return None;
        };
        let entry = entries.iter_mut().find(|entry| entry.key == key);
        entry.map(|entry| &mut entry.node)
    }

    /// Whether it is a table, or a list of tables.
    fn has_tables(&self) -> bool {
        match self {
            Self::Table(_) => true,
            Self::List(list) => list
                .first()
                .is_some_and(|first| matches!(first.value, Self::Table(_))),
            _ => false,
        }
    }
}

/// The tree of a text that was parsed.
pub(crate) fn parsed(table: DeTable<'_>) -> Value {
    let entry = |(key, value): (Spanned<DeString<'_>>, Spanned<DeValue<'_>>)| Entry {
        span: Some(key.span()),
        key: String::from(key.into_inner()),
        node: Node {
            span: Some(value.span()),
            value: parsed_value(value.into_inner()),
        },
    };
    let mut entries: Vec<Entry> = table.into_iter().map(entry).collect();
    // In the order of the text, so that the first error is the first in the text.
    entries.sort_by_key(|entry| entry.span.as_ref().map(|span| span.start));
    Value::Table(entries)
}

fn parsed_value(value: DeValue<'_>) -> Value {
    match value {
        DeValue::Table(table) => parsed(table),
        DeValue::Array(array) => {
            let node = |value: Spanned<DeValue<'_>>| Node {
                span: Some(value.span()),
                value: parsed_value(value.into_inner()),
            };
            Value::List(array.into_iter().map(node).collect())
        }
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Boolean(truth) => Value::Truth(truth),
        DeValue::Integer(digits) => match i64::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => Value::LongInteger(digits.to_string()),
        },
        DeValue::Float(digits) => Value::Float {
            value: digits.as_str().parse().unwrap_or(f64::NAN),
            digits: Some(digits.as_str().to_owned()),
        },
        DeValue::Datetime(_) => Value::Date,
    }
}

/// The tree of a table in memory: plain values of each table first, then its tables, as a TOML text has them.
pub(crate) fn in_memory(table: toml::Table) -> Value {
    let entry = |(key, value)| Entry::new(key, value_in_memory(value));
    let mut entries: Vec<Entry> = table.into_iter().map(entry).collect();
    entries.sort_by_key(|entry| entry.node.value.has_tables());
    Value::Table(entries)
}

fn value_in_memory(value: toml::Value) -> Value {
    match value {
        toml::Value::Table(table) => in_memory(table),
        toml::Value::Array(array) => {
            let nodes = array.into_iter().map(|value| value_in_memory(value).into());
            Value::List(nodes.collect())
        }
        toml::Value::String(text) => Value::Text(text),
        toml::Value::Boolean(truth) => Value::Truth(truth),
        toml::Value::Integer(number) => Value::Integer(number),
        toml::Value::Float(number) => number.into(),
        toml::Value::Datetime(_) => Value::Date,
    }
}

#[cfg(test)]
mod tests {
    use toml::de::DeTable;

    use crate::file::decode::tree::{Entry, Node, Value, in_memory, parsed};

    /// The tree without its places.
    fn bare(value: Value) -> Value {
        let node = |node: Node| Node::from(bare(node.value));
        match value {
            Value::Table(entries) => {
                let entry = |entry: Entry| Entry::new(entry.key, node(entry.node));
                Value::Table(entries.into_iter().map(entry).collect())
            }
            Value::List(list) => Value::List(list.into_iter().map(node).collect()),
            Value::Float { value, .. } => value.into(),
            other => other,
        }
    }

    #[test]
    fn text_and_memory_give_the_same_tree() {
        let text = "b = [1, 2.5, [true, 'x']]\nc = -inf\n[a]\nd = 1979-05-27\n[[a.e]]\nf = 0x10\n[[a.e]]\n";
        let table: toml::Table = text.parse().unwrap();
        let read = parsed(DeTable::parse(text).unwrap().into_inner());
        assert_eq!(bare(read), in_memory(table));
    }

    #[test]
    fn entries_are_in_the_order_of_the_text() {
        let text = "z = 18446744073709551616\na = 1\nm = 1e400\n";
        let Value::Table(entries) = parsed(DeTable::parse(text).unwrap().into_inner()) else {
            panic!("a document is a table");
        };
        let keys: Vec<&str> = entries.iter().map(|entry| entry.key.as_str()).collect();
        assert_eq!(keys, ["z", "a", "m"]);
        assert!(matches!(&entries[0].node.value, Value::LongInteger(digits) if digits.len() == 20));
        assert_eq!(entries[2].node.span, Some(text.len() - 6..text.len() - 1));
    }
}
