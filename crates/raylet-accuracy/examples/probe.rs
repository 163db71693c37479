//! scratch
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use raylet::engine::plan::Plan;
use raylet::engine::settings::*;
use raylet::engine::simulate::simulate;
use raylet::engine::tally::FATES;
use raylet::math::random::uniform;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::bend::*;
use raylet::optics::doe::*;
use raylet::optics::frame::Frame;
use raylet::optics::screen::*;
use raylet::optics::shape::*;
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet_accuracy::collins::*;
use raylet_accuracy::pixels::Pixels as RefPixels;
use raylet_accuracy::rayleigh_sommerfeld::rayleigh_sommerfeld;

fn at(z: f64) -> Frame {
    Frame::GLOBAL.moved(Vec3::new(0.0, 0.0, z))
}
fn random_phase(n: usize) -> Array2<Complex64> {
    Array2::from_shape_fn((n, n), |(j, i)| {
        Complex64::cis(std::f64::consts::TAU * uniform(7, [j as u32, i as u32, 0, 0]))
    })
}
fn doe_screen(values: Array2<Complex64>, pitch: f64) -> Screen {
    Screen {
        name: "doe".into(),
        frame: Frame::GLOBAL,
        index: 1.0,
        arrives: 1.0,
        act: Act::Doe(Doe {
            layers: vec![Layer::Pixels(Pixels {
                pitch: [pitch; 2],
                values,
                form: PixelForm::Box,
            })],
            aperture: Aperture::OPEN,
            reflect: false,
        }),
    }
}
fn sensor(z: f64, n: usize, pitch: f64) -> Screen {
    Screen {
        name: "sensor".into(),
        frame: at(z),
        index: 1.0,
        arrives: 1.0,
        act: Act::Sensor(Sensor {
            pixels: [n, n],
            pitch: [pitch; 2],
        }),
    }
}
fn plane(p: [f64; 2]) -> Source {
    Source::Plane {
        direction: Vec3::new(p[0], p[1], (1.0 - p[0] * p[0] - p[1] * p[1]).sqrt()),
        origin: Vec3::new(0.0, 0.0, 0.0),
    }
}
fn error(a: &Array2<Complex64>, b: &Array2<Complex64>) -> (f64, f64) {
    let norm: f64 = b.iter().map(|v| v.norm_sqr()).sum();
    let e: f64 = a.iter().zip(b).map(|(x, y)| (x - y).norm_sqr()).sum();
    let cross: Complex64 = a.iter().zip(b).map(|(x, y)| x.conj() * y).sum();
    let na: f64 = a.iter().map(|v| v.norm_sqr()).sum();
    let shape = 1.0 - cross.norm_sqr() / na / norm;
    ((e / norm).sqrt(), shape.max(0.0).sqrt())
}
fn report(name: &str, system: &System, settings: &Settings, exact: &Array2<Complex64>) {
    let clock = std::time::Instant::now();
    let out = simulate(system, settings, &|_| {}).unwrap();
    let seconds = clock.elapsed().as_secs_f64();
    let (e, s) = error(&out.field.values, exact);
    println!("{name}: error {e:.2e} shape {s:.2e} in {seconds:.3} s");
    for hop in &out.hops {
        match &hop.plan {
            Plan::Free(_, f) => println!("   free {:?}", f.bands.map(|b| b.count)),
            Plan::Beamlets(b) => println!(
                "   sigma {:.4} bands {:?} eta {:.1e} -> {:.1e} correct {} actual eta {:.1e} -> {:.1e} dropped {:.1e} rays {} evals {:.2e} predicted {:.2} s foot {:.3}",
                b.sigma,
                b.bands.map(|b| b.count),
                b.eta,
                b.eta_corrected,
                b.correct,
                hop.tally.eta(),
                hop.tally.eta_corrected(),
                hop.tally.dropped(),
                hop.tally.total_rays(),
                hop.tally.evaluations as f64,
                b.seconds,
                b.footprint
            ),
        }
        print!(
            "   power {:?} samples {:?} t {:.3}",
            hop.power, hop.samples, hop.seconds
        );
        for f in FATES {
            let s = hop.tally.share(f);
            if s > 0.0 {
                print!(" {} {:.4} ({})", f.name(), s, hop.tally.rays(f));
            }
        }
        println!();
    }
}
fn main() {
    let which: String = std::env::args().nth(1).unwrap_or("free".into());
    if which == "free" {
        let n = 120;
        for tilt in [[0.0, 0.0], [10f64.to_radians().sin(), 0.0]] {
            for z in [30.0, 120.0, 400.0] {
                let system = System {
                    wavelength: 1.0,
                    source: plane(tilt),
                    screens: vec![doe_screen(random_phase(n), 0.5), sensor(z, 40, 1.7)],
                    trains: vec![vec![]],
                };
                let axis: Vec<f64> = (0..40).map(|i| (i as f64 - 19.5) * 1.7).collect();
                let mut points = vec![];
                for y in &axis {
                    for x in &axis {
                        points.push([*x, *y, z]);
                    }
                }
                let exact = rayleigh_sommerfeld(
                    &RefPixels {
                        pitch: 0.5,
                        transmission: random_phase(n),
                    },
                    tilt,
                    1.0,
                    4,
                    &points,
                );
                let exact = Array2::from_shape_vec((40, 40), exact).unwrap();
                for padding in [4.0, 6.0] {
                    report(
                        &format!("free z {z} tilt {tilt:?} padding {padding}"),
                        &system,
                        &Settings {
                            padding,
                            ..Settings::default()
                        },
                        &exact,
                    );
                }
                report(
                    &format!("beamlets z {z}"),
                    &system,
                    &Settings {
                        method: Method::Beamlet,
                        ..Settings::default()
                    },
                    &exact,
                );
            }
        }
    }
    if which == "vary" {
        let n = 120;
        let z = 120.0;
        let system = System {
            wavelength: 1.0,
            source: plane([0.0; 2]),
            screens: vec![doe_screen(random_phase(n), 0.5), sensor(z, 40, 1.7)],
            trains: vec![vec![]],
        };
        let axis: Vec<f64> = (0..40).map(|i| (i as f64 - 19.5) * 1.7).collect();
        let mut points = vec![];
        for y in &axis {
            for x in &axis {
                points.push([*x, *y, z]);
            }
        }
        let exact = rayleigh_sommerfeld(
            &RefPixels {
                pitch: 0.5,
                transmission: random_phase(n),
            },
            [0.0; 2],
            1.0,
            4,
            &points,
        );
        let exact = Array2::from_shape_vec((40, 40), exact).unwrap();
        let base = Settings {
            method: Method::Beamlet,
            ..Settings::default()
        };
        report("base", &system, &base, &exact);
        report(
            "modes 1e-4",
            &system,
            &Settings {
                mode_threshold: 1e-4,
                ..base.clone()
            },
            &exact,
        );
        report(
            "foot 1e-5",
            &system,
            &Settings {
                footprint_threshold: 1e-5,
                ..base.clone()
            },
            &exact,
        );
        report(
            "step 1.25",
            &system,
            &Settings {
                step: 1.25,
                ..base.clone()
            },
            &exact,
        );
        report(
            "period 7",
            &system,
            &Settings {
                period: 7.0,
                ..base.clone()
            },
            &exact,
        );
        report(
            "correct",
            &system,
            &Settings {
                correction: Correction::On,
                ..base.clone()
            },
            &exact,
        );
        report(
            "sigma 6",
            &system,
            &Settings {
                sigma: Some(6.0),
                ..base.clone()
            },
            &exact,
        );
        report(
            "sigma 15",
            &system,
            &Settings {
                sigma: Some(15.0),
                ..base.clone()
            },
            &exact,
        );
    }
    if which == "lens" {
        let n = 200;
        let lam = 0.7e-3;
        let index = 1.513063997196;
        for (orientation, z) in [(0, 44.7), (0, 46.7), (0, 40.0), (1, 44.7), (1, 49.0)] {
            let radius = 25.8;
            let mut face = |z: f64, c: f64, n: [f64; 2]| Surface {
                shape: if c == 0.0 {
                    Shape::Plane
                } else {
                    Shape::Conic(Conic {
                        curvature: c,
                        conic: 0.0,
                    })
                },
                frame: at(z),
                aperture: Aperture::disc(12.7),
                interface: Interface::Refract,
                coating: Coating::Ideal,
                index: n,
            };
            let train = if orientation == 0 {
                vec![
                    face(3.0, 1.0 / radius, [1.0, index]),
                    face(8.3, 0.0, [index, 1.0]),
                ]
            } else {
                vec![
                    face(3.0, 0.0, [1.0, index]),
                    face(8.3, -1.0 / radius, [index, 1.0]),
                ]
            };
            let system = System {
                wavelength: lam,
                source: plane([0.0; 2]),
                screens: vec![
                    doe_screen(random_phase(n), 6.3e-3),
                    sensor(8.3 + z, 256, 6.3e-3),
                ],
                trains: vec![train],
            };
            let power = (index - 1.0) / radius;
            let abcd = Abcd::identity().drift(3.0, 1.0);
            let abcd = if orientation == 0 {
                abcd.refract(power).drift(5.3, index).refract(0.0)
            } else {
                abcd.drift(5.3, index).refract(power)
            }
            .drift(z, 1.0);
            let axis = Array1::from_iter((0..256).map(|i| (i as f64 - 127.5) * 6.3e-3));
            let exact = collins(
                &RefPixels {
                    pitch: 6.3e-3,
                    transmission: random_phase(n),
                },
                [0.0; 2],
                lam,
                abcd,
                4,
                [&axis, &axis],
            )
            .unwrap();
            report(
                &format!("lens orientation {orientation} z {z}"),
                &system,
                &Settings::default(),
                &exact,
            );
            let a = simulate(&system, &Settings::default(), &|_| {})
                .unwrap()
                .field
                .values;
            let b = simulate(
                &system,
                &Settings {
                    sigma: Some(0.07),
                    ..Settings::default()
                },
                &|_| {},
            )
            .unwrap()
            .field
            .values;
            let c = simulate(
                &system,
                &Settings {
                    sigma: Some(0.05),
                    ..Settings::default()
                },
                &|_| {},
            )
            .unwrap()
            .field
            .values;
            let crop = |a: &Array2<Complex64>, h: usize| {
                a.slice(ndarray::s![128 - h..128 + h, 128 - h..128 + h])
                    .to_owned()
            };
            println!(
                "   auto-0.07 {:?} 0.07-0.05 {:?}",
                error(&a, &b),
                error(&b, &c)
            );
            for h in [16, 32, 64, 128] {
                println!("   h {h} {:?}", error(&crop(&b, h), &crop(&exact, h)));
            }
        }
    }
}
