//! How far raylet is off on curved diffractive mirrors, by both of its methods.

use raylet::engine::settings::{Method, Settings};
use raylet_accuracy::mirror::{Bench, Coat};
fn main() {
    let quick = |coat| Bench {
        coat,
        width: 160.0,
        distance: 250.0,
        points: 24,
        pitch: 1.3,
    };
    for (name, coat) in [
        ("bare", Coat::Bare),
        ("focus", Coat::Focus(250.0)),
        ("two foci", Coat::TwoFoci(0.08, 250.0)),
        ("random", Coat::Random(2.0)),
    ] {
        for method in [Method::Auto, Method::Beamlet] {
            let settings = Settings {
                method,
                ..Settings::default()
            };
            let nodes = if let Coat::Random(_) = coat { 6 } else { 4 };
            let p = quick(coat).problem(name, settings, nodes);
            match p.measure() {
                Ok(m) => println!("{}: {m:?}", p.name),
                Err(e) => println!("{}: {e}", p.name),
            }
        }
    }
}
