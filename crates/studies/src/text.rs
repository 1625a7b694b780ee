//! Values serialized as the text that a command line takes.

/// Implements the conversions of serde's `try_from = "String"` and `into = "String"` by a type's
/// `FromStr` and `Display`.
macro_rules! written_as_text {
    ($value:ty) => {
        impl TryFrom<String> for $value {
            type Error = crate::Error;

            fn try_from(text: String) -> crate::Result<Self> {
                text.parse()
            }
        }

        impl From<$value> for String {
            fn from(value: $value) -> Self {
                value.to_string()
            }
        }
    };
}
pub(crate) use written_as_text;
