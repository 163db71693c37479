"""Stacks of runs: several fields, wavelengths and distances in one call, and their tables."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

import raylet
from raylet.sweep_table import SweepTable


def test_a_sweep_is_the_runs_that_it_stands_for() -> None:
    system = (
        raylet.System(wavelength_um=0.5)
        .add_doe(raylet.lens(focal_length_mm=10.0), aperture=raylet.disc(0.2), thickness_mm=10.0)
        .add_sensor(pixels=(12, 10), pitch_um=3.0)
    )
    found = system.simulate(fields=[(0.0, 0.0), (0.1, 0.0)], wavelengths=[0.45, 0.5, 0.55])
    assert found.dims == ("field", "wavelength", "y", "x") and found.field.shape == (2, 3, 10, 12)
    one = raylet.System(wavelength_um=0.55).plane_wave(angle_deg=(0.1, 0.0))
    one.add_doe(raylet.lens(focal_length_mm=10.0, wavelength_um=0.5), aperture=raylet.disc(0.2), thickness_mm=10.0)
    one.add_sensor(pixels=(12, 10), pitch_um=3.0)
    assert np.array_equal(found.field[1, 2], one.simulate().field)
    assert [row["wavelength_um"] for row in found.table[:3]] == [0.45, 0.5, 0.55]
    followed = system.simulate(fields=[(0.0, 0.0), (3.0, 0.0)], follow=True)
    for result in followed.results:
        across = result.intensity.sum(axis=0)
        assert abs(np.sum(across * result.x_mm) / across.sum()) < 1e-3
        assert result.intensity.max() > 0.95 * followed.results[0].intensity.max()
    both = found.incoherent([[1.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    assert np.allclose(both, found.intensity[0, 0] + 2.0 * found.intensity[1, 2], rtol=1e-12)
    focus = system.simulate(distances=np.array([9.0, 10.0, 11.0]))
    assert focus.intensity.max(axis=(1, 2)).argmax() == 1 and focus.distances_mm == [9.0, 10.0, 11.0]
    assert "raylet.Sweep distance x y x x: 3 runs" in repr(focus)
    # The long form is the same call.
    long = system.sweep(distances_mm=[9.0, 10.0, 11.0])
    assert np.array_equal(long.field, focus.field) and long.dims == focus.dims
    assert "data:image/png" in found.results[0, 0]._repr_html_() and "<pre>" in system._repr_html_()


def test_runs_side_by_side_have_the_bits_that_they_have_alone() -> None:
    system = raylet.System(wavelength_um=0.5).add_doe(
        raylet.lens(focal_length_mm=10.0), aperture=raylet.disc(0.2), thickness_mm=10.0
    )
    system.add_sensor(pixels=(12, 10), pitch_um=3.0)
    ways, seen = [9.0, 9.5, 10.0, 10.5, 11.0], []
    found = system.simulate(distances=ways, threads=4, progress=lambda share, what: seen.append((share, what)))
    for way, field in zip(ways, found.field):
        assert np.array_equal(field, system.simulate(distances=[way], threads=1).field[0])
    assert max(share for share, _ in seen) <= 1.0 and seen[-1][0] == 1.0
    assert all(re.fullmatch(r"run [1-5] of 5 to 'element\[1\]'( \(attempt \d\))?", what) for _, what in seen)


def test_the_first_run_that_fails_is_told_and_a_stop_ends_all() -> None:
    system = raylet.System(wavelength_um=0.5).add_stop(raylet.disc(0.02), thickness_mm=1.0)
    system.add_sensor(pixels=(4, 4), pitch_um=3.0)
    with pytest.raises(raylet.RayletError, match=r"thickness_mm"):
        system.simulate(distances=[1.0, -1.0, 2.0])

    def stop(share: float, what: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        system.simulate(distances=[1.0, 2.0, 3.0], progress=stop)


@pytest.mark.parametrize(
    ("given", "kind", "message"),
    [
        ({"wavelengths": 0.5}, ValueError, r"wavelengths has shape \(\), expected \(runs,\)"),
        ({"distances": [[1.0]]}, ValueError, r"distances has shape \(1, 1\), expected \(runs,\)"),
        ({"distances": []}, ValueError, "distances is empty"),
        ({"distances": ["far"]}, TypeError, "distances has elements of type"),
        ({"fields": [0.0, 1.0]}, ValueError, r"fields has shape \(2,\), expected \(runs, 2\) for angles"),
        (
            {"fields": [(0.0, 0.0, -5.0)]},
            ValueError,
            r"fields has shape \(1, 3\).*angle_deg of a source of kind 'plane'",
        ),
        ({"follow": True}, TypeError, "follow goes with fields, wavelengths or distances"),
        ({"wavelengths_um": [0.5]}, TypeError, "wavelengths_um"),
        ({"distances": [5.0], "method": "none"}, raylet.RayletError, "method"),
    ],
)
def test_what_is_no_list_of_runs_is_refused_by_its_name(given: Any, kind: type[Exception], message: str) -> None:
    system = raylet.System(wavelength_um=0.5)
    system.add_stop(raylet.disc(0.02), thickness_mm=5.0).add_sensor(pixels=(4, 4), pitch_um=3.0)
    with pytest.raises(kind, match=message):
        system.simulate(**given)


def test_lists_of_runs_that_the_system_has_not_are_refused() -> None:
    bare = raylet.System(wavelength_um=[0.5, 0.6]).add_sensor(pixels=(4, 4), pitch_um=3.0)
    with pytest.raises(TypeError, match="sweep takes fields, wavelengths_um or distances_mm"):
        bare.sweep()
    with pytest.raises(TypeError, match="wavelengths is not given, expected which of the system's several"):
        bare.simulate(distances=[1.0])
    with pytest.raises(TypeError, match="wavelengths_um is not given"):
        bare.sweep(fields=[(0.0, 0.0)])
    with pytest.raises(raylet.RayletError, match="distances lead from the last element to the sensor, found no"):
        bare.simulate(wavelengths=[0.5], distances=[1.0])
    fibre = raylet.System(wavelength_um=0.5).fibre_source(core_radius_um=2.0, numerical_aperture=0.1, distance_mm=0.1)
    with pytest.raises(TypeError, match="fields is given for a source of kind 'fibre', expected one of plane,"):
        fibre.add_sensor(pixels=(4, 4), pitch_um=3.0).simulate(fields=[(0.0, 0.0)])


def test_a_sweep_warns_where_it_was_called() -> None:
    system = raylet.System(wavelength_um=0.5).add_stop(raylet.disc(0.01), thickness_mm=0.2)
    system.add_sensor(pixels=(4, 4), pitch_um=3.0, decenter_mm=(1.8, 0.0))
    with pytest.warns(UserWarning) as one:
        system.simulate()
    with pytest.warns(UserWarning) as several:
        system.simulate(distances=[0.2])
    with pytest.warns(UserWarning) as long:
        system.sweep(distances_mm=[0.2])
    assert {warning.filename for warnings in (one, several, long) for warning in warnings} == {__file__}


def test_a_sweep_is_reported_as_a_table(tmp_path: Path) -> None:
    system = (
        raylet.System(wavelength_um=0.5)
        .add_doe(raylet.lens(focal_length_mm=2.0), aperture=raylet.disc(0.1), thickness_mm=2.0)
        .add_sensor(pixels=(24, 20), pitch_um=1.0)
    )
    sweep = system.simulate(fields=[(0.0, 0.0), (-3.0, 1.0)], distances=[1.9, 2.0], follow=True)
    row, result = sweep.table[3], sweep.results[1, 1]
    assert (row["angle_x_deg"], row["angle_y_deg"], row["distance_mm"], row["wavelength_um"]) == (-3.0, 1.0, 2.0, 0.5)
    assert row["error"] == result.error and row["target_reached"] is (result.error < 1.1e-3)
    assert row["light_share"] == result.power_share[0] and row["peak"] == result.intensity.max()
    at = np.unravel_index(result.intensity.argmax(), result.intensity.shape)
    assert (row["peak_x_mm"], row["peak_y_mm"]) == (result.x_mm[at[1]], result.y_mm[at[0]])
    assert 2.0 < row["fwhm_x_um"] < 6.0 and 0.0 < row["seconds"] <= result.seconds
    sweep.save_table(tmp_path / "table.csv")
    head, *lines = (tmp_path / "table.csv").read_text().splitlines()
    assert head.split(",") == list(row) and len(lines) == 4
    assert lines[3].split(",")[:5] == ["-3.0", "1.0", "2.0", "0.5", repr(row["error"])]
    text, page = repr(sweep), sweep._repr_html_()
    title, head, units, *runs = text.splitlines()
    assert title == "<raylet.Sweep field x distance x y x x: 4 runs; λ 0.5 µm; method free>"
    assert head.split()[:2] == ["field", "distance"] and units.split()[:3] == ["°", "mm", "%"]
    assert runs[3].startswith("  -3, 1  2     ") and len(runs) == 4
    assert page.count("<tr>") == 5 and "<td>-3, 1</td>" in page and "<th>distance in mm</th>" in page
    # The program has the same columns.
    book = (ROOT / "docs" / "result.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in book for name in row)


@pytest.mark.parametrize("place", [(-0.25, 12.5, -1000.0), (-12.5, 10.25)])
def test_no_line_of_a_table_is_wider_than_80_columns(place: tuple[float, ...]) -> None:
    names = ("source_x_mm", "source_y_mm", "source_z_mm") if len(place) == 3 else ("angle_x_deg", "angle_y_deg")
    row = {**dict(zip(names, place)), "distance_mm": 48.35, "wavelength_um": 0.6328, "error": 2.5e-3}
    row |= {
        "target_error": 1e-3,
        "target_reached": False,
        "light_share": 0.98765,
        "peak": 123456.0,
        "seconds": 1234.567,
    }
    row |= {"peak_x_mm": -12.34567, "peak_y_mm": -0.00012, "fwhm_x_um": 123.456, "fwhm_y_um": None, "method": "beamlet"}
    other = {
        **row,
        **dict.fromkeys(names, 0.5),
        "wavelength_um": 1.064,
        "distance_mm": 50.0,
        "method": "local_bands free",
    }
    for rows in ([row], [row, other], [row, other] * 60):
        text = SweepTable("raylet.Sweep", rows).text()
        assert all(len(line) <= 80 for line in text.splitlines()), text
        # What is too wide stands in two tables, each with what tells the runs apart.
        assert text.count("distance") == text.count("λ") == 2 and "* above the target error 1e-3" in text
        assert text.count("0.6328") == 2 * min((len(rows) + 1) // 2, 50)
    usual = SweepTable("raylet.Sweep", [row, {**row, "wavelength_um": 0.55}]).text()
    assert usual.count("error") == 2 and "method beamlet" in usual.splitlines()[0]
