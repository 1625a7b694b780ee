//! Numbers in texts, and values serialized as the text that a command line takes.

/// A number to seven digits with a true minus sign, for captions.
pub fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    let plain = rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs());
    if plain { format!("{rounded}") } else { format!("{rounded:e}") }.replace('-', "−")
}

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
