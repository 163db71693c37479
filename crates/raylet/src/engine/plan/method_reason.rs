//! The reason for the method of a hop, in words.

use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::{Method, Settings};
use crate::optics::refraction::Interface;
use crate::optics::shape::Shape;
use crate::optics::system::Hop;

/// Name of the method of a plan.
pub(crate) fn method_name(plan: &Plan) -> &'static str {
    match plan {
        Plan::Free(..) => "free",
        Plan::Beamlets(_) => "beamlet",
        Plan::Planes(_) => "plane",
        Plan::Paper(_) => "paper",
    }
}

/// Why this plan was made for this hop.
pub(crate) fn reason(hop: &Hop, plan: &Plan, settings: &Settings) -> String {
    if settings.method != Method::Auto {
        return String::from("requested");
    }
    if let Plan::Free(..) = plan {
        return String::from("parallel screens with nothing but plane plates between them");
    }
    obstacle(hop)
}

/// What keeps a hop from going without rays.
fn obstacle(hop: &Hop) -> String {
    let count = |test: &dyn Fn(&crate::optics::surface::Surface) -> bool| {
        hop.train.iter().filter(|s| test(s)).count()
    };
    let curved = count(&|s| s.shape != Shape::Plane);
    let mirrors = count(&|s| s.interface == Interface::Reflect);
    let plural = |n: usize| if n == 1 { "" } else { "s" };
    if curved > 0 {
        return format!(
            "{curved} curved surface{} between the screens",
            plural(curved)
        );
    }
    if mirrors > 0 {
        return format!("{mirrors} mirror{} between the screens", plural(mirrors));
    }
    if !hop.from.frame.is_parallel(&hop.to.frame) {
        return String::from("the screens are not parallel");
    }
    String::from("a tilted plate, or the edge of one, between the screens")
}
