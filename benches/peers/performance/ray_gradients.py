"""Rays with gradients by all curvatures of a lens, beside Optiland and DeepLens, both with PyTorch.

The loss is the mean square of the distances of landings from the axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from benches.peers.performance.lenses import CASES, WAVE_UM, Real, choose, in_optiland, pupil, starts, to_raylet
from benches.peers.performance.own_process import in_own_process

import raylet

#: Rays of a run.
RAYS = 200_000


def by_raylet(number: int, rays: int) -> Callable[[], Real]:
    """The gradient by all curvatures, in the order of the surfaces."""
    case = CASES[number]
    system = to_raylet(case)
    curved = curved_parts(system)
    Px, Py = pupil(case, rays)

    def run() -> Real:
        found = system.trace(Px=Px, Py=Py, parts=-1)
        return found.adjoint(curved, x=2.0 / rays * found.x[0], y=2.0 / rays * found.y[0])

    return run


def curved_parts(system: raylet.System) -> list[str]:
    """The paths of all radii of spheres."""
    return [f"{part['name']}.radius_mm" for part in system.parts if part["kind"] == "sphere"]


def by_optiland(number: int, rays: int) -> Callable[[], Real]:
    """The same by Optiland: radii carry gradients, and −R² turns these into those of curvatures."""
    import optiland.backend as be

    place, along = starts(CASES[number], rays)
    choose("torch")
    be.grad_mode.enable()

    def run() -> Real:
        lens = CASES[number].lens()
        radii = []
        for surface in lens.surfaces.surfaces[1:-1]:
            geometry = surface.geometry
            radius = float(be.to_numpy(geometry.radius))
            if np.isfinite(radius):
                geometry.radius = be.array(radius).detach().clone().requires_grad_(True)
                radii.append(geometry.radius)
        landed = in_optiland(lens, place, along)
        loss = (landed.x**2 + landed.y**2).mean()
        loss.backward()
        return np.array([-float(radius.grad) * float(radius.detach()) ** 2 for radius in radii])

    return run


def by_deeplens(number: int, rays: int) -> Callable[[], Real]:
    """The same by DeepLens."""
    import torch
    from deeplens import GeoLens
    from deeplens.geometric_surface import Plane, Spheric
    from deeplens.light import Ray

    case = CASES[number]
    place, along = (torch.tensor(array.T.copy()) for array in starts(case, rays))
    *elements, _ = to_raylet(case)._document["element"]

    def run() -> Real:
        lens = GeoLens(dtype=torch.float64, device="cpu", primary_wvln=WAVE_UM)
        lens.surfaces, curvatures = [], []
        for element in elements:
            index = element["glass"]["index"]
            thickness = torch.tensor(element["thickness_mm"], dtype=torch.float64)
            given = {"r": case.semi_aperture_mm, "d_next": thickness}
            given["mat2"] = "air" if index == 1.0 else f"{index!r}/1e30"
            if element["radius_mm"] is None:
                lens.surfaces.append(Plane(**given))
                continue
            curvatures.append(torch.tensor(1.0 / element["radius_mm"], dtype=torch.float64, requires_grad=True))
            lens.surfaces.append(Spheric(c=1.0, **given))
            lens.surfaces[-1].c = curvatures[-1]
        landed = lens.trace2sensor(Ray(place, along, wvln=WAVE_UM, is_coherent=True)).o
        (landed[:, 0] ** 2 + landed[:, 1] ** 2).mean().backward()
        return np.array([float(curvature.grad) for curvature in curvatures])

    return run


def rows() -> Iterator[tuple[tuple[float, float], str]]:
    """For each lens the ratios of the rate of raylet to those of Optiland and DeepLens, and the row of the table."""
    for number, case in enumerate(CASES):
        surfaces = len(to_raylet(case).parts) - 1
        own, *peers = (in_own_process(way, number, RAYS, runs=3) for way in (by_raylet, by_optiland, by_deeplens))
        rate, *others = (RAYS * surfaces / took.seconds / 1e6 for took in (own, *peers))
        cells = [case.name, str(len(own.found)), f"{rate:.3g}", f"{own.megabytes:.0f} MB"]
        for peer, other in zip(peers, others, strict=True):
            off = float(np.linalg.norm(peer.found - own.found) / np.linalg.norm(own.found))
            cells += [f"{other:.3g}", f"{peer.megabytes:.0f} MB", f"{off:.0e}", f"{rate / other:.3g}"]
        yield (rate / others[0], rate / others[1]), "| " + " | ".join(cells) + " |"
