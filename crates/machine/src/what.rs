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
    /// A contact's elongation along its tangent; the index of one of two tangents, `None` for the
    /// only one.
    TangentE(Option<usize>),
    /// A contact's force along its tangent, which resists this elongation; the index as for
    /// [`TangentE`](Self::TangentE).
    TangentF(Option<usize>),
    /// Inner displacement of a spring in series, or of a contact's slider, in the unit of its
    /// elongation; the index as for [`TangentE`](Self::TangentE).
    Slider(Option<usize>),
    /// Rate of the inner displacement: a derivative in FMUs, not a column.
    SliderRate(Option<usize>),
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
    /// All kinds of columns of bodies and elements, whose [`word`](Self::word) has one part.
    pub const ALL: [Self; 15] = [
        Self::S,
        Self::V,
        Self::A,
        Self::E,
        Self::Rate,
        Self::F,
        Self::TangentE(None),
        Self::TangentF(None),
        Self::Slider(None),
        Self::TangentE(Some(0)),
        Self::TangentF(Some(0)),
        Self::Slider(Some(0)),
        Self::TangentE(Some(1)),
        Self::TangentF(Some(1)),
        Self::Slider(Some(1)),
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
            Self::TangentE(None) => "et",
            Self::TangentE(Some(0)) => "et[0]",
            Self::TangentE(Some(_)) => "et[1]",
            Self::TangentF(None) => "ft",
            Self::TangentF(Some(0)) => "ft[0]",
            Self::TangentF(Some(_)) => "ft[1]",
            Self::Slider(None) => "slider",
            Self::Slider(Some(0)) => "slider[0]",
            Self::Slider(Some(_)) => "slider[1]",
            Self::SliderRate(None) => "slider.rate",
            Self::SliderRate(Some(0)) => "slider[0].rate",
            Self::SliderRate(Some(_)) => "slider[1].rate",
            Self::Value | Self::Output(_) | Self::State(_) | Self::StateRate(_) => "",
        }
    }

    /// SI unit.
    pub fn unit(self, dimension: Dimension) -> &'static str {
        let units = match self {
            Self::S | Self::E | Self::TangentE(_) | Self::Slider(_) => ["m", "rad"],
            Self::V | Self::Rate | Self::SliderRate(_) => ["m/s", "rad/s"],
            Self::A => ["m/s2", "rad/s2"],
            Self::F | Self::TangentF(_) => ["N", "N.m"],
            Self::Value | Self::Output(_) | Self::State(_) => ["1"; 2],
            Self::StateRate(_) => ["1/s"; 2],
        };
        units[usize::from(dimension == Dimension::Rotation)]
    }
}
