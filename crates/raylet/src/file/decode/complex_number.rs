//! A complex number of a scene: a number where it is real, else `[re, im]`.

use std::fmt;

use num_complex::Complex64;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Unexpected, Visitor};
use serde::{Serialize, Serializer};

/// A complex number as a scene writes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexNumber(pub Complex64);

/// Both forms in words.
const EXPECTED: &str = "a number, or [re, im] of a complex one";

impl<'de> Deserialize<'de> for ComplexNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Parts)
    }
}

/// Reads either form.
struct Parts;

impl<'de> Visitor<'de> for Parts {
    type Value = ComplexNumber;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(EXPECTED)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<ComplexNumber, E> {
        if !value.is_finite() {
            return Err(E::invalid_value(
                Unexpected::Float(value),
                &"a finite number",
            ));
        }
        Ok(ComplexNumber(value.into()))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<ComplexNumber, E> {
        self.visit_f64(value as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<ComplexNumber, A::Error> {
        let mut parts: Vec<f64> = Vec::new();
        while let Some(part) = items.next_element()? {
            parts.push(part);
        }
        match *parts.as_slice() {
            [re, im] => Ok(ComplexNumber(Complex64::new(re, im))),
            _ => Err(A::Error::invalid_length(parts.len(), &EXPECTED)),
        }
    }
}

impl Serialize for ComplexNumber {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.im == 0.0 {
            true => self.0.re.serialize(serializer),
            false => [self.0.re, self.0.im].serialize(serializer),
        }
    }
}

impl JsonSchema for ComplexNumber {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ComplexNumber".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [
                { "type": "number" },
                { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 }
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::file::decode::complex_number::ComplexNumber;

    #[test]
    fn both_forms_are_read_and_written() {
        for (text, re, im) in [
            ("-0.5", -0.5, 0.0),
            ("2.0", 2.0, 0.0),
            ("[0.25,-3.0]", 0.25, -3.0),
        ] {
            let read: ComplexNumber = serde_json::from_str(text).unwrap();
            assert_eq!(read.0, Complex64::new(re, im));
            let written = serde_json::to_string(&read).unwrap();
            assert_eq!(
                serde_json::from_str::<ComplexNumber>(&written).unwrap(),
                read
            );
        }
        for text in ["[1]", "[1, 2, 3]", "true"] {
            let refusal = serde_json::from_str::<ComplexNumber>(text).unwrap_err();
            assert!(refusal.to_string().contains("[re, im]"), "{refusal}");
        }
    }
}
