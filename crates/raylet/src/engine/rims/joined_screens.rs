//! Screens that stand in one place: their actions multiply, so that one screen has them all.

use crate::engine::rims::pixel_light::PixelValues;
use crate::optics::aperture::{Aperture, Outline};
use crate::optics::doe::Doe;
use crate::optics::pixels::pixel_axes::system_on_pixel_axes;
use crate::optics::screen::{Screen, ScreenKind};
use crate::optics::system::System;

/// For each hop, whether its two screens stand in one place and are joined: there is nothing between them, and one element can
/// have the layers of both. Elements that both have pixels are not joined where their pixels vary.
pub(crate) fn joining_hops(system: &System, values: PixelValues) -> Vec<bool> {
    let mut joining = Vec::new();
    let mut before: Option<Screen> = None;
    for hop in system.hops() {
        let from = before.as_ref().unwrap_or(hop.from);
        let near = hop.train.is_empty() && is_same_place(from, hop.to);
        before = near.then(|| product(from, hop.to, values)).flatten();
        joining.push(before.is_some());
    }
    joining
}

/// A system with one screen in place of the two of each hop that is `joining`, on the axes of its pixels, and where its given
/// screens stand in it.
pub(crate) fn joined(system: &System, joining: &[bool]) -> (System, Vec<usize>) {
    let mut places = vec![0];
    let mut all = System {
        screens: system.screens.first().cloned().into_iter().collect(),
        trains: Vec::new(),
        ..system.clone()
    };
    for (hop, joins) in system.hops().zip(joining) {
        let from = all.screens.last_mut().filter(|_| *joins);
        let both = from.and_then(|from| {
            let both = product(from, hop.to, PixelValues::Fixed)?;
            *from = both;
            Some(())
        });
        if both.is_none() {
            all.trains.push(hop.train.to_vec());
            all.screens.push(hop.to.clone());
        }
        places.push(all.trains.len());
    }
    (system_on_pixel_axes(&all), places)
}

/// Whether light that leaves one screen is at the other, everywhere.
fn is_same_place(from: &Screen, to: &Screen) -> bool {
    from.frame == to.frame
        && from.shape == to.shape
        && from.leaves() == to.arrives
        && from.index_behind() == to.index
}

/// The screen that acts as two in its place; nothing where no screen does.
fn product(from: &Screen, to: &Screen, values: PixelValues) -> Option<Screen> {
    let (kind, main) = match (&from.kind, &to.kind) {
        (ScreenKind::Sensor(_), _) | (_, ScreenKind::Sensor(_)) => return None,
        (ScreenKind::Stop(a), ScreenKind::Stop(b)) => (ScreenKind::Stop(common(a, b)), to),
        (ScreenKind::Stop(a), ScreenKind::Doe(doe)) => (cut(doe, a), to),
        (ScreenKind::Doe(doe), ScreenKind::Stop(a)) => (cut(doe, a), from),
        // An interface transmits light in the direction that it has there.
        _ if from.behind.is_some() || to.behind.is_some() => return None,
        (ScreenKind::Doe(a), ScreenKind::Doe(b)) => (ScreenKind::Doe(both(a, b, values)?), to),
    };
    Some(Screen {
        name: main.name.clone(),
        kind,
        index: from.index,
        behind: from.behind.or(to.behind),
        arrives: from.arrives,
        ..to.clone()
    })
}

/// An element in an aperture.
fn cut(doe: &Doe, aperture: &Aperture) -> ScreenKind {
    ScreenKind::Doe(Doe {
        aperture: common(aperture, &doe.aperture),
        ..doe.clone()
    })
}

/// Two elements as one; nothing where their pixels have other lattices, or both vary.
fn both(a: &Doe, b: &Doe, values: PixelValues) -> Option<Doe> {
    let free = [a, b].iter().all(|doe| doe.free_pixels().is_some());
    if free && values == PixelValues::Varying || a.reflect && b.reflect {
        return None;
    }
    let layers = a.layers.iter().chain(&b.layers);
    let both = Doe {
        layers: layers.cloned().collect(),
        aperture: common(&a.aperture, &b.aperture),
        reflect: a.reflect || b.reflect,
    };
    both.shares_lattice().then_some(both)
}

/// What two apertures leave open.
fn common(a: &Aperture, b: &Aperture) -> Aperture {
    match (&a.outline, &b.outline) {
        (Outline::Open, _) => return b.clone(),
        (_, Outline::Open) => return a.clone(),
        _ if lies_in(a, b) => return a.clone(),
        _ if lies_in(b, a) => return b.clone(),
        _ => {}
    }
    // What the second leaves over of the first, taken from the first.
    a.clone().blocked(a.clone().blocked(b.clone()))
}

/// Whether an aperture lies in another that has no holes, as far as points along their edges tell.
fn lies_in(inner: &Aperture, outer: &Aperture) -> bool {
    let whole = matches!(
        outer.outline,
        Outline::Disc { .. } | Outline::Rectangle { .. } | Outline::Polygon { .. }
    );
    let within = inner.rim().iter().all(|[x, y]| outer.depth(*x, *y) > -1e-9);
    let free = outer.rim().iter().all(|[x, y]| inner.depth(*x, *y) < 1e-9);
    whole && within && free
}

#[cfg(test)]
mod tests {
    use crate::engine::rims::joined_screens::{common, joined, joining_hops};
    use crate::engine::rims::pixel_light::PixelValues;
    use crate::fixtures::noise::noise;
    use crate::fixtures::parts::{box_pixels, element, lit, on_axis, open_screen, screen, sensor};
    use crate::optics::aperture::Aperture;
    use crate::optics::doe::Layer;
    use crate::optics::phase::profile::Profile;
    use crate::optics::screen::ScreenKind;
    use crate::optics::system::System;

    fn vortex(radius: f64) -> ScreenKind {
        let layer = Layer::Phase(Profile::Vortex { charge: 1 });
        ScreenKind::Doe(element(layer, Aperture::disc(radius)))
    }

    fn system(kinds: Vec<ScreenKind>) -> System {
        let mut screens: Vec<_> = kinds
            .into_iter()
            .map(|kind| screen(on_axis(1.0), kind))
            .collect();
        let trains = vec![Vec::new(); screens.len()];
        screens.push(screen(on_axis(9.0), sensor(4, 1.0)));
        lit(screens, trains)
    }

    /// What both leave open: the smaller where it lies in the larger, and what every point says.
    #[test]
    fn apertures_in_one_place_cut_together() {
        let disc = Aperture::disc(1.0);
        let slit = Aperture::turned_rectangle(2.0, 0.4, 0.3, [0.1, 0.0]);
        let ring = Aperture::disc(3.0).blocked(Aperture::disc(0.5));
        for (a, b) in [(&disc, &slit), (&disc, &ring), (&ring, &slit)] {
            let both = common(a, b);
            for (x, y) in (0..400).map(|n| (f64::from(n % 20) - 9.7, f64::from(n / 20) - 9.2)) {
                let (x, y) = (0.3 * x, 0.3 * y);
                assert_eq!(both.contains(x, y), a.contains(x, y) && b.contains(x, y));
            }
        }
        assert_eq!(common(&Aperture::disc(2.0), &disc), disc);
        assert_eq!(common(&disc, &Aperture::OPEN), disc);
    }

    /// A stop, two phases and pixels in one place are one screen, and the transmission is the product.
    #[test]
    fn screens_in_one_place_are_one() {
        let stop = ScreenKind::Stop(Aperture::disc(5.0));
        let pixels = box_pixels(noise((8, 8), 0), 1.0);
        let given = system(vec![stop, vortex(6.0), pixels, vortex(4.0)]);
        let joining = joining_hops(&given, PixelValues::Varying);
        assert_eq!(joining, [true, true, true, false]);
        let (one, places) = joined(&given, &joining);
        assert_eq!((one.screens.len(), one.trains.len()), (2, 1));
        assert_eq!(places, [0, 0, 0, 0, 1]);
        let ScreenKind::Doe(doe) = &one.screens[0].kind else {
            panic!("{:?}", one.screens[0].kind)
        };
        assert_eq!(doe.aperture, Aperture::disc(4.0));
        let [
            _,
            ScreenKind::Doe(first),
            ScreenKind::Doe(second),
            ScreenKind::Doe(third),
            _,
        ] = [0, 1, 2, 3, 4].map(|n| given.screens[n].kind.clone())
        else {
            panic!("elements")
        };
        let at = |doe: &crate::optics::doe::Doe| doe.transmission(1.3, 0.4);
        let expected = at(&first) * at(&second) * at(&third);
        assert!((at(doe) - expected).norm() < 1e-12);
    }

    /// Screens apart, or of pixels that both vary, keep their hop.
    #[test]
    fn other_screens_stay_two() {
        let pixels = || box_pixels(noise((8, 8), 0), 1.0);
        let both = system(vec![pixels(), pixels()]);
        assert_eq!(joining_hops(&both, PixelValues::Varying), [false, false]);
        assert_eq!(joining_hops(&both, PixelValues::Fixed), [true, false]);
        let mut apart = system(vec![vortex(1.0), vortex(1.0)]);
        apart.screens[0] = open_screen(on_axis(0.999));
        assert_eq!(joining_hops(&apart, PixelValues::Fixed), [false, false]);
    }
}
