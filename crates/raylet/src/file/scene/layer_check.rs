//! Faults of an element's layers that no single value shows.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use crate::file::decode::fault::Fault;
use crate::file::decode::number::LEAST;
use crate::file::decode::place::Place;
use crate::file::model::scene_arrays::Arrays;
use crate::file::scene::element::{Coordinates, DoeElement};
use crate::file::scene::layer::{
    KinoformLayer, Layer, PhaseGridLayer, PixelLayer, PolynomialLayer, RadialTableLayer,
    RecordedWave, SumLayer,
};
use crate::file::scene::surface_shape::HIGHEST_POWER;
use crate::optics::phase::radial_table::RadialTable;
use crate::optics::pixels::pixel_grid::PixelForm;
use crate::optics::surface_coordinates::SurfaceCoordinates;

/// Checks the layers of an element. What depends on an array is passed over while it is not loaded.
///
/// # Errors
/// The first fault, with its address.
pub(crate) fn check_element_layers(
    doe: &DoeElement,
    arrays: &Arrays,
    place: &Place<'_>,
) -> Result<(), Fault> {
    let around = Around {
        rim: element_rim(doe, arrays, place),
        arrays,
    };
    check_layers(&doe.layer, &around, &place.inner(".layer"))
}

/// What layers are checked against.
struct Around<'a, 'l> {
    /// Points along the edge of their element.
    rim: Vec<[f64; 2]>,
    /// The arrays of the scene as far as they are loaded.
    arrays: &'a Arrays<'l>,
}

/// Points along the edge of an element on the coordinates of its layers. None where its shape is not loaded yet.
fn element_rim(doe: &DoeElement, arrays: &Arrays, place: &Place<'_>) -> Vec<[f64; 2]> {
    let rim = doe.aperture.optics().rim();
    match doe.coordinates {
        Coordinates::Projected => rim,
        Coordinates::Surface => {
            let shape = arrays.shape(&doe.surface_shape(), &place.path);
            let own = shape.and_then(|shape| SurfaceCoordinates::of(&shape));
            own.map_or_else(Vec::new, |own| {
                rim.into_iter().filter_map(|at| own.at(at)).collect()
            })
        }
    }
}

/// Checks every layer of a product.
fn check_layers(layers: &[Layer], around: &Around<'_, '_>, place: &Place<'_>) -> Result<(), Fault> {
    for (i, layer) in layers.iter().enumerate() {
        let place = place.inner(&format!("[{i}]"));
        match layer {
            Layer::Pixels(pixels) => check_pixels(pixels, &place)?,
            Layer::Sum(sum) => check_sum(sum, around, &place)?,
            Layer::Kinoform(kinoform) => check_kinoform(kinoform, around, &place)?,
            Layer::RadialTable(table) => check_table(table, &around.rim, &place)?,
            Layer::PhaseGrid(grid) => check_grid(grid, around, &place)?,
            Layer::Polynomial(sum) => check_powers(sum, &place)?,
            Layer::TwoPoint(hologram) => {
                check_wave(&hologram.object, &place.inner(".object"))?;
                check_wave(&hologram.reference, &place.inner(".reference"))?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// Most steps and orders of a kinoform.
const MOST_LEVELS: u32 = 65_536;
const MOST_ORDERS: usize = 101;

/// A kinoform is made of analytic phases, and has each order once.
fn check_kinoform(
    kinoform: &KinoformLayer,
    around: &Around<'_, '_>,
    place: &Place<'_>,
) -> Result<(), Fault> {
    check_layers(&kinoform.layer, around, &place.inner(".layer"))?;
    // An axicon turns light by one angle at every wavelength, which no profile does.
    let other = |layer: &Layer| layer.placement().is_none() || matches!(layer, Layer::Axicon(_));
    if let Some(i) = kinoform.layer.iter().position(other) {
        return place.inner(&format!(".layer[{i}].kind")).refuse(
            "a layer that is no analytic phase of one profile",
            "\"lens\", \"radial\", \"radial_table\", \"phase_grid\", \"grating\", \"vortex\", \"zernike\", \"xy\" or \"two_point\"",
        );
    }
    if let Some(levels) = kinoform
        .levels
        .filter(|levels| !(2..=MOST_LEVELS).contains(levels))
    {
        let expected = format!("from 2 to {MOST_LEVELS} steps, or no levels for a ramp");
        return place.inner(".levels").refuse(levels.to_string(), expected);
    }
    let orders: BTreeSet<i32> = kinoform.orders.iter().copied().collect();
    if orders.len() < kinoform.orders.len() || orders.len() > MOST_ORDERS {
        let found = format!("{:?}", kinoform.orders);
        return place
            .inner(".orders")
            .refuse(found, format!("each order once, at most {MOST_ORDERS}"));
    }
    Ok(())
}

/// Share of the extent of samples by which an aperture may reach beyond it.
const BEYOND_SAMPLES: f64 = 1e-9;

/// The radii of a table grow from zero to the edge of the aperture, each with its phase.
fn check_table(table: &RadialTableLayer, rim: &[[f64; 2]], place: &Place<'_>) -> Result<(), Fault> {
    let radii = &table.radius_mm;
    let (at_radii, least) = (place.inner(".radius_mm"), RadialTable::FEWEST);
    if radii.len() < least {
        let found = format!("{} radii", radii.len());
        return at_radii.refuse(found, format!("at least {least}"));
    }
    if table.phase_rad.len() != radii.len() {
        let found = format!("{} phases", table.phase_rad.len());
        let expected = format!("{}, one for each radius", radii.len());
        return place.inner(".phase_rad").refuse(found, expected);
    }
    if let Some(first) = radii.first().filter(|first| **first != 0.0) {
        let place = place.inner(".radius_mm[0]");
        return place.refuse(first.to_string(), "0: the table begins at the centre");
    }
    let mut pairs = radii.iter().zip(radii.iter().skip(1)).enumerate();
    if let Some((i, (low, high))) = pairs.find(|(_, (low, high))| *high - *low < LEAST) {
        let place = place.inner(&format!(".radius_mm[{}]", i + 1));
        return place.refuse(high.to_string(), format!("more than {low}: radii grow"));
    }
    let [x, y] = table.centre_mm;
    let edge = (rim.iter()).fold(0.0f64, |most, at| most.max((at[0] - x).hypot(at[1] - y)));
    let last = radii.last().copied().unwrap_or_default();
    match edge > last * (1.0 + BEYOND_SAMPLES) {
        true => at_radii.refuse(
            format!("radii up to {last} mm"),
            format!(
                "up to {edge:.6} mm, where the aperture ends as seen from the centre of the table"
            ),
        ),
        false => Ok(()),
    }
}

/// The samples of a phase lie all over the aperture.
fn check_grid(
    grid: &PhaseGridLayer,
    around: &Around<'_, '_>,
    place: &Place<'_>,
) -> Result<(), Fault> {
    let phases = around.arrays.real(&format!("{}.phase", place.path));
    let Some((ny, nx)) = phases.map(|phases| phases.dim()) else {
        return Ok(());
    };
    let half = |count: usize, pitch_um: f64| 0.5e-3 * pitch_um * count.saturating_sub(1) as f64;
    let [pitch_x, pitch_y] = grid.pitch_um;
    let reach = [half(nx, pitch_x), half(ny, pitch_y)];
    let placement = grid.placement();
    let inside = (around.rim.iter()).map(|at| placement.inwards(at[0], at[1]));
    let edge = inside.fold([0.0f64; 2], |most, [x, y]| {
        [most[0].max(x.abs()), most[1].max(y.abs())]
    });
    let beyond = |edge: f64, reach: f64| edge > reach * (1.0 + BEYOND_SAMPLES);
    match beyond(edge[0], reach[0]) || beyond(edge[1], reach[1]) {
        true => place.inner(".phase").refuse(
            format!(
                "samples up to {:.6} mm along x and {:.6} mm along y from their middle",
                reach[0], reach[1]
            ),
            format!(
                "up to {:.6} and {:.6} mm, where the aperture ends on their axes",
                edge[0], edge[1]
            ),
        ),
        false => Ok(()),
    }
}

/// Powers of a phase are limited as those of surfaces are.
fn check_powers(sum: &PolynomialLayer, place: &Place<'_>) -> Result<(), Fault> {
    for (i, term) in sum.terms.iter().enumerate() {
        for (key, power) in [("x", term.x), ("y", term.y)] {
            if power > HIGHEST_POWER {
                let place = place.inner(&format!(".terms[{i}].{key}"));
                return place.refuse(power.to_string(), format!("at most {HIGHEST_POWER}"));
            }
        }
    }
    Ok(())
}

/// A wave of a hologram is collimated, or that of a point beside the element.
fn check_wave(wave: &RecordedWave, place: &Place<'_>) -> Result<(), Fault> {
    let Some([_, _, z]) = wave.point_mm else {
        let [p, q] = wave.angle_deg.map(|angle| angle.to_radians().sin());
        if p.hypot(q) >= 1.0 {
            return place.inner(".angle_deg").refuse(
                format!("sines {p:.4} and {q:.4}, which no direction has"),
                "angles whose sines have squares that add to less than 1",
            );
        }
        return Ok(());
    };
    if wave.angle_deg != [0.0; 2] {
        return place.inner(".angle_deg").refuse(
            "a direction beside a point",
            "either the point or the direction",
        );
    }
    if z.abs() < LEAST {
        let expected = "at least 1e-12 in size: the point lies before or behind the element";
        return place.inner(".point_mm[2]").refuse(z.to_string(), expected);
    }
    Ok(())
}

/// A pixel layer needs arrays, or a size, and not two kinds of arrays.
fn check_pixels(pixels: &PixelLayer, place: &Place<'_>) -> Result<(), Fault> {
    let parts = pixels.phase.is_some() || pixels.amplitude.is_some();
    match (&pixels.transmission, parts) {
        (Some(_), true) => place.inner(".transmission").refuse(
            "a transmission beside a phase or an amplitude",
            "either the transmission or its parts",
        ),
        (None, false) if pixels.size.is_none() => place.refuse(
            "no array",
            "`phase`, `amplitude` or `transmission`, or a `size` for a hologram still to come",
        ),
        _ if pixels.fill < 1.0 && pixels.pixel != PixelForm::Box => place.inner(".fill").refuse(
            format!("{} with pixels that are no boxes", pixels.fill),
            "pixel = \"box\", or fill = 1",
        ),
        _ => check_fringing(pixels, place),
    }
}

/// Widest Gaussian of crosstalk over the pitch, and the sub-pixels that there may be.
const WIDEST_CROSSTALK: f64 = 10.0;
const SUB_PIXELS: RangeInclusive<usize> = 2..=64;

/// Fly-back and crosstalk are those of box pixels without gaps.
fn check_fringing(pixels: &PixelLayer, place: &Place<'_>) -> Result<(), Fault> {
    let pitch = pixels.pitch_um[0].min(pixels.pitch_um[1]);
    if !SUB_PIXELS.contains(&pixels.sub_pixels) {
        let place = place.inner(".sub_pixels");
        return place.refuse(pixels.sub_pixels.to_string(), "from 2 to 64 sub-pixels");
    }
    for (key, value, most) in [
        ("fly_back_um", pixels.fly_back_um, pitch),
        (
            "crosstalk_um",
            pixels.crosstalk_um,
            WIDEST_CROSSTALK * pitch,
        ),
    ] {
        let place = place.inner(&format!(".{key}"));
        if value > most {
            let expected = format!("at most {most}, for a pitch of {pitch}");
            return place.refuse(value.to_string(), expected);
        }
        if value > 0.0 && pixels.pixel != PixelForm::Box {
            return place.refuse(
                format!("{value} with pixels that are no boxes"),
                format!("pixel = \"box\", or {key} = 0"),
            );
        }
        if value > 0.0 && pixels.fill < 1.0 {
            return place.refuse(
                format!(
                    "{value} beside gaps between the pixels, fill = {}",
                    pixels.fill
                ),
                format!("fill = 1, or {key} = 0"),
            );
        }
    }
    Ok(())
}

/// A sum needs layers in each term, and as many weights as terms.
fn check_sum(sum: &SumLayer, around: &Around<'_, '_>, place: &Place<'_>) -> Result<(), Fault> {
    let count = sum.terms.len();
    if let Some(weights) = sum.weights.as_ref().filter(|w| w.len() != count) {
        return place.inner(".weights").refuse(
            format!("{} weights", weights.len()),
            format!("{count}, one for each term"),
        );
    }
    for (i, term) in sum.terms.iter().enumerate() {
        let place = place.inner(&format!(".terms[{i}]"));
        if term.is_empty() {
            return place.refuse("an empty term", "at least one layer");
        }
        check_layers(term, around, &place)?;
    }
    Ok(())
}
