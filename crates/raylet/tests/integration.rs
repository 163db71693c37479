//! What the library computes, through its public interface.
//!
//! One program for all files: it compiles in a fraction of the time of one program each.

mod abandon;
mod analytic_phases;
mod astigmatism;
mod correction;
mod edge_light;
mod estimate;
mod far_away;
mod foreign_rays;
mod gaussian_beams;
mod given_fields;
mod gradients;
mod hologram;
mod interfaces;
mod local_bands;
mod paper_scenes;
mod paper_variance;
mod pixel_gaps;
mod placed_pixels;
mod plane_prefactor;
mod rays;
mod scattered_rays;
mod scene_elements;
mod screens_in_one_place;
mod surface_coordinates;
mod system_builder;
mod tapered_sources;
