//! What happens to waves.
