//! With the correction of the aberration inside beamlets, wide beamlets give the same field as narrow ones,
//! which have hardly any aberration.

use raylet::engine::chain::simulate::simulate;
use raylet::engine::plan::settings::{Correction, Method, Settings};
use raylet::optics::refraction::Coating;
use raylet::optics::surface::Surface;
use raylet::optics::system::System;
use raylet::wave::grid::metrics::field_error;
use raylet_testkit::noise::phases;
use raylet_testkit::parts::{box_pixels, conic, face, lit, on_axis, screen, sensor};

/// Random phases on pixels of 4λ behind which a strong lens stands; lengths in wavelengths.
fn system() -> System {
    let sphere = face(on_axis(20.0), conic(1.0 / 200.0, 0.0), [1.0, 1.5]);
    let back = face(on_axis(45.0), conic(0.0, 0.0), [1.5, 1.0]);
    let bare = |face: Surface| Surface {
        coating: Coating::Unit,
        ..face
    };
    lit(
        vec![
            screen(on_axis(0.0), box_pixels(phases([12, 12], 5), 4.0)),
            screen(on_axis(300.0), sensor(30, 1.0)),
        ],
        vec![vec![bare(sphere), bare(back)]],
    )
}

#[test]
fn wide_beamlets_are_put_right() {
    let run = |sigma: f64, correction: Correction| {
        let settings = Settings {
            method: Method::Beamlet,
            sigma: Some(sigma),
            correction,
            ..Settings::default()
        };
        simulate(&system(), &settings, &|_| {})
            .unwrap()
            .field
            .values
    };
    let narrow = run(4.5, Correction::On);
    let error = |correction: Correction| {
        let wide = run(11.0, correction);
        field_error(wide.view(), narrow.view()).unwrap()
    };
    let (off, on) = (error(Correction::Off), error(Correction::On));
    assert!(off > 2.5e-3 && on < 0.4 * off, "{off:.2e}, {on:.2e}");
}
