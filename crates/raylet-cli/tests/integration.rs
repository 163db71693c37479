//! What the program does, run as its users run it.
//!
//! One program for all files: it compiles in a fraction of the time of one program each.

mod bad_compare;
mod bad_files;
mod bad_hologram;
mod bad_input;
mod bad_reference;
mod bad_systems;
mod bare_mirror;
mod check_lines;
mod checkpoints;
mod compare;
mod convert;
mod design;
mod elements;
mod endings;
mod export;
mod flat_patches;
mod forecasts;
mod import;
mod lens_files;
mod memory;
mod memory_advice;
mod overwriting;
mod paper;
mod reference_method;
mod refusal;
mod simulate;
mod stage;
mod systems_designed;
