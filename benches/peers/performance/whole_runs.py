"""Whole simulations and designs of small systems, each in a process of its own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from benches.peers.performance.machine import ROOT
from benches.peers.performance.own_process import Figures, in_own_process

import raylet

PROGRAM = ROOT / "target" / "release" / "raylet"


def hologram_before_lens(threads: int | None = None) -> Callable[[], raylet.Result]:
    """System 3 of the source paper: 200² pixels of 6.3 µm, here of random phases, and a plano-convex lens."""
    system = (
        raylet.System(wavelength_um=0.7)
        .add_doe(
            raylet.pixels(pitch_um=6.3, phase=random_phases(200)),
            aperture=raylet.disc(0.63),
            thickness_mm=3.0,
            name="hologram",
        )
        .add_surface(radius_mm=25.8, thickness_mm=5.3, glass=1.5131, semi_aperture_mm=12.7)
        .add_surface(semi_aperture_mm=12.7, thickness_mm=44.7)
        .add_sensor(pixels=(200, 200), pitch_um=6.3)
    )
    return lambda: system.simulate(threads=threads)


def strong_lens() -> Callable[[], raylet.Result]:
    """Random pixels of 2 λ, 60 λ wide, before a plano-convex lens with a radius of 200 λ, 100 λ across; λ = 1 µm."""
    system = (
        raylet.System(wavelength_um=1.0)
        .add_doe(
            raylet.pixels(pitch_um=2.0, phase=random_phases(30)),
            aperture=raylet.rectangle(0.06, 0.06),
            thickness_mm=0.02,
            name="pixels",
        )
        .add_surface(radius_mm=0.2, thickness_mm=0.025, glass=1.5, semi_aperture_mm=0.05)
        .add_surface(semi_aperture_mm=1.0, thickness_mm=0.25)
        .add_sensor(pixels=(64, 64), pitch_um=0.7)
    )
    return system.simulate


def curved_mirror() -> Callable[[], raylet.Result]:
    """Random pixels of 0.5 λ on a mirror with a radius of 500 λ, 160 λ wide; λ = 1 µm."""
    system = (
        raylet.System(wavelength_um=1.0)
        .add_doe(
            raylet.pixels(pitch_um=0.5, phase=random_phases(320)),
            aperture=raylet.disc(0.08),
            radius_mm=-0.5,
            reflect=True,
            thickness_mm=-0.25,
            name="mirror",
        )
        .add_sensor(pixels=(128, 128), pitch_um=0.5)
    )
    return system.simulate


def from_scene(name: str) -> Callable[[], raylet.Result]:
    """A scene of `scenes/real_size`."""
    return raylet.load(ROOT / "scenes" / "real_size" / name).simulate


def random_phases(side: int) -> np.ndarray:
    return np.random.default_rng(7).uniform(0.0, 2.0 * np.pi, (side, side))


@dataclass(frozen=True)
class Whole:
    """A run with its figures."""

    words: str
    figures: Figures

    def markdown(self) -> str:
        result, took = self.figures.found, self.figures
        rays = sum(result.tally.values())
        seconds = (f"{took.processor_seconds:.2f} s", f"{took.seconds:.2f} s", f"{took.megabytes:.0f} MB")
        return "| " + " | ".join((self.words, *seconds, f"{rays:.2g}", f"{result.error:.1e}")) + " |"


def runs() -> dict[str, Whole]:
    """All of them by short names; two threads but for the first row."""
    all_runs: dict[str, tuple[str, Callable[..., Callable[[], raylet.Result]], tuple[object, ...]]] = {
        "one thread": ("hologram of 200² pixels, lens, 200² sensor pixels; one thread", hologram_before_lens, (1,)),
        "hologram": ("the same on two threads", hologram_before_lens, (2,)),
        "strong": ("60 λ of random pixels, a strong lens, 64² sensor pixels", strong_lens, ()),
        "mirror": ("random pixels of λ/2 on a curved mirror 160 λ wide, without rays", curved_mirror, ()),
        "modulator one": ("`slm_camera.toml` on one thread", modulator, (1,)),
        "modulator": ("the same on two threads", modulator, (2,)),
        "achromat": ("`hybrid_achromat.toml`", from_scene, ("hybrid_achromat.toml",)),
    }
    found = {}
    for name, (words, prepare, arguments) in all_runs.items():
        times = 1 if prepare is modulator else 3
        found[name] = Whole(words, in_own_process(prepare, *arguments, runs=times))
    return found


def modulator(threads: int) -> Callable[[], raylet.Result]:
    """The modulator with its camera at real size."""
    system = raylet.load(ROOT / "scenes" / "real_size" / "slm_camera.toml")
    return lambda: system.simulate(threads=threads)


#: Iterations of the design, and the correlation that they are to reach.
ITERATIONS, CORRELATION = 24, 0.99


def hologram_design() -> tuple[float, float, float, str]:
    """Seconds by the clock and of processors, memory in MB and correlation of the design `scenes/paper/fig5.toml`."""
    subprocess.run(["cargo", "build", "--release", "--quiet", "--workspace", "--bin", "raylet"], cwd=ROOT, check=True)
    with tempfile.TemporaryDirectory() as folder:
        # The phase is written beside the scene.
        for name in ("fig5.toml", "smiley.png"):
            shutil.copy(ROOT / "scenes" / "paper" / name, folder)
        begin = time.perf_counter()
        command = [PROGRAM, "design", Path(folder) / "fig5.toml", "--out", Path(folder) / "out"]
        command += ["--iterations", str(ITERATIONS)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
            printed = process.stdout.read() if process.stdout else ""
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.perf_counter() - begin
    ncc = re.search(r"NCC ([\d.]+)", printed)
    if process.returncode != 0 or not ncc or float(ncc[1]) < CORRELATION:
        raise RuntimeError(f"the design ended with {process.returncode}: {printed}")
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e3, ncc[1]


def of_import(module: str) -> float:
    """Seconds of an import in a new process, the least of several."""
    timed = f"import time; t = time.perf_counter(); import {module}; print(time.perf_counter() - t)"
    command = [sys.executable, "-c", timed]
    return min(float(subprocess.run(command, capture_output=True, text=True, check=True).stdout) for _ in range(5))


def first_result() -> float:
    """Seconds of a new process that loads and runs a lens of 20 mm at once, the least of several."""
    scene = ROOT / "scenes" / "real_size" / "hybrid_achromat.toml"
    whole = f"import raylet; raylet.load({str(scene)!r}).simulate()"
    seconds = []
    for _ in range(3):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", whole], check=True)
        seconds.append(time.perf_counter() - begin)
    return min(seconds)
