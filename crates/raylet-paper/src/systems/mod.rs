//! The three systems of figure 4, each by several methods.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`system1`] | A weak grating over the whole of a plano-convex lens |
//! | [`system2`] | A hologram close to its sensor |
//! | [`system3`] | A hologram before a plano-convex lens |
//! | [`method_comparison`] | Ways to carry the light of one system side by side |
//! | [`system_table`] | These as a table and a document |

pub mod method_comparison;
pub mod system1;
pub mod system2;
pub mod system3;
pub mod system_table;
