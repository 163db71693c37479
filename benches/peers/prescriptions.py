"""Writes scenes/prescriptions/reference.json: what Optiland and ray-optics make of the lens files beside it.

Optiland reads each .zmx file by itself, ray-optics each .zmx and each .seq file. For each lens the numbers are its
focal length, its back focal distance, the index behind each surface, and where real rays meet the image. Needs optiland
0.6.3, rayoptics 0.9.8 and nothing of raylet; ray-optics leaves templates (.smx) beside some files:

    python benches/peers/prescriptions.py

A ray starts at a point of the plane through the vertex of the first surface; places are in the unit of the file, since
neither converts units, and directions are unit vectors. ray-optics leaves diffractive phases out of the focal length,
and writes lengths behind a mirror with its sign.
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
from rayoptics.gui.appcmds import open_model
from rayoptics.parax.firstorder import compute_first_order
from rayoptics.raytr.raytrace import trace

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


def rayoptics_landings(model: Any, wave_nm: float, radius: float) -> list[dict[str, Any]]:
    """The same of a model of ray-optics."""
    rays, sequence = [], model["seq_model"]
    # The object is moved to a plane a little before the first surface.
    back = radius + 1.0
    sequence.gaps[0].thi = back
    model.update_model()
    for (px, py), (p, q) in STARTS:
        start, cosines = (px * radius, py * radius), (p, q, math.sqrt(1.0 - p * p - q * q))
        at = np.array([start[0] - back * p / cosines[2], start[1] - back * q / cosines[2], 0.0])
        try:
            point = trace(sequence, at, np.array(cosines), wave_nm)[0][-1][0]
            landing = [number(point[0]), number(point[1])]
        except Exception:
            landing = [None]
        rays.append({"start": start, "direction": cosines, "landing": None if None in landing else landing})
    return rays


def behind(sequence: Any, wave_nm: float) -> float:
    """The distance from the last surface that bends light to the last one, from which ray-optics counts."""
    indices = [abs(float(gap.medium.rindex(wave_nm))) for gap in sequence.gaps]
    distance, last = 0.0, len(indices) - 1
    while last > 0 and indices[last] == indices[last - 1] and sequence.ifcs[last].interact_mode != "reflect":
        last -= 1
        distance += abs(float(sequence.gaps[last].thi))
    return distance


def attempted(path: Path) -> dict[str, Any]:
    """All numbers of one file of CODE V or Zemax, or why ray-optics has none."""
    try:
        return rayoptics_reference(path)
    except Exception as error:
        return {"refused": f"{type(error).__name__}: {error}"}


def states_reference(path: Path) -> bool:
    """Whether a file of CODE V says which wavelength is the reference."""
    return any(line.split()[:1] in (["REF"], ["ref"]) for line in path.read_text().splitlines())


def rayoptics_reference(path: Path) -> dict[str, Any]:
    """All numbers of one file of CODE V or Zemax."""
    model = open_model(path)
    spectrum = model["optical_spec"]["wvls"]
    place = spectrum.reference_wvl
    if path.suffix.lower() == ".seq" and not states_reference(path):
        # The reference wavelength is the middle one then, of which ray-optics takes the first.
        place = (len(spectrum.wavelengths) - 1) // 2
    wave_nm = float(spectrum.wavelengths[place])
    spectrum.reference_wvl = place
    sequence = model["seq_model"]
    # The thickness of the image is a defocus, which ray-optics keeps beside its rays.
    sequence.gaps[-1].thi += model["optical_spec"]["focus"].focus_shift
    model.update_model()
    found: dict[str, Any] = {"wavelength_um": wave_nm / 1e3}
    found["indices"] = [abs(float(gap.medium.rindex(wave_nm))) for gap in sequence.gaps] + [1.0]
    first = compute_first_order(model, sequence.stop_surface or 1, wave_nm).fod
    # Nothing bends the light of some files, which have a focal length of zero then.
    power = abs(float(first.efl)) > 1e-9
    found["focal_length"] = abs(float(first.efl)) if power else None
    found["back_focal_distance"] = abs(float(first.bfl)) + behind(sequence, wave_nm) if power else None
    found["rays"] = rayoptics_landings(model, wave_nm, float(first.enp_radius))
    return found


def main() -> None:
    files = sorted(path for path in FOLDER.iterdir() if path.suffix.lower() == ".zmx")
    sequences = sorted(path for path in FOLDER.iterdir() if path.suffix.lower() == ".seq")
    programs = ("optiland", "rayoptics", "numpy")
    document = {
        "versions": {name: version(name) for name in programs} | {"python": platform.python_version()},
        "lenses": {path.name: reference(path) for path in files},
        "sequences": {path.name: attempted(path) for path in sequences},
        "zemax": {path.name: attempted(path) for path in files},
    }
    (FOLDER / "reference.json").write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
