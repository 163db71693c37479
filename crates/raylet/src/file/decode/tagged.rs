//! Enums whose variant is chosen by the `kind` key of their table.

/// Declares an enum whose variant is chosen by the `kind` key of its table.
///
/// Writing and the JSON Schema use serde's `tag = "kind"`; reading leaves the choice to the decoder.
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
                deserializer.deserialize_enum(crate::file::decode::from_tree::BY_KIND, KINDS, Chooser)
            }
        }
    };
}
pub(crate) use tagged;
