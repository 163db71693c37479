//! FITS files: headers of cards and arrays of big-endian numbers, read and written.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `fits_header` | The cards of a header: keywords and their values |
//! | `fits_reader` | The images of a FITS file, found without their data and read one by one |
//! | `fits_writer` | Headers and arrays in whole blocks of 2880 bytes |

pub(crate) mod fits_header;
pub(crate) mod fits_reader;
pub(crate) mod fits_writer;
