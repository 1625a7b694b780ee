//! Empty library: the benches of this package are the other programs in this folder.
