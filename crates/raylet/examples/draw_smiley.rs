//! Draws scenes/smiley.png, the target of the source paper's free-space and lens holograms; with a number of
//! pixels along a side, the same enlarged as the paper's is for its designs.
//!
//! `cargo run --release -p raylet --example draw_smiley -- scenes/smiley.png`
//! `cargo run --release -p raylet --example draw_smiley -- scenes/paper/smiley.png 200`

use raylet::file::arrays::image::{ImageError, write_gray16};
use raylet_testkit::smiley::{enlarged, smiley};

fn main() -> Result<(), ImageError> {
    let path = std::env::args().nth(1);
    let path = path.unwrap_or_else(|| String::from("scenes/smiley.png"));
    let side = std::env::args().nth(2).and_then(|side| side.parse().ok());
    let image = match side {
        Some(side) => enlarged(&smiley(100), side),
        None => smiley(100),
    };
    write_gray16(path, image.view(), [0.0, 1.0])
}
