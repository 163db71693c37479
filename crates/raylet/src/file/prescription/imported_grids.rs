//! Grids of values inside a lens file: arrays that its scene names, and that an import leaves beside it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use ndarray::Array2;

use crate::file::arrays::array::BorrowedArray;
use crate::file::decode::fault::Fault;
use crate::file::prescription::sequential::Face;
use crate::file::scene::element::Element;
use crate::file::scene::layer::Layer;
use crate::file::scene::scene_file::Scene;
use crate::file::scene::surface_shape::Shape;
use crate::optics::sag_grid::SagGrid;

/// Part of a pitch over which the curvature in the middle of a grid is taken.
const STEP: f64 = 1e-2;

/// What the values of a grid are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GridKind {
    /// Heights in µm.
    Sag,
    /// Phases in rad.
    Phase,
}

/// A grid of a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaceGrid {
    /// What its values are.
    pub kind: GridKind,
    /// The file that the scene names.
    pub file: PathBuf,
    /// The values [y, x] with rows growing with y.
    pub values: Arc<Array2<f64>>,
    /// Distance of neighbouring points along x and y in mm.
    pub pitch_mm: [f64; 2],
}

/// An array that a scene names.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedArray {
    /// The file beside the scene.
    pub file: PathBuf,
    /// The path of the scene's field that names it.
    pub field: String,
    /// Its values [y, x].
    pub values: Arc<Array2<f64>>,
}

impl FaceGrid {
    /// The second derivative by y in the middle, in the unit of the values over mm²; zero where there is no spline.
    pub(crate) fn curvature_y(&self) -> f64 {
        let Some(spline) = SagGrid::new(&self.values, self.pitch_mm) else {
            return 0.0;
        };
        let step = STEP * self.pitch_mm[1];
        let at = |y: f64| spline.sag(0.0, y).unwrap_or(0.0);
        (at(step) - 2.0 * at(0.0) + at(-step)) / (step * step)
    }
}

/// The grids of surfaces by the files that a scene names.
pub(crate) fn grids_of(surface: &[Face]) -> BTreeMap<PathBuf, Arc<Array2<f64>>> {
    let grids = surface.iter().filter_map(|face| face.grid.as_ref());
    grids
        .map(|grid| (grid.file.clone(), Arc::clone(&grid.values)))
        .collect()
}

/// The arrays that a scene names, of these grids.
pub(crate) fn named_arrays(
    scene: &Scene,
    grids: &BTreeMap<PathBuf, Arc<Array2<f64>>>,
) -> Vec<ImportedArray> {
    let mut list = Vec::new();
    let mut add = |field: String, file: &PathBuf| {
        if let Some(values) = grids.get(file) {
            list.push(ImportedArray {
                file: file.clone(),
                field,
                values: Arc::clone(values),
            });
        }
    };
    for (i, element) in scene.element.iter().enumerate() {
        for (place, surface) in element.surface_shapes() {
            if let Some(Shape::Grid(grid)) = surface.shape {
                add(
                    format!("element[{i}]{place}.shape.height_um"),
                    &grid.height_um,
                );
            }
        }
        let Element::Doe(doe) = element else {
            continue;
        };
        for (j, layer) in doe.layer.iter().enumerate() {
            if let Layer::PhaseGrid(grid) = layer {
                add(format!("element[{i}].layer[{j}].phase"), &grid.phase);
            }
        }
    }
    list
}

/// The scene with its arrays in memory, checked.
///
/// # Errors
/// An array that does not fit its surface or layer.
pub(crate) fn with_arrays(mut scene: Scene, arrays: &[ImportedArray]) -> Result<Scene, Fault> {
    if arrays.is_empty() {
        return Ok(scene);
    }
    let lent = arrays.iter().map(|array| {
        let values = BorrowedArray::Real(array.values.view());
        (array.field.clone(), values)
    });
    scene.arrays.hold(&lent.collect());
    scene.load()
}
