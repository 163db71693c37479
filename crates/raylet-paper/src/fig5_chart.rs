//! The picture of figure 5: the target, and the phase and the sensor of each design.

#![expect(
    clippy::indexing_slicing,
    reason = "runs, elements and pixels are made here, as many as are given"
)]

use std::f64::consts::PI;

use ndarray::Array2;
use raylet::file::model::project::SceneDesign;
use raylet_plot::colour::ColourMap;
use raylet_plot::figure::{Figure, Panel};

use crate::study_error::StudyError;

/// One of the designs.
pub(crate) struct Shown<'a> {
    pub(crate) name: &'a str,
    /// Phase of the pixels in rad, [y, x].
    pub(crate) phase: &'a Array2<f64>,
    /// |U|² on the sensor through the real lens, [y, x].
    pub(crate) intensity: &'a Array2<f64>,
    /// Correlation of it with the target picture.
    pub(crate) ncc: f64,
}

/// The phases above, the target picture and the sensors below.
pub(crate) fn fig5_picture(
    designs: &[Shown],
    target: &Array2<f64>,
    scene_design: &SceneDesign,
) -> Result<Vec<u8>, StudyError> {
    let ends = |half: f64| [-half, half];
    let (x, y) = (
        ends(scene_design.sensor_half[0]),
        ends(scene_design.sensor_half[1]),
    );
    let target = Panel::image(target.view(), x, y)
        .title("Target")
        .quantity("intensity", "");
    let (mut phases, mut seen): (Vec<Panel>, Vec<Panel>) = (Vec::new(), vec![target.into()]);
    for design in designs {
        let wrapped = design
            .phase
            .mapv(|phase| (phase + PI).rem_euclid(2.0 * PI) - PI);
        let [across, up] = scene_design.elements[0].1;
        let phase = Panel::image(wrapped, ends(across), ends(up))
            .title(design.name)
            .colours(ColourMap::Phase)
            .quantity("phase", "rad");
        phases.push(phase.into());
        let sensor = Panel::image(design.intensity.view(), x, y)
            .title(design.name)
            .note(format!("NCC {:.4}", design.ncc))
            .quantity("|U|²", "");
        seen.push(sensor.into());
    }
    let title = "A hologram before the LA1131-A: designs, and what they show through the real lens";
    Ok(Figure::new(vec![phases, seen], title)
        .width(1500.0)
        .to_png(1.5)?)
}
