"""Lenses whose rays are timed, and rays through them by several programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import optiland.backend as be
from numpy.typing import NDArray
from optiland.materials import IdealMaterial
from optiland.optic import Optic
from optiland.rays import RealRays
from optiland.samples.objectives import CookeTriplet, DoubleGauss

import raylet
import raylet.optiland

WAVE_UM = 0.5876

Real = NDArray[np.float64]


def singlet() -> Optic:
    """A sphere of 25.8 mm, a plane and an image plane."""
    lens = Optic()
    lens.surfaces.add(index=0, thickness=be.inf)
    lens.surfaces.add(index=1, radius=25.8, thickness=5.3, material=IdealMaterial(1.5131), is_stop=True)
    lens.surfaces.add(index=2, radius=be.inf, thickness=46.5)
    lens.surfaces.add(index=3)
    lens.set_aperture(aperture_type="EPD", value=10.0)
    lens.fields.set_type(field_type="angle")
    lens.fields.add(y=0)
    lens.wavelengths.add(value=WAVE_UM, is_primary=True)
    return lens


@dataclass(frozen=True)
class Case:
    """A lens, and the part of its first aperture that rays fill."""

    name: str
    lens: Callable[[], Optic]
    semi_aperture_mm: float
    pupil: float


CASES = (
    Case("singlet", singlet, 12.7, 0.4),
    Case("Cooke triplet", CookeTriplet, 10.0, 0.3),
    Case("double Gauss", DoubleGauss, 15.0, 0.4),
)


def pupil(case: Case, count: int) -> Real:
    """Places in the pupil, at random."""
    return case.pupil * np.random.default_rng(3).uniform(-0.7, 0.7, (2, count))


def to_raylet(case: Case) -> raylet.System:
    """The lens as a system of raylet."""
    be.set_backend("numpy")
    return raylet.optiland.to_system(case.lens(), WAVE_UM, semi_aperture_mm=case.semi_aperture_mm)


def starts(case: Case, count: int) -> tuple[Real, Real]:
    """Places 10 mm before the lens, (3, rays), and direction cosines of rays as raylet starts them."""
    Px, Py = pupil(case, count)
    start = to_raylet(case).trace(Px=Px, Py=Py, parts=0)
    place = np.stack([start.x[0], start.y[0], start.z[0]])
    along = np.stack([start.L[0], start.M[0], start.N[0]])
    return place - 10.0 * along, along


def in_optiland(lens: Optic, place: Real, along: Real) -> Any:
    """The same rays in Optiland, traced to the image."""
    ones = be.ones(place.shape[1])
    rays = RealRays(*map(be.array, place), *map(be.array, along), ones, ones * WAVE_UM)
    lens.surfaces.trace(rays, skip=1)
    return rays


def choose(backend: str) -> None:
    """Lets Optiland compute in double precision with this backend."""
    be.set_backend(backend)
    if backend == "torch":
        be.set_precision("float64")
