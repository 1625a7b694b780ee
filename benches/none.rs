//! Empty library: the benches of this package are the programs beside this file.
