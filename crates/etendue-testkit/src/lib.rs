//! Statistical tests and image comparison for light transport. Takes closures and slices, knows none of our types.
