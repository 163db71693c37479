//! Optimisers: from value and gradient to the next point.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`descent`] | Gradient descent with momentum, and Adam |
//! | [`lbfgs`] | L-BFGS with bounds |
//! | [`optimizer`] | The optimiser of a design, one of these |
//! | `reduction` | Sums over long lists with the same bits for any number of threads |
//! | [`schedule`] | The step length of a descent by iteration |
//! | [`space`] | Bounds and scales of parameters |
//! | [`step`] | What an optimiser answers |
//! | `wolfe` | A line search that ends where the strong Wolfe conditions hold |

pub mod descent;
pub mod lbfgs;
pub mod optimizer;
pub(crate) mod reduction;
pub mod schedule;
pub mod space;
pub mod step;
pub(crate) mod wolfe;
