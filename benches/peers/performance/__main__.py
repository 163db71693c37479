"""Writes docs/performance.md and its picture; `make performance` runs it.

Each figure is the best of several runs. Beside each stands its error, or how far it is from that of raylet's wheel.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

from benches.peers.performance import fourier_sums, growth, library, machine, ray_gradients, ray_rates, whole_runs
from benches.peers.performance.targets import Measured, targets
from benches.peers.performance.words import (
    BOUNDS,
    GRADIENT_HEAD,
    GROWTH_HEAD,
    HEAD,
    LOOP_HEAD,
    OTHER_HEAD,
    RAY_HEAD,
    SUM_HEAD,
    TAIL,
    WHOLE_HEAD,
)

T = TypeVar("T")


def seconds(text: str) -> float:
    """A time such as "867.3 ms" in seconds."""
    number, unit = text.split()
    return float(number) * {"s": 1.0, "ms": 1e-3, "µs": 1e-6}[unit]


def step(name: str, run: Callable[[], T]) -> T:
    """What a part of the work returns; says on the terminal how long it took."""
    begin = time.perf_counter()
    found = run()
    print(f"{name}: {time.perf_counter() - begin:.0f} s", file=sys.stderr, flush=True)
    return found


def page() -> str:
    """The whole page."""
    versions = {name: version(name) for name in ("raylet", "optiland", "deeplens-core", "numpy", "torch", "finufft")}
    peak, bandwidth = machine.limits()
    rays = step("rays", lambda: list(ray_rates.rows()))
    gradients = step("gradients of rays", lambda: list(ray_gradients.rows()))
    speed = step("sums and gradients", lambda: library.medians("speed", "beamlets", "gradients", "paper", "nufft"))
    loops = step("loops of rays", lambda: library.rates(speed))
    loop_rows = step("instructions", lambda: list(library.rows(loops, peak)))
    sums = step("Fourier sums", lambda: list(fourier_sums.rows()))
    runs = step("whole runs", whole_runs.runs)
    design = step("design", whole_runs.hologram_design)
    grown = step("cost against work", lambda: list(growth.points()))
    growth.draw(grown)
    by_clock = {name: run.figures.seconds for name, run in runs.items()}
    draws = library.millions(speed["whole"])
    found = Measured(
        loops=loops,
        rays={(row.lens, row.threads): row.rate for row in rays if row.program == "raylet"},
        gradients=[ratios for ratios, _ in gradients],
        sums=[ratio for ratio, _ in sums],
        draws=draws,
        passes=(
            seconds(speed["forward"]),
            seconds(speed["forward_and_adjoint/0"]),
            seconds(speed["forward_and_adjoint/4"]),
        ),
        processor={name: run.figures.processor_seconds for name, run in runs.items()},
        threads={
            "the hologram and lens": (by_clock["one thread"], by_clock["hologram"]),
            "the modulator and camera": (by_clock["modulator one"], by_clock["modulator"]),
        },
        design=design[0],
        imported=whole_runs.of_import("raylet"),
        first=whole_runs.first_result(),
    )
    parts = [
        HEAD.format(machine=machine.name(), cores=machine.cores(), peak=peak, bandwidth=bandwidth, **versions),
        *(target.markdown() for target in targets(found)),
        RAY_HEAD.format(**versions).rstrip(),
        *(row.markdown() for row in rays),
        GRADIENT_HEAD.format(rays=ray_gradients.RAYS, **versions).rstrip(),
        *(row for _, row in gradients),
        LOOP_HEAD.rstrip(),
        *loop_rows,
        BOUNDS.format(draws=draws).rstrip(),
        SUM_HEAD.format(**versions).rstrip(),
        *(row for _, row in sums),
        WHOLE_HEAD.rstrip(),
        *(run.markdown() for run in runs.values()),
        OTHER_HEAD.rstrip(),
        *others(speed, design, found),
        GROWTH_HEAD.rstrip(),
        *(point.markdown() for point in grown),
    ]
    parts[0] = parts[0].rstrip()
    return "\n".join(parts) + "\n" + TAIL


def others(speed: dict[str, str], design: tuple[float, float, float, str], found: Measured) -> list[str]:
    """Figures that have no table of their own."""
    by_clock, processor, megabytes, ncc = design
    figures = {
        "the light of a hologram through a lens, once planned": speed["forward"],
        "the same with gradients by all pixels": speed["forward_and_adjoint/0"],
        "the same with gradients by all pixels and four numbers": speed["forward_and_adjoint/4"],
        "draws of the source paper's method, with all that belongs to them": speed["whole"],
        f"design of `scenes/paper/fig5.toml`, to a correlation of {ncc}": (
            f"{by_clock:.1f} s, {processor:.1f} s of processors, {megabytes:.0f} MB"
        ),
        "`import raylet` in a new process": f"{found.imported:.2f} s",
        "`import numpy` alone, which it needs": f"{whole_runs.of_import('numpy'):.2f} s",
        "a new process that simulates `hybrid_achromat.toml` (20 mm, f/4)": f"{found.first:.2f} s",
    }
    return [f"| {what} | {figure} |" for what, figure in figures.items()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=machine.ROOT / "docs" / "performance.md")
    parser.parse_args().out.write_text(page())


if __name__ == "__main__":
    main()
