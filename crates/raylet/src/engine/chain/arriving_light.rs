//! The light that arrives at a screen as a whole field, and the grids on which it is sampled and summed.

use crate::engine::chain::simulate_error::SimulateError;
use crate::engine::plan::direction_spread::LightDirections;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::Settings;
use crate::math::vec3::Vec3;
use crate::optics::screen::{Screen, ScreenKind, Sensor};
use crate::optics::system::{Hop, System};
use crate::wave::grid::field::{Field, Grid};
use crate::wave::grid::height_stack::HeightStack;
use crate::wave::grid::raster::Raster;
use crate::wave::grid::sampling::{Reach, apply_screen, plan_grid, plan_raster};

/// Directions of the incident light on the first screen: cosines at its centre and the largest |p|.
pub(crate) fn incidence(system: &System) -> ([f64; 2], [f64; 2]) {
    let screen = &system.screens[0];
    let cosines = |point: Vec3| {
        let d = screen
            .frame
            .direction_to_local(system.source.direction(point));
        [d.x * screen.index, d.y * screen.index]
    };
    let centre = cosines(screen.frame.origin);
    let mut largest = centre.map(f64::abs);
    if let Some([x0, x1, y0, y1]) = screen.bounds() {
        for (x, y) in [(x0, y0), (x0, y1), (x1, y0), (x1, y1)] {
            let p = cosines(screen.frame.to_global(Vec3::new(x, y, 0.0)));
            largest = [largest[0].max(p[0].abs()), largest[1].max(p[1].abs())];
        }
    }
    let k = system.wavenumber() * screen.index;
    let spread = screen.index * system.source.spread_at(screen.frame.origin, k);
    (centre, largest.map(|p| p + spread))
}

/// The incident field of the source on a grid of the first screen.
pub(crate) fn illuminate(system: &System, grid: Grid) -> Field {
    let screen = &system.screens[0];
    let k = system.wavenumber() * screen.index;
    let mut field = Field::zeros(grid.clone());
    ndarray::Zip::indexed(field.values.rows_mut()).par_for_each(|j, mut row| {
        let y = grid.y.node(j);
        for (i, value) in row.iter_mut().enumerate() {
            let x = grid.x.node(i);
            let z = screen.height([x, y]).map_or(0.0, |here| here.z);
            let point = screen.frame.to_global(Vec3::new(x, y, z));
            *value = system.source.field(point, k);
        }
    });
    field
}

/// Direction on the next screen of the ray through the middle of this one; straight on when it is lost.
pub(crate) fn chief(hop: &Hop, chief: [f64; 2]) -> [f64; 2] {
    match hop.trace([0.0, 0.0], chief, &mut ()) {
        Ok(landing) => landing.cosines,
        Err(_) => [0.0, 0.0],
    }
}

/// The light that arrives at a screen: its field, and its directions.
pub struct Arriving {
    /// The field as summed before the screen acts; nothing on the first screen, which the source lights.
    pub sum: Option<HeightStack>,
    /// Its directions, roughly: the chief direction and the usual spread about it.
    pub directions: LightDirections,
    /// Its largest optical direction cosines |p| along x and y.
    pub reach: [f64; 2],
}

impl Arriving {
    /// The source's light on the first screen.
    pub fn from_source(system: &System) -> Self {
        let (chief, reach) = incidence(system);
        Self {
            sum: None,
            directions: LightDirections {
                chief,
                usual: reach,
            },
            reach,
        }
    }

    /// The light on any grid of the screen, before the screen acts.
    pub(crate) fn on(&self, system: &System, screen: &Screen, grid: Grid) -> Field {
        match &self.sum {
            None => illuminate(system, grid),
            Some(levels) => levels.on(screen, &grid),
        }
    }

    /// The field just before and just behind a screen, on nodes that resolve what arrives and what matters
    /// behind it.
    ///
    /// # Errors
    /// When the screen cannot be sampled, or lets nothing through.
    pub fn pass(
        &self,
        system: &System,
        screen: &Screen,
        leaving: [f64; 2],
        settings: &Settings,
    ) -> Result<(Field, Field), SimulateError> {
        let reach = Reach {
            arriving: self.reach,
            leaving,
        };
        let grid = plan_grid(screen, reach, system.wavelength, settings.samples_allowed())?;
        let arrived = self.on(system, screen, grid);
        let mut behind = arrived.clone();
        apply_screen(screen, &mut behind);
        if behind.power() == 0.0 {
            return Err(SimulateError::NoLight(screen.name.clone()));
        }
        Ok((arrived, behind))
    }

    /// The field just behind a screen on finer nodes than those of [`Arriving::pass`]; nothing where they take more memory than
    /// is allowed.
    pub(crate) fn on_other_samples(
        &self,
        system: &System,
        screen: &Screen,
        leaving: [f64; 2],
        settings: &Settings,
    ) -> Option<Field> {
        let reach = Reach {
            arriving: self.reach.map(|p| FINER * p),
            leaving: leaving.map(|p| FINER * p),
        };
        let grid = plan_grid(screen, reach, system.wavelength, settings.samples_allowed()).ok()?;
        let mut behind = self.on(system, screen, grid);
        apply_screen(screen, &mut behind);
        Some(behind)
    }
}

/// How much finer nodes are on which a run is checked.
const FINER: f64 = 1.4;

/// The raster on which light is summed on a screen: a sensor's own pixels, or one that resolves `reach`.
///
/// # Errors
/// When the screen cannot be sampled.
pub fn receiving_raster(
    hop: &Hop,
    reach: [f64; 2],
    settings: &Settings,
) -> Result<Raster, SimulateError> {
    let allowed = settings.samples_allowed();
    Ok(match &hop.to.kind {
        ScreenKind::Sensor(sensor) => Raster::of(sensor),
        _ => plan_raster(hop.to, reach, hop.wavelength, allowed)?,
    })
}

/// The sensor at the end of a system.
///
/// # Errors
/// When the last screen is none.
pub(crate) fn sensor_of(system: &System) -> Result<&Sensor, SimulateError> {
    match system.screens.last() {
        Some(Screen {
            kind: ScreenKind::Sensor(sensor),
            ..
        }) => Ok(sensor),
        last => Err(SimulateError::NoSensor(
            last.map(|screen| screen.name.clone()).unwrap_or_default(),
        )),
    }
}

/// Largest |p| behind the screen that its nodes are to resolve for a plan.
pub fn leaving(plan: &Plan) -> [f64; 2] {
    if let Plan::Free(_, free) = plan {
        return [0, 1].map(|a| free.largest()[a].min(free.reach[a]));
    }
    let bands = plan.bands();
    [0, 1].map(|a| {
        let band = &bands[a];
        let last = band.count.max(1) - 1;
        band.at(0).abs().max(band.at(last).abs())
    })
}

/// Largest |p| of the light that a plan brings to the next screen.
pub(crate) fn arrival_reach(hop: &Hop, plan: &Plan) -> [f64; 2] {
    match plan {
        Plan::Free(_, free) => free.largest().map(|p| p.min(hop.to.index)),
        Plan::Beamlets(beamlets) => beamlets.arriving,
        Plan::Planes(planes) => planes.arriving,
        Plan::Paper(paper) => paper.arriving,
    }
}
