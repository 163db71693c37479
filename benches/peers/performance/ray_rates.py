"""Rates of rays from Python, beside other ray tracers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import optiland.backend as be
from benches.peers.performance.lenses import CASES, Case, Real, choose, in_optiland, pupil, singlet, starts, to_raylet
from benches.peers.performance.own_process import in_own_process

#: Rays of a run: of raylet, and of the others, which take longer and more memory.
OWN_RAYS, PEER_RAYS = 10_000_000, 1_000_000


@dataclass(frozen=True)
class Row:
    """The rate of one program with one lens."""

    lens: str
    program: str
    threads: str
    rays: int
    seconds: float
    surfaces: int
    megabytes: float
    off_mm: float

    @property
    def rate(self) -> float:
        """Rays at surfaces each second, in millions."""
        return self.rays * self.surfaces / self.seconds / 1e6

    def markdown(self) -> str:
        off = "0" if self.off_mm == 0.0 else f"{self.off_mm:.0e}"
        figures = (f"{self.rays:.0e}", f"{self.seconds:.2f} s", f"{self.rate:.3g}", f"{self.megabytes:.0f} MB", off)
        return "| " + " | ".join((self.lens, self.program, self.threads, *figures)) + " |"


def rows() -> Iterator[Row]:
    """The rates of all programs with all lenses."""
    for number, case in enumerate(CASES):
        # Surfaces and the image plane; the entrance is no surface.
        surfaces = len(to_raylet(case).parts) - 1
        for threads in (1, 2):
            found = in_own_process(by_raylet, number, threads)
            if not found.found:
                raise RuntimeError(f"{case.name}: rays are lost")
            yield Row(case.name, "raylet", str(threads), OWN_RAYS, found.seconds, surfaces, found.megabytes, 0.0)
        reference = landings(case)
        peers: list[tuple[str, str, Callable[..., Any], Any]] = [
            ("Optiland, numpy", "all", by_optiland, "numpy"),
            ("Optiland, torch", "all", by_optiland, "torch"),
        ]
        if case.lens is singlet:
            peers.append(("NumPy, closed form", "1", by_closed_form, None))
        for program, threads, prepare, chosen in peers:
            found = in_own_process(prepare, number, chosen)
            off = max(float(np.abs(own - other).max()) for own, other in zip(reference, found.found, strict=True))
            yield Row(case.name, program, threads, PEER_RAYS, found.seconds, surfaces, found.megabytes, off)


def landings(case: Case) -> tuple[Real, Real]:
    """Where the rays of the other programs land by raylet."""
    Px, Py = pupil(case, PEER_RAYS)
    rays = to_raylet(case).trace(Px=Px, Py=Py, parts=-1)
    return rays.x[0], rays.y[0]


def by_raylet(number: int, threads: int) -> Callable[[], bool]:
    case = CASES[number]
    system = to_raylet(case)
    Px, Py = pupil(case, OWN_RAYS)
    return lambda: bool(system.trace(Px=Px, Py=Py, parts=-1, threads=threads).arrived.all())


def by_optiland(number: int, backend: str) -> Callable[[], tuple[Real, Real]]:
    case = CASES[number]
    place, along = starts(case, PEER_RAYS)
    choose(backend)
    lens = case.lens()

    def run() -> tuple[Real, Real]:
        rays = in_optiland(lens, place, along)
        return np.asarray(be.to_numpy(rays.x)), np.asarray(be.to_numpy(rays.y))

    return run


def by_closed_form(number: int, _: None) -> Callable[[], tuple[Real, Real]]:
    return partial(by_numpy, *starts(CASES[number], PEER_RAYS))


def by_numpy(place: Real, along: Real) -> tuple[Real, Real]:
    """Where the same rays land behind the singlet, by arrays and closed forms."""
    (x, y, z), (L, M, N) = place, along
    radius, thickness, back, n = 25.8, 5.3, 46.5, 1.5131
    # A sphere through the origin.
    b = x * L + y * M + (z - radius) * N
    c = x * x + y * y + (z - radius) * (z - radius) - radius * radius
    length = -b - np.sqrt(b * b - c)
    x, y, z = x + length * L, y + length * M, z + length * N
    nx, ny, nz = -x / radius, -y / radius, 1.0 - z / radius
    L, M, N = refracted((L, M, N), (nx, ny, nz), 1.0 / n)
    # A plane, then the image.
    length = (thickness - z) / N
    x, y = x + length * L, y + length * M
    L, M, N = n * L, n * M, np.sqrt(1.0 - n * n * (1.0 - N * N))
    return x + back * L / N, y + back * M / N


def refracted(d: tuple[Real, Real, Real], normal: tuple[Real, Real, Real], ratio: float) -> tuple[Real, Real, Real]:
    """Snell's law for unit vectors."""
    cosine = sum(a * b for a, b in zip(d, normal))
    gamma = np.sqrt(1.0 - ratio * ratio * (1.0 - cosine * cosine)) - ratio * cosine
    L, M, N = (ratio * a + gamma * b for a, b in zip(d, normal))
    return L, M, N
