//! Figure 6: conformal diffractive mirrors.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`conformal_mirror`] | The mirror of figure 6: its substrate, pixels and sensor; patches of a sphere |
//! | [`fig6`] | Figure 6, forward: a mirror with conjugate phases |
//! | [`conformal_methods`] | Such a mirror by several methods, against the direct integral over its surface |
//! | [`conformal_chart`] | The pictures of it |
//! | [`fig6_foci`] | Figure 6, designed: a mirror with two foci |
//! | [`fig6_s`] | Figure 6, designed: a mirror that shows a letter S |
//! | [`mirror_design`] | The pixels of such a mirror as a design: target, loss and start |
//! | `mirror_search` | What these designs share: the search for a mirror's pixels |
//! | [`mirror_chart`] | The picture of such a search |
//! | [`conformal_seen`] | What a mirror with given pixels shows |

pub mod conformal_chart;
pub mod conformal_methods;
pub mod conformal_mirror;
pub mod conformal_seen;
pub mod fig6;
pub mod fig6_foci;
pub mod fig6_s;
pub mod mirror_chart;
pub mod mirror_design;
mod mirror_search;
