"""Systems of the guide's gallery beside their closed forms: the pages' own snippets are run, and what they find is
compared here. A tolerance is the measured difference, rounded up."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

FENCED = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
GUIDE = ROOT / "docs" / "guide"

pytestmark = pytest.mark.filterwarnings("ignore:.*the pixels sum to:UserWarning")


def run(page: str, *headings: str) -> dict[str, Any]:
    """The names that a page defines before its first heading and under some of its headings."""
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("Agg")
    path, names = GUIDE / f"{page}.md", {"__name__": "guide"}
    text = path.read_text(encoding="utf-8")
    sections = re.split(r"^(?=## )", text, flags=re.MULTILINE)
    found = [next(part for part in sections if part.startswith(f"## {heading}\n")) for heading in headings]
    for section in [sections[0], *found]:
        line = text[: text.index(section)].count("\n")
        for code in FENCED.finditer(section):
            above = line + section[: code.start(1)].count("\n")
            exec(compile("\n" * above + code.group(1), str(path), "exec"), names)
    plt.close("all")
    return names


def test_all_sections_of_tested_pages_are_run_here() -> None:
    """Of pages that the site of continuous integration does not run again."""
    tested = re.search(r"^TESTED_PAGES = (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert tested
    source = (ROOT / "python" / "tests" / "test_gallery.py").read_text()
    for page in tested.group(1).split():
        for heading in re.findall(r"^## (.*)$", (GUIDE / f"{page}.md").read_text(), re.MULTILINE):
            assert f'run("{page}", "{heading}")' in source, heading


def test_lines_of_a_spectrometer_stand_where_the_grating_equation_sends_them() -> None:
    found = run("gallery_gratings", "A spectrometer")
    places = np.array(found["places"])
    # The lens distorts by 16 µm at its edge; a ray through it has this.
    assert abs(places[:, 0] - places[:, 1]).max() < 1.5e-4
    assert abs(places[:, 0] - places[:, 2]).max() < 0.017
    # Rayleigh's criterion for 6000 lines: the peak of one line on the first zero of the other.
    assert abs(found["apart"] - found["zero"]) < 1e-3
    assert found["rest"] < 0.006


def test_orders_of_a_modulator_have_the_shares_of_its_staircase_and_its_gaps() -> None:
    found = run("gallery_gratings", "A modulator with a blazed grating")
    orders = np.array(found["orders"])
    assert abs(orders[:, 0] - orders[:, 1]).max() < 1.1e-3
    assert abs(orders[:, 2] - orders[:, 3]).max() < 1e-3

    # The sensor sees 98 % of each order of the lattice: so much of it is in the middle of its spot, as above.
    shares = np.array(found["lattice"])
    assert abs(shares[:, 0] / shares[:, 1] - 0.98).max() < 0.015


def test_a_zone_plate_of_two_levels_has_its_share_in_the_focus() -> None:
    found = run("gallery", "A binary zone plate")
    assert abs(found["peak"] - 4.0 / np.pi**2) < 0.02


def test_a_dammann_grating_makes_seven_beams_of_the_published_power() -> None:
    found = run("gallery_gratings", "A Dammann grating")
    shares = np.array(found["shares"])
    assert abs(shares[:, 0] - shares[:, 1]).max() < 6e-5
    seven = shares[0] + 2.0 * shares[1:4].sum(axis=0)
    assert abs(seven[0] - seven[1]) < 3e-4
    assert abs(seven[2] - 0.786) < 3e-4
    assert np.ptp(shares[:4, 2]) < 1.1e-5


def test_a_gaussian_beam_becomes_flat() -> None:
    found = run("gallery_beams", "A Gaussian beam made flat")
    assert abs(found["mean"] / found["level"] - 1.0) < 2e-3
    assert found["off"] < 9.5e-3
    assert found["spread"] < 0.013


def test_an_axicon_makes_a_bessel_beam() -> None:
    found = run("gallery_beams", "An axicon")
    closed = found["on_axis"](found["far"])
    assert abs(found["middles"] / closed - 1.0).max() < 5e-3
    assert abs(found["dark"] / found["zero"] - 1.0) < 4e-3
    across = found["across"] / found["across"].max()
    assert np.linalg.norm(across - found["closed"]) < 5e-3 * np.linalg.norm(across)


def test_a_vortex_has_the_ring_of_the_closed_form() -> None:
    found = run("gallery_beams", "A vortex in a focus")
    assert abs(found["found"] / found["radius"] - 1.0) < 9e-4
    assert found["unlike"] < 8e-4
    assert found["row"][0] < 1e-12 * found["row"].max()


def test_a_hybrid_achromat_is_as_huygens_and_a_paraxial_trace_have_it() -> None:
    found = run("gallery_imaging", "A hybrid achromat at 0° and 10°")
    foci = np.array(found["foci"])
    assert abs(foci[:, 0] - foci[:, 1]).max() < 2e-6
    assert abs(foci[1, 1] - found["rear"]) < 1e-6
    assert abs(foci[2, 1] - foci[0, 1]) < 0.032 and abs(foci[2, 2] - foci[0, 2]) > 0.31
    assert len(found["errors"]) == 6
    assert max(found["errors"]) < 7e-4
    assert all(row["target_reached"] for sweep in (found["axis"], found["aside"]) for row in sweep.table)
    assert abs(found["kept"] - found["first"]) < 2e-3


def test_a_cubic_mask_keeps_the_contrast_of_a_phone_lens() -> None:
    found = run("gallery_imaging", "A phone lens with a cubic mask")
    by_rays = [rays for rays, _ in found["worst"].values()]
    assert max(by_rays) < 7e-3
    assert max(ideal for (alpha, _), (_, ideal) in found["worst"].items() if alpha) < 0.014
    assert found["worst"][0.0, 0.0][1] < 0.017


def test_a_combiner_shows_the_eye_what_was_recorded() -> None:
    found = run("gallery_imaging", "A holographic combiner")
    # The rim's light turns the phase of single pixels, and not that of blocks of them.
    for phase in (found["flat"], found["error"]):
        assert phase.std() < 5e-3
        assert abs(phase.reshape(12, 8, 12, 8).mean((1, 3))).max() < 3e-3
    assert abs(found["image"] - found["grating"]) < 1e-4
