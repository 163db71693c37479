//! The cells of an element, row by row: an array is never needed as a whole.

use std::path::{Path, PathBuf};

use crate::file::arrays::array::BorrowedArray;
use crate::file::decode::fault::Fault;
use crate::file::fabrication::designed_levels::DesignedLevels;
use crate::file::fabrication::export_choices::Quantity;
use crate::file::fabrication::open_part::OpenPart;
use crate::file::fabrication::relief::Relief;
use crate::optics::aperture::Aperture;
use crate::optics::pixels::active_area::ActiveArea;

/// Rows of numbers, from any place and in any order.
pub(crate) trait CellRows {
    /// Number of cells [nx, ny].
    fn size(&self) -> [usize; 2];

    /// Puts the numbers of row `y`, along x, into `values`, which has room for one row. Rows grow with y.
    ///
    /// # Errors
    /// A file that cannot be read.
    fn row(&mut self, y: usize, values: &mut [f64]) -> Result<(), Fault>;
}

/// The cells of an element, and what is known of them.
pub(crate) struct Cells<'a> {
    /// Their rows.
    pub rows: Box<dyn CellRows + 'a>,
    /// Distance of neighbouring cells along x and y, in µm.
    pub pitch_um: [f64; 2],
    /// What they hold.
    pub quantity: Quantity,
    /// The relief that makes a phase, as far as it is known.
    pub relief: Relief,
    /// The part that the aperture of the element leaves open, where it is not left out.
    pub open: Option<OpenPart>,
    /// The aperture on the axes of the cells, where it has a shape on these.
    pub aperture: Option<Aperture>,
    /// The levels that the scene states.
    pub designed: Option<DesignedLevels>,
    /// The part of a cell that has its value.
    pub active: ActiveArea,
    /// Whether rows are mirrored in x.
    pub mirror: bool,
    /// The file that a message names.
    pub file: PathBuf,
    /// What the element is called.
    pub name: String,
    /// What the export leaves out, in sentences.
    pub losses: Vec<String>,
}

impl<'a> Cells<'a> {
    /// Touching cells without an aperture, of which nothing else is known.
    pub(crate) fn new(rows: Box<dyn CellRows + 'a>, pitch_um: [f64; 2], file: &Path) -> Self {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        Self {
            rows,
            pitch_um,
            quantity: Quantity::Phase,
            relief: Relief::default(),
            open: None,
            aperture: None,
            designed: None,
            active: ActiveArea::WHOLE,
            mirror: false,
            file: file.to_path_buf(),
            name: name.into_owned(),
            losses: Vec::new(),
        }
    }

    /// Number of cells [nx, ny].
    pub(crate) fn size(&self) -> [usize; 2] {
        self.rows.size()
    }

    /// Calls `visit` with each row, from that of the smallest y.
    ///
    /// # Errors
    /// A row that cannot be read, a value that is not finite, or an error of `visit`.
    pub(crate) fn each_row(
        &mut self,
        mut visit: impl FnMut(usize, &[f64]) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let [nx, ny] = self.size();
        let mut values = vec![0.0; nx];
        for y in 0..ny {
            self.read_row(y, &mut values)?;
            visit(y, &values)?;
        }
        Ok(())
    }

    /// One row, as the element is seen: [`CLOSED`](crate::file::fabrication::open_part::CLOSED) outside of its aperture.
    ///
    /// # Errors
    /// A row that cannot be read, or a value that is not finite.
    pub(crate) fn read_row(&mut self, y: usize, values: &mut [f64]) -> Result<(), Fault> {
        self.rows.row(y, values)?;
        if let Some(x) = values.iter().position(|value| !value.is_finite()) {
            let found = format!("a value at [{y}, {x}] that is not finite");
            return Err(Fault::of_file(&self.file, found, "finite values only"));
        }
        if let Some(open) = &self.open {
            open.close(y, self.rows.size(), values);
        }
        if self.mirror {
            values.reverse();
        }
        Ok(())
    }
}

/// Which real number is taken of a complex one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Its argument.
    Phase,
    /// Its modulus.
    Amplitude,
}

impl Part {
    /// The number of a complex one.
    pub(crate) fn of(self, re: f64, im: f64) -> f64 {
        match self {
            Self::Phase => im.atan2(re),
            Self::Amplitude => re.hypot(im),
        }
    }
}

/// Which part of complex numbers a quantity is.
///
/// # Errors
/// A quantity that is real.
pub(crate) fn part_of(file: &Path, quantity: Quantity) -> Result<Part, Fault> {
    match quantity {
        Quantity::Phase => Ok(Part::Phase),
        Quantity::Amplitude => Ok(Part::Amplitude),
        Quantity::Height | Quantity::Level => {
            let expected = format!("real numbers of a {}", quantity.with_unit());
            Err(Fault::of_file(file, "complex numbers", expected))
        }
    }
}

/// Rows of an array that somebody else holds, times a factor.
pub(crate) struct BorrowedRows<'a> {
    /// The array.
    pub array: BorrowedArray<'a>,
    /// What is taken of complex numbers.
    pub part: Part,
    /// The factor.
    pub scale: f64,
}

impl CellRows for BorrowedRows<'_> {
    fn size(&self) -> [usize; 2] {
        let [ny, nx] = self.array.shape();
        [nx, ny]
    }

    fn row(&mut self, y: usize, values: &mut [f64]) -> Result<(), Fault> {
        match &self.array {
            BorrowedArray::Real(array) => {
                let row = (y < array.nrows()).then(|| array.row(y));
                let numbers = row.iter().flatten();
                (values.iter_mut().zip(numbers)).for_each(|(to, from)| *to = self.scale * from);
            }
            BorrowedArray::Complex(array) => {
                let row = (y < array.nrows()).then(|| array.row(y));
                let numbers = row.iter().flatten().map(|z| self.part.of(z.re, z.im));
                (values.iter_mut().zip(numbers)).for_each(|(to, from)| *to = self.scale * from);
            }
        }
        Ok(())
    }
}

/// Rows of levels, each times a step.
pub(crate) struct LevelRows {
    /// Number of cells [nx, ny].
    pub size: [usize; 2],
    /// The levels, row by row.
    pub levels: Vec<u16>,
    /// The value of a level over that of the one below.
    pub step: f64,
}

impl CellRows for LevelRows {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn row(&mut self, y: usize, values: &mut [f64]) -> Result<(), Fault> {
        let [nx, _] = self.size;
        let row = self.levels.chunks(nx.max(1)).nth(y).unwrap_or_default();
        (values.iter_mut().zip(row)).for_each(|(to, level)| *to = self.step * f64::from(*level));
        Ok(())
    }
}

/// Rows of a function of x and y in mm, at the centres of a grid about the origin.
pub(crate) struct FunctionRows<F> {
    /// Number of cells [nx, ny].
    pub size: [usize; 2],
    /// Distance of neighbouring cells in mm.
    pub pitch: [f64; 2],
    /// The function.
    pub function: F,
}

impl<F: Fn(f64, f64) -> f64> CellRows for FunctionRows<F> {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn row(&mut self, y: usize, values: &mut [f64]) -> Result<(), Fault> {
        let [nx, ny] = self.size;
        let [dx, dy] = self.pitch;
        let at = |i: usize, count: usize, pitch: f64| {
            (i as f64 - 0.5 * (count.saturating_sub(1)) as f64) * pitch
        };
        let height = at(y, ny, dy);
        for (x, value) in values.iter_mut().enumerate() {
            *value = (self.function)(at(x, nx, dx), height);
        }
        Ok(())
    }
}
