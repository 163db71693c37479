//! Brute-force references.
