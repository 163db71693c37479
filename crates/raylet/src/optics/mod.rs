//! What the parts are.
