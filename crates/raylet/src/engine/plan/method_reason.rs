//! The reason for the method of a hop, in words.

use crate::engine::plan::hop_method::HopMethod;
use crate::engine::plan::hop_plan::Plan;
use crate::engine::plan::settings::{Method, Settings};
use crate::optics::refraction::Interface;
use crate::optics::shape::Shape;
use crate::optics::system::Hop;

/// Name of the method of a hop.
pub(crate) fn method_name(method: &HopMethod) -> &'static str {
    match method {
        HopMethod::WholeField(Plan::Free(..)) => "free",
        HopMethod::WholeField(Plan::Beamlets(_)) => "beamlet",
        HopMethod::WholeField(Plan::Planes(_)) => "plane",
        HopMethod::WholeField(Plan::Paper(_)) => "paper",
        HopMethod::LocalBands(_) => "local_bands",
    }
}

/// Why this method was taken for this hop.
pub(crate) fn reason(hop: &Hop, method: &HopMethod, settings: &Settings) -> String {
    if settings.method != Method::Auto {
        return String::from("requested");
    }
    match method {
        HopMethod::LocalBands(_) => String::from("whole fields take more time or memory"),
        HopMethod::WholeField(Plan::Free(..)) => {
            String::from("parallel screens with nothing but plane plates between them")
        }
        HopMethod::WholeField(_) => obstacle(hop),
    }
}

/// Why a hop needs rays, in words.
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
