"""The figures that raylet aims at, beside those that were measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

#: Draws of the source paper's systems 1 and 3.
DRAWS = {"1": 1.64e9, "3": 4e9}


@dataclass(frozen=True)
class Target:
    """What is aimed at, and what was measured."""

    words: str
    aim: float
    found: float
    unit: str
    least: bool

    def markdown(self) -> str:
        reached = self.found >= self.aim if self.least else self.found <= self.aim
        unit = f" {self.unit}" if self.unit else ""
        sign = "≥" if self.least else "≤"
        figures = (f"{sign} {self.aim:g}{unit}", f"{self.found:.3g}{unit}", "yes" if reached else "no")
        return "| " + " | ".join((self.words, *figures)) + " |"


def least(words: str, aim: float, found: float, unit: str = "") -> Target:
    """A figure that is to be so large."""
    return Target(words, aim, found, unit, True)


def most(words: str, aim: float, found: float, unit: str = "") -> Target:
    """A figure that is to be so small."""
    return Target(words, aim, found, unit, False)


@dataclass(frozen=True)
class Measured:
    """What the tables of the page hold."""

    #: Rates of loops on one core, in millions each second.
    loops: dict[str, float]
    #: Rates of rays from Python by lens and threads, in millions of rays at surfaces each second.
    rays: dict[tuple[str, str], float]
    #: For each lens the ratios to the rates of Optiland and DeepLens, both with PyTorch; ratios to those of FINUFFT.
    gradients: list[tuple[float, float]]
    sums: list[float]
    #: Draws of the paper's method each second and core, in millions, and most memory of such a run in MB.
    draws: float
    #: Seconds of the passes: forward, with gradients by pixels, by numbers too.
    passes: tuple[float, float, float]
    #: Seconds of processor time of whole runs, and by the clock on one and two threads.
    processor: dict[str, float]
    threads: dict[str, tuple[float, float]]
    #: Seconds of the design of figure 5, of an import, and of a first result.
    design: float
    imported: float
    first: float


def targets(found: Measured) -> Iterator[Target]:
    """All of them."""
    rate = "million rays at surfaces/s"
    yield least("rays: sphere, plane, sensor; one core", 300, found.loops["block"], rate)
    yield least("the same with 4 × 4 Jacobians", 60, found.loops["block_jacobian"], rate)
    yield least("rays through a double Gauss lens, one core", 150, found.loops["block_double_gauss"], rate)
    yield least("1e7 rays from Python through a triplet, arrays included", 100, found.rays["Cooke triplet", "2"], rate)
    for name, aim, ratios in zip(("Optiland", "DeepLens"), (10, 20), zip(*found.gradients)):
        words = f"rays with gradients by all curvatures, beside {name} with PyTorch; least of three lenses"
        yield least(words, aim, min(ratios), "times")
    yield least("Fourier sums, beside FINUFFT; least of all rows", 1, min(found.sums), "times")
    yield least("draws of the source paper's method, one core", 20, found.draws, "million/s")
    for system, seconds in (("1", 60), ("3", 180)):
        words = f"all draws of its system {system} ({DRAWS[system]:.3g}), by that rate on two cores"
        yield most(words, seconds, DRAWS[system] / found.draws / 2e6, "s")
    yield least("values of beamlets on a raster, one core", 800, found.loops["values"], "million/s")
    yield most("hologram and lens by beamlets: plan, rays and sum", 0.3, found.processor["one thread"], "s of a core")
    yield most(
        "60 λ of random pixels, a strong lens, 64² sensor pixels", 0.25, found.processor["strong"], "s of a core"
    )
    yield most("curved mirror, 160 λ wide, without rays", 1, found.processor["mirror"], "s of a core")
    yield most("design of figure 5 of the source paper, to a correlation of 0.99", 20, found.design, "s")
    forward, by_pixels, by_numbers = found.passes
    yield most("gradients by pixels, over the way there", 1.5, by_pixels / forward - 1.0, "times")
    yield most("gradients by pixels and four numbers, over the way there", 2.5, by_numbers / forward - 1.0, "times")
    for words, (one, two) in found.threads.items():
        yield least(f"two threads beside one: {words}", 1.85, one / two, "times")
    yield most("`import raylet`", 0.15, found.imported, "s")
    yield most("first result of a new process", 0.3, found.first, "s")
