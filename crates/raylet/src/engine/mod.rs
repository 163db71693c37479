//! Who runs which rays.
