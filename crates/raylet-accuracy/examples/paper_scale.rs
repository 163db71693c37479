//! Rate and memory of the source paper's method on its largest problem: a hologram of 200² pixels, its
//! plano-convex lens, 10⁴ draws at each of as many positions as the argument says.

use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Method, Paper, Sampler, Settings};
use raylet::optics::refraction::Coating;
use raylet::optics::system::System;
use raylet_accuracy::problems::problem::{doe, face, random_pixels, sensor};
use raylet_testkit::parts::plane_wave;

const PITCH: f64 = 6.3e-3;

fn main() {
    let positions = std::env::args().nth(1).and_then(|n| n.parse().ok());
    let index = 1.513_063_997_196;
    let surface = |z, radius, index| face(z, radius, 12.7, Coating::Ideal, index);
    let system = System {
        wavelength: 0.7e-3,
        source: plane_wave([0.0; 2]),
        screens: vec![
            doe(0.0, &random_pixels(200, PITCH)),
            sensor(53.0, 200, PITCH),
        ],
        trains: vec![vec![
            surface(3.0, 25.8, [1.0, index]),
            surface(8.3, f64::INFINITY, [index, 1.0]),
        ]],
    };
    for sampler in [Sampler::Multinomial, Sampler::Systematic] {
        let settings = Settings {
            method: Method::Paper,
            paper: Paper {
                rays: positions.unwrap_or(400),
                secondary: 10_000,
                patch: Some(100.0 * PITCH),
                sampler,
                ..Paper::default()
            },
            ..Settings::default()
        };
        match simulate(&system, &settings, &|_| {}) {
            Err(error) => println!("{error}"),
            Ok(outcome) => {
                let hop = &outcome.hops[0];
                println!(
                    "{sampler:?}: {} rays for {:.1e} draws in {:.1} s: {:.2e} draws/s, standard error {:.3}",
                    hop.tally.total_rays(),
                    hop.method.rays(),
                    hop.seconds,
                    hop.method.rays() / hop.seconds,
                    hop.tally.standard_error().unwrap_or(f64::NAN)
                );
            }
        }
    }
    // The most that was ever held.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    for line in status.lines().filter(|line| line.starts_with("VmHWM")) {
        println!("{line}");
    }
}
