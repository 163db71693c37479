//! Files of CODE V (.seq).
//!
//! | file | what it holds |
//! | --- | --- |
//! | `codev_commands` | The text as commands: comments, continued lines, quotes, short and long words |
//! | `codev_header` | Commands of the whole lens: units, aperture, fields, wavelengths |
//! | `codev_glass` | Names and codes of glasses, and glasses whose indices the file has |
//! | `codev_edge` | Apertures of surfaces |
//! | `codev_tilt` | Shifts and tilts of surfaces, as turns of the axis before and behind them |
//! | `codev_shape` | Shapes of surfaces |
//! | `codev_phase` | Diffractive phases and gratings |
//! | `codev_surface` | The commands of one surface |
//! | `codev_relations` | Values that are given by others: pick-ups, solves, zoom positions |
//! | `codev_reader` | A file as a sequential prescription |
//! | `codev_test` | Tests: whole files by hand, their axes, apertures, glasses, phases, relations and faults |

pub(crate) mod codev_commands;
pub(crate) mod codev_edge;
pub(crate) mod codev_glass;
pub(crate) mod codev_header;
pub(crate) mod codev_phase;
pub(crate) mod codev_reader;
pub(crate) mod codev_relations;
pub(crate) mod codev_shape;
pub(crate) mod codev_surface;
#[cfg(test)]
mod codev_test;
pub(crate) mod codev_tilt;
