"""DeepLens: the same rays, the same gradients, and a paper's system with its rays in DeepLens's hands."""

from __future__ import annotations

import warnings
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
    pytest.importorskip("deeplens")
    import torch
    from deeplens import GeoLens
    from deeplens.geometric_surface import Aperture, Aspheric, Plane, Spheric
    from deeplens.light import Ray

    import raylet.deeplens

pytestmark = [pytest.mark.torch, pytest.mark.filterwarnings("ignore")]

#: Index 1.5131 at every wavelength.
GLASS = "1.5131/1e30"


def double(value: float) -> torch.Tensor:
    return torch.tensor(value, dtype=torch.float64)


def geolens(*surfaces: Any) -> Any:
    lens = GeoLens(dtype=torch.float64, device="cpu", primary_wvln=0.7)
    lens.surfaces = list(surfaces)
    return lens


def two_sided(rows: Any, rim: float) -> tuple[raylet.System, Any]:
    """Surfaces (radius, thickness, index, aspheric) as a raylet system and as a DeepLens lens."""
    own, surfaces = raylet.System(wavelength_um=0.7), []
    for radius, thickness, index, aspheric in rows:
        bent = {} if aspheric is None else {"conic": -0.6, "aspheric": aspheric}
        own.add_surface(radius_mm=radius, thickness_mm=thickness, glass=index, semi_aperture_mm=rim, **bent)
        given = {"r": rim, "d_next": double(thickness), "mat2": "air" if index == 1.0 else f"{index}/1e30"}
        if radius is None:
            surfaces.append(Plane(**given))
        elif aspheric is None:
            surfaces.append(Spheric(c=1.0 / radius, **given))
        else:
            surfaces.append(Aspheric(c=1.0 / radius, k=-0.6, ai=aspheric, **given))
    return own.add_sensor(pixels=(4, 4), pitch_um=10.0), geolens(*surfaces)


SINGLET = [(25.8, 5.3, 1.5131, None), (None, 46.5, 1.0, None)]
ASPHERE = [(25.8, 5.3, 1.5131, [1e-6, 2e-9]), (None, 46.5, 1.0, None)]
TRIPLET = [
    (23.713, 4.831, 1.691, None),
    (7331.288, 5.86, 1.0, None),
    (-24.456, 0.975, 1.6734, None),
    (21.896, 4.822, 1.0, None),
    (86.759, 3.127, 1.691, None),
    (-20.4942, 41.10346, 1.0, None),
]


def launched(own: raylet.System, count: int, pupil: float, field_deg: float, **choices: Any) -> Any:
    random = np.random.default_rng(3)
    Px, Py, Hx, Hy = random.uniform(-0.7, 0.7, (4, count))
    return own.trace(Hx, Hy, pupil * Px, pupil * Py, field_deg=field_deg, **choices)


def by_deeplens(lens: Any, rays: Any) -> Any:
    """The same rays from 10 mm before the lens; their paths are counted from the same wavefront."""
    place = np.stack([rays.x[0], rays.y[0], rays.z[0]], 1)
    along = np.stack([rays.L[0], rays.M[0], rays.N[0]], 1)
    start = place - 10.0 * along / along[:, 2:]
    ray = lens.trace2sensor(Ray(torch.tensor(start), torch.tensor(along), wvln=0.7, is_coherent=True))
    assert (ray.is_valid.numpy() > 0)[rays.arrived].all()
    return ray.o[:, 0], ray.o[:, 1], ray.opl[:, 0] + torch.tensor((start * along).sum(1))


@pytest.mark.parametrize(
    ("rows", "rim", "pupil", "field_deg"),
    [(SINGLET, 12.7, 0.7, 5.0), (ASPHERE, 12.7, 0.7, 5.0), (TRIPLET, 10.0, 0.35, 14.0)],
)
def test_hits_and_paths_agree(rows: Any, rim: float, pupil: float, field_deg: float, monkeypatch: Any) -> None:
    """Places to 1e-10 mm and paths to 1e-9 mm: DeepLens adds 1e-12 below the root of Snell's law. Without that all
    agree to 1e-12 mm."""
    own, lens = two_sided(rows, rim)
    rays = launched(own, 300, pupil, field_deg)
    assert rays.arrived.sum() > 100

    def gaps() -> list[float]:
        pairs = zip((rays.x, rays.y, rays.opl_mm), by_deeplens(lens, rays))
        return [np.abs(mine[-1] - theirs.numpy())[rays.arrived].max() for mine, theirs in pairs]

    assert np.all(np.array(gaps()) < [1e-10, 1e-10, 1e-9])
    monkeypatch.setattr("deeplens.geometric_surface.base_surface.EPSILON", 0.0)
    assert max(gaps()) < 1e-12


@pytest.mark.parametrize(("rows", "rim"), [(SINGLET, 12.7), (TRIPLET, 10.0)])
def test_gradients_by_curvature_agree(rows: Any, rim: float) -> None:
    """Derivatives of landings and paths by the curvature of the first surface, against DeepLens's autograd."""
    own, lens = two_sided(rows, rim)
    name = "element[0].radius_mm"
    rays = launched(own, 5, 0.35, 5.0, derivatives=[name])
    curvature = double(1.0 / rows[0][0]).requires_grad_()
    lens.surfaces[0].c = curvature
    for which, value in zip((0, 1, 4), by_deeplens(lens, rays)):
        for ray in range(5):
            (by_curvature,) = torch.autograd.grad(value[ray], curvature, retain_graph=True)
            assert rays.derivatives[name][which, ray] == pytest.approx(float(by_curvature), rel=1e-8, abs=1e-8)


def hologram_before() -> Any:
    """The hologram's plane, and 3 mm behind it the LA1131-A."""
    return geolens(
        Aperture(r=5.0, d_next=double(3.0)),
        Spheric(c=1 / 25.8, r=12.7, d_next=double(5.3), mat2=GLASS),
        Plane(r=12.7, d_next=double(44.7), mat2="air"),
    )


def hybrid(**choices: Any) -> Any:
    layer = raylet.pixels(pitch_um=PITCH, phase=PHASE)
    return raylet.deeplens.Hybrid(hologram_before(), 0, layer, **{**HOLOGRAM, **choices})


def test_system_of_the_paper_with_rays_in_deeplenss_hands() -> None:
    assert apart(hybrid().field(), hologram_first().simulate().field) < 1e-3


def test_gradients_of_that_system() -> None:
    """By the phases, and by a curvature of the lens in DeepLens's hands, against raylet's own."""
    other = hybrid(threshold=0.0, tolerance=1e-6, sigma_mm=0.075, towards=(-0.022, 0.022, -0.022, 0.022))
    phase = torch.tensor(PHASE, requires_grad=True)
    curvature = double(1 / 25.8).requires_grad_()
    other.lens.surfaces[1].c = curvature
    field = other.field(phase)
    weight = np.random.default_rng(5).uniform(0.0, 1.0, field.shape)
    (torch.tensor(weight) * field.abs().square()).sum().backward()

    linearised = hologram_first().settings(target_error=1e-4).linearised("doe", parameters=["element[1].radius_mm"])
    passage = linearised(PHASE)
    (by_phase,), by_number = passage.adjoint(2.0 * weight * passage.field)
    assert apart(phase.grad, by_phase) < 1e-3
    assert float(curvature.grad) == pytest.approx(by_number[0], rel=1e-3)


def lens_first(**choices: Any) -> Any:
    """A small lens, and the hologram behind it."""
    lens = geolens(
        Aperture(r=2.0, d_next=double(1.0)),
        Spheric(c=0.1, r=2.0, d_next=double(1.0), mat2=GLASS),
        Plane(r=2.0, d_next=double(1.0), mat2="air"),
        Plane(r=2.0, d_next=double(15.0), mat2="air"),
    )
    layer = raylet.pixels(pitch_um=BEHIND_PITCH, phase=PHASE)
    return raylet.deeplens.Hybrid(lens, 3, layer, **{**BEHIND, **choices})


def test_element_behind_a_lens_and_finite_object() -> None:
    other, own = lens_first(), hologram_behind()
    assert apart(other.field(), own.simulate().field) < 1e-3
    foreign = other.field(fov_y=-float(np.rad2deg(np.arctan(1.0 / 200.0))), depth=-200.0)
    assert apart(foreign, own.point_source((0.0, 1.0, -200.0)).simulate().field) < 1e-3


@pytest.mark.slow
def test_gradients_to_the_lens_before_the_element() -> None:
    """By its curvature and by the phases, of how far the field is from that of a lens 20 % stronger, against
    differences of raylet's own runs."""
    other = lens_first(threshold=0.0, tolerance=1e-6)
    other.lens.surfaces[1].c = double(0.1 + STRONGER)
    wanted = other.field(torch.tensor(PHASE)).detach()
    phase = torch.tensor(PHASE, requires_grad=True)
    curvature = double(0.1).requires_grad_()
    other.lens.surfaces[1].c = curvature
    distance(other.field(phase), wanted).backward()
    assert missed(wanted.numpy(), float(curvature.grad), phase.grad.numpy()) < 1e-3


def test_what_it_cannot_do_is_refused() -> None:
    layer = raylet.pixels(pitch_um=PITCH, phase=PHASE)
    with pytest.raises(NotImplementedError, match=r"surfaces\[1\] of the DeepLens lens is a Spheric, expected"):
        raylet.deeplens.Hybrid(hologram_before(), 1, layer, **HOLOGRAM)
    with pytest.raises(IndexError, match="surface is 7, expected 0 to 2"):
        raylet.deeplens.Hybrid(hologram_before(), 7, layer, **HOLOGRAM)
    single = hologram_before().astype(torch.float32)
    with pytest.raises(TypeError, match=r"surfaces\[0\].d_next of the DeepLens lens is torch.float32 on cpu, expected"):
        raylet.deeplens.Hybrid(single, 0, layer, **HOLOGRAM)
    with pytest.raises(ValueError, match="no ray of this field reaches the element"):
        lens_first().field(fov_y=80.0)
