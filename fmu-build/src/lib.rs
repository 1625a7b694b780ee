//! Packs the library into an FMU, runs it and draws what happened.
