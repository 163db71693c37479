//! Draws scenes/smiley.png, the target of the source paper's free-space and lens holograms.
//!
//! `cargo run --release -p raylet --example draw_smiley -- scenes/smiley.png`

use raylet::design::smiley::smiley;
use raylet::file::image::{ImageError, write_gray16};

fn main() -> Result<(), ImageError> {
    let path = std::env::args().nth(1);
    let path = path.unwrap_or_else(|| String::from("scenes/smiley.png"));
    write_gray16(path, smiley(100).view(), [0.0, 1.0])
}
