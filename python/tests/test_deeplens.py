"""DeepLens: the same rays, the same gradients, and a paper's system with its rays in DeepLens's hands."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from conftest import noise

import raylet

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pytest.importorskip("deeplens")
    import torch
    from deeplens import GeoLens
    from deeplens.geometric_surface import Aperture, Plane, Spheric

    import raylet.deeplens

pytestmark = pytest.mark.filterwarnings("ignore")

#: Index 1.5131 at every wavelength.
GLASS = "1.5131/1e30"


def double(value: float) -> torch.Tensor:
    return torch.tensor(value, dtype=torch.float64)


def geolens(*surfaces: Any) -> Any:
    lens = GeoLens(dtype=torch.float64, device="cpu", primary_wvln=0.7)
    lens.surfaces = list(surfaces)
    return lens


#: System 3 of the source paper at half its size: a hologram 3 mm before the LA1131-A.
PHASE = noise((25, 25))
PITCH, SENSOR, SIGMA = 25.2, {"pixels": (48, 48), "pitch_um": 12.6}, 0.1
TOWARDS = (-0.014, 0.014, -0.014, 0.014)


def singlet() -> Any:
    return geolens(
        Aperture(r=5.0, d_next=double(3.0)),
        Spheric(c=1 / 25.8, r=12.7, d_next=double(5.3), mat2=GLASS),
        Plane(r=12.7, d_next=double(44.7), mat2="air"),
    )


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
    return raylet.deeplens.Hybrid(singlet(), 0, layer, **given)


def test_system_of_the_paper_with_rays_in_deeplenss_hands() -> None:
    own = own_system().simulate().field
    foreign = hybrid().field().numpy()
    assert np.linalg.norm(foreign - own) < 1e-3 * np.linalg.norm(own)


def test_gradients_of_that_system() -> None:
    """By the phases, and by a curvature of the lens in DeepLens's hands, against raylet's own."""
    other = hybrid(threshold=0.0, tolerance=1e-6, sigma_mm=0.075, towards=(-0.022, 0.022, -0.022, 0.022))
    phase = torch.tensor(PHASE, requires_grad=True)
    curvature = double(1 / 25.8).requires_grad_()
    other.lens.surfaces[1].c = curvature
    field = other.field(phase)
    weight = np.random.default_rng(5).uniform(0.0, 1.0, field.shape)
    (torch.tensor(weight) * field.abs().square()).sum().backward()

    bench = own_system().settings(target_error=1e-4).bench("doe", numbers=["element[1].radius_mm"])
    passage = bench(PHASE)
    (by_phase,), by_number = passage.adjoint(2.0 * weight * passage.field)
    error = np.linalg.norm(phase.grad.numpy() - by_phase) / np.linalg.norm(by_phase)
    assert error < 1e-3
    assert float(curvature.grad) == pytest.approx(by_number[0], rel=1e-3)
