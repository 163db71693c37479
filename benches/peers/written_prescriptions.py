"""Compares lens files that raylet writes with those that it read: how far Optiland and ray-optics see them apart.

`raylet export` writes each lens file of scenes/prescriptions as .zmx and .seq. Optiland and ray-optics read both. Rays
start parallel to the axis and are followed to the image. Needs optiland 0.6.3, rayoptics 0.9.8, and the program raylet:

    python benches/peers/written_prescriptions.py target/release/raylet

Lines begin with the largest difference of landings over the radius of the pupil, then that of the focal lengths.
"""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from optiland.fileio import load_zemax_file
from optiland.rays import RealRays
from rayoptics.gui.appcmds import open_model
from rayoptics.parax.firstorder import compute_first_order
from rayoptics.raytr.raytrace import trace

FOLDER = Path(__file__).parents[2] / "scenes" / "prescriptions"

#: Parts of the radius of the entrance pupil where rays start.
STARTS = [(0.0, 0.0), (0.0, 0.7), (0.4, -0.3), (-0.2, 0.3)]

#: Focal length and landings, for a radius in mm at which rays start.
Numbers = tuple[float, list[tuple[float, float]]]


def of_optiland(path: Path, radius: float, unit: float, wave: float) -> Numbers:
    """The numbers of Optiland at a wavelength in µm; it does not convert units."""
    lens = load_zemax_file(str(path))
    back, landings = (0.5 * radius + 1.0) / unit, []
    for px, py in STARTS:
        values = (px * radius / unit, py * radius / unit, -back, 0.0, 0.0, 1.0, 1.0, wave)
        beam = RealRays(*([value] for value in values))
        lens.surfaces.trace(beam)
        lens.surfaces[-1].geometry.localize(beam)
        landings.append((float(np.ravel(beam.x)[0]) * unit, float(np.ravel(beam.y)[0]) * unit))
    try:
        focal_length = abs(float(np.ravel(lens.paraxial.f2())[0])) * unit
    except Exception:
        focal_length = math.nan
    return focal_length, landings


def of_rayoptics(path: Path, radius: float, unit: float, wave: float) -> Numbers:
    """The numbers of ray-optics, which does not convert units either."""
    model = open_model(path)
    spectrum, sequence = model["optical_spec"]["wvls"], model["seq_model"]
    wave_nm = 1e3 * wave
    spectrum.reference_wvl = min(
        range(len(spectrum.wavelengths)), key=lambda place: abs(spectrum.wavelengths[place] - wave_nm)
    )
    sequence.gaps[-1].thi += model["optical_spec"]["focus"].focus_shift
    model.update_model()
    focal_length = abs(float(compute_first_order(model, sequence.stop_surface or 1, wave_nm).fod.efl))
    sequence.gaps[0].thi = (radius + 1.0) / unit
    model.update_model()
    landings = []
    for px, py in STARTS:
        at = np.array([px * radius / unit, py * radius / unit, 0.0])
        point = trace(sequence, at, np.array([0.0, 0.0, 1.0]), wave_nm)[0][-1][0]
        landings.append((float(point[0]) * unit, float(point[1]) * unit))
    return focal_length * unit, landings


def compared(read: Callable[..., Numbers], first: Path, second: Path, unit: float, radius: float, wave: float) -> str:
    """How far the numbers of two files differ, or why one has none."""
    numbers = []
    for path, scale in ((first, unit), (second, 1.0)):
        try:
            numbers.append(read(path, radius, scale, wave))
        except Exception as error:
            return f"{path.suffix} refused: {type(error).__name__}"
    (f, there), (g, here) = numbers
    apart = max(math.dist(a, b) for a, b in zip(there, here)) / radius
    lengths = abs(f - g) / abs(f) if abs(f) > 1e-9 and math.isfinite(f) else 0.0
    return f"{apart:.1e} {lengths:.1e}"


def main() -> None:
    program = sys.argv[1]
    peers: list[tuple[str, Callable[..., Any], tuple[str, ...]]] = [
        ("Optiland", of_optiland, (".zmx",)),
        ("ray-optics", of_rayoptics, (".zmx", ".seq")),
    ]
    with tempfile.TemporaryDirectory() as room:
        for path in sorted(FOLDER.iterdir()):
            end = path.suffix.lower()
            if end not in (".zmx", ".seq"):
                continue
            target = Path(room) / f"a{end}"
            command = [program, "export", str(path), "-o", str(target), "--overwrite"]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                print(f"{path.name}: {done.stderr.splitlines()[0]}")
                continue
            told = done.stdout.splitlines()
            width = [line.split()[-1] for line in told if "entrance pupil diameter" in line]
            wave = [line.split()[3].rstrip(",") for line in told if line.startswith("Its wavelengths are")]
            text = path.read_bytes().replace(b"\x00", b"").decode("latin-1")
            unit = 25.4 if "UNIT IN " in text or "DIM   I" in text else 1.0
            for name, read, ends in peers:
                if end in ends:
                    answer = compared(read, path, target, unit, 0.5 * float(width[0]), float(wave[0]))
                    print(f"{path.name}: {name} {answer}", flush=True)


if __name__ == "__main__":
    main()
