"""Rates of the loops of the library, by its own benchmarks, and how near they are to what the machine can do."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator

from benches.peers.performance.machine import ROOT

#: What the benchmark of rays counts: its names there, and the loop whose instructions are counted.
LOOPS = {
    "block": ("rays in blocks: sphere, plane, sensor; positions, cosines and paths in columns", "rays in blocks"),
    "block_asphere": ("the same with an asphere of three coefficients in place of the sphere", None),
    "block_double_gauss": ("the same through the eleven surfaces of a double Gauss lens", None),
    "system_double_gauss": ("the same as a whole system, from the pupil to places and directions in arrays", None),
    "block_jacobian": (
        "rays in blocks with their 4 × 4 Jacobians: sphere, plane, sensor",
        "rays in blocks with Jacobians",
    ),
    "block_beamlet": (
        "beamlets in blocks: amplitude and complex curvature; sphere, plane, sensor",
        "beamlets in blocks",
    ),
    "block_beamlet_asphere": ("the same with an asphere in place of the sphere", None),
    "plain": ("single rays: sphere, plane", "single rays"),
    "jacobian": ("single rays with dual numbers: sphere, plane", None),
    "beamlet": ("single beamlets: sphere, plane", None),
    "values": ("values of beamlets summed on a raster", "sum of beamlets"),
    "nufft_type1": ("points of a Fourier sum, type 1, 256² modes, 1e-6", "Fourier sum from points"),
    "nufft_type2": ("points of a Fourier sum, type 2, 256² modes, 1e-6", "Fourier sum to points"),
}


def medians(bench: str, *only: str) -> dict[str, str]:
    """The medians that a benchmark of the library prints, on one thread, as rates or times. A benchmark with several
    arguments has one name for each: its own, a stroke and the argument."""
    command = ["cargo", "bench", "--package", "raylet", "--bench", bench, "--", *only]
    environment = os.environ | {"RAYON_NUM_THREADS": "1"}
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, env=environment).stdout
    lines = printed.splitlines()
    found, above = {}, ""
    for line, rates in zip(lines, [*lines[1:], ""]):
        name = re.match(r"([│ ]*)[├╰]─ ([\w.-]+) .*?│.*?│ +([^│]+?) +│", line)
        bare = re.match(r"[│ ]*[├╰]─ (\w+) +│", line)
        if bare:
            above = bare[1]
        if name:
            counted = "item/s" in rates
            figure = rates.strip("│ ").split("│")[2].strip() if counted else name[3]
            found[name[2]] = found[f"{above}/{name[2]}"] = figure
    return found


def operations() -> dict[str, tuple[float, float, float]]:
    """For each loop its instructions, sums and products, and quotients and roots for an item, with the widest vector
    instructions of the machine."""
    command = ["cargo", "test", "--release", "--quiet", "--workspace", "--test", "instructions"]
    printed = subprocess.run(
        [*command, "--", "--operations"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    found = {}
    for line in printed.splitlines():
        cells = line.split("\t")
        if len(cells) == 5:
            # Narrower instructions come first.
            found[cells[0]] = (float(cells[2]), float(cells[3]), float(cells[4]))
    return found


def rates(speed: dict[str, str]) -> dict[str, float]:
    """The rate of each loop in millions of items each second; `speed` has the figures of the benchmark of that name."""
    of_rays = medians("rays")
    known = of_rays | {
        "values": speed["values"],
        "nufft_type1": speed["nufft_type1/0.000001"],
        "nufft_type2": speed["nufft_type2/0.000001"],
    }
    return {name: millions(known[name]) for name in LOOPS}


def millions(text: str) -> float:
    """A rate such as "3.07 Mitem/s" in millions."""
    number, unit = text.split()
    return float(number) * {"G": 1e3, "M": 1.0, "K": 1e-3}[unit[0]]


def rows(rates: dict[str, float], peak: float) -> Iterator[str]:
    """The rates, and of counted loops the share of the core's operations, whose number each second is `peak` · 1e9."""
    counted = operations()
    for name, (words, loop) in LOOPS.items():
        cells = [words, f"{rates[name]:.4g}"]
        if loop is None:
            cells += [""] * 4
        else:
            instructions, simple, quotients = counted[loop]
            each_second = rates[name] * (simple + quotients) / 1e3
            cells += [f"{instructions:.3g}", f"{simple:.3g}", f"{quotients:.2g}", f"{100 * each_second / peak:.0f} %"]
        yield "| " + " | ".join(cells) + " |"
