//! Dependencies between packages, and imports between files of a package, point downwards.
