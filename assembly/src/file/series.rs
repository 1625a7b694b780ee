//! Reading of a spring's partner in series.

use super::reading::{FileTable, Reading};
use crate::description::{Dimension, Series, SeriesLaw};
use crate::kinds;

/// The keys of a spring that has a partner.
pub(super) const KEYS: [&str; 2] = ["series_damping", "slider"];

/// Whether a table has a partner.
pub(super) fn is_given(table: &FileTable) -> bool {
    table.has("series_damping")
}

/// Reads the partner; `Some(None)` without one, `None` for one that is refused.
pub(super) fn read(reading: &mut Reading, table: &FileTable, dimension: Dimension) -> Option<Option<Series>> {
    if !is_given(table) {
        let slider = reading.optional(table, "slider");
        if let Some(slider) = &slider {
            reading.refuse(
                slider,
                "is the inner place of a spring in series; allowed is it beside series_damping",
            );
        }
        return slider.is_none().then_some(None);
    }
    let preload = reading.optional(table, "preload");
    if let Some(preload) = &preload {
        let text = "stands beside series_damping; allowed is slider, the inner place at time 0, which gives the spring a force";
        reading.refuse(preload, text);
    }
    let damping = reading.required_number(table, "series_damping", kinds::DASHPOT, dimension);
    let slider = reading.number_or(table, "slider", kinds::SLIDER, dimension, 0.0);
    let law = SeriesLaw::Dashpot { damping: damping? };
    Some(Some(Series { law, slider: slider? })).filter(|_| preload.is_none())
}
