"""Processor time and memory against the work: pixels of the element and of the sensor, up to 8192²."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from benches.peers.performance.machine import ROOT
from benches.peers.performance.own_process import in_own_process

import raylet

PICTURE = ROOT / "docs" / "performance.png"

#: Pixels along each axis.
SIDES = (256, 512, 1024, 2048, 4096, 8192)


@dataclass(frozen=True)
class Point:
    """One run."""

    varied: str
    side: int
    beamlets: int
    processor_seconds: float
    megabytes: float
    error: float

    def markdown(self) -> str:
        took = (f"{self.processor_seconds:.2f} s", f"{self.megabytes:.0f} MB", f"{self.error:.1e}")
        return "| " + " | ".join((self.varied, f"{self.side}²", f"{self.beamlets:.2g}", *took)) + " |"


def before_lens(side: int, seen: int) -> Callable[[], tuple[float, int]]:
    """Random pixels of 2 µm before a plano-convex lens of f = 50 mm, `side` along each axis, and a sensor of 128 µm in
    its focus with `seen` pixels along each axis. Returns the expected error and the number of beamlets."""
    phases = np.random.default_rng(7).uniform(0.0, 2.0 * np.pi, (side, side)).astype(np.float32)
    half = 1e-3 * side
    system = (
        raylet.System(wavelength_um=0.532)
        .add_doe(
            raylet.pixels(pitch_um=2.0, phase=phases),
            aperture=raylet.rectangle(2.0 * half, 2.0 * half),
            thickness_mm=5.0,
            name="pixels",
        )
        .add_surface(radius_mm=25.8, thickness_mm=5.3, glass=1.5195, semi_aperture_mm=12.7)
        .add_surface(semi_aperture_mm=12.7, thickness_mm=45.5)
        .add_sensor(pixels=(seen, seen), pitch_um=128.0 / seen)
    )

    def run() -> tuple[float, int]:
        result = system.simulate()
        return result.error, sum(result.tally.values())

    return run


def points() -> Iterator[Point]:
    """All runs: of more and more pixels before 128² of the sensor, and of 512² before more and more of the sensor."""
    for varied, sizes in (
        ("pixels of the element", [(side, 128) for side in SIDES]),
        ("pixels of the sensor", [(512, side) for side in SIDES]),
    ):
        for side, seen in sizes:
            took = in_own_process(before_lens, side, seen, runs=1)
            error, beamlets = took.found
            changed = side if varied.endswith("element") else seen
            yield Point(varied, changed, beamlets, took.processor_seconds, took.megabytes, error)


def draw(found: list[Point]) -> None:
    """Draws processor time and memory against pixels, each with lines of slope one."""
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.0), layout="constrained")
    for varied, marker in (("pixels of the element", "o"), ("pixels of the sensor", "s")):
        these = [point for point in found if point.varied == varied]
        pixels = [point.side**2 for point in these]
        left.loglog(pixels, [point.processor_seconds for point in these], marker=marker, label=varied)
        right.loglog(pixels, [point.megabytes for point in these], marker=marker, label=varied)
    for axes, what in ((left, "processor time in s"), (right, "memory of the run in MB")):
        low, high = SIDES[0] ** 2, SIDES[-1] ** 2
        top = axes.get_ylim()[1]
        axes.loglog([low, high], [top * low / high, top], color="0.7", linestyle=":", label="as the pixels")
        axes.set_xlabel("number of pixels")
        axes.set_ylabel(what)
        axes.grid(alpha=0.3)
    left.legend()
    figure.savefig(PICTURE, dpi=110)
