//! Elements and loads without a place, and the room that they take: in a row to the right names
//! are above their symbols, in an upright row to the right of them.

use crate::connections::Symbol;
use crate::sizes::{ARM_FONT, BESIDE, FONT, NAME, REACH, ROOM};
use crate::ways::Way;
use vibro_figures::canvas::text_width;

/// Smallest length of a symbol.
pub(crate) const SYMBOL: f64 = 230.0;
/// Length of the symbol itself between the texts of its lever arms.
const BARE: f64 = 240.0;

/// An element or a load without a position.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub name: String,
    /// `None` for a load's arrow.
    pub symbol: Option<Symbol>,
    pub faces: bool,
    pub arms: [Option<String>; 2],
}

/// Extent of a symbol across the row, without its name.
pub(crate) fn height_of(symbol: Option<Symbol>) -> f64 {
    match symbol {
        Some(Symbol::Spring { zigzag: true, dashpot: true, .. } | Symbol::Series { dashpot: true, .. }) => {
            132.0
        }
        Some(Symbol::Link) => 36.0,
        None => 44.0,
        Some(Symbol::Stop { .. } | Symbol::Freewheel) => 84.0,
        Some(_) => 64.0,
    }
}

impl Way {
    /// Extent of an item across the row, with its texts and the distance to the next item.
    pub(crate) fn lane(self, item: &Item) -> f64 {
        let height = height_of(item.symbol);
        if self.is_upright() {
            return height + self.tail(item);
        }
        let arms = if item.arms.iter().any(Option::is_some) { 0.8 * ARM_FONT } else { 0.0 };
        NAME + height.max(2.0 * arms) + ROOM
    }

    /// The part of an upright lane behind the symbol.
    pub(crate) fn tail(self, item: &Item) -> f64 {
        if !self.is_upright() {
            return 0.0;
        }
        let of = |text: &str, font: f64| if text.is_empty() { 0.0 } else { BESIDE + text_width(text, font) };
        let half = 0.5 * height_of(item.symbol);
        let arms = item.arms.iter().flatten().map(|arm| of(arm, ARM_FONT) - half);
        arms.fold(of(&item.name, FONT), f64::max) + ROOM
    }

    /// Distance from the beginning of an item's lane to the middle of its symbol.
    pub(crate) fn middle(self, item: &Item) -> f64 {
        match self {
            Self::Right => NAME + 0.5 * (self.lane(item) - NAME - ROOM),
            Self::Down | Self::Up => 0.5 * height_of(item.symbol),
        }
    }

    /// Length that the text of a lever arm takes at an end of a symbol.
    pub(crate) fn room_of(self, arm: Option<&str>) -> f64 {
        let text = |arm: &str| if self.is_upright() { 1.2 * ARM_FONT } else { text_width(arm, ARM_FONT) };
        arm.map_or(0.0, |arm| text(arm) + 20.0)
    }

    /// Length of a symbol with its name and lever arms along the row.
    pub(crate) fn need(self, item: &Item) -> f64 {
        // The symbol is centred, so both ends get the space for the longer text.
        let arm = item.arms.iter().map(|arm| self.room_of(arm.as_deref())).fold(0.0, f64::max);
        let bare = SYMBOL.max(if arm > 0.0 { BARE + 2.0 * arm } else { 0.0 });
        // The name of a load moves with its body towards the ground.
        let room = if item.symbol.is_none() { REACH } else { 0.0 };
        let name = if self.is_upright() { 0.0 } else { text_width(&item.name, FONT) + ROOM + room };
        bare.max(name)
    }
}
