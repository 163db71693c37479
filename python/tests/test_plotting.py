"""Pictures of layouts and results."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import raylet
from raylet import _raylet

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


@pytest.mark.parametrize(("pixels", "label"), [((24, 1), "x in µm"), ((1, 24), "y in µm")])
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


def _slit(pixels: tuple[int, int], waves: int) -> raylet.Result:
    """The light behind a small square in so many wavelengths."""
    system = raylet.System(wavelength_um=[0.45, 0.55, 0.65, 0.75][:waves], title="A square")
    system.add_stop(raylet.rectangle(0.05, 0.05), thickness_mm=5.0)
    return system.add_sensor(pixels=pixels, pitch_um=5.0).simulate()


#: What `raylet simulate` shows of so many wavelengths: the wavelength of each row, or the sum.
_ROWS = {1: [""], 3: ["λ = 0.45 µm", "λ = 0.55 µm", "λ = 0.65 µm"], 4: ["sum of 4 wavelengths", "λ = 0.45 µm"]}


@pytest.mark.parametrize("waves", [1, 3, 4])
@pytest.mark.parametrize("pixels", [(24, 20), (64, 4), (4, 64), (300, 20)])
def test_panels_are_those_of_the_command_line(pixels: tuple[int, int], waves: int) -> None:
    result = _slit(pixels, waves)
    names = [f"λ = {wave} µm" for wave in result.wavelength_um]
    plan = json.loads(_raylet.sensor_panels(result.x_mm.tolist(), result.y_mm.tolist(), names))
    assert [row["note"] for row in plan["rows"]] == _ROWS[waves]
    figure, axes = result.plot()
    figure.canvas.draw()
    assert axes.shape == (len(plan["rows"]), 3)
    for row, line in zip(plan["rows"], axes):
        # The sum has no phase.
        shown = [ax for ax in line if ax.figure is not None]
        titles = ["Intensity", "Intensity, logarithmic", "Phase"][: 2 if row["channel"] is None else 3]
        assert [title for _, title in row["panels"]] == titles
        assert [ax.get_title().split("\n")[0] for ax in shown] == titles
        assert all(row["note"] in ax.get_title() for ax in shown)

        # The values of all wavelengths of the row, over the edges of the outer pixels.
        fields = result.fields if row["channel"] is None else [result.fields[row["channel"]]]
        intensity = sum(abs(field) ** 2 for field in fields)
        most = intensity.max()
        expected = [intensity, np.maximum(intensity / most, 1e-5), np.angle(fields[0])]
        for ax, values in zip(shown, expected):
            (image,) = ax.images
            drawn = np.ma.filled(image.get_array(), np.nan)
            lit = intensity > 1e-4 * most if ax is line[2] else np.full(intensity.shape, True)
            assert np.allclose(drawn[lit], values[lit], rtol=1e-12)
            assert np.isnan(drawn[~lit]).all()
            half = 2.5e-3 * np.array(pixels)
            assert np.allclose(image.get_extent(), [-half[0], half[0], -half[1], half[1]], rtol=1e-9)
            unit = "mm" if max(pixels) == 300 else "µm"
            assert (plan["unit"], ax.get_xlabel(), ax.get_ylabel()) == (unit, f"x in {unit}", f"y in {unit}")
    plt.close(figure)


@pytest.mark.parametrize("pixels", [(24, 20), (128, 4), (4, 128), (257, 32)])
def test_labels_of_ticks_stand_apart_and_few_rows_are_seen(pixels: tuple[int, int]) -> None:
    result = _slit(pixels, 3)
    for figure, axes in (result.plot(), result.plot("log")):
        figure.canvas.draw()
        for ax in np.ravel(axes):
            frame = ax.get_window_extent()
            assert 0.06 < frame.height / frame.width < 15.0
            for axis, (low, high) in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
                ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
                boxes = [tick.label1.get_window_extent() for tick in ticks]
                assert boxes and not any(one.overlaps(other) for one, other in combinations(boxes, 2))
        plt.close(figure)


def test_one_panel_of_one_wavelength_can_be_chosen() -> None:
    result = _slit((24, 20), 3)
    figure, mine = plt.subplots()
    for what, ax, channel, values in (
        (None, mine, None, abs(result.fields[0]) ** 2),
        (None, mine, 2, abs(result.fields[2]) ** 2),
        ("amplitude", None, 1, abs(result.fields[1])),
    ):
        found, drawn = result.plot(what, ax, channel=channel)
        assert found is figure if ax else found is not figure
        assert np.allclose(drawn.images[-1].get_array(), values, rtol=1e-12)
    figure, axes = result.plot(channel=1)
    assert axes.shape == (1, 3) and figure.get_suptitle() == "A square, λ = 0.55 µm"
    with pytest.raises(IndexError, match="channel is 3"):
        result.plot(channel=3)
    plt.close("all")


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
