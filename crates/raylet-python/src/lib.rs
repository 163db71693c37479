//! The extension module behind the Python package `raylet`: arrays and words in, arrays and words out. What they
//! mean is the library's affair, and how they are asked for that of `python/raylet`.

mod arrays;
mod bench;
mod design;
mod look;
mod rays;
mod refusal;
mod scene;
mod simulate;
mod trace;
mod watch;

use pyo3::prelude::*;

#[pymodule]
fn _raylet(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add(
        "RayletError",
        module.py().get_type::<refusal::RayletError>(),
    )?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<bench::Bench>()?;
    module.add_class::<bench::Passage>()?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(design::hologram, module)?)?;
    module.add_function(wrap_pyfunction!(design::design, module)?)?;
    module.add_function(wrap_pyfunction!(trace::trace, module)?)?;
    module.add_function(wrap_pyfunction!(look::layout, module)?)?;
    module.add_function(wrap_pyfunction!(look::parts, module)?)?;
    module.add_function(wrap_pyfunction!(look::element, module)?)?;
    module.add_function(wrap_pyfunction!(look::glasses, module)?)?;
    module.add_function(wrap_pyfunction!(rays::scatter, module)?)?;
    module.add_function(wrap_pyfunction!(rays::scatter_adjoint, module)?)?;
    module.add_function(wrap_pyfunction!(rays::beams, module)?)?;
    module.add_function(wrap_pyfunction!(rays::gather, module)?)?;
    module.add_function(wrap_pyfunction!(rays::gather_adjoint, module)?)
}
