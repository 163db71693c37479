"""Pictures of layouts and results."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import pytest

import raylet

plt = pytest.importorskip("matplotlib.pyplot")


@pytest.fixture(autouse=True)
def _no_window() -> None:
    plt.switch_backend("Agg")


@pytest.mark.parametrize("name", ["phone_lens", "cooke_triplet", "slm_camera", "cassegrain"])
def test_names_in_a_layout_stand_apart_and_inside(scenes: Path, name: str) -> None:
    figure, ax = raylet.load(scenes / "real_size" / f"{name}.toml").draw()
    figure.canvas.draw()
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) > 2
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    frame = ax.get_window_extent()
    assert all(frame.y0 < box.y0 and box.y1 < frame.y1 for box in boxes)
    plt.close(figure)


def test_neighbours_of_one_name_share_it(scenes: Path) -> None:
    figure, ax = raylet.load(scenes / "real_size" / "phone_lens.toml").draw()
    assert [text.get_text() for text in ax.texts] == ["stop", "10 × asphere", "sensor"]
    plt.close(figure)


@pytest.mark.parametrize(("pixels", "label"), [((24, 1), "x in mm"), ((1, 24), "y in mm")])
def test_one_row_of_pixels_is_drawn_as_a_curve(pixels: tuple[int, int], label: str) -> None:
    system = raylet.System(wavelength_um=0.5, title="A slit")
    system.add_stop(raylet.rectangle(0.05, 0.05), thickness_mm=5.0)
    result = system.add_sensor(pixels=pixels, pitch_um=5.0).simulate()
    axis = result.x_mm if pixels[1] == 1 else result.y_mm
    for what, values in (("intensity", result.intensity), ("phase", result.phase)):
        figure, ax = result.plot(what)
        (line,) = ax.lines
        assert line.get_xdata().tolist() == axis.tolist()
        drawn, expected = line.get_ydata(), values.ravel()
        lit = result.intensity.ravel() > 1e-3 * result.intensity.max()
        assert drawn[lit].tolist() == expected[lit].tolist()
        assert (ax.get_xlabel(), ax.get_title(), bool(ax.images)) == (label, "A slit", False)
        plt.close(figure)
