"""Optiland: the same rays, the same gradients, and a paper's system with its rays in Optiland's hands."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from foreign import (
    BEHIND,
    BEHIND_PITCH,
    HOLOGRAM,
    PHASE,
    PITCH,
    STRONGER,
    apart,
    distance,
    hologram_behind,
    hologram_first,
    missed,
)

import raylet

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pytest.importorskip("optiland")
    import optiland.backend as be
    from optiland.coatings import SimpleCoating
    from optiland.materials import IdealMaterial
    from optiland.optic import Optic
    from optiland.physical_apertures import RadialAperture
    from optiland.rays import RealRays
    from optiland.samples.objectives import CookeTriplet, DoubleGauss
    from scipy.spatial.transform import Rotation

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


def hybrid(**choices: Any) -> Any:
    return raylet.optiland.Hybrid(
        singlet(3.0), 1, raylet.pixels(pitch_um=PITCH, phase=PHASE), **{**HOLOGRAM, **choices}
    )


def test_system_of_the_paper_with_rays_in_optilands_hands() -> None:
    assert apart(hybrid().field(), hologram_first().simulate().field) < 1e-3


def test_coatings_and_apertures_count() -> None:
    """A quarter of the intensity is half the field; an aperture that no ray passes leaves nothing."""
    clear, coated, closed = hybrid(), hybrid(), hybrid()
    coated.optic.surfaces[3].interaction_model.coating = SimpleCoating(transmittance=0.25)
    assert apart(coated.field(), 0.5 * clear.field()) < 1e-12
    closed.optic.surfaces[3].aperture = RadialAperture(r_max=6.0, r_min=5.0)
    assert np.all(closed.field() == 0.0)


def test_gradients_of_that_system(torch: Any) -> None:
    """By the phases, and by a curvature of the lens in Optiland's hands, against raylet's own."""
    other = hybrid(threshold=0.0, tolerance=1e-6, sigma_mm=0.075, towards=(-0.022, 0.022, -0.022, 0.022))
    phase = torch.tensor(PHASE, requires_grad=True)
    radius = torch.tensor(25.8, dtype=torch.float64, requires_grad=True)
    other.optic.surfaces[2].geometry.radius = radius
    field = other.field(phase)
    weight = np.random.default_rng(5).uniform(0.0, 1.0, field.shape)
    (torch.tensor(weight) * field.abs().square()).sum().backward()

    linearised = hologram_first().settings(target_error=1e-4).linearised("doe", parameters=["element[1].radius_mm"])
    passage = linearised(PHASE)
    (by_phase,), by_number = passage.adjoint(2.0 * weight * passage.field)
    assert apart(phase.grad, by_phase) < 1e-3
    assert -float(radius.grad) * 25.8**2 == pytest.approx(by_number[0], rel=1e-3)


#: A tilt about x, then about the y axis that stays, is another about x, the new y and the new z.
TILT = Rotation.from_euler("xyz", [5.0, -3.0, 0.0], degrees=True)


def lens_first(
    *, radius: float = np.inf, tilted: bool = False, distance: float = np.inf, height: float = 0.0, **choices: Any
) -> Any:
    """A small lens, and behind it the hologram on a plane, a curved or a tilted surface."""
    lens = Optic()
    lens.surfaces.add(index=0, radius=be.inf, thickness=distance)
    lens.surfaces.add(index=1, radius=be.inf, thickness=1.0, is_stop=True)
    lens.surfaces.add(index=2, radius=10.0, thickness=1.0, material=IdealMaterial(1.5131))
    lens.surfaces.add(index=3, radius=be.inf, thickness=1.0)
    turn = {"rx": np.deg2rad(5.0), "ry": np.deg2rad(-3.0)} if tilted else {}
    lens.surfaces.add(index=4, radius=radius, thickness=15.0, **turn)
    lens.surfaces.add(index=5)
    lens.set_aperture(aperture_type="EPD", value=1.0)
    lens.fields.set_type(field_type="angle" if np.isinf(distance) else "object_height")
    lens.fields.add(y=height)
    lens.wavelengths.add(value=0.7, is_primary=True)
    if tilted:
        x, y, _ = TILT.as_matrix()[2]
        choices["towards"] = (x - 0.06, x + 0.06, y - 0.06, y + 0.06)
    return raylet.optiland.Hybrid(lens, 4, raylet.pixels(pitch_um=BEHIND_PITCH, phase=PHASE), **{**BEHIND, **choices})


def test_element_behind_a_lens() -> None:
    assert apart(lens_first().field(), hologram_behind().simulate().field) < 1e-3


@pytest.mark.slow
def test_element_on_a_curved_surface_behind_a_lens() -> None:
    assert apart(lens_first(radius=12.0).field(), hologram_behind(radius_mm=12.0).simulate().field) < 1e-3


def test_element_on_a_tilted_surface() -> None:
    own = hologram_behind(tilt_deg=TILT.as_euler("XYZ", degrees=True).tolist())
    assert apart(lens_first(tilted=True).field(), own.simulate().field) < 1e-3


def test_finite_object() -> None:
    own = hologram_behind().point_source((0.0, 1.0, -200.0))
    assert apart(lens_first(distance=200.0, height=1.0).field(Hy=1.0), own.simulate().field) < 1e-3


@pytest.mark.slow
def test_gradients_to_the_lens_before_the_element(torch: Any) -> None:
    """By its curvature and by the phases of an element on a curved and tilted surface in the light of a point, of how
    far the field is from that of a lens 20 % stronger, against differences of raylet's own runs."""
    turn = TILT.as_euler("XYZ", degrees=True).tolist()
    own: dict[str, Any] = {"source": (0.0, 1.0, -200.0), "radius_mm": 12.0, "tilt_deg": turn}
    other = lens_first(radius=12.0, tilted=True, distance=200.0, height=1.0, threshold=0.0, tolerance=1e-6)
    other.optic.surfaces[2].geometry.radius = torch.tensor(1.0 / (0.1 + STRONGER), dtype=torch.float64)
    wanted = other.field(PHASE, Hy=1.0).detach()
    phase = torch.tensor(PHASE, requires_grad=True)
    radius = torch.tensor(10.0, dtype=torch.float64, requires_grad=True)
    other.optic.surfaces[2].geometry.radius = radius
    distance(other.field(phase, Hy=1.0), wanted).backward()
    assert missed(wanted.numpy(), -float(radius.grad) * 10.0**2, phase.grad.numpy(), **own) < 1e-3


def test_what_it_cannot_do_is_refused(torch: Any) -> None:
    layer = raylet.pixels(pitch_um=PITCH, phase=PHASE)
    with pytest.raises(IndexError, match="surface is 9, expected 1 to 4"):
        raylet.optiland.Hybrid(singlet(3.0), 9, layer, **HOLOGRAM)
    back = singlet(3.0)
    back.surfaces[1].geometry.cs.rx = be.array(np.pi)
    with pytest.raises(NotImplementedError, match="against its z axis, expected along it"):
        raylet.optiland.Hybrid(back, 1, layer, **HOLOGRAM).field()
    with pytest.raises(ValueError, match=r"phase has shape \(3, 3\), expected \(25, 25\)"):
        hybrid().field(np.zeros((3, 3)))
    be.set_precision("float32")
    with pytest.raises(TypeError, match="single precision, expected"):
        hybrid().field()
    be.set_precision("float64")
