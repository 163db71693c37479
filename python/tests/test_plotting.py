"""Pictures of layouts and results."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import raylet

matplotlib = pytest.importorskip("matplotlib")
plt = pytest.importorskip("matplotlib.pyplot")


@pytest.fixture(autouse=True)
def _no_window() -> None:
    plt.switch_backend("Agg")


@pytest.mark.parametrize("name", ["phone_lens", "cooke_triplet", "slm_camera", "cassegrain"])
def test_names_in_a_layout_stand_apart_and_inside(scenes: Path, name: str) -> None:
    figure, ax = raylet.load(scenes / "real_size" / f"{name}.toml").draw()
    figure.canvas.draw()
    # Of the words alone, without the lines that lead to them.
    boxes = [matplotlib.text.Text.get_window_extent(text) for text in ax.texts]
    assert len(boxes) > 2
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    frame = ax.get_window_extent()
    assert all(frame.y0 < box.y0 and box.y1 < frame.y1 for box in boxes)

    # None lies on glass.
    glass = [patch.get_transform().transform_path(patch.get_path()) for patch in ax.patches]
    assert not any(path.intersects_bbox(box, filled=True) for path in glass for box in boxes)
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


def test_the_rays_of_all_fields_are_drawn(scenes: Path) -> None:
    achromat = raylet.load(scenes / "achromat.toml")
    for fields, names in ((None, ["0°, 0°", "2.5°, 0°", "5°, 0°"]), ([[0.0, 0.0], [3.0, 0.0]], ["0°, 0°", "3°, 0°"])):
        figure, ax = achromat.draw(fields=fields)
        legend = ax.get_legend()
        assert [text.get_text() for text in legend.get_texts()] == names
        colours = [line.get_color() for line in legend.get_lines()]
        rays = [line for line in ax.lines if line.get_color() in colours and len(line.get_xdata())]
        assert [line.get_color() for line in rays] == [colour for colour in colours for _ in range(5)]
        plt.close(figure)
    with pytest.raises(ValueError, match="fields have shape"):
        achromat.draw(fields=[[1.0]])


@pytest.mark.parametrize("angle", [0.0, 14.0, 20.0])
def test_rays_come_through_to_the_sensor(scenes: Path, angle: float) -> None:
    figure, ax = raylet.load(scenes / "real_size" / "cooke_triplet.toml").draw(fields=[[angle, 0.0]])
    ends = [line.get_xdata()[-1] for line in ax.lines if line.get_color() == "tab:orange"]
    assert len(ends) == 5 and np.ptp(ends) < 1e-9
    plt.close(figure)


def test_a_folded_system_fills_its_picture(scenes: Path) -> None:
    figure, ax = raylet.load(scenes / "toroidal_fold.toml").draw()
    figure.canvas.draw()
    drawn, (left, right), (low, high) = ax.dataLim, ax.get_xlim(), ax.get_ylim()
    assert drawn.width > 0.3 * (right - left) and drawn.height > 0.7 * (high - low)

    # The lines of neighbouring rays do not run into each other before they meet.
    rays = [line for line in ax.lines if line.get_color() == "tab:orange"]
    starts = ax.transData.transform([line.get_xydata()[0] for line in rays])
    gap = np.hypot(*np.diff(starts, axis=0).T).min() * 72.0 / figure.dpi
    assert gap > 2.0 * rays[0].get_linewidth()
    plt.close(figure)
