//! The transform of a box.

use std::f64::consts::PI;

/// sin(πt)/πt.
pub(crate) fn sinc(t: f64) -> f64 {
    if t == 0.0 {
        1.0
    } else {
        (PI * t).sin() / (PI * t)
    }
}
