//! The header of a beam file of Zemax (.zbf): samples, unit, pilot beam, wavelength. All numbers are little endian.
//!
//! | version | whole numbers of 32 bits | numbers of 64 bits |
//! | --- | --- | --- |
//! | 1 | version, nx, ny, polarised, unit, 4 unused | dx, dy, then z, Rayleigh range and waist along x, the same along y, λ, index, two efficiencies, 8 unused |
//! | 0, short | the same | dx, dy, z x, Rayleigh x, λ, z y, Rayleigh y, waist y, waist x, index |
//! | 0, long | the same | dx, dy, z, Rayleigh, λ, waist, 5 unused |
//!
//! Public readers disagree about version 0; the length of the file decides between its two layouts.

/// Bytes of the whole numbers at the start.
pub(crate) const WHOLE: usize = 36;

/// Numbers of 64 bits in the header of version 1, and in both layouts of version 0.
const DOUBLES: usize = 20;
const SHORT: usize = 10;
const LONG: usize = 11;

/// Bytes of a header of version 1.
pub(crate) const BYTES: usize = WHOLE + 8 * DOUBLES;

/// Bytes of a sample of one component.
pub(crate) const SAMPLE: u64 = 16;

/// Units by their number: the name, and how many mm they have.
const UNITS: [(&str, f64); 4] = [("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("m", 1000.0)];

/// What stands before the samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    /// Version of the format, 0 or 1.
    pub(crate) version: u32,
    /// Samples along x and y.
    pub(crate) size: [u32; 2],
    /// Whether Ey follows Ex.
    pub(crate) polarised: bool,
    /// Name of the unit.
    pub(crate) unit: &'static str,
    /// Distance of samples along x and y in mm.
    pub(crate) step_mm: [f64; 2],
    /// The pilot beam along x and y.
    pub(crate) pilot: [Pilot; 2],
    /// Wavelength in mm in the medium.
    pub(crate) wavelength_mm: f64,
    /// Index of the medium.
    pub(crate) index: f64,
    /// Bytes before the samples.
    pub(crate) bytes: usize,
}

/// The Gaussian beam by which OpticStudio chooses its steps, along one axis, in mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pilot {
    /// Position behind the waist.
    pub(crate) z: f64,
    /// Rayleigh range.
    pub(crate) rayleigh: f64,
    /// Radius of the waist.
    pub(crate) waist: f64,
}

impl Pilot {
    /// The radius of the sphere to which phases are relative; none for a plane, within the Rayleigh range.
    pub(crate) fn radius(&self) -> Option<f64> {
        (self.z != 0.0 && self.z.abs() >= self.rayleigh.abs()).then_some(self.z)
    }
}

impl Header {
    /// The header at the start of a file of this length.
    ///
    /// # Errors
    /// What does not belong into a beam file, as (found, expected).
    pub(crate) fn parse(start: &[u8], length: u64) -> Result<Self, (String, String)> {
        let refuse = |found: String, expected: &str| Err((found, expected.to_owned()));
        let [version, nx, ny, polarised, unit] = [0, 1, 2, 3, 4].map(|i| whole(start, i));
        let layouts: &[usize] = match version {
            Some(1) => &[DOUBLES],
            Some(0) => &[SHORT, LONG],
            Some(other) => {
                return refuse(
                    format!("version {other}"),
                    "a binary beam file of version 0 or 1",
                );
            }
            None => return refuse(format!("{length} bytes"), "a header of 36 bytes and more"),
        };
        let (Some(nx @ 1..), Some(ny @ 1..)) = (nx, ny) else {
            let found = format!("{} x {} samples", nx.unwrap_or(0), ny.unwrap_or(0));
            return refuse(found, "at least 1 x 1");
        };
        let size = [nx, ny].map(i32::cast_unsigned);
        let polarised = match polarised {
            Some(0) => false,
            Some(1) => true,
            other => {
                let found = format!("polarised: {}", other.unwrap_or(-1));
                return refuse(found, "0 (no) or 1 (yes)");
            }
        };
        let known = unit.and_then(|unit| usize::try_from(unit).ok());
        let Some((unit, mm)) = known.and_then(|unit| UNITS.get(unit)).copied() else {
            let found = format!("unit {}", unit.unwrap_or(-1));
            return refuse(found, "0 (mm), 1 (cm), 2 (in) or 3 (m)");
        };

        let count = layout_of(layouts, size, polarised, length)?;
        let header = Self {
            version: u32::from(count == DOUBLES),
            size,
            polarised,
            unit,
            bytes: WHOLE + 8 * count,
            ..Self::of_numbers(start.get(WHOLE..).unwrap_or_default(), count, mm)
        };
        header.check()?;
        Ok(header)
    }

    /// What the numbers of 64 bits of a layout say, with lengths in mm.
    fn of_numbers(bytes: &[u8], count: usize, mm: f64) -> Self {
        let number = |i: usize| {
            let eight = bytes.get(8 * i..).and_then(<[u8]>::first_chunk);
            eight.map_or(0.0, |eight| f64::from_le_bytes(*eight))
        };
        let pilot = |places: [usize; 3]| {
            let [z, rayleigh, waist] = places.map(|i| mm * number(i));
            Pilot { z, rayleigh, waist }
        };
        let (places, wavelength, index) = match count {
            DOUBLES => ([[2, 3, 4], [5, 6, 7]], number(8), number(9)),
            SHORT => ([[2, 3, 8], [5, 6, 7]], number(4), number(9)),
            _ => ([[2, 3, 5]; 2], number(4), 1.0),
        };
        Self {
            version: 0,
            size: [0; 2],
            polarised: false,
            unit: "",
            step_mm: [mm * number(0), mm * number(1)],
            pilot: places.map(pilot),
            wavelength_mm: mm * wavelength,
            index,
            bytes: 0,
        }
    }

    /// Refuses steps, wavelengths and indices that no beam has.
    fn check(&self) -> Result<(), (String, String)> {
        let [dx, dy] = self.step_mm;
        for (name, value) in [
            ("dx", dx),
            ("dy", dy),
            ("wavelength", self.wavelength_mm),
            ("index", self.index),
        ] {
            if !(1e-12..=1e12).contains(&value) {
                let expected = "a number from 1e-12 to 1e12 (lengths in mm)";
                return Err((format!("{name} = {value}"), expected.to_owned()));
            }
        }
        Ok(())
    }

    /// Wavelength in vacuum in µm.
    pub(crate) fn vacuum_um(&self) -> f64 {
        self.wavelength_mm * self.index * 1e3
    }

    /// √(dx dy) in mm: what a field of raylet is multiplied by, so that |E|² is the power of a sample.
    pub(crate) fn scale(&self) -> f64 {
        self.step_mm.iter().product::<f64>().sqrt()
    }

    /// The bytes of a header of version 1 in mm.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(BYTES);
        let [nx, ny] = self.size;
        for whole in [1, nx, ny, u32::from(self.polarised), 0, 0, 0, 0, 0] {
            bytes.extend(whole.to_le_bytes());
        }
        let pilots = self.pilot.iter().flat_map(|p| [p.z, p.rayleigh, p.waist]);
        let medium = [self.wavelength_mm, self.index];
        for number in self.step_mm.into_iter().chain(pilots).chain(medium) {
            bytes.extend(number.to_le_bytes());
        }
        bytes.resize(BYTES, 0);
        bytes
    }
}

/// Whole number `i` of the header.
fn whole(start: &[u8], i: usize) -> Option<i32> {
    let four = start.get(4 * i..)?.first_chunk()?;
    Some(i32::from_le_bytes(*four))
}

/// The layout, as its count of numbers, with which the samples end where the file ends.
fn layout_of(
    layouts: &[usize],
    [nx, ny]: [u32; 2],
    polarised: bool,
    length: u64,
) -> Result<usize, (String, String)> {
    let components = if polarised { 2 } else { 1 };
    let samples = u64::from(nx).saturating_mul(u64::from(ny));
    let content = samples.saturating_mul(SAMPLE * components);
    let needs = |count: usize| content.saturating_add((WHOLE + 8 * count) as u64);
    let fits = layouts.iter().find(|count| needs(**count) == length);
    fits.copied().ok_or_else(|| {
        let lengths: Vec<_> = layouts
            .iter()
            .map(|count| needs(*count).to_string())
            .collect();
        let lengths = lengths.join(" or ");
        let expected =
            format!("{lengths} bytes for {nx} x {ny} samples of {components} components");
        (format!("a file of {length} bytes"), expected)
    })
}
