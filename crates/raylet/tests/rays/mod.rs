//! Rays against geometry: surfaces that form perfect images, gratings, and the laws that every traced
//! ray obeys.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `stage` | Hops and screens from which the tests build their systems |
//! | `blocks` | Rays of whole systems in blocks are those that are followed one by one |
//! | `canonical` | What holds for every ray through any system: the symplectic form, Malus and Dupin, reversibility |
//! | `glass` | Indices that glass makers and standard papers print |
//! | `grating` | The grating equation, with the optical path that goes with it |
//! | `oval` | Cartesian ovals, which image a point into a point |
//! | `published` | Rays that other programs print |
//! | `stigmatic` | Conics that bring every ray to one point over one optical path |

mod blocks;
mod canonical;
mod glass;
mod grating;
mod oval;
mod published;
mod stage;
mod stigmatic;
