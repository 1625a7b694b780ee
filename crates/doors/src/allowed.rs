//! Table of the functions of one version of FMI, with the states of each function.

/// Declares the enumeration `Function` from a table: name, then the states of Model Exchange and
/// of Co-Simulation as masks with bit `Stage as u16`.
macro_rules! function_table {
    ($(#[$doc:meta])* $prefix:literal; $($name:ident: $exchange:expr, $cosimulation:expr;)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // named as in the standard
        pub enum Function { $($name,)* }

        /// All functions.
        pub const FUNCTIONS: &[Function] = &[$(Function::$name,)*];

        const NAMES: &[&str] = &[$(concat!($prefix, stringify!($name)),)*];
        const MODEL_EXCHANGE: &[u16] = &[$($exchange,)*];
        const CO_SIMULATION: &[u16] = &[$($cosimulation,)*];

        impl Function {
            /// Name of the function in C.
            pub fn name(self) -> &'static str {
                NAMES[self as usize]
            }

            /// Whether the function may be called in `stage` of an instance of type `interface`.
            pub fn allowed(self, interface: $crate::Interface, stage: Stage) -> bool {
                let masks = match interface {
                    $crate::Interface::ModelExchange => MODEL_EXCHANGE,
                    $crate::Interface::CoSimulation => CO_SIMULATION,
                };
                masks[self as usize] & (1 << stage as u16) != 0
            }
        }
    };
}
pub(crate) use function_table;

/// Asserts that the rows of a table agree with a standard's table, transcribed a second time from
/// its text: each function's name, then one mark per state for each of two interface types.
#[cfg(test)]
macro_rules! assert_is_the_standards {
    ($standard:expr, $columns:expr, $expected:expr) => {
        let lines: Vec<_> = $standard.lines().filter(|line| !line.trim().is_empty()).collect();
        assert_eq!(lines.len(), FUNCTIONS.len());
        for (line, function) in lines.iter().zip(FUNCTIONS) {
            let cells: Vec<_> = line.split_whitespace().collect();
            assert_eq!(cells[0], function.name());
            for (column, (interface, states)) in $columns.into_iter().enumerate() {
                let marks = cells[1 + column];
                assert_eq!(marks.len(), states.len());
                for (state, mark) in states.iter().zip(marks.chars()) {
                    let expected: bool = $expected(*function, *state, mark);
                    assert_eq!(function.allowed(interface, *state), expected, "{line} {state:?}");
                }
            }
        }
    };
}
#[cfg(test)]
pub(crate) use assert_is_the_standards;
