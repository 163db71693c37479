"""Optiland: the same rays, the same gradients, and a paper's system with its rays in Optiland's hands."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from conftest import noise

import raylet

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pytest.importorskip("optiland")
    import optiland.backend as be
    from optiland.materials import IdealMaterial
    from optiland.optic import Optic
    from optiland.rays import RealRays
    from optiland.samples.objectives import CookeTriplet, DoubleGauss

    import raylet.optiland

pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture
def torch() -> Iterator[Any]:
    module = pytest.importorskip("torch")
    be.set_backend("torch")
    be.set_precision("float64")
    be.grad_mode.enable()
    yield module
    be.grad_mode.disable()
    be.set_backend("numpy")


def singlet(first: float = 0.0) -> Optic:
    """The LA1131-A; a plane of air so far before it if that is not zero."""
    lens = Optic()
    lens.surfaces.add(index=0, radius=be.inf, thickness=be.inf)
    number = 1
    if first:
        lens.surfaces.add(index=1, radius=be.inf, thickness=first, is_stop=True)
        number = 2
    lens.surfaces.add(index=number, radius=25.8, thickness=5.3, material=IdealMaterial(1.5131), is_stop=not first)
    lens.surfaces.add(index=number + 1, radius=be.inf, thickness=44.7 if first else 46.5)
    lens.surfaces.add(index=number + 2)
    lens.set_aperture(aperture_type="EPD", value=1.26 if first else 10.0)
    lens.fields.set_type(field_type="angle")
    lens.fields.add(y=0)
    lens.wavelengths.add(value=0.7, is_primary=True)
    return lens


def launched(system: raylet.System, count: int, pupil: float, field_deg: float) -> Any:
    random = np.random.default_rng(3)
    Px, Py = pupil * random.uniform(-0.7, 0.7, (2, count))
    Hx, Hy = random.uniform(-0.7, 0.7, (2, count))
    return system.trace(Hx, Hy, Px, Py, field_deg=field_deg)


def by_optiland(lens: Optic, rays: Any, wave: float) -> tuple[Any, Any, Any]:
    """The same rays from 10 mm before the lens; their paths are counted from the same wavefront."""
    place = np.stack([rays.x[0], rays.y[0], rays.z[0]])
    along = np.stack([rays.L[0], rays.M[0], rays.N[0]])
    start = place - 10.0 * along / along[2]
    same = RealRays(*map(be.array, start), *map(be.array, along), be.ones(len(start[0])), be.ones(len(start[0])) * wave)
    lens.surfaces.trace(same, skip=1)
    return same.x, same.y, same.opd + be.array(np.sum(start * along, axis=0))


@pytest.mark.parametrize(
    ("lens", "aperture", "pupil", "field_deg"),
    [(singlet, 12.7, 0.9, 5.0), (CookeTriplet, 10.0, 0.45, 14.0), (DoubleGauss, 15.0, 0.6, 10.0)],
)
def test_hits_and_paths_agree(lens: Any, aperture: float, pupil: float, field_deg: float) -> None:
    """To 1e-10 mm; measured below 1e-12."""
    optic, wave = lens(), 0.5876
    system = raylet.optiland.to_system(optic, wave, semi_aperture_mm=aperture)
    rays = launched(system, 300, pupil, field_deg)
    assert rays.arrived.sum() > 100
    x, y, path = by_optiland(optic, rays, wave)
    for own, other in ((rays.x, x), (rays.y, y), (rays.opl_mm, path)):
        assert np.abs(own[-1] - other)[rays.arrived].max() < 1e-10


@pytest.mark.parametrize(("lens", "aperture", "pupil"), [(singlet, 12.7, 0.9), (CookeTriplet, 10.0, 0.45)])
def test_gradients_by_curvature_agree(torch: Any, lens: Any, aperture: float, pupil: float) -> None:
    """Derivatives of landings by the curvature of the first surface, against Optiland's autograd, to 1e-8."""
    optic, wave = lens(), 0.5876
    system = raylet.optiland.to_system(optic, wave, semi_aperture_mm=aperture)
    path = "element[0].radius_mm"
    random = np.random.default_rng(3)
    rays = system.trace(0.0, 0.3, *(pupil * random.uniform(-0.7, 0.7, (2, 5))), field_deg=5.0, derivatives=[path])
    radius = torch.tensor(float(optic.surfaces[1].geometry.radius), dtype=torch.float64, requires_grad=True)
    optic.surfaces[1].geometry.radius = radius
    landed = by_optiland(optic, rays, wave)
    for which, value in zip((0, 1, 4), landed):
        for ray in range(5):
            (by_radius,) = torch.autograd.grad(value[ray], radius, retain_graph=True)
            by_curvature = -float(by_radius) * float(radius) ** 2
            assert rays.derivatives[path][which, ray] == pytest.approx(by_curvature, rel=1e-8, abs=1e-8)


#: System 3 of the source paper at half its size: a hologram 3 mm before the LA1131-A.
PHASE = noise((25, 25))
PITCH, SENSOR, SIGMA = 25.2, {"pixels": (48, 48), "pitch_um": 12.6}, 0.1
TOWARDS = (-0.014, 0.014, -0.014, 0.014)


def own_system() -> raylet.System:
    return (
        raylet.System(wavelength_um=0.7)
        .add_doe(raylet.pixels(pitch_um=PITCH, phase=PHASE), aperture=raylet.disc(0.31), thickness_mm=3.0, name="doe")
        .add_surface(radius_mm=25.8, thickness_mm=5.3, glass=1.5131, semi_aperture_mm=12.7)
        .add_surface(thickness_mm=44.7, semi_aperture_mm=12.7)
        .add_sensor(**SENSOR)
    )


def hybrid(**choices: Any) -> Any:
    layer = raylet.pixels(pitch_um=PITCH, phase=PHASE)
    rim = raylet.disc(0.31)
    given = {"aperture": rim, "sigma_mm": SIGMA, "towards": TOWARDS, **SENSOR, **choices}
    return raylet.optiland.Hybrid(singlet(3.0), 1, layer, **given)


def test_system_of_the_paper_with_rays_in_optilands_hands() -> None:
    own = own_system().simulate().field
    foreign = hybrid().field()
    assert np.linalg.norm(foreign - own) < 1e-3 * np.linalg.norm(own)


def test_gradients_of_that_system(torch: Any) -> None:
    """By the phases, and by a curvature of the lens in Optiland's hands, against raylet's own."""
    other = hybrid(threshold=0.0, tolerance=1e-6, sigma_mm=0.075, towards=(-0.022, 0.022, -0.022, 0.022))
    phase = torch.tensor(PHASE, requires_grad=True)
    radius = torch.tensor(25.8, dtype=torch.float64, requires_grad=True)
    other.optic.surfaces[2].geometry.radius = radius
    field = other.field(phase)
    weight = np.random.default_rng(5).uniform(0.0, 1.0, field.shape)
    (torch.tensor(weight) * field.abs().square()).sum().backward()

    bench = own_system().settings(target_error=1e-4).bench("doe", numbers=["element[1].radius_mm"])
    passage = bench(PHASE)
    (by_phase,), by_number = passage.adjoint(2.0 * weight * passage.field)
    error = np.linalg.norm(phase.grad.numpy() - by_phase) / np.linalg.norm(by_phase)
    assert error < 1e-3
    assert -float(radius.grad) * 25.8**2 == pytest.approx(by_number[0], rel=1e-3)
