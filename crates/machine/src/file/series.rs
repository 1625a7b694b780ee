//! Reading of the dashpot or slider in series with a spring.

use super::reading::{FileTable, Reading};
use crate::description::{Dimension, Series, SeriesLaw};
use crate::kinds;

/// Keys of the dashpot or slider in series with a spring.
pub(super) const KEYS: [&str; 3] = ["slip", "series_damping", "slider"];

/// Whether a spring's table has a dashpot or slider in series.
pub(super) fn is_given(table: &FileTable) -> bool {
    table.has("series_damping") || table.has("slip")
}

/// Reads the dashpot or slider; `Some(None)` if there is none, `None` if it is refused.
pub(super) fn read(reading: &mut Reading, table: &FileTable, dimension: Dimension) -> Option<Option<Series>> {
    if !is_given(table) {
        let slider = reading.optional(table, "slider");
        if let Some(slider) = &slider {
            let text = "requires `series_damping` or `slip`: it is the inner position of a spring in series";
            reading.refuse(slider, text);
        }
        return slider.is_none().then_some(None);
    }
    let mut is_sound = true;
    if let Some(preload) = reading.optional(table, "preload") {
        let text = "cannot be combined with `series_damping` or `slip`: use `slider`, \
                    the inner position at time 0, for a force at the start";
        reading.refuse(&preload, text);
        is_sound = false;
    }
    if let (Some(slip), true) = (reading.optional(table, "slip"), table.has("series_damping")) {
        let text = "cannot be combined with `series_damping`: use `slip` for a slider in series, \
                    or `series_damping` for a dashpot in series";
        reading.refuse(&slip, text);
        is_sound = false;
    }
    let law = match table.has("slip") {
        true => {
            let slip = reading.required_number(table, "slip", kinds::SLIP, dimension);
            slip.map(|slip| SeriesLaw::Slider { slip })
        }
        false => {
            let damping = reading.required_number(table, "series_damping", kinds::SERIES_DAMPING, dimension);
            damping.map(|damping| SeriesLaw::Dashpot { damping })
        }
    };
    let slider = reading.number_or(table, "slider", kinds::SLIDER, dimension, 0.0);
    Some(Some(Series { law: law?, slider: slider? })).filter(|_| is_sound)
}
