"""Writes scenes/prescriptions/reference.json: what Optiland makes of the lens files beside it.

Optiland reads each .zmx file by itself. For each lens the numbers are its focal length, its back focal distance, the
index behind each surface, and where real rays meet the image. Needs optiland 0.6.3 and nothing of raylet:

    python benches/peers/prescriptions.py

A ray starts at a point of the plane through the vertex of the first surface; places are in the unit of the file, since
Optiland does not convert units, and directions are unit vectors.
"""

from __future__ import annotations

import json
import math
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from optiland.fileio import load_zemax_file
from optiland.rays import RealRays

FOLDER = Path(__file__).parents[2] / "scenes" / "prescriptions"

#: Parts of the radius of the entrance pupil where rays start, each with its direction cosines along x and y.
STARTS = [((0.0, 0.0), (0.0, 0.0)), ((0.0, 0.7), (0.0, 0.0)), ((0.4, -0.3), (0.0, 0.0)), ((-0.2, 0.3), (0.004, -0.007))]


def number(value: Any) -> float | None:
    """A finite number, or none."""
    found = float(np.ravel(value)[0])
    return found if math.isfinite(found) else None


def first_order(lens: Any, wave: float) -> dict[str, float | None]:
    """The focal length, and the focus behind the last surface that bends light."""
    positions = [float(np.ravel(z)[0]) for z in lens.surfaces.positions]
    indices = [float(np.ravel(n)[0]) for n in lens.n(wave)]
    bends = [
        i
        for i in range(1, len(indices) - 1)
        if math.isfinite(float(np.ravel(lens.surfaces.radii[i])[0])) or abs(indices[i] - indices[i - 1]) > 1e-12
    ]
    focus = number(lens.paraxial.F2())
    distance = None if focus is None or not bends else focus + positions[-1] - positions[bends[-1]]
    return {"focal_length": number(lens.paraxial.f2()), "back_focal_distance": distance}


def landings(lens: Any, wave: float, radius: float) -> list[dict[str, Any]]:
    """Where rays meet the image, on its own axes; none where they are lost."""
    rays = []
    for (px, py), (p, q) in STARTS:
        start, cosines = (px * radius, py * radius), (p, q, math.sqrt(1.0 - p * p - q * q))
        # A little before the first surface, which may be hollow.
        back = 0.5 * radius + 1.0
        x, y = (s - back * c / cosines[2] for s, c in zip(start, cosines))
        beam = RealRays(*([value] for value in (x, y, -back, *cosines, 1.0, wave)))
        lens.surfaces.trace(beam)
        lens.surfaces[-1].geometry.localize(beam)
        landing = [number(beam.x), number(beam.y)]
        rays.append({"start": start, "direction": cosines, "landing": None if None in landing else landing})
    return rays


def reference(path: Path) -> dict[str, Any]:
    """All numbers of one file, or why Optiland has none."""
    try:
        lens = load_zemax_file(str(path))
    except Exception as error:
        return {"refused": f"{type(error).__name__}: {error}"}
    wave = float(lens.primary_wavelength)
    found: dict[str, Any] = {"wavelength_um": wave}
    found["indices"] = [abs(float(np.ravel(n)[0])) for n in lens.n(wave)]
    try:
        found |= first_order(lens, wave)
    except Exception as error:
        found |= {"focal_length": None, "back_focal_distance": None, "without_first_order": type(error).__name__}
    try:
        radius = 0.5 * float(np.ravel(lens.paraxial.EPD())[0])
    except Exception:
        radius = 0.5 * float(lens.aperture.value)
    found["rays"] = landings(lens, wave, radius)
    return found


def main() -> None:
    files = sorted(path for path in FOLDER.iterdir() if path.suffix.lower() == ".zmx")
    document = {
        "versions": {"optiland": version("optiland"), "numpy": version("numpy"), "python": platform.python_version()},
        "lenses": {path.name: reference(path) for path in files},
    }
    (FOLDER / "reference.json").write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
