//! Clear apertures, as a scene file describes them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::file::decode::fault::Fault;
use crate::file::decode::number::{not_negative, positive};
use crate::file::decode::place::Place;
use crate::optics::aperture::{self as optics, Outline};
use crate::optics::polygon::{area, crosses_itself};

/// The open part of an element, such as { disc = { radius_mm = 0.63 } }: one outline, and what is blocked
/// inside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Aperture {
    /// Within a circle.
    #[serde(default)]
    pub disc: Option<Disc>,
    /// Within a rectangle.
    #[serde(default)]
    pub rectangle: Option<Rectangle>,
    /// Between two circles.
    #[serde(default)]
    pub annulus: Option<Annulus>,
    /// Within a polygon of equal sides and angles.
    #[serde(default)]
    pub regular_polygon: Option<RegularPolygon>,
    /// Within any polygon.
    #[serde(default)]
    pub polygon: Option<Polygon>,
    /// Parts of the aperture that are blocked, each described as an aperture is.
    #[serde(default)]
    pub blocked: Vec<Aperture>,
}

/// The inside of a circle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Radius in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub radius_mm: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// The inside of a rectangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Full width along x in millimetres, before it is turned.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub width_mm: f64,
    /// Full height along y in millimetres, before it is turned.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub height_mm: f64,
    /// Turn about its centre in degrees from x towards y.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// The ring between two circles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Annulus {
    /// Radius of the obstruction in millimetres.
    #[serde(deserialize_with = "not_negative")]
    #[schemars(extend("minimum" = 0))]
    pub inner_radius_mm: f64,
    /// Radius of the aperture in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub outer_radius_mm: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// The inside of a regular polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegularPolygon {
    /// Number of sides, from 3 to 1000.
    #[schemars(extend("minimum" = 3, "maximum" = 1000))]
    pub sides: usize,
    /// Distance of the corners from the centre in millimetres.
    #[serde(deserialize_with = "positive")]
    #[schemars(extend("minimum" = 1e-12))]
    pub radius_mm: f64,
    /// Direction of the first corner in degrees from x towards y.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Centre [x, y] in millimetres.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// The inside of a polygon whose sides do not cross.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Polygon {
    /// Its corners [x, y] in millimetres in order, seen from `centre_mm`; from 3 to 1000 of them.
    pub corners_mm: Vec<[f64; 2]>,
    /// Where [x, y] in millimetres the corners are counted from.
    #[serde(default)]
    pub centre_mm: [f64; 2],
}

/// Most corners of a polygon.
const MOST_CORNERS: usize = 1000;

impl Aperture {
    /// The aperture that is described, once it is checked; one without an outline has no edge.
    pub(crate) fn optics(&self) -> optics::Aperture {
        let shaped = |outline: Outline, centre: [f64; 2]| optics::Aperture { outline, centre };
        let open = if let Some(disc) = &self.disc {
            let radius = disc.radius_mm;
            shaped(Outline::Disc { radius }, disc.centre_mm)
        } else if let Some(one) = &self.rectangle {
            let (half_x, half_y) = (0.5 * one.width_mm, 0.5 * one.height_mm);
            let angle = one.rotation_deg.to_radians();
            optics::Aperture::turned_rectangle(half_x, half_y, angle, one.centre_mm)
        } else if let Some(ring) = &self.annulus {
            let (inner, outer) = (ring.inner_radius_mm, ring.outer_radius_mm);
            shaped(Outline::Annulus { inner, outer }, ring.centre_mm)
        } else if let Some(one) = &self.regular_polygon {
            let angle = one.rotation_deg.to_radians();
            optics::Aperture::regular_polygon(one.sides, one.radius_mm, angle, one.centre_mm)
        } else if let Some(one) = &self.polygon {
            let corners = one.corners_mm.clone();
            shaped(Outline::Polygon { corners }, one.centre_mm)
        } else {
            optics::Aperture::OPEN
        };
        let blocked = self.blocked.iter().map(Aperture::optics);
        blocked.fold(open, optics::Aperture::blocked)
    }

    /// Checks that there is one outline with an inside, and the same of what is blocked.
    pub(crate) fn check(&self, place: &Place<'_>) -> Result<(), Fault> {
        let given = [
            self.disc.is_some(),
            self.rectangle.is_some(),
            self.annulus.is_some(),
            self.regular_polygon.is_some(),
            self.polygon.is_some(),
        ];
        let expected = "one of `disc`, `rectangle`, `annulus`, `regular_polygon`, `polygon`";
        match given.into_iter().filter(|given| *given).count() {
            1 => {}
            0 => return place.refuse("no outline", expected),
            _ => return place.refuse("several outlines", expected),
        }
        if let Some(ring) = &self.annulus
            && ring.inner_radius_mm >= ring.outer_radius_mm
        {
            return place.inner(".annulus.inner_radius_mm").refuse(
                ring.inner_radius_mm.to_string(),
                format!("less than outer_radius_mm = {}", ring.outer_radius_mm),
            );
        }
        if let Some(one) = &self.regular_polygon
            && !(3..=MOST_CORNERS).contains(&one.sides)
        {
            return place.inner(".regular_polygon.sides").refuse(
                one.sides.to_string(),
                format!("from 3 to {MOST_CORNERS} sides"),
            );
        }
        if let Some(one) = &self.polygon {
            check_corners(&one.corners_mm, &place.inner(".polygon.corners_mm"))?;
        }
        for (i, part) in self.blocked.iter().enumerate() {
            part.check(&place.inner(&format!(".blocked[{i}]")))?;
        }
        Ok(())
    }
}

/// A polygon must have an inside.
fn check_corners(corners: &[[f64; 2]], place: &Place<'_>) -> Result<(), Fault> {
    if !(3..=MOST_CORNERS).contains(&corners.len()) {
        let found = format!("{} corners", corners.len());
        return place.refuse(found, format!("from 3 to {MOST_CORNERS} corners"));
    }
    if crosses_itself(corners) {
        return place.refuse("a polygon whose sides cross or touch", "corners in order");
    }
    if area(corners) == 0.0 {
        return place.refuse("corners on one line", "a polygon with an inside");
    }
    Ok(())
}

/// The keys of a surface that describe its clear aperture.
#[derive(Clone, Copy, Debug)]
pub struct Rim<'a> {
    /// Radius of a centred disc in mm.
    pub semi_aperture_mm: Option<f64>,
    /// Or any aperture.
    pub aperture: Option<&'a Aperture>,
}

impl Rim<'_> {
    /// The aperture that is described, once it is checked.
    pub(crate) fn optics(&self) -> optics::Aperture {
        match (self.aperture, self.semi_aperture_mm) {
            (Some(aperture), _) => aperture.optics(),
            (None, Some(radius)) => optics::Aperture::disc(radius),
            (None, None) => optics::Aperture::OPEN,
        }
    }

    /// The key that holds it, as a step from its table.
    pub(crate) fn key(&self) -> &'static str {
        match self.aperture {
            Some(_) => ".aperture",
            None => ".semi_aperture_mm",
        }
    }

    /// Checks that it is given in one way.
    pub(crate) fn check(&self, place: &Place<'_>) -> Result<(), Fault> {
        match (self.aperture, self.semi_aperture_mm) {
            (Some(aperture), None) => aperture.check(&place.inner(".aperture")),
            (None, Some(_)) => Ok(()),
            (Some(_), Some(_)) => place
                .inner(".aperture")
                .refuse("an aperture beside semi_aperture_mm", "either of the two"),
            (None, None) => place.refuse(
                "no `semi_aperture_mm`",
                "the key `semi_aperture_mm` here, or `aperture`",
            ),
        }
    }
}
