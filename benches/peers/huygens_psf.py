"""Writes docs/huygens_psf.md: point spread functions beside the Huygens PSF of Optiland; `make huygens-psf` runs it.

Both programs read the numbers of the same scene; indices of glasses are raylet's. Optiland sums spherical waves from
rays of equal weight on a square grid over the entrance pupil, so the edge of the pupil is a staircase: its error falls
as the grid grows.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import optiland.backend as be
import tomllib
from numpy.typing import NDArray
from optiland.materials import IdealMaterial
from optiland.optic import Optic
from optiland.psf.huygens_fresnel import ScalarHuygensPSF

import raylet

ROOT = Path(__file__).parents[2]

#: Sensor pixels along each side, and points of the pupil along a diameter.
PIXELS, GRIDS = 32, (64, 128, 256, 512)

Real = NDArray[np.float64]

HEAD = """# Point spread functions beside Optiland's

`make huygens-psf` makes this page, with Optiland {version} and NumPy. Lenses of [real size](real_size.md), bare, in
collimated light at the angles of the table. Numbers are ‖a − b‖/‖b‖ of the two intensities on {pixels} × {pixels}
pixels about the chief ray, each over its own norm. Optiland's `HuygensPSF` sums spherical waves from rays on a square
grid over the entrance pupil, 64 to 512 points across: the difference falls with that grid. Expected is the error of the
field that raylet expects of its run. Seconds are by the clock, with two threads, for Optiland with 512 points.

Optiland fills the paraxial entrance pupil, so raylet's stop has the height of Optiland's marginal ray on it. Off the
axis this is the same pupil only where the stop stands before the lens; the triplet, whose stop is inside, is compared
on the axis.

At f/2, in the phone lens, 2e-3 to 5e-3 stay. Optiland gives all rays the same weight, wherever they leave the lens;
that this is the reason is likely, but not shown. On the axis the [exact field](exact_fields.md) of this lens is 1.9e-4
from raylet's.

| lens | field | {grids} | expected | raylet | Optiland |
| --- | --- | {rule} | --- | --- | --- |
"""


@dataclass(frozen=True)
class Case:
    """A scene whose stop, or element at the stop, is replaced by a bare stop."""

    scene: str
    stop: int
    pitch_um: float
    angles_deg: tuple[float, ...]

    def elements(self) -> list[dict[str, Any]]:
        """The elements of the scene."""
        text = (ROOT / f"scenes/real_size/{self.scene}.toml").read_text(encoding="utf-8")
        rows: list[dict[str, Any]] = tomllib.loads(text)["element"]
        return rows

    def wave_um(self) -> float:
        """Its wavelength."""
        text = (ROOT / f"scenes/real_size/{self.scene}.toml").read_text(encoding="utf-8")
        return float(tomllib.loads(text)["wavelength_um"])


CASES = (
    Case("cooke_triplet", 2, 1.0, (0.0,)),
    Case("phone_lens", 0, 0.5, (0.0, 20.0, 35.0)),
    Case("telescope_doublet", 0, 1.0, (0.0, 0.5)),
)


def system(case: Case, radius_mm: float, angle_deg: float, at_mm: tuple[float, float]) -> raylet.System:
    """The lens in raylet, with a stop of this radius and the sensor about this point."""
    made = raylet.System(wavelength_um=case.wave_um()).plane_wave(angle_deg=(0.0, angle_deg))
    for number, element in enumerate(case.elements()):
        keys = dict(element)
        kind = keys.pop("kind")
        if number == case.stop:
            keys.pop("layer", None)
            made.add("stop", **{**keys, "aperture": raylet.disc(radius_mm)})
        elif kind == "lens":
            made.add_lens(*keys.pop("surface"), **keys)
        elif kind != "sensor":
            made.add(kind, **keys)
    # Optiland's points reach from edge to edge of its square.
    pitch = case.pitch_um * PIXELS / (PIXELS - 1)
    return made.add_sensor(pixels=(PIXELS, PIXELS), pitch_um=pitch, decenter_mm=at_mm)


def surfaces(case: Case) -> Iterator[dict[str, Any]]:
    """Its surfaces from the stop on and, inside a lens, those before it."""
    for number, element in enumerate(case.elements()[:-1]):
        if number == case.stop:
            yield {"thickness_mm": element["thickness_mm"], "stop": True}
        elif element["kind"] == "lens":
            for surface in element["surface"]:
                yield {"thickness_mm": element["thickness_mm"], **surface}
        elif element["kind"] == "surface":
            yield element


def optic(case: Case) -> Optic:
    """The lens in Optiland, with the indices that raylet has."""
    known = system(case, 1.0, 0.0, (0.0, 0.0)).parts
    indices = [part["index"] for part in known if part["kind"] not in ("stop", "sensor")]
    lens = Optic()
    lens.surfaces.add(index=0, thickness=be.inf)
    number, refracting = 1, 0
    for number, surface in enumerate(surfaces(case), 1):
        stop = "stop" in surface
        shape: dict[str, Any] = {"radius": surface.get("radius_mm", be.inf), "conic": surface.get("conic", 0.0)}
        if "aspheric" in surface:
            shape |= {"surface_type": "even_asphere", "coefficients": [0.0, *surface["aspheric"]]}
        index = 1.0 if stop else indices[refracting]
        refracting += not stop
        lens.surfaces.add(
            index=number, thickness=surface["thickness_mm"], material=IdealMaterial(index), is_stop=stop, **shape
        )
    lens.surfaces.add(index=number + 1)
    stops = [element["aperture"]["disc"]["radius_mm"] for element in case.elements() if "aperture" in element]
    lens.set_aperture(aperture_type="float_by_stop_size", value=2.0 * stops[1 if case.stop else 0])
    lens.fields.set_type(field_type="angle")
    for angle in sorted({0.0, max(case.angles_deg) or 1.0}):
        lens.fields.add(y=angle)
    lens.wavelengths.add(value=case.wave_um(), is_primary=True)
    return lens


def marginal_mm(lens: Optic, wave_um: float) -> float:
    """The height of the marginal ray on the stop."""
    lens.trace_generic(0, 0, 0, 1, wave_um)
    stop = next(surface for surface in lens.surfaces if surface.is_stop)
    return abs(float(np.ravel(be.to_numpy(stop.y))[0]))


def row(case: Case, angle_deg: float) -> str:
    """A row of the table."""
    lens, wave = optic(case), case.wave_um()
    field = (0.0, angle_deg / (max(case.angles_deg) or 1.0))
    found: list[tuple[Real, float]] = []
    at = (0.0, 0.0)
    for grid in GRIDS:
        start = time.perf_counter()
        psf = ScalarHuygensPSF(lens, field, wave, num_rays=grid, image_size=PIXELS, pixel_pitch=case.pitch_um * 1e-3)
        found.append((np.asarray(psf.psf), time.perf_counter() - start))
        at = (float(np.ravel(psf.cx)[0]), float(np.ravel(psf.cy)[0]))
    start = time.perf_counter()
    own = system(case, marginal_mm(lens, wave), angle_deg, at).simulate()
    seconds = time.perf_counter() - start
    apart = " | ".join(f"{distance(psf, own.intensity):.1e}" for psf, _ in found)
    name = case.scene.replace("_", " ")
    return f"| {name} | {angle_deg:g}° | {apart} | {own.error:.1e} | {seconds:.1f} s | {found[-1][1]:.1f} s |"


def distance(theirs: Real, ours: Real) -> float:
    """‖a − b‖ of two intensities, each over its own norm."""
    return float(np.linalg.norm(theirs / np.linalg.norm(theirs) - ours / np.linalg.norm(ours)))


def main() -> None:
    """Measures, and writes the page."""
    warnings.simplefilter("ignore")
    head = HEAD.format(
        version=version("optiland"),
        pixels=PIXELS,
        grids=" | ".join(f"{grid} points" for grid in GRIDS),
        rule=" | ".join("---" for _ in GRIDS),
    )
    rows = [row(case, angle) for case in CASES for angle in case.angles_deg]
    (ROOT / "docs/huygens_psf.md").write_text(head + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
