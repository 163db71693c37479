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
