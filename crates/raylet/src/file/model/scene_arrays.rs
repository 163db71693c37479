//! All the arrays that the layers of a scene name, and the transmissions they make.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

use crate::file::arrays::array::{Array, BorrowedArray};
use crate::file::arrays::memory::MemoryLimit;
use crate::file::decode::fault::Fault;
use crate::file::decode::origin::Origin;
use crate::file::maps::array_file::{SampledArray, read_array};
use crate::file::scene::element::Element;
use crate::file::scene::illumination::{FieldIllumination, Illumination};
use crate::file::scene::layer::{HeightLayer, Layer, PhaseGridLayer, PixelLayer, SumLayer};
use crate::file::scene::surface_shape::{GridShape, Shape, SurfaceShape};
use crate::math::spline::FEWEST;
use crate::optics::shape as optics;

/// Arrays by the path of the field that names their file, such as `element[0].layer[1].phase`. A file
/// that several fields name is held once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrays<'a> {
    by_field: BTreeMap<String, Source<'a>>,
}

/// Where the values of a field are.
#[derive(Clone, Debug, PartialEq)]
enum Source<'a> {
    /// Read from a file.
    Held(Arc<Array>),
    /// In the memory of a caller, who gave them in place of a file.
    Lent(BorrowedArray<'a>),
}

impl<'a> Source<'a> {
    fn borrowed(&self) -> BorrowedArray<'_> {
        match self {
            Source::Held(array) => array.borrowed(),
            Source::Lent(array) => array.shorter(),
        }
    }

    /// The same for a shorter while.
    fn shorter<'b>(&self) -> Source<'b>
    where
        'a: 'b,
    {
        match self {
            Source::Held(array) => Source::Held(Arc::clone(array)),
            Source::Lent(look) => Source::Lent(look.shorter()),
        }
    }
}

impl<'a> Arrays<'a> {
    /// Every array that the light and the elements name, within `limit` bytes for all of them. Those that are `lent`, by the
    /// path of the field, are taken from there, and are not copied; those that are `held` already are shared;
    /// the rest are read.
    ///
    /// # Errors
    /// The first array that cannot be used, reported at the field that names it.
    pub(crate) fn load(
        light: &Illumination,
        elements: &[Element],
        origin: &Origin,
        limit: u64,
        lent: &BTreeMap<String, BorrowedArray<'a>>,
        held: &Arrays<'static>,
    ) -> Result<Self, Fault> {
        let mut loader = Loader {
            origin,
            lent,
            held,
            left: limit,
            by_file: BTreeMap::new(),
            by_field: BTreeMap::new(),
        };
        if let Illumination::Field(field) = light {
            loader.field(field)?;
        }
        for (i, element) in elements.iter().enumerate() {
            if let Element::Doe(doe) = element {
                loader.layers(&doe.layer, &format!("element[{i}].layer"))?;
            }
            for (place, surface) in element.surface_shapes() {
                if let Some(Shape::Grid(grid)) = surface.shape {
                    loader.grid(grid, &format!("element[{i}]{place}.shape"))?;
                }
            }
        }
        Ok(Self {
            by_field: loader.by_field,
        })
    }

    /// Adds copies of arrays in the memory of a caller, by the path of the field that each replaces.
    pub(crate) fn hold(&mut self, lent: &BTreeMap<String, BorrowedArray<'_>>) {
        let copy = |(path, look): (&String, &BorrowedArray)| {
            let array = match look {
                BorrowedArray::Real(values) => Array::Real(values.to_owned()),
                BorrowedArray::Complex(values) => Array::Complex(values.to_owned()),
            };
            (path.clone(), Source::Held(Arc::new(array)))
        };
        self.by_field.extend(lent.iter().map(copy));
    }

    /// The array of a field, if it names one and is loaded.
    pub(crate) fn get(&self, field: &str) -> Option<BorrowedArray<'_>> {
        self.by_field.get(field).map(Source::borrowed)
    }

    /// The complex transmission [y, x] of the active areas of a pixel layer at the path `layer_path`: amplitude times
    /// exp(i · scale · phase), or the transmission itself, or ones for a blank of known size. Nothing when its arrays are not
    /// loaded.
    pub(crate) fn transmission(
        &self,
        layer: &PixelLayer,
        layer_path: &str,
    ) -> Option<Array2<Complex64>> {
        let get = |key: &str| self.get(&format!("{layer_path}.{key}"));
        if layer.transmission.is_some() {
            return get("transmission").map(complex);
        }

        // A missing factor is one; a named one must be there.
        let phase = layer.phase.as_ref().map(|_| get("phase"));
        let amplitude = layer.amplitude.as_ref().map(|_| get("amplitude"));
        match (phase, amplitude) {
            (None, None) => layer
                .size
                .map(|[nx, ny]| Array2::from_elem((ny, nx), Complex64::new(1.0, 0.0))),
            (Some(phase), None) => Some(phases(phase?, layer.phase_scale)),
            (None, Some(amplitude)) => Some(complex(amplitude?)),
            (Some(phase), Some(amplitude)) => {
                Some(phases(phase?, layer.phase_scale) * complex(amplitude?))
            }
        }
    }

    /// The samples [y, x] of the source's field; nothing when not loaded.
    pub(crate) fn source_samples(&self) -> Option<Array2<Complex64>> {
        self.get("source.samples").map(complex)
    }

    /// The shape that the keys of a surface at a path describe; nothing when its array is not loaded.
    pub(crate) fn shape(&self, shape: &SurfaceShape<'_>, path: &str) -> Option<optics::Shape> {
        shape.optics(self.heights_um(&format!("{path}.shape")))
    }

    /// The heights [y, x] in µm of a height layer or grid at a path; nothing when not loaded.
    pub(crate) fn heights_um(&self, path: &str) -> Option<ArrayView2<'_, f64>> {
        self.real(&format!("{path}.height_um"))
    }

    /// The real array [y, x] of a field; nothing when not loaded.
    pub(crate) fn real(&self, field: &str) -> Option<ArrayView2<'_, f64>> {
        match self.get(field) {
            Some(BorrowedArray::Real(values)) => Some(values),
            _ => None,
        }
    }
}

/// Any array as complex numbers.
fn complex(array: BorrowedArray) -> Array2<Complex64> {
    match array {
        BorrowedArray::Real(values) => values.mapv(|x| Complex64::new(x, 0.0)),
        BorrowedArray::Complex(values) => values.to_owned(),
    }
}

/// exp(i · scale · phase) of a real array.
fn phases(array: BorrowedArray, scale: f64) -> Array2<Complex64> {
    match array {
        BorrowedArray::Real(values) => values.mapv(|phase| Complex64::cis(scale * phase)),
        BorrowedArray::Complex(values) => values.mapv(|phase| Complex64::cis(scale * phase.re)),
    }
}

/// The state of loading: what is left of the memory, and what is there already.
struct Loader<'s, 'a> {
    origin: &'s Origin,
    lent: &'s BTreeMap<String, BorrowedArray<'a>>,
    held: &'s Arrays<'static>,
    left: u64,
    by_file: BTreeMap<(PathBuf, Option<String>, String), SampledArray>,
    by_field: BTreeMap<String, Source<'a>>,
}

impl<'a> Loader<'_, 'a> {
    /// Loads the arrays of a list of layers at this path.
    fn layers(&mut self, layers: &[Layer], path: &str) -> Result<(), Fault> {
        for (i, layer) in layers.iter().enumerate() {
            let path = format!("{path}[{i}]");
            match layer {
                Layer::Pixels(pixels) => self.pixels(pixels, &path)?,
                Layer::Height(height) => self.height(height, &path)?,
                Layer::PhaseGrid(grid) => self.phase_grid(grid, &path)?,
                Layer::Kinoform(kinoform) => {
                    self.layers(&kinoform.layer, &format!("{path}.layer"))?;
                }
                Layer::Sum(sum) => self.sum(sum, &path)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// The samples of a source, which are held at twice their number along each axis.
    fn field(&mut self, field: &FieldIllumination) -> Result<(), Fault> {
        let array = self.array(
            &field.samples,
            field.key.as_deref(),
            ("source", "samples"),
            field.pitch_um,
        )?;
        let [ny, nx] = array.borrowed().shape();
        let refuse = |(found, expected)| self.origin.fault("source.samples", found, expected);
        let given = format!("{ny} rows of {nx}");
        if let Some([width, height]) = field.size.filter(|size| *size != [nx, ny]) {
            let expected = format!("{height} rows of {width} as in its size");
            return Err(refuse((given, expected)));
        }
        let bytes = (nx as u64).saturating_mul(ny as u64).saturating_mul(4 * 16);
        let limit = MemoryLimit::of_settings(self.left);
        limit.check(given, bytes).map_err(refuse)?;
        self.left -= bytes;
        Ok(())
    }

    fn sum(&mut self, sum: &SumLayer, path: &str) -> Result<(), Fault> {
        for (i, term) in sum.terms.iter().enumerate() {
            self.layers(term, &format!("{path}.terms[{i}]"))?;
        }
        Ok(())
    }

    fn height(&mut self, layer: &HeightLayer, path: &str) -> Result<(), Fault> {
        let key = layer.key.as_deref();
        let array = self.array(&layer.height_um, key, (path, "height_um"), layer.pitch_um)?;
        self.require_real(&array, path, "height_um")?;
        self.require_size(
            &array,
            layer.size,
            &layer.height_um,
            &format!("{path}.height_um"),
        )
    }

    fn phase_grid(&mut self, layer: &PhaseGridLayer, path: &str) -> Result<(), Fault> {
        let array = self.array(
            &layer.phase,
            layer.key.as_deref(),
            (path, "phase"),
            layer.pitch_um,
        )?;
        self.require_real(&array, path, "phase")?;
        let field = format!("{path}.phase");
        self.require_size(&array, layer.size, &layer.phase, &field)?;
        self.require_spline(&array, &layer.phase, &field)
    }

    /// An array has the size that its layer gives.
    fn require_size(
        &self,
        array: &Source,
        size: Option<[usize; 2]>,
        file: &Path,
        field: &str,
    ) -> Result<(), Fault> {
        let [ny, nx] = array.borrowed().shape();
        match size {
            Some([width, height]) if [width, height] != [nx, ny] => {
                let found = format!("{}: {ny} rows of {nx}", file.display());
                let expected = format!("{height} rows of {width} as in its size");
                Err(self.origin.fault(field, found, expected))
            }
            _ => Ok(()),
        }
    }

    /// A spline through an array needs a few values along each axis.
    fn require_spline(&self, array: &Source, file: &Path, field: &str) -> Result<(), Fault> {
        let [ny, nx] = array.borrowed().shape();
        if ny < FEWEST || nx < FEWEST {
            let found = format!("{}: {ny} rows of {nx}", file.display());
            let expected = format!("at least {FEWEST} rows of {FEWEST} for a spline");
            return Err(self.origin.fault(field, found, expected));
        }
        Ok(())
    }

    fn grid(&mut self, grid: &GridShape, path: &str) -> Result<(), Fault> {
        let array = self.array(
            &grid.height_um,
            grid.key.as_deref(),
            (path, "height_um"),
            grid.pitch_um,
        )?;
        self.require_real(&array, path, "height_um")?;
        self.require_spline(&array, &grid.height_um, &format!("{path}.height_um"))
    }

    fn pixels(&mut self, layer: &PixelLayer, path: &str) -> Result<(), Fault> {
        // All arrays of a layer, and its size where that is given, must agree in shape.
        let mut shape = layer.size.map(|[nx, ny]| [ny, nx]);
        let named = [
            ("phase", &layer.phase),
            ("amplitude", &layer.amplitude),
            ("transmission", &layer.transmission),
        ];
        for (field, file) in named {
            let Some(file) = file else { continue };
            let array = self.array(file, layer.key.as_deref(), (path, field), layer.pitch_um)?;
            if field != "transmission" {
                self.require_real(&array, path, field)?;
            }
            let given = array.borrowed().shape();
            match shape {
                Some(expected) if expected != given => {
                    let [ny, nx] = given;
                    let found = format!("{}: {ny} rows of {nx}", file.display());
                    let [ny, nx] = expected;
                    let expected = format!("{ny} rows of {nx} as in the rest of the layer");
                    return Err(self
                        .origin
                        .fault(&format!("{path}.{field}"), found, expected));
                }
                _ => shape = Some(given),
            }
        }
        self.sub_pixels(layer, shape, path)?;
        self.blank(layer, path)
    }

    /// Sub-pixels take memory besides the pixels.
    fn sub_pixels(
        &mut self,
        layer: &PixelLayer,
        shape: Option<[usize; 2]>,
        path: &str,
    ) -> Result<(), Fault> {
        let (Some([ny, nx]), Some(fringing)) = (shape, layer.fringing()) else {
            return Ok(());
        };
        let [rows, columns] = [ny, nx].map(|count| count.saturating_mul(fringing.sub_pixels));
        let bytes = (rows as u64)
            .saturating_mul(columns as u64)
            .saturating_mul(16);
        MemoryLimit::of_settings(self.left)
            .check(format!("{rows} rows of {columns} sub-pixels"), bytes)
            .map_err(|(found, expected)| {
                let field = format!("{path}.sub_pixels");
                self.origin.fault(&field, found, expected)
            })?;
        self.left -= bytes;
        Ok(())
    }

    /// A layer of known size without arrays takes memory too.
    fn blank(&mut self, layer: &PixelLayer, path: &str) -> Result<(), Fault> {
        let named = [&layer.phase, &layer.amplitude, &layer.transmission];
        let Some([nx, ny]) = layer
            .size
            .filter(|_| named.iter().all(|file| file.is_none()))
        else {
            return Ok(());
        };
        let bytes = (nx as u64).saturating_mul(ny as u64).saturating_mul(16);
        MemoryLimit::of_settings(self.left)
            .check(format!("{ny} rows of {nx}"), bytes)
            .map_err(|(found, expected)| {
                self.origin.fault(&format!("{path}.size"), found, expected)
            })?;
        self.left -= bytes;
        Ok(())
    }

    fn require_real(&self, array: &Source, path: &str, field: &str) -> Result<(), Fault> {
        match array.borrowed() {
            BorrowedArray::Real(_) => Ok(()),
            BorrowedArray::Complex(_) => Err(self
                .origin
                .fault(
                    &format!("{path}.{field}"),
                    "a complex array",
                    "a real array",
                )
                .hint("complex arrays belong under `transmission`")),
        }
    }

    /// The array that one field names, read unless it is there already. A file that says its pitch must say that of the scene.
    fn array(
        &mut self,
        file: &Path,
        key: Option<&str>,
        (path, field): (&str, &str),
        pitch_um: [f64; 2],
    ) -> Result<Source<'a>, Fault> {
        let path = format!("{path}.{field}");
        if let Some(look) = self.lent.get(&path) {
            look.check(field)
                .map_err(|(found, expected)| self.origin.fault(&path, found, expected))?;
            let lent = Source::Lent(*look);
            self.by_field.insert(path, lent.clone());
            return Ok(lent);
        }
        if let Some(held) = self.held.by_field.get(&path) {
            self.by_field.insert(path, held.shorter());
            return Ok(held.shorter());
        }
        let file = self.origin.beside(file);
        let identity = (file.clone(), key.map(str::to_owned), field.to_owned());
        let read = match self.by_file.get(&identity) {
            Some(read) => read.clone(),
            None => {
                let read = read_array(&file, key, field, self.left)
                    .map_err(|inner| self.origin.fault_of_file(&path, inner))?;
                self.left = self.left.saturating_sub(read.values.bytes());
                read
            }
        };
        read.require_pitch(pitch_um).map_err(|(found, expected)| {
            let inner = Fault::of_file(&file, found, expected);
            self.origin.fault_of_file(&path, inner)
        })?;
        let held = Source::Held(Arc::clone(&read.values));
        self.by_file.insert(identity, read);
        self.by_field.insert(path, held.clone());
        Ok(held)
    }
}
