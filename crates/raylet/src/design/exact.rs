//! Numbers written so that reading gives back the same bits, whatever the format.
//!
//! Decimal digits may lose the last bit on the way through a file, and JSON has no infinity. For the
//! attribute `#[serde(with = "...")]`.

/// One number, as the integer of the same 64 bits.
pub mod number {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Writes the bits.
    ///
    /// # Errors
    /// Those of the format.
    pub(crate) fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        (value.to_bits() as i64).serialize(to)
    }

    /// Reads the bits.
    ///
    /// # Errors
    /// Those of the format.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(f64::from_bits(i64::deserialize(from)? as u64))
    }
}

/// A list of numbers, as base64 (RFC 4648) of their bytes, lowest first.
pub mod list {
    use base64::Engine;
    use base64::prelude::BASE64_STANDARD;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    /// Writes the bytes.
    ///
    /// # Errors
    /// Those of the format.
    pub(crate) fn serialize<S: Serializer>(values: &[f64], to: S) -> Result<S::Ok, S::Error> {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        to.serialize_str(&BASE64_STANDARD.encode(bytes))
    }

    /// Reads the bytes.
    ///
    /// # Errors
    /// Those of the format, and text that is not base64 of whole numbers.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
        let text = String::deserialize(from)?;
        let bytes = BASE64_STANDARD.decode(text).map_err(D::Error::custom)?;
        let (numbers, rest) = bytes.as_chunks::<8>();
        if !rest.is_empty() {
            return Err(D::Error::custom(format!("{} bytes left over", rest.len())));
        }
        Ok(numbers
            .iter()
            .map(|bytes| f64::from_le_bytes(*bytes))
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};

    use crate::design::exact;

    #[derive(Serialize, Deserialize)]
    struct Both {
        #[serde(with = "exact::number")]
        one: f64,
        #[serde(with = "exact::list")]
        many: Vec<f64>,
    }

    #[test]
    fn every_bit_comes_back_and_damage_is_refused() {
        let many = vec![0.1, -0.0, f64::INFINITY, f64::MIN_POSITIVE / 3.0, f64::NAN];
        for one in many.clone() {
            let both = Both {
                one,
                many: many.clone(),
            };
            let text = serde_json::to_string(&both).unwrap();
            let back: Both = serde_json::from_str(&text).unwrap();
            assert_eq!(back.one.to_bits(), one.to_bits());
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&back.many), bits(&many));
        }
        let short = serde_json::from_str::<Both>(r#"{"one": 3, "many": "AAAA"}"#);
        assert!(short.is_err());
    }
}
