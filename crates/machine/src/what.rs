//! Kinds of quantities, with their words and units.

use crate::description::Dimension;

/// Kind of a quantity of a body or an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum What {
    /// A body's coordinate.
    S,
    /// The rate of a body's coordinate.
    V,
    /// A body's acceleration.
    A,
    /// An element's elongation.
    E,
    /// The rate of an element's elongation.
    Rate,
    /// An element's force, which resists its elongation; a load's force on its body.
    F,
    /// A contact's elongation along its tangent.
    TangentE,
    /// A contact's force along its tangent, which resists this elongation.
    TangentF,
    /// Inner displacement of a spring in series, or of a contact's slider, in the unit of its
    /// elongation.
    Slider,
    /// Rate of the inner displacement: a derivative in FMUs, not a column.
    SliderRate,
    /// The value of a signal that blocks read.
    Value,
    /// Output of a block, by its index.
    Output(usize),
    /// State of a block, by its index: states of the file, then for a sampled block the outputs
    /// that act and the delayed outputs.
    State(usize),
    /// The rate of a state of a block.
    StateRate(usize),
}

impl What {
    /// All kinds whose [`word`](Self::word) has one part, unlike `slider.rate`.
    pub const ALL: [Self; 9] = [
        Self::S,
        Self::V,
        Self::A,
        Self::E,
        Self::Rate,
        Self::F,
        Self::TangentE,
        Self::TangentF,
        Self::Slider,
    ];

    /// The kinds that bodies have.
    pub const OF_BODIES: [Self; 3] = [Self::S, Self::V, Self::A];

    /// Last part of a quantity's name; empty for signals and blocks, whose element determines the
    /// name.
    pub fn word(self) -> &'static str {
        match self {
            Self::S => "s",
            Self::V => "v",
            Self::A => "a",
            Self::E => "e",
            Self::Rate => "rate",
            Self::F => "f",
            Self::TangentE => "et",
            Self::TangentF => "ft",
            Self::Slider => "slider",
            Self::SliderRate => "slider.rate",
            Self::Value | Self::Output(_) | Self::State(_) | Self::StateRate(_) => "",
        }
    }

    /// SI unit.
    pub fn unit(self, dimension: Dimension) -> &'static str {
        let units = match self {
            Self::S | Self::E | Self::TangentE | Self::Slider => ["m", "rad"],
            Self::V | Self::Rate | Self::SliderRate => ["m/s", "rad/s"],
            Self::A => ["m/s2", "rad/s2"],
            Self::F | Self::TangentF => ["N", "N.m"],
            Self::Value | Self::Output(_) | Self::State(_) => ["1"; 2],
            Self::StateRate(_) => ["1/s"; 2],
        };
        units[usize::from(dimension == Dimension::Rotation)]
    }
}
