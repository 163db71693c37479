//! The levels of an element that its scene states: those of its design, or those of a kinoform.

use crate::file::fabrication::export_choices::MOST_LEVELS;
use crate::file::scene::element::Element;
use crate::file::scene::layer::Layer;
use crate::file::scene::scene_file::Scene;

/// Levels that a scene states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DesignedLevels {
    /// How many there are.
    pub count: u16,
    /// The largest height in µm that a design allows, where it states one.
    pub highest_um: Option<f64>,
}

impl DesignedLevels {
    /// The step between heights in µm, where a whole wave is `depth_um` deep: levels divide the whole waves that the
    /// largest height holds, or lie between zero and a smaller height.
    pub(crate) fn step_um(&self, depth_um: f64) -> f64 {
        let highest = self.highest_um.unwrap_or(depth_um);
        // A height given as one wave in decimals is one.
        let waves = (highest / depth_um * (1.0 + 1e-9)).floor();
        match waves >= 1.0 {
            true => waves * depth_um / f64::from(self.count),
            false => highest / f64::from(self.count - 1),
        }
    }
}

/// The levels of a layer of an element, both by their numbers.
pub(crate) fn designed_levels(
    scene: &Scene,
    element: usize,
    layer: usize,
) -> Option<DesignedLevels> {
    let Some(Element::Doe(doe)) = scene.element.get(element) else {
        return None;
    };
    if let Some(Layer::Kinoform(kinoform)) = doe.layer.get(layer) {
        return stated(kinoform.levels? as usize, None);
    }

    // A design is about the first layer with pixels.
    let gridded =
        |layer: &Layer| matches!(layer, Layer::Pixels(_) | Layer::Height(_) | Layer::Sum(_));
    if doe.layer.iter().position(gridded) != Some(layer) {
        return None;
    }
    let design = scene.design.as_ref()?;
    let is_own = |name: &str| scene.number_of(name) == Some(element);
    if design.element.is_empty() {
        let hologram = scene.hologram.as_ref()?;
        let levels = design.levels.filter(|_| is_own(&hologram.element));
        return stated(levels?, None);
    }
    let part = design.element.iter().find(|part| is_own(&part.name))?;
    stated(part.levels?, part.highest_um)
}

/// Levels of a number that a file can hold.
fn stated(count: usize, highest_um: Option<f64>) -> Option<DesignedLevels> {
    let fits = (2..=MOST_LEVELS as usize).contains(&count);
    fits.then_some(DesignedLevels {
        count: count as u16,
        highest_um,
    })
}

#[cfg(test)]
mod tests {
    use crate::file::fabrication::designed_levels::DesignedLevels;

    #[test]
    fn levels_divide_whole_waves() {
        let step = |highest_um| {
            let levels = DesignedLevels {
                count: 4,
                highest_um,
            };
            levels.step_um(1.2)
        };
        assert_eq!(step(None), 0.3);
        assert_eq!(step(Some(1.2)), 0.3);
        assert_eq!(step(Some(2.5)), 0.6);
        // Less than a wave: from zero to the largest height.
        assert!((step(Some(0.9)) - 0.3).abs() < 1e-15);
        assert!((step(Some(0.6)) - 0.2).abs() < 1e-15);
    }
}
