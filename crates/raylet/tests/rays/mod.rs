//! Rays against geometry: surfaces that form perfect images, gratings, and the laws that every traced
//! ray obeys.

mod canonical;
mod glass;
mod grating;
mod oval;
mod stage;
mod stigmatic;
