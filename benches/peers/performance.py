"""Writes docs/performance.md: the speed of rays, alone and beside other ray tracers; `make performance` runs it.

Each figure is the best of several runs. Beside each stands how far its landings are from those of raylet's wheel.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import finufft
import numpy as np
import optiland.backend as be
from numpy.typing import NDArray
from optiland.materials import IdealMaterial
from optiland.optic import Optic
from optiland.rays import RealRays
from optiland.samples.objectives import CookeTriplet, DoubleGauss

import raylet
import raylet.optiland

ROOT = Path(__file__).parents[2]
WAVE_UM = 0.5876
RUNS = 3

#: Sums that are computed directly.
LOOKED_AT = 12

#: Rays of a run: of raylet, and of the others, which take longer and more memory.
OWN_RAYS, PEER_RAYS = 10_000_000, 1_000_000

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


@dataclass(frozen=True)
class Row:
    """The rate of one program with one lens."""

    lens: str
    program: str
    threads: str
    rays: int
    seconds: float
    surfaces: int
    off_mm: float

    def markdown(self) -> str:
        rate = self.rays * self.surfaces / self.seconds / 1e6
        off = "0" if self.off_mm == 0.0 else f"{self.off_mm:.0e}"
        cells = (self.lens, self.program, self.threads, f"{self.rays:.0e}", f"{self.seconds:.2f} s", f"{rate:.3g}", off)
        return "| " + " | ".join(cells) + " |"


def best(run: Callable[[], Any]) -> tuple[float, Any]:
    """The least seconds of several runs, and what the last returned."""
    seconds = []
    for _ in range(RUNS):
        begin = time.perf_counter()
        found = run()
        seconds.append(time.perf_counter() - begin)
    return min(seconds), found


def pupil(case: Case, count: int) -> Real:
    return case.pupil * np.random.default_rng(3).uniform(-0.7, 0.7, (2, count))


def rows(case: Case) -> Iterator[Row]:
    """The rates of all programs with one lens."""
    be.set_backend("numpy")
    optic = case.lens()
    system = raylet.optiland.to_system(optic, WAVE_UM, semi_aperture_mm=case.semi_aperture_mm)
    # Surfaces and the image plane; the entrance is no surface.
    surfaces = len(system.parts) - 1
    Px, Py = pupil(case, OWN_RAYS)
    for threads in (1, 2):
        seconds, rays = best(partial(system.trace, Px=Px, Py=Py, parts=-1, threads=threads))
        if not rays.arrived.all():
            raise RuntimeError(f"{case.name}: rays are lost")
        yield Row(case.name, "raylet", str(threads), OWN_RAYS, seconds, surfaces, 0.0)
    Px, Py = pupil(case, PEER_RAYS)
    start = system.trace(Px=Px, Py=Py, parts=[0, -1])
    for backend in ("numpy", "torch"):
        be.set_backend(backend)
        if backend == "torch":
            be.set_precision("float64")
        seconds, places = best(partial(by_optiland, case.lens(), start))
        yield Row(case.name, f"Optiland, {backend}", "all", PEER_RAYS, seconds, surfaces, off(start, places))
    if case.lens is singlet:
        seconds, places = best(partial(by_numpy, start))
        yield Row(case.name, "NumPy, closed form", "1", PEER_RAYS, seconds, surfaces, off(start, places))


def off(rays: raylet.Rays, places: tuple[Real, Real]) -> float:
    """The largest difference of a landing in mm."""
    return max(float(np.abs(own[1] - other).max()) for own, other in zip((rays.x, rays.y), places))


def by_optiland(lens: Optic, start: raylet.Rays) -> tuple[Real, Real]:
    """Where the same rays land in Optiland, from 10 mm before the lens."""
    place = np.stack([start.x[0], start.y[0], start.z[0]])
    along = np.stack([start.L[0], start.M[0], start.N[0]])
    place = place - 10.0 * along
    ones = be.ones(place.shape[1])
    rays = RealRays(*map(be.array, place), *map(be.array, along), ones, ones * WAVE_UM)
    lens.surfaces.trace(rays, skip=1)
    return np.asarray(be.to_numpy(rays.x)), np.asarray(be.to_numpy(rays.y))


def by_numpy(start: raylet.Rays) -> tuple[Real, Real]:
    """Where the same rays land behind the singlet, by arrays and closed forms."""
    x, y, z = start.x[0], start.y[0], start.z[0]
    L, M, N = start.L[0], start.M[0], start.N[0]
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


#: What the benchmarks of the library count, and their names there.
LOOPS = {
    "block": "rays in blocks: sphere, plane, sensor; positions, cosines and paths in columns",
    "block_asphere": "the same with an asphere of three coefficients in place of the sphere",
    "block_jacobian": "rays in blocks with their 4 × 4 Jacobians: sphere, plane, sensor",
    "block_beamlet": "beamlets in blocks: amplitude and complex curvature; sphere, plane, sensor",
    "block_beamlet_asphere": "the same with an asphere in place of the sphere",
    "plain": "single rays: sphere, plane",
    "jacobian": "single rays with dual numbers: sphere, plane",
    "beamlet": "single beamlets: sphere, plane",
}


def loops() -> Iterator[str]:
    """Rates of the loops of the library on one core, by its own benchmark."""
    found = medians("rays")
    for name, words in LOOPS.items():
        yield f"| {words} | {found[name].split()[0]} |"


def own_sums() -> Iterator[tuple[str, ...]]:
    """Rates and errors of raylet's Fourier sums, by its own program: type, modes, tolerance, threads, rate, error."""
    command = ["cargo", "run", "--release", "--quiet", "--package", "raylet", "--example", "nufft_speed", "--"]
    command.append(str(OWN_RAYS))
    text = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for line in text.splitlines():
        kind, modes, tolerance, threads, points, seconds, error = line.split()
        yield kind, modes, tolerance, threads, f"{int(points) / float(seconds) / 1e6:.3g}", f"{float(error):.0e}"


def peer_sums() -> Iterator[tuple[str, ...]]:
    """The same of FINUFFT, with as many random points."""
    rng = np.random.default_rng(5)
    u, v = rng.uniform(0.0, 2.0 * np.pi, (2, OWN_RAYS))
    strengths = rng.uniform(-0.5, 0.5, OWN_RAYS) + 1j * rng.uniform(-0.5, 0.5, OWN_RAYS)
    for modes in (256, 1024):
        values = rng.uniform(-0.5, 0.5, (modes, modes)) + 1j * rng.uniform(-0.5, 0.5, (modes, modes))
        order = np.arange(modes) - modes // 2
        looked_at = rng.integers(0, modes, (LOOKED_AT, 2))
        over_points = [np.sum(strengths * np.exp(1j * (order[i] * u + order[j] * v))) for i, j in looked_at]
        wave_u, wave_v = (np.exp(-1j * np.outer(axis[:LOOKED_AT], order)) for axis in (u, v))
        over_modes = np.einsum("ni,ij,nj->n", wave_u, values, wave_v)
        for tolerance in (1e-3, 1e-6, 1e-9):
            for threads in (1, 2):
                chosen = {"eps": tolerance, "nthreads": threads}
                first = partial(finufft.nufft2d1, u, v, strengths, (modes, modes), isign=1, **chosen)
                second = partial(finufft.nufft2d2, u, v, values, isign=-1, **chosen)
                seconds, sums = best(first)
                found = [sums[i, j] for i, j in looked_at]
                yield sum_row("1", modes, chosen, seconds, relative(found, over_points))
                seconds, sums = best(second)
                yield sum_row("2", modes, chosen, seconds, relative(sums[:LOOKED_AT], over_modes))


def sum_row(kind: str, modes: int, chosen: dict[str, Any], seconds: float, error: float) -> tuple[str, ...]:
    """Type, modes, tolerance, threads, millions of points a second and error."""
    rate = OWN_RAYS / seconds / 1e6
    return kind, str(modes), f"{chosen['eps']:.0e}", str(chosen["nthreads"]), f"{rate:.3g}", f"{error:.0e}"


def relative(found: Any, exact: Any) -> float:
    """The relative error of some sums."""
    return float(np.linalg.norm(np.subtract(found, exact)) / np.linalg.norm(exact))


def sums() -> Iterator[str]:
    """Rates of Fourier sums over scattered points, beside those of FINUFFT."""
    for (kind, modes, tolerance, threads, rate, error), peer in zip(own_sums(), peer_sums(), strict=True):
        ratio = float(rate) / float(peer[4])
        cells = (kind, f"{modes}²", tolerance, threads, rate, error, peer[4], peer[5], f"{ratio:.2f}")
        yield "| " + " | ".join(cells) + " |"


def medians(bench: str, *only: str) -> dict[str, str]:
    """The medians that a benchmark of the library prints, on one thread, as rates or times."""
    command = ["cargo", "bench", "--package", "raylet", "--bench", bench, "--", *only]
    environment = os.environ | {"RAYON_NUM_THREADS": "1"}
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, env=environment).stdout
    lines = printed.splitlines()
    found = {}
    for line, rates in zip(lines, [*lines[1:], ""]):
        name = re.match(r"[│ ]*[├╰]─ (\w+) .*?│.*?│ +([^│]+?) +│", line)
        if name:
            counted = "item/s" in rates
            found[name[1]] = rates.strip("│ ").split("│")[2].strip() if counted else name[2]
    return found


def first_result() -> tuple[float, float]:
    """Seconds of `import raylet` in a new process, and of a process that loads and runs the demo's lens at once."""
    imported = "import time; t = time.perf_counter(); import raylet; print(time.perf_counter() - t)"
    whole = f"import raylet; raylet.load({str(ROOT / 'scenes' / 'real_size' / 'hybrid_achromat.toml')!r}).simulate()"
    of_import, of_run = [], []
    for _ in range(RUNS):
        printed = subprocess.run([sys.executable, "-c", imported], capture_output=True, text=True, check=True).stdout
        of_import.append(float(printed))
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", whole], check=True)
        of_run.append(time.perf_counter() - begin)
    return min(of_import), min(of_run)


HEAD = """\
# Performance

`make performance` makes this page on the machine at hand: {machine}, {cores} processors, raylet {raylet}.
Rates are in millions of rays at surfaces each second; the image plane counts as a surface, the place where rays start
does not. All numbers are of double precision.

## Rays from Python, beside other ray tracers

Rays fill a part of the pupil at random and all arrive. The time of raylet has all that `System.trace(…, parts=-1)`
does, arrays included; that of Optiland {optiland} (NumPy {numpy}, PyTorch {torch}) its trace of rays that are there.
"Off" is the largest difference of a landing from that of raylet, in mm. The row of NumPy is the formulas of a sphere
and a plane in arrays, without edges and lost rays (`benches/peers/performance.py`). By the rates of the loops below,
rays take an eighth of raylet's time with the singlet on one thread; the rest is arrays and their memory.

| lens | program | threads | rays | time | rate | off in mm |
| --- | --- | --- | --- | --- | --- | --- |
"""

LOOP_HEAD = """
## The loops of the library, on one core

`cargo bench -p raylet --bench rays`, medians. Blocks hold 128 rays in columns, eight in each vector of the processor.
They have the same bits with any vector instructions and beside any other rays. Their landings are those of single rays
to 1e-11 mm, their Jacobians and beamlets to 1e-10 and 1e-8 (`crates/raylet/src/engine/ray_block/hop_rays_test.rs`).

| loop | rate |
| --- | --- |
"""


SUM_HEAD = """
## Fourier sums over scattered points, beside FINUFFT

`cargo run --release -p raylet --example nufft_speed` and FINUFFT {finufft}, 1e7 random points in double precision, the
best of three runs: type 1 from points to modes, type 2 from modes to points. Rates are in millions of points each
second, plans of FINUFFT included. Errors are those of twelve modes or points, against direct sums.

| type | modes | tolerance | threads | raylet | error | FINUFFT | error | ratio |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
"""

OTHER_HEAD = """
## Sums, gradients and the start

`cargo bench -p raylet --bench speed`, medians on one thread. The hologram has 200² pixels before a catalogue lens and
256² pixels on the sensor; the numbers are a curvature, a conic constant, an index and the place of the sensor.

| what | figure |
| --- | --- |
"""


TAIL = """

Changes of the loops are noticed without a clock: a test counts their instructions, with each kind of vector
instructions of the machine, and compares the counts with those that are stored
(`crates/raylet/benches/instructions`, `make instruction-counts`).

Times, memory and errors of whole systems are in [Systems at their real size](real_size.md); how they grow with the
aperture is a plot in [Cost and error against the aperture](aperture_scaling.md).
"""


def others() -> Iterator[str]:
    """Figures that have no table of their own."""
    found = medians("speed", "beamlets", "gradients", "paper")
    yield f"| values of beamlets summed on a raster | {found['values']} |"
    yield f"| the light of a hologram through a lens, once planned | {found['forward']} |"
    yield f"| the same with gradients by all pixels | {found['0']} |"
    yield f"| the same with gradients by all pixels and four numbers | {found['4']} |"
    yield f"| draws of the source paper's method, with all that belongs to them | {found['whole']} |"
    of_import, of_run = first_result()
    yield f"| `import raylet` in a new process | {of_import:.2f} s |"
    yield f"| a new process that simulates `hybrid_achromat.toml` (20 mm, f/4) | {of_run:.2f} s |"


def page() -> str:
    """The whole page."""
    versions = {name: version(name) for name in ("raylet", "optiland", "numpy", "torch", "finufft")}
    processor = Path("/proc/cpuinfo").read_text()
    model = re.search(r"model name\s*: (.*)", processor)
    machine = model[1] if model else platform.processor()
    machine += " with " + next((name for name in ("avx512_vnni", "avx2") if f" {name} " in processor), "sse2")
    head = HEAD.format(machine=machine, cores=len(os.sched_getaffinity(0)), **versions)
    table = [row.markdown() for case in CASES for row in rows(case)]
    parts = [head + "\n".join(table), LOOP_HEAD + "\n".join(loops())]
    parts.append(SUM_HEAD.format(**versions) + "\n".join(sums()))
    parts.append(OTHER_HEAD + "\n".join(others()))
    return "\n".join(parts) + TAIL


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "performance.md")
    parser.parse_args().out.write_text(page())


if __name__ == "__main__":
    main()
