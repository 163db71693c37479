//! Hops without rays.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`free_method`] | Which method without rays carries a hop, and why the others do not |
//! | `spot_check` | The error of a free hop, measured at a few points by the direct sum |

pub mod free_method;
pub(crate) mod spot_check;
