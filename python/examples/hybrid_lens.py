"""A hybrid lens of a catalogue from its CODE V file: foci and Strehl ratios of three colours, the halo of its kinoform.

    python python/examples/hybrid_lens.py [--out docs/hybrid_lens.md]

Edmund Optics 65-988 has a kinoform on its curved front. The file gives the phase of the first order. Here it is also
the sawtooth that one makes of it, with the orders 0 and 2: at other wavelengths than its own it sends light into them.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import tomllib
from numpy.typing import NDArray

import raylet

ROOT = Path(__file__).parents[2]
LENS = ROOT / "scenes" / "prescriptions" / "CODV_65988.seq"

#: Fraunhofer's lines in µm.
LINES = {"F": 0.4861327, "d": 0.5875618, "C": 0.6562725}
DESIGN_UM = LINES["d"]

#: Distances of the sensor from the paraxial focus in mm.
SCAN = np.linspace(-0.018, 0.018, 25)

Real = NDArray[np.float64]


def lens(orders: list[int] | None, pixels: int, pitch_um: float) -> raylet.System:
    """The lens of the file with another sensor, its phase as it is or as the sawtooth that has these orders."""
    document = tomllib.loads(raylet.load(str(LENS)).to_toml())
    system = raylet.System(list(LINES.values()), title=document["title"]).plane_wave()
    for element in document["element"]:
        kind = element.pop("kind")
        if kind == "sensor":
            element |= {"pixels": [pixels, pixels], "pitch_um": pitch_um}
        if "layer" in element and orders is not None:
            layers = [raylet.kinoform(element["layer"], orders=orders, wavelength_um=DESIGN_UM, glass=element["glass"])]
            element["layer"] = layers
        system.add(kind, **element)
    return system


def surfaces() -> dict[str, Any]:
    """The numbers of the lens that a paraxial trace needs, as they are in the file."""
    return {"front": 9.93, "back": -48.3, "thickness": 3.7, "power": 2.0 * 0.001807322521767816 / DESIGN_UM}


def index(um: float) -> float:
    """The index between those of the table in the file, by a parabola in 1/λ² through the nearest three."""
    waves = np.array([0.65, 0.6, 0.5876, 0.5461, 0.4861, 0.48])
    indices = np.array([1.5286, 1.5306, 1.53116, 1.5334, 1.5378, 1.5384])
    near = np.argsort(np.abs(waves - um))[:3]
    return float(np.polyval(np.polyfit(waves[near] ** -2, indices[near], 2), um**-2))


def paraxial_focus(um: float, with_kinoform: bool) -> float:
    """Distance of the focus from the back in mm, by a ray that comes at height 1."""
    given, n = surfaces(), index(um)
    power = (n - 1.0) / given["front"] + with_kinoform * given["power"] * um
    slope = -power / n
    height = 1.0 + given["thickness"] * slope
    slope = n * slope + height * (n - 1.0) / given["back"]
    return -height / slope


def best_focus(um: float) -> tuple[Real, Real, float, float]:
    """Distances, the intensities on the axis there, and the distance and height of the highest point."""
    distances = paraxial_focus(um, True) + SCAN
    sweep = lens(None, 9, 0.1).simulate(wavelengths=[um], distances=list(distances))
    heights = np.array([result.intensity.max() for result in np.ravel(sweep.results)])
    top = int(np.clip(heights.argmax(), 1, len(heights) - 2))
    curve = np.polyfit(SCAN[top - 1 : top + 2], heights[top - 1 : top + 2], 2)
    place = -0.5 * curve[1] / curve[0]
    return distances, heights, float(distances[0] - SCAN[0] + place), float(np.polyval(curve, place))


def radial_mean(result: raylet.Result, rings: Real) -> Real:
    """The mean intensity of the pixels in each ring."""
    x, y = np.meshgrid(result.x_mm, result.y_mm)
    place = np.digitize(np.hypot(x, y), rings)
    return np.array([result.intensity[place == n].mean() for n in range(1, len(rings))])


def page(out: Path) -> None:
    """Runs all, and writes the page and its picture."""
    figure, (through, across) = plt.subplots(1, 2, figsize=(11.0, 4.2), layout="constrained")
    file_focus = float(tomllib.loads(raylet.load(str(LENS)).to_toml())["element"][1]["thickness_mm"])
    reference = best_focus(DESIGN_UM)[3] * DESIGN_UM**2
    rings = np.linspace(0.0, 0.5, 61)
    rows = []
    for name, um in LINES.items():
        distances, heights, focus, height = best_focus(um)
        strehl = height * um**2 / reference
        through.plot(1e3 * (distances - file_focus), heights * um**2 / reference, label=f"{name}, {um:.4f} µm")
        core, smooth = (lens(orders, 97, 0.25).simulate(wavelengths=[um]).results[0] for orders in ([0, 1, 2], None))
        wide = lens([0, 1, 2], 251, 4.0).simulate(wavelengths=[um]).results[0]
        profile = radial_mean(wide, rings) * um**2 / reference
        across.semilogy(1e3 * 0.5 * (rings[1:] + rings[:-1]), profile, label=f"{name}, orders 0, 1 and 2")
        alone = lens(None, 251, 4.0).simulate(wavelengths=[um]).results[0]
        profile = radial_mean(alone, rings) * um**2 / reference
        across.semilogy(1e3 * 0.5 * (rings[1:] + rings[:-1]), profile, ":", color=across.lines[-1].get_color())
        at_file = smooth.intensity.max() * um**2 / reference
        depth = DESIGN_UM / um * (index(um) - 1.0) / (index(DESIGN_UM) - 1.0)
        cells = [
            f"{name}, {um:.4f} µm",
            f"{paraxial_focus(um, False):.4f}",
            f"{paraxial_focus(um, True):.4f}",
            f"{focus:.4f}",
            f"{strehl:.2f}",
            f"{at_file:.3f}",
            f"{np.sinc(1.0 - depth) ** 2:.1%}",
            f"{core.power_share[0]:.1%}",
            f"{smooth.power_share[0]:.1%}",
            f"{core.error:.1e}",
        ]
        rows.append("| " + " | ".join(cells) + " |")
    through.set(xlabel="distance from the focus of the file (µm)", ylabel="intensity on the axis × λ², over that of d")
    through.set_title("Through focus, first order")
    across.set(xlabel="radius (µm)", ylabel="mean intensity × λ², over the peak of d")
    across.set_title("Halo in the plane of the file (dotted: first order alone)")
    through.legend()
    across.legend()
    figure.savefig(out.with_suffix(".png"), dpi=110)
    out.write_text(HEAD + "\n".join(rows) + TAIL)


HEAD = """\
# A hybrid lens of a catalogue

`python python/examples/hybrid_lens.py` makes this page. Edmund Optics 65-988 is a plastic asphere of f = 15 mm and
12 mm width with a kinoform on its curved front. Its CODE V file is `scenes/prescriptions/CODV_65988.seq`, which
`raylet.load` reads. It is run at its full size with collimated light on the axis.

The file has the phase of the first order. The sawtooth that makes it has one height for all wavelengths: at wavelengths
beside its own it sends light into the orders 0 and 2.

| column | meaning |
| --- | --- |
| lens alone | paraxial focus without the kinoform in mm behind the last vertex, with indices by the file's table |
| paraxial | the same with the kinoform's first order |
| focus | where the intensity on the axis is largest |
| peak | intensity there times λ², over that of d: the Strehl ratio, if d is perfect |
| in the file's plane | the same at 12.946 mm |
| first order | share of the light that the sawtooth sends into it, sinc²(1 − α) |
| sawtooth | share of the light behind the front within 12 µm of the axis along x and y, in the file's plane |
| phase | the same of the phase of the file |
| error | expected error of the field of the sawtooth |

| line | lens alone | paraxial | focus | peak | in the file's plane | first order | sawtooth | phase | error |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
"""

TAIL = """

The light of order 0 comes to the focus of the lens alone. By paraxial rays its halo has a radius of 6 mm times the
distance of the two foci over the focal length: 0.26 mm for F and 0.35 mm for C. The rim of this fast lens makes it
wider.

![Intensity through focus and across the halo](hybrid_lens.png)
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "hybrid_lens.md")
    page(parser.parse_args().out)


if __name__ == "__main__":
    main()
