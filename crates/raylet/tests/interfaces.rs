//! Elements on interfaces and on curved screens by local bands: against direct sums over the surface, and against the
//! same surfaces as parts of a train.

use ndarray::Array2;
use num_complex::Complex64;
use raylet::engine::chain::forecast::forecast;
use raylet::engine::chain::simulate::simulate;
use raylet::engine::geometrical::system_trace::trace_system;
use raylet::engine::local_bands::carry::{
    LocalBandCotangent, carry, carry_kept, carry_kept_adjoint,
};
use raylet::engine::local_bands::settings::{LocalBandSettings, SourceAperture};
use raylet::engine::plan::hop_method::HopMethod;
use raylet::engine::plan::settings::{Method, Settings};
use raylet::engine::progress::uncancelled;
use raylet::file::model::build;
use raylet::file::scene::scene_file::Scene;
use raylet::math::vec3::Vec3;
use raylet::optics::aperture::Aperture;
use raylet::optics::doe::{Doe, Layer};
use raylet::optics::frame::Frame;
use raylet::optics::phase::profile::Profile;
use raylet::optics::pixels::pixel_grid::PixelForm;
use raylet::optics::refraction::Coating;
use raylet::optics::screen::{MediumBehind, Screen, ScreenKind};
use raylet::optics::shape::Shape;
use raylet::optics::source::Source;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::wave::free::rayleigh::{Emitter, Emitters};
use raylet::wave::grid::field::Field;
use raylet_testkit::noise::column;
use raylet_testkit::parts::{
    conic, element, face, mirror, on_axis, pixel_layer, plane_wave, screen, sensor,
};
use raylet_testkit::scenes::scene_path;

const WAVELENGTH: f64 = 1e-3;
const GLASS: f64 = 1.5;

/// Relative L2 distance.
fn distance<'a>(
    found: impl IntoIterator<Item = &'a Complex64>,
    exact: impl IntoIterator<Item = &'a Complex64> + Clone,
) -> f64 {
    let norm: f64 = exact.clone().into_iter().map(|u| u.norm_sqr()).sum();
    let pairs = found.into_iter().zip(exact);
    let off: f64 = pairs.map(|(a, b)| (a - b).norm_sqr()).sum();
    (off / norm).sqrt()
}

/// A screen between glass and air.
fn out_of_glass(frame: Frame, shape: Shape, doe: Doe, coating: Coating) -> Screen {
    Screen {
        shape,
        index: GLASS,
        behind: Some(MediumBehind {
            index: 1.0,
            coating,
        }),
        ..screen(frame, ScreenKind::Doe(doe))
    }
}

/// A run with windows of these widths, in which little is left out.
fn run(system: &System, sigmas: &[f64], aperture: SourceAperture) -> Field {
    let settings = LocalBandSettings {
        threshold: 1e-4,
        period: 7.0,
        edge_nodes: 32.0,
        aperture,
        ..LocalBandSettings::new(sigmas.to_vec())
    };
    carry(system, &settings).unwrap().field
}

/// Nodes of a disc in polar coordinates, which end at its rim, with their areas: three of Gauss in each ring.
fn polar(radius: f64) -> Vec<([f64; 2], f64)> {
    const RINGS: usize = 220;
    const TURNS: usize = 1400;
    let (width, turn) = (radius / RINGS as f64, std::f64::consts::TAU / TURNS as f64);
    let node = |ring: usize, (aside, weight): (f64, f64)| {
        let r = width * (ring as f64 + 0.5 + 0.5 * aside);
        let around = move |n: usize| {
            let (sine, cosine) = (turn * n as f64).sin_cos();
            ([r * cosine, r * sine], weight * width * r * turn)
        };
        (0..TURNS).map(around)
    };
    let root = 0.6f64.sqrt();
    let gauss = [(-root, 5.0 / 18.0), (0.0, 8.0 / 18.0), (root, 5.0 / 18.0)];
    let rings = (0..RINGS).flat_map(|ring| gauss.map(|place| (ring, place)));
    rings.flat_map(|(ring, place)| node(ring, place)).collect()
}

/// An element on a sphere of glass to air, lit in glass, and the sum over its surface.
struct OnSphere {
    curvature: f64,
    radius: f64,
    layers: Vec<Layer>,
    phase: fn(f64, f64) -> f64,
    /// Optical cosines of the light in glass.
    incident: [f64; 2],
    /// Middle of the sensor.
    sensor: [f64; 3],
}

const PIXELS: usize = 20;
const PITCH: f64 = 2e-3;

impl OnSphere {
    fn system(&self) -> System {
        let mut doe = element(self.layers[0].clone(), Aperture::disc(self.radius));
        doe.layers = self.layers.clone();
        let shape = match self.curvature {
            0.0 => Shape::Plane,
            curvature => conic(curvature, 0.0),
        };
        let [x, y, z] = self.sensor;
        System {
            wavelength: WAVELENGTH,
            source: plane_wave(self.incident.map(|p| p / GLASS)),
            screens: vec![
                out_of_glass(Frame::GLOBAL, shape, doe, Coating::Ideal),
                screen(
                    Frame::GLOBAL.moved(Vec3::new(x, y, z)),
                    sensor(PIXELS, PITCH),
                ),
            ],
            trains: vec![Vec::new()],
        }
    }

    /// Height and slopes of the sphere.
    fn sphere(&self, x: f64, y: f64) -> (f64, [f64; 2]) {
        let c = self.curvature;
        let root = (1.0 - c * c * (x * x + y * y)).sqrt();
        let z = c * (x * x + y * y) / (1.0 + root);
        (z, [c * x / root, c * y / root])
    }

    /// The field that the element emits into air: refracted by Snell, transmitted without loss of power, times exp(iφ).
    fn emitter(&self, [x, y]: [f64; 2], area: f64) -> Emitter {
        let k = std::f64::consts::TAU / WAVELENGTH;
        let (z, slope) = self.sphere(x, y);
        let [px, py] = self.incident;
        let pz = (GLASS * GLASS - px * px - py * py).sqrt();
        let steep = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        let before = (pz - slope[0] * px - slope[1] * py) / steep;
        let after = (before * before + 1.0 - GLASS * GLASS).sqrt();
        let phase = k * (px * x + py * y + pz * z) + (self.phase)(x, y);
        Emitter {
            at: [x, y, z],
            slope,
            strength: Complex64::from_polar((before / after).sqrt() * area, phase),
        }
    }

    /// The centres of the sensor's pixels.
    fn points(&self) -> Vec<[f64; 3]> {
        let [x, y, z] = self.sensor;
        let place = |i: usize| (i as f64 - 0.5 * (PIXELS - 1) as f64) * PITCH;
        let point = |n: usize| [x + place(n % PIXELS), y + place(n / PIXELS), z];
        (0..PIXELS * PIXELS).map(point).collect()
    }

    /// The sum over the surface.
    fn summed(&self) -> Vec<Complex64> {
        let nodes = polar(self.radius).into_iter();
        let emitters = nodes.map(|(at, area)| self.emitter(at, area));
        Emitters::of_nodes(emitters).field_at(&self.points(), WAVELENGTH)
    }
}

/// A grating of 8 µm on a plane interface sends its order where the grating equation has it, with the field of the sum.
#[test]
fn a_grating_on_a_plane_interface_agrees_with_the_direct_sum_slow() {
    const PERIOD: f64 = 8e-3;
    let incident = [0.1, -0.05];
    let grating = Profile::Linear {
        gradient: [std::f64::consts::TAU / PERIOD, 0.0],
    };
    // n₂ sin θ₂ = n₁ sin θ₁ + λ/Λ.
    let [px, py] = [incident[0] + WAVELENGTH / PERIOD, incident[1]];
    let pz = (1.0 - px * px - py * py).sqrt();
    let z = 3.0;
    let case = OnSphere {
        curvature: 0.0,
        radius: 0.3,
        layers: vec![Layer::Phase(grating)],
        phase: |x, _| std::f64::consts::TAU * x / PERIOD,
        incident,
        sensor: [z * px / pz, z * py / pz, z],
    };
    let system = case.system();
    let ray = trace_system(&system, &system.source, [0.0; 2]);
    let landed = ray.hits[1].point;
    assert!((landed.x - case.sensor[0]).abs() < 1e-12 && (landed.y - case.sensor[1]).abs() < 1e-12);
    let found = run(&system, &[0.027], SourceAperture::Hard);
    let error = distance(&found.values, &case.summed());
    assert!(error < 1e-4, "{error:e}");
}

/// A kinoform and a grating on a sphere of 1.2 mm radius and 0.11 mm height, under tilted light.
fn kinoform() -> OnSphere {
    const SLOPE: f64 = 60.0;
    const BENT: f64 = -900.0;
    let kinoform = Profile::Radial {
        radius: 1.0,
        coefficients: vec![BENT, 300.0],
    };
    let grating = Profile::Linear {
        gradient: [0.0, SLOPE],
    };
    OnSphere {
        curvature: -1.0 / 1.2,
        radius: 0.5,
        layers: vec![Layer::Phase(kinoform), Layer::Phase(grating)],
        phase: |x, y| {
            let square = x * x + y * y;
            BENT * square + 300.0 * square * square + SLOPE * y
        },
        incident: [0.06, -0.03],
        sensor: [0.08, -0.03, 1.3],
    }
}

/// Lit by the source itself, and by beamlets from an aperture in the glass that cuts nothing.
#[test]
fn a_kinoform_on_a_sphere_of_glass_agrees_with_the_sum_over_its_surface_slow() {
    let case = kinoform();
    let exact = case.summed();
    let mut system = case.system();
    let direct = run(&system, &[0.012], SourceAperture::Hard);
    let error = distance(&direct.values, &exact);
    assert!(error < 3e-4, "{error:e}");

    let aperture = Screen {
        index: GLASS,
        ..screen(on_axis(-0.6), ScreenKind::Stop(Aperture::disc(0.8)))
    };
    system.screens.insert(0, aperture);
    system.trains.push(Vec::new());
    let through = run(&system, &[0.012, 0.012], SourceAperture::Soft);
    let error = distance(&through.values, &exact);
    assert!(error < 5e-4, "{error:e}");
}

/// The height of a surface at its rim.
fn height(shape: &Shape, radius: f64) -> f64 {
    shape.height(radius, 0.0).unwrap().z
}

/// A lens with a rim on its front, under tilted light; its front as a surface behind an aperture, or as an element without
/// a phase.
fn lens(coating: Coating, on_element: bool) -> System {
    const RADIUS: f64 = 0.5;
    let shape = conic(1.0 / 3.0, -0.4);
    let frame = on_axis(0.5).tilted([0.05, -0.03, 0.2]);
    let back = Surface {
        coating,
        ..face(on_axis(1.7), conic(-1.0 / 5.0, 0.3), [GLASS, 1.0])
    };
    let at_rim = Vec3::new(0.0, 0.0, height(&shape, RADIUS));
    let disc = Aperture::disc(RADIUS);
    let (first, train) = match on_element {
        true => {
            let flat = Layer::Phase(Profile::Linear { gradient: [0.0; 2] });
            let behind = MediumBehind {
                index: GLASS,
                coating,
            };
            let element = Screen {
                shape,
                behind: Some(behind),
                ..screen(frame, ScreenKind::Doe(element(flat, disc)))
            };
            (element, vec![back])
        }
        false => {
            let front = Surface {
                coating,
                ..face(frame, shape, [1.0, GLASS])
            };
            let stop = screen(frame.moved(at_rim), ScreenKind::Stop(disc));
            (stop, vec![front, back])
        }
    };
    let end = Frame::GLOBAL.moved(Vec3::new(0.16, -0.1, 4.5));
    System {
        wavelength: WAVELENGTH,
        source: plane_wave([0.05, -0.03]),
        screens: vec![first, screen(end, sensor(PIXELS, 3e-3))],
        trains: vec![train],
    }
}

#[test]
fn an_element_without_a_phase_on_a_lens_changes_nothing_slow() {
    for coating in [Coating::Ideal, Coating::Fresnel] {
        let field = |on_element: bool| {
            let system = lens(coating, on_element);
            run(&system, &[0.02], SourceAperture::Hard).values
        };
        let error = distance(&field(true), &field(false));
        assert!(error < 3e-4, "{coating:?} {error:e}");
    }
}

/// A curved mirror with a rim, as a surface behind an aperture or as an element without a phase.
#[test]
fn a_reflecting_element_without_a_phase_is_a_mirror_slow() {
    const RADIUS: f64 = 0.5;
    let shape = conic(-1.0 / 6.0, 0.0);
    let frame = Frame::GLOBAL.tilted([0.25, 0.0, 0.0]);
    let turned = Frame::GLOBAL.tilted([0.5, 0.0, 0.0]);
    let end = Screen {
        arrives: -1.0,
        ..screen(
            turned.moved(Vec3::new(0.0, 0.0, -2.8)),
            sensor(PIXELS, 3e-3),
        )
    };
    let system = |on_element: bool| {
        let disc = Aperture::disc(RADIUS);
        let (first, train) = match on_element {
            true => {
                let flat = Layer::Phase(Profile::Linear { gradient: [0.0; 2] });
                let doe = Doe {
                    reflect: true,
                    ..element(flat, disc)
                };
                let element = Screen {
                    shape: shape.clone(),
                    ..screen(frame, ScreenKind::Doe(doe))
                };
                (element, Vec::new())
            }
            false => {
                let at_rim = Vec3::new(0.0, 0.0, height(&shape, RADIUS));
                let stop = screen(frame.moved(at_rim), ScreenKind::Stop(disc));
                (stop, vec![mirror(frame, shape.clone())])
            }
        };
        System {
            wavelength: WAVELENGTH,
            source: plane_wave([0.01, -0.008]),
            screens: vec![first, end.clone()],
            trains: vec![train],
        }
    };
    let field = |on_element: bool| run(&system(on_element), &[0.02], SourceAperture::Hard).values;
    let error = distance(&field(true), &field(false));
    assert!(error < 1e-4, "{error:e}");
}

/// Pixels on a plane and on a curved interface: the field is linear in the pixels of each.
#[test]
fn carry_kept_dot_product_on_a_curved_interface() {
    let values = |seed: u64| Array2::from_shape_vec((8, 7), column(56, seed)).unwrap();
    let pixels = |pitch: f64, seed: u64| pixel_layer(values(seed), pitch, PixelForm::Box);
    let first = element(pixels(0.02, 1), Aperture::disc(0.06));
    let second = element(pixels(0.03, 2), Aperture::disc(0.1));
    let bent = out_of_glass(on_axis(2.0), conic(-0.8, 0.0), second, Coating::Fresnel);
    let system = System {
        wavelength: 0.5e-3,
        source: plane_wave([0.01, -0.005]),
        screens: vec![
            screen(Frame::GLOBAL, ScreenKind::Doe(first)),
            bent,
            screen(on_axis(4.0), sensor(8, 0.01)),
        ],
        trains: vec![
            vec![face(on_axis(1.0), conic(0.05, 0.0), [1.0, GLASS])],
            Vec::new(),
        ],
    };
    let settings = LocalBandSettings {
        threshold: 3e-2,
        ..LocalBandSettings::new(vec![0.03, 0.03])
    };
    let (outcome, kept) = carry_kept(&system, &settings, &|_| uncancelled()).unwrap();
    let bar = Field {
        grid: outcome.field.grid.clone(),
        values: Array2::from_shape_vec((8, 8), column(64, 3)).unwrap(),
    };
    let cotangent = LocalBandCotangent {
        field: &bar,
        variations: &[],
        pulse: &uncancelled,
    };
    let backs = carry_kept_adjoint(&system, &settings, &kept, &cotangent).unwrap();
    let backs = backs.pixels;
    let inner = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
        a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
    };
    let forward = inner(&bar.values, &outcome.field.values);
    assert!(forward.norm() > 0.0);
    for (seed, back) in [1, 2].into_iter().zip(&backs) {
        let reverse = inner(back.as_ref().unwrap(), &values(seed));
        let off = (forward - reverse).norm() / forward.norm();
        assert!(off < 1e-10, "{off:e}");
    }
}

/// Edmund Optics 65-988 at the d line: 15.02 mm of focal length, its focus 12.94603 mm behind it, for all of its zones.
#[test]
fn a_hybrid_lens_of_the_catalogue_has_its_focal_length_and_its_focus() {
    let scene = Scene::read(&scene_path("real_size/hybrid_asphere")).unwrap();
    let system = build::system(&scene, 0).unwrap();
    for height in [1e-3, 1.5, 3.0, 4.5, 5.9] {
        let ray = trace_system(&system, &system.source, [height, 0.0]);
        let [_, back, sensor] = ray.hits[..] else {
            panic!("{ray:?}")
        };
        let at_focus = sensor.point.x.hypot(sensor.point.y);
        assert!(at_focus < 1e-4, "{height}: {at_focus:e}");
        if height < 0.1 {
            let focal_length = -height / back.direction.x;
            assert!((focal_length - 15.02).abs() < 5e-3, "{focal_length}");
        }
    }
}

/// Whole fields refuse an interface and name what carries it; left to itself, a run takes local bands.
#[test]
fn whole_fields_refuse_an_interface() {
    let case = lens(Coating::Ideal, true);
    for method in [Method::Beamlet, Method::Plane, Method::Paper] {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let error = simulate(&case, &settings, &|_| {}).unwrap_err().to_string();
        assert!(error.contains("'element'"), "{error}");
        assert!(error.contains("local_bands"), "{error}");
    }
    let forecasts = forecast(&case, &Settings::default()).unwrap();
    let [only] = &forecasts[..] else {
        panic!("one hop: {}", forecasts.len())
    };
    assert!(matches!(only.method, HopMethod::LocalBands(_)));
}

/// A point's light on the first, curved screen: the sum over the surface agrees.
#[test]
fn light_of_a_point_on_a_curved_element_agrees_with_the_sum_slow() {
    let mut case = OnSphere {
        curvature: 1.0 / 2.0,
        radius: 0.4,
        layers: vec![Layer::Phase(Profile::Radial {
            radius: 1.0,
            coefficients: vec![-1500.0],
        })],
        phase: |x, y| -1500.0 * (x * x + y * y),
        incident: [0.0; 2],
        sensor: [0.0, 0.0, 4.0],
    };
    case.sensor[0] = 0.02;
    let point = [0.3, 0.1, -20.0];
    let mut system = case.system();
    system.source = Source::point(point, Vec3::new(0.0, 0.0, 0.0));
    system.screens[0].index = 1.0;
    system.screens[0].behind = None;

    // The field of the point on the surface, times exp(iφ).
    let k = std::f64::consts::TAU / WAVELENGTH;
    let nodes = polar(case.radius).into_iter().map(|([x, y], area)| {
        let (z, slope) = case.sphere(x, y);
        let light = system.source.field(Vec3::new(x, y, z), k);
        Emitter {
            at: [x, y, z],
            slope,
            strength: light * Complex64::from_polar(area, (case.phase)(x, y)),
        }
    });
    let exact = Emitters::of_nodes(nodes).field_at(&case.points(), WAVELENGTH);
    let found = run(&system, &[0.02], SourceAperture::Hard);
    let error = distance(&found.values, &exact);
    assert!(error < 2e-4, "{error:e}");
}
