//! What should change.
