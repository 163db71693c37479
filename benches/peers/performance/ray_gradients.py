"""Rays with gradients by all curvatures of a lens, beside Optiland with PyTorch.

The loss is the mean square of the distances of landings from the axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from benches.peers.performance.lenses import CASES, Real, choose, in_optiland, pupil, starts, to_raylet
from benches.peers.performance.own_process import in_own_process

#: Rays of a run, and rays whose derivatives raylet gives at a time.
RAYS, AT_ONCE = 200_000, 50_000


def by_raylet(number: int, rays: int) -> Callable[[], Real]:
    """The gradient by all curvatures, in the order of the surfaces."""
    case = CASES[number]
    system = to_raylet(case)
    curved = [f"{part['name']}.radius_mm" for part in system.parts if part["kind"] == "sphere"]
    Px, Py = pupil(case, rays)

    def run() -> Real:
        total = np.zeros(len(curved))
        for first in range(0, rays, AT_ONCE):
            part = slice(first, first + AT_ONCE)
            found = system.trace(Px=Px[part], Py=Py[part], parts=-1, derivatives=curved)
            for i, path in enumerate(curved):
                dx, dy = found.derivatives[path][:2]
                total[i] += 2.0 * (found.x[0] @ dx + found.y[0] @ dy)
        return total / rays

    return run


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


def rows() -> Iterator[tuple[float, str]]:
    """For each lens the ratio of both rates, and the row of the table."""
    for number, case in enumerate(CASES):
        surfaces = len(to_raylet(case).parts) - 1
        own, peer = (in_own_process(prepare, number, RAYS, runs=2) for prepare in (by_raylet, by_optiland))
        off = float(np.linalg.norm(peer.found - own.found) / np.linalg.norm(own.found))
        rates = [RAYS * surfaces / took.seconds / 1e6 for took in (own, peer)]
        each = peer.megabytes * 1e6 / (RAYS * surfaces)
        cells = (
            case.name,
            str(len(own.found)),
            f"{rates[0]:.3g}",
            f"{own.megabytes:.0f} MB",
            f"{rates[1]:.3g}",
            f"{peer.megabytes:.0f} MB, {each:.0f} bytes",
            f"{off:.0e}",
            f"{rates[0] / rates[1]:.3g}",
        )
        yield rates[0] / rates[1], "| " + " | ".join(cells) + " |"
