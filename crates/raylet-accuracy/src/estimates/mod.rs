//! How well raylet estimates its own error: random small systems, their exact fields, and the ratios of the two.
//!
//! | file | what it holds |
//! |---|---|
//! | `nodes` | quadrature nodes of discs, rectangles and pixels |
//! | `surface_sum` | the field on a sensor by surface integrals from each surface to the next |
//! | `random_systems` | random systems of twelve kinds |
//! | `error_ratios` | runs of raylet beside the surface integrals, and how their ratios are spread |
//! | `report` | the same as a section of the accuracy report |

pub mod nodes;

pub mod surface_sum;

pub mod random_systems;

pub mod error_ratios;

pub mod report;
