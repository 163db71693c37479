"""Rates of Fourier sums over scattered points, beside those of FINUFFT."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import finufft
import numpy as np
from benches.peers.performance.machine import ROOT
from benches.peers.performance.own_process import in_own_process

POINTS = 10_000_000

#: Sums that are computed directly.
LOOKED_AT = 12

#: Modes along each axis, tolerances and threads.
MODES, TOLERANCES, THREADS = (256, 1024), (1e-3, 1e-6, 1e-9), (1, 2)

#: A row: type, modes, tolerance, threads, rate, error, memory in MB.
Sum = tuple[str, ...]


def own_sums() -> Iterator[Sum]:
    """Rates, errors and memory of raylet's sums, by its own program."""
    command = ["cargo", "build", "--release", "--quiet", "--workspace", "--example", "nufft_speed"]
    subprocess.run(command, cwd=ROOT, check=True)
    program = ROOT / "target" / "release" / "examples" / "nufft_speed"
    text = subprocess.run([program, str(POINTS)], capture_output=True, text=True, check=True).stdout
    for line in text.splitlines():
        kind, modes, tolerance, threads, points, seconds, error, megabytes = line.split()
        rate = f"{int(points) / float(seconds) / 1e6:.3g}"
        yield kind, modes, tolerance, threads, rate, f"{float(error):.0e}", megabytes


def peer_sums() -> Iterator[Sum]:
    """The same of FINUFFT, with as many random points."""
    for modes in MODES:
        for tolerance in TOLERANCES:
            for threads in THREADS:
                for kind in (1, 2):
                    found = in_own_process(of_finufft, kind, modes, tolerance, threads)
                    rate = f"{POINTS / found.seconds / 1e6:.3g}"
                    figures = (rate, f"{found.found:.0e}", f"{found.megabytes:.0f}")
                    yield str(kind), str(modes), f"{tolerance:.0e}", str(threads), *figures


def of_finufft(kind: int, modes: int, tolerance: float, threads: int) -> Callable[[], float]:
    """Sums by FINUFFT, which return their relative error."""
    rng = np.random.default_rng(5)
    u, v = rng.uniform(0.0, 2.0 * np.pi, (2, POINTS))
    order = np.arange(modes) - modes // 2
    chosen: dict[str, Any] = {"eps": tolerance, "nthreads": threads}
    if kind == 1:
        strengths = rng.uniform(-0.5, 0.5, POINTS) + 1j * rng.uniform(-0.5, 0.5, POINTS)
        looked_at = rng.integers(0, modes, (LOOKED_AT, 2))
        exact = np.array([np.sum(strengths * np.exp(1j * (order[i] * u + order[j] * v))) for i, j in looked_at])
        first = partial(finufft.nufft2d1, u, v, strengths, (modes, modes), isign=1, **chosen)
        return lambda: relative(first()[tuple(looked_at.T)], exact)
    values = rng.uniform(-0.5, 0.5, (modes, modes)) + 1j * rng.uniform(-0.5, 0.5, (modes, modes))
    wave_u, wave_v = (np.exp(-1j * np.outer(axis[:LOOKED_AT], order)) for axis in (u, v))
    over_modes = np.einsum("ni,ij,nj->n", wave_u, values, wave_v)
    second = partial(finufft.nufft2d2, u, v, values, isign=-1, **chosen)
    return lambda: relative(second()[:LOOKED_AT], over_modes)


def relative(found: Any, exact: Any) -> float:
    """The relative error of some sums."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


def rows() -> Iterator[tuple[float, str]]:
    """The ratio of both rates, and the row of the table."""
    for own, peer in zip(own_sums(), peer_sums(), strict=True):
        kind, modes, tolerance, threads, *figures = own
        if float(tolerance) != float(peer[2]) or (kind, modes, threads) != (peer[0], peer[1], peer[3]):
            raise RuntimeError(f"sums of another kind: {own}, {peer}")
        ratio = float(own[4]) / float(peer[4])
        cells = (kind, f"{modes}²", tolerance, threads, *figures, *peer[4:], f"{ratio:.2f}")
        yield ratio, "| " + " | ".join(cells) + " |"
