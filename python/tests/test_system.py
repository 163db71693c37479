"""Systems in code: what they give, what they refuse, and that nothing is copied on the way."""

from __future__ import annotations

import copy
import inspect
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import hologram, noise, through_lens

import raylet


def test_what_may_be_wrong_is_reported_before_a_run() -> None:
    system = raylet.System(wavelength_um=[0.7, 0.6])
    pixels = raylet.pixels(pitch_um=0.8, phase=np.zeros((20, 20)))
    system.add_doe(pixels, aperture=raylet.disc(0.1), thickness_mm=5.0, name="doe")
    system.add_sensor(pixels=(20, 20), pitch_um=5.0, name="sensor")
    lines = system.check()
    assert "warning, doe to sensor: the pixels of 'doe' cover 0.64 % of its aperture; beside them it is dark" in lines
    assert len(set(lines)) == len(lines)
    kinds = {one["properties"]["kind"]["const"] for one in raylet.schema()["$defs"]["Element"]["oneOf"]}
    assert {"doe", "surface", "sensor"} <= kinds


def test_python_has_every_key_of_layers_and_sources() -> None:
    """The keyword arguments of the functions that make layers and light are the keys of scene files, but for those that
    say where in a file an array is."""
    makers: dict[str, dict[str, Any]] = {
        "Layer": {kind: getattr(raylet, kind) for kind in raylet.layers.__dict__ if hasattr(raylet, kind)},
        "Illumination": {
            "plane": raylet.System.plane_wave,
            "point": raylet.System.point_source,
            "gaussian": raylet.System.gaussian_beam,
            "field": raylet.System.field_source,
            "fibre": raylet.System.fibre_source,
        },
    }
    makers["Layer"]["sum"] = raylet.superposition
    for table, functions in makers.items():
        for variant in raylet.schema()["$defs"][table]["oneOf"]:
            kind = variant["properties"]["kind"]["const"]
            keys = set(variant["properties"]) - {"kind", "key"}
            assert keys == arguments(functions[kind]), (table, kind)
    for table, function in {"BeamTaper": raylet.beam_taper, "ConeTaper": raylet.cone_taper}.items():
        assert set(raylet.schema()["$defs"][table]["properties"]) == arguments(function), table


def arguments(function: Any) -> set[str]:
    return set(inspect.signature(function).parameters) - {"self"}


def test_apertures_stand_where_they_are_told() -> None:
    """A regular polygon is the polygon of its corners, also about a centre of its own, and so is a ring."""
    turn = np.radians(20.0 + 60.0 * np.arange(6))
    corners = np.stack([0.2 * np.cos(turn), 0.2 * np.sin(turn)], axis=1)

    def seen(aperture: Any, shift: float = 0.0) -> Any:
        system = (
            raylet.System(wavelength_um=0.5)
            .add_stop(aperture, thickness_mm=1.0)
            .add_sensor(pixels=(2, 2), pitch_um=1.0)
        )
        start = [[x + shift, y, -1.0] for x, y in 0.22 * noise((60, 2)) / np.pi - 0.22]
        return system.trace(start_mm=start, cosines=[0.0, 0.0, 1.0]).arrived

    hexagon = seen(raylet.regular_polygon(6, 0.2, rotation_deg=20.0))
    assert 5 < hexagon.sum() < 60 and np.array_equal(hexagon, seen(raylet.polygon(corners)))
    centre = (0.3, 0.0)
    assert np.array_equal(hexagon, seen(raylet.polygon(corners, centre_mm=centre), 0.3))
    assert np.array_equal(hexagon, seen(raylet.regular_polygon(6, 0.2, rotation_deg=20.0, centre_mm=centre), 0.3))
    ring = seen(raylet.annulus(0.1, 0.2))
    assert 5 < ring.sum() < 60 and np.array_equal(ring, seen(raylet.annulus(0.1, 0.2, centre_mm=centre), 0.3))
    broken = raylet.System(wavelength_um=0.5).add_coordinate_break(tilt_deg=(0.0, 5.0, 0.0), name="turn")
    assert broken._document["element"][0]["name"] == "turn"


def test_python_has_every_key_of_apertures() -> None:
    tables = raylet.schema()["$defs"]
    outlines = tables["Aperture"]["properties"]
    assert set(outlines) - {"blocked"} == {"disc", "rectangle", "annulus", "regular_polygon", "polygon"}
    for kind in set(outlines) - {"blocked"}:
        table = outlines[kind]["anyOf"][0]["$ref"].rsplit("/", 1)[-1]
        assert set(tables[table]["properties"]) == arguments(getattr(raylet, kind)), kind
    assert "blocked" in raylet.obstructed(raylet.disc(2.0), raylet.disc(1.0))


def test_python_has_every_key_of_elements_and_settings() -> None:
    tables = raylet.schema()["$defs"]
    disc, system = raylet.disc(1.0), raylet.System(wavelength_um=0.5)
    # The arguments without which there is no such element.
    needed: dict[str, tuple[tuple[Any, ...], dict[str, Any]]] = {
        "doe": ((raylet.lens(focal_length_mm=5.0),), {"aperture": disc}),
        "lens": (({"semi_aperture_mm": 1.0, "thickness_mm": 1.0, "glass": 1.5}, {"semi_aperture_mm": 1.0}), {}),
        "surface": ((), {"semi_aperture_mm": 1.0}),
        "mirror": ((), {"semi_aperture_mm": 1.0}),
        "stop": ((disc,), {}),
        "paraxial_lens": ((5.0,), {"aperture": disc}),
        "coordinate_break": ((), {}),
        "sensor": ((), {"pixels": (1, 1), "pitch_um": 1.0}),
    }
    for variant in tables["Element"]["oneOf"]:
        kind = variant["properties"]["kind"]["const"]
        listed, given = needed[kind]
        add = getattr(raylet.System, f"add_{kind}")
        for key, entry in variant["properties"].items():
            if key in {"kind", "layer", "surface", "aperture", "focal_length_mm"}:
                continue
            is_known(add, copy.deepcopy(system), *listed, **{**given, key: example(entry)})
    for key, entry in tables["LensSurface"]["properties"].items():
        is_known(copy.deepcopy(system).add_lens, {key: example(entry)}, {})
    for key, entry in tables["Settings"]["properties"].items():
        is_known(copy.deepcopy(system).settings, **{key: example(entry)})
    apart = {"version", "source", "element", "settings", "hologram", "design"}
    assert arguments(raylet.System.__init__) == set(raylet.schema()["properties"]) - apart
    with pytest.raises(AssertionError, match="has no argument"):
        is_known(copy.deepcopy(system).add_stop, disc, nonesuch=1)


def test_python_takes_every_shape() -> None:
    """Shapes are dictionaries with the keys of scene files."""
    system = raylet.System(wavelength_um=0.5)
    for variant in raylet.schema()["$defs"]["Shape"]["oneOf"]:
        shape = {key: example(entry) for key, entry in variant["properties"].items()}
        is_known(copy.deepcopy(system).add_surface, shape=shape, semi_aperture_mm=1e-6)


def example(entry: dict[str, Any]) -> Any:
    """A value that a key may have by the schema."""
    if "$ref" in entry:
        return example(raylet.schema()["$defs"][entry["$ref"].rsplit("/", 1)[-1]])
    if "const" in entry:
        return entry["const"]
    either = entry.get("oneOf") or entry.get("anyOf")
    if either:
        return example(either[0])
    kind = entry["type"] if isinstance(entry["type"], str) else entry["type"][0]
    if kind == "object":
        return {key: example(inner) for key, inner in entry["properties"].items() if key in entry.get("required", ())}
    if kind == "array":
        return [example(entry["items"])] * max(entry.get("minItems", 1), 1)
    number = max(entry.get("minimum", 0.0), min(2, 0.5 * entry.get("exclusiveMaximum", entry.get("maximum", 4.0))))
    return {"number": float(number), "integer": int(number), "boolean": True, "string": "text"}[kind]


def is_known(call: Any, *listed: Any, **keys: Any) -> None:
    """Whether a call has these arguments, whatever else it may refuse."""
    try:
        call(*listed, **keys)
    except (ValueError, TypeError) as error:
        assert "unknown key" not in str(error) and "has no argument" not in str(error), str(error)


def gaussian(x: Any, w: float, z: float, k: float) -> Any:
    """One axis of a Gaussian beam at a distance z from its waist."""
    q = z - 0.5j * k * w * w
    return np.sqrt(-0.5j * k * w * w / q) * np.exp(0.5j * k * x * x / q)


def test_a_gaussian_beam_is_wider_behind_its_waist() -> None:
    system = (
        raylet.System(wavelength_um=0.5)
        .gaussian_beam((50.0, 80.0), waist_mm=(0.0, 0.0, -10.0))
        .add_stop(raylet.disc(0.5), thickness_mm=20.0)
        .add_sensor(pixels=(41, 41), pitch_um=20.0)
    )
    result, k = system.simulate(), 2e3 * np.pi / 0.5
    x, y = result.x_mm, result.y_mm[:, None]
    exact = gaussian(x, 0.05, 30.0, k) * gaussian(y, 0.08, 30.0, k) * np.exp(30j * k)
    assert np.linalg.norm(result.field - exact) < 1e-3 * np.linalg.norm(exact)
    with pytest.raises(ValueError, match="Hx, Hy are not zero, expected zero for a Gaussian beam"):
        system.trace(Hx=0.5, field_deg=1.0)
    rays = system.trace(Px=0.2)
    assert rays.x[-1] == pytest.approx(0.1 * (1 + 20.0 * 10.0 / (10.0**2 + (0.5 * k * 0.05**2) ** 2)), rel=1e-3)


def test_slips_are_told_before_a_run() -> None:
    """Degrees, grey levels, light that cannot leave a grating, crossing surfaces, a sensor in glass."""
    random = np.random.default_rng(1)

    def told(*layers: dict[str, Any], radius_mm: float | None = None, thickness_mm: float = 1.0) -> str:
        system = raylet.System(wavelength_um=0.55).add_doe(*layers, aperture=raylet.disc(0.05), thickness_mm=1.0)
        if radius_mm is not None:
            system.add_surface(radius_mm=radius_mm, glass="N-BK7", thickness_mm=thickness_mm, semi_aperture_mm=2.0)
        if thickness_mm < 1.0:
            system.add_surface(radius_mm=-5.0, thickness_mm=5.0, semi_aperture_mm=2.0)
        return "\n".join(system.add_sensor(pixels=(8, 8), pitch_um=2.0).check())

    def pixels(phase: Any, scale: float = 1.0) -> dict[str, Any]:
        return raylet.pixels(pitch_um=8.0, phase=phase, phase_scale=scale)

    flat, degrees = pixels(np.zeros((12, 12))), random.uniform(0.0, 360.0, (12, 12))
    assert "look like degrees" in told(pixels(degrees))
    assert "look like" not in told(pixels(degrees, np.pi / 180.0))
    assert "look like grey levels" in told(pixels(random.integers(0, 256, (12, 12)).astype(float)))
    assert "look like degrees" in told(pixels(180.0 * random.integers(0, 2, (12, 12))))
    assert "does not propagate" in told(raylet.grating(period_um=0.4))
    assert "does not propagate" not in told(raylet.grating(period_um=0.6))
    assert "does not propagate" in told(raylet.kinoform([raylet.grating(period_um=0.4)]))
    assert "cross inside their apertures" in told(flat, radius_mm=5.0, thickness_mm=0.01)
    assert "stands in a medium of index 1.5185" in told(flat, radius_mm=5.0)


def test_all_light_comes_to_a_sensor_in_glass() -> None:
    """|U|² is smaller in glass by its index, for the same power."""
    system = (
        raylet.System(wavelength_um=0.5)
        .add_stop(raylet.disc(0.04), thickness_mm=0.05)
        .add_surface(glass={"index": 1.5}, thickness_mm=0.05, semi_aperture_mm=0.2)
        .add_sensor(pixels=(400, 400), pitch_um=0.25)
    )
    result = system.simulate(method="beamlet")
    assert result.power_share[0] == pytest.approx(1.0, abs=5e-3)


def test_unknown_arguments_fail_where_they_are_given() -> None:
    system = raylet.System(wavelength_um=0.5)
    with pytest.raises(TypeError, match=r"add_stop has no argument 'radius_m'\nIts arguments: aperture, decenter_mm"):
        system.add_stop(raylet.disc(1.0), radius_m=2.0)
    with pytest.raises(TypeError, match=r"has no argument 'radius'; did you mean radius_mm\?"):
        system.add_surface(radius=20.0)
    with pytest.raises(TypeError, match=r"no element is of kind 'lense', expected one of coordinate_break, doe, lens"):
        system.add("lense")


def test_a_glass_is_given_by_its_own_numbers() -> None:
    def index(glass: Any) -> float:
        system = raylet.System(wavelength_um=0.4861327).add_stop(raylet.disc(1.0), thickness_mm=1.0)
        system.add_surface(glass=glass, thickness_mm=1.0, semi_aperture_mm=2.0).add_sensor(pixels=(4, 4), pitch_um=1.0)
        return float(system.parts[1]["index"])

    assert index({"nd": 1.5168, "vd": 64.17}) == pytest.approx(index("N-BK7"), abs=1e-4)
    with pytest.raises(
        raylet.RayletError, match=r"add_surface, element\[1\]: glass: found a medium with nd, expected one of: index;"
    ):
        index({"nd": 1.5168})


def test_a_glass_of_ones_own_has_its_dispersion_at_every_wavelength(tmp_path: Path) -> None:
    """By Sellmeier's formula with one pair and with four, and by a table, in Python and from a scene file: the fields
    are those with the index of each wavelength."""
    waves = [0.45, 0.55, 0.65]
    pairs = [[1.04, 0.006], [0.23, 0.02], [1.0, 103.0], [0.01, 0.03]]

    def by_formula(wave: Any, count: int) -> Any:
        return np.sqrt(1.0 + sum(b * wave**2 / (wave**2 - c) for b, c in pairs[:count]))

    table = np.linspace(0.4, 0.7, 7)
    glasses = [
        ({"sellmeier": pairs[:1], "range_um": [0.4, 0.7]}, by_formula(np.array(waves), 1)),
        ({"sellmeier": pairs}, by_formula(np.array(waves), 4)),
        ({"wavelengths_um": table, "indices": 1.6 - 0.1 / table + 0.05 / table**2}, None),
    ]

    def fields(wavelength_um: Any, glass: Any, folder: Path | None = None) -> Any:
        system = raylet.System(wavelength_um=wavelength_um).add_stop(raylet.disc(0.2), thickness_mm=0.1)
        system.add_surface(radius_mm=3.0, glass=glass, thickness_mm=0.5, semi_aperture_mm=0.5)
        system.add_surface(semi_aperture_mm=0.5, thickness_mm=4.0).add_sensor(pixels=(15, 15), pitch_um=3.0)
        if folder is not None:
            system.save(folder / "scene.toml", overwrite=True)
            system = raylet.load(folder / "scene.toml")
        return system.simulate().field

    for glass, indices in glasses:
        indices = 1.6 - 0.1 / np.array(waves) + 0.05 / np.array(waves) ** 2 if indices is None else indices
        found = fields(waves, glass)
        assert np.array_equal(fields(waves, glass, tmp_path), found)
        for field, wave, index in zip(found, waves, indices):
            exact = fields(wave, {"index": float(index)})
            assert np.linalg.norm(field - exact) < 1e-9 * np.linalg.norm(exact)


def test_focus_of_a_diffractive_lens() -> None:
    """In the focus of an ideal lens of radius a the field is ∫ cos θ/(λr) dA = (πf/λ) log(1 + a²/f²)."""
    system = (
        raylet.System(wavelength_um=0.7)
        .add_doe(raylet.lens(focal_length_mm=50.0), aperture=raylet.disc(1.0), thickness_mm=50.0)
        .add_sensor(pixels=(21, 21), pitch_um=4.0)
    )
    result = system.simulate()
    peak = abs(result.field[10, 10])
    assert peak == pytest.approx(np.pi * 50.0 / 0.7e-3 * np.log1p(1.0 / 50.0**2), rel=1e-6)
    assert result.x_mm[10] == 0.0 and result.x_mm[11] == pytest.approx(4e-3)
    assert result.error is not None and result.error < 1e-3


def test_code_and_scene_file_give_the_same_bits(scenes: Path, tmp_path: Path) -> None:
    """A scene file and the same system built in code, arrays from a file or from memory."""
    phase = noise((10, 12))
    np.save(tmp_path / "phase.npy", phase)
    built = through_lens(phase)
    text = built.to_toml().replace("array in memory", "phase.npy")
    (tmp_path / "scene.toml").write_text(text)
    loaded = raylet.load(tmp_path / "scene.toml")
    assert np.array_equal(built.simulate().field, loaded.simulate(threads=1).field)


def test_axes_of_arrays_are_y_x() -> None:
    """A phase that grows along x sends light towards +x: columns are x."""
    x = (np.arange(40) - 19.5) * 4e-3
    tilt = 2.0 * np.pi / 0.7e-3 * 0.02 * x
    result = hologram(np.tile(tilt, (30, 1)), pixels=(61, 31)).simulate()
    mean = (result.intensity.sum(axis=0) * result.x_mm).sum() / result.intensity.sum()
    assert mean == pytest.approx(0.02 * 2.0, abs=0.01)
    assert result.field.shape == (31, 61)


def test_several_wavelengths_come_first() -> None:
    one = raylet.System(wavelength_um=0.7)
    two = raylet.System(wavelength_um=[0.5, 0.7])
    for system in (one, two):
        system.add_doe(
            raylet.lens(focal_length_mm=20.0, wavelength_um=0.7), aperture=raylet.disc(0.3), thickness_mm=20.0
        )
        system.add_sensor(pixels=(9, 7), pitch_um=3.0)
    alone, both = one.simulate(), two.simulate()
    assert both.field.shape == (2, 7, 9) and both.wavelength_um == [0.5, 0.7]
    assert np.array_equal(both.field[1], alone.field)


def test_field_is_handed_over_and_phases_are_looked_at() -> None:
    """The field's memory is the library's own; arrays of float64 are taken as they lie, strides and all."""
    phase = noise((10, 12))
    result = hologram(phase).simulate()
    assert not result.field.flags.owndata and not isinstance(result.field.base, np.ndarray)
    assert result.field is result.fields[0]

    system = hologram(phase)
    system._compiled()
    (held,) = system._arrays.values()
    assert np.shares_memory(held, phase) and held.ctypes.data == phase.ctypes.data

    # Turned and stepped views give what copies give.
    large = noise((40, 36))
    view = large[::-2, 1::3].T[:, ::-1]
    assert np.array_equal(hologram(view).simulate().field, hologram(view.copy()).simulate().field)


def test_memory_of_a_large_element_is_taken_once() -> None:
    """What a run of a large element needs beside the array it is given: the transmission it makes of it, and fields."""
    import resource

    phase = np.zeros((3000, 3000))
    system = (
        raylet.System(wavelength_um=0.7)
        .add_doe(raylet.pixels(pitch_um=1.0, phase=phase), aperture=raylet.disc(1.4), name="large", thickness_mm=50.0)
        .add_sensor(pixels=(8, 8), pitch_um=5.0)
    )
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    system._compiled()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 0.5 * phase.nbytes / 1024


def test_pixels_are_replaced_without_touching_the_original() -> None:
    system = hologram(noise((10, 12)))
    other = system.with_pixels("hologram", phase=noise((10, 12), 1))
    assert np.array_equal(other.simulate().field, hologram(noise((10, 12), 1)).simulate().field)
    assert np.array_equal(system.simulate().field, hologram(noise((10, 12))).simulate().field)
    with pytest.raises(raylet.RayletError, match="'holo'.*'hologram'"):
        system.with_pixels("holo", phase=noise((10, 12)))


def test_errors_name_the_field() -> None:
    system = hologram(noise((10, 12)))
    system.add_sensor(pixels=(4, 4), pitch_um=1.0)
    with pytest.raises(raylet.RayletError) as caught:
        system.simulate()
    assert caught.value.path == "element[1].kind" or caught.value.path.startswith("element[")
    bad = raylet.System(wavelength_um=0.1).add_surface(
        radius_mm=5.0, glass="N-BK7", semi_aperture_mm=1.0, thickness_mm=5.0
    )
    bad.add_sensor(pixels=(4, 4), pitch_um=1.0)
    with pytest.raises(raylet.RayletError, match="N-BK7 at a wavelength of 0.1 µm") as caught:
        bad.simulate()
    assert caught.value.path == "element[0].glass"
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    ("phase", "error", "message"),
    [
        (np.zeros(4), ValueError, r"shape \(4,\), expected two axes"),
        (np.zeros((0, 4)), ValueError, "at least one value"),
        (np.array([["a"]]), TypeError, "real or complex"),
        (np.array([[None]]), TypeError, "real or complex"),
    ],
)
def test_arrays_are_refused_where_they_are_given(phase: np.ndarray, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        raylet.pixels(pitch_um=4.0, phase=phase)


def test_values_that_are_none_are_refused_at_the_field() -> None:
    phase = noise((10, 12))
    phase[3, 4] = np.nan
    with pytest.raises(raylet.RayletError, match=r"NaN at \[3, 4\]") as caught:
        hologram(phase).simulate()
    assert caught.value.path == "element[0].layer[0].phase"
    with pytest.raises(raylet.RayletError, match="a complex array"):
        hologram(np.exp(1j * noise((10, 12)))).simulate()


def test_settings_of_a_call() -> None:
    system = through_lens(noise((10, 12)))
    result = system.simulate(target_error=1e-2, memory_limit_mb=500.0, seed=7)
    assert result.report["settings"]["target_error"] == 1e-2
    assert result.report["settings"]["memory_limit_mb"] == 500.0
    assert result.report["settings"]["seed"] == 7
    with pytest.raises(raylet.RayletError) as caught:
        system.simulate(method="beam")
    assert caught.value.path == "settings.method"
    with pytest.raises(ValueError, match="threads is 0"):
        system.simulate(threads=0)


def test_results_explain_themselves(tmp_path: Path) -> None:
    result = through_lens(noise((10, 12))).simulate()
    text = repr(result)
    for word in ["16 x 12 pixels of 8 µm", "beamlet", "arrived", "expected field error", "% of the light"]:
        assert word in text, text
    assert result.methods == ["beamlet"] and result.tally["arrived"] > 0
    result.save(tmp_path / "field.npz")
    with np.load(tmp_path / "field.npz") as saved:
        assert np.array_equal(saved["field"][0], result.field)
    system = repr(through_lens(noise((10, 12))))
    assert "hologram" in system and "sphere" in system


def test_a_result_marks_a_missed_target_and_light_that_cannot_be() -> None:
    with pytest.warns(UserWarning, match="misses the target"):
        missed = through_lens(noise((10, 12))).simulate()
    assert "(above the target 1e-03)" in repr(missed)
    focus = (
        raylet.System(wavelength_um=0.5)
        .add_doe(raylet.lens(focal_length_mm=0.5), aperture=raylet.disc(0.05), thickness_mm=0.5)
        .add_sensor(pixels=(3, 3), pitch_um=5.0)
    )
    with pytest.warns(UserWarning, match="more light than came: the pixels are too coarse"):
        bright = focus.simulate()
    share = bright.power_share[0]
    assert share is not None and share > 3.0 and "more light on the sensor than came" in repr(bright)


def test_systems_can_be_copied_and_named() -> None:
    system = copy.deepcopy(hologram(noise((4, 5))).settings(target_error=1e-2))
    assert system.simulate().field.shape == (20, 24)
    assert "SCHOTT:N-BK7" in raylet.glasses()
    assert "not complete" in repr(raylet.System(wavelength_um=0.5))


def test_linearised_gradient_without_a_framework() -> None:
    """The dot product of forward and adjoint, and both kinds of pixels."""
    linearised = hologram(noise((4, 5))).linearised("hologram")
    phase, moved = noise((4, 5), 1), noise((4, 5), 2) - np.pi
    passage = linearised(phase)
    bar = np.exp(1j * noise(passage.field.shape, 3))
    step = 1e-6
    difference = (linearised(phase + step * moved).field - linearised(phase - step * moved).field) / (2 * step)
    (by_phase,), _ = passage.adjoint(bar)
    assert np.vdot(bar, difference).real == pytest.approx(np.sum(by_phase * moved), rel=1e-8)

    t = 0.5 * np.exp(1j * phase)
    passage = linearised(t)
    change = np.exp(1j * noise((4, 5), 4))
    (by_t,), _ = passage.adjoint(bar)
    exact = linearised(t + change).field - passage.field
    assert np.vdot(bar, exact).real == pytest.approx(np.vdot(by_t, change).real, rel=1e-10)


def test_linearised_takes_the_settings_of_a_run() -> None:
    """Plans by other settings give another field; a setting that is none is refused as a run refuses it."""
    system, phase = through_lens(noise((6, 6))), noise((6, 6))
    usual = system.linearised("hologram")(phase).field
    beamlets = system.linearised("hologram", method="beamlet", target_error=1e-1, seed=3, memory_limit_mb=500.0)
    difference = np.linalg.norm(beamlets(phase).field - usual) / np.linalg.norm(usual)
    assert 0.0 < difference < 0.1
    with pytest.raises(raylet.RayletError, match="target_error"):
        system.linearised("hologram", target_error=2.0)
    with pytest.raises(raylet.RayletError, match="memory_limit_mb"):
        system.linearised("hologram", memory_limit_mb=0.0)


def test_linearised_names_the_elements_there_are() -> None:
    with pytest.raises(raylet.RayletError, match="'doe' has no pixels.*those that have: 'hologram'"):
        hologram(noise((4, 5))).linearised("doe")
    lens = (
        raylet.System(wavelength_um=0.7)
        .add_surface(radius_mm=5.0, thickness_mm=1.0, glass="N-BK7", semi_aperture_mm=1.0)
        .add_surface(semi_aperture_mm=1.0, thickness_mm=9.0)
        .add_sensor(pixels=(8, 8), pitch_um=8.0)
    )
    with pytest.raises(raylet.RayletError, match="N-BK7.*glass.index"):
        lens.linearised(parameters=["element[0].glass.index"])


def test_the_package_takes_no_time_of_its_own() -> None:
    """What a call takes beyond the library's own clock is below a twentieth of it."""
    system = through_lens(noise((30, 30)), pixels=(48, 40))
    system.simulate(progress=False)
    start = time.perf_counter()
    result = system.simulate(progress=False)
    beyond = time.perf_counter() - start - result.seconds
    assert beyond < 0.05 * result.seconds + 2e-3


def test_saved_systems_are_the_same(tmp_path: Path) -> None:
    """Arrays in memory and files of a scene elsewhere, read again from another folder."""
    system = hologram(noise((8, 8)))
    system.save(tmp_path / "one" / "scene.toml")
    there = raylet.load(tmp_path / "one" / "scene.toml")
    assert np.array_equal(there.simulate().field, system.simulate().field)
    there.save(tmp_path / "two" / "again.toml")
    again = raylet.load(tmp_path / "two" / "again.toml")
    assert np.array_equal(again.simulate().field, system.simulate().field)
    assert sorted(path.name for path in tmp_path.rglob("*.npy")) == ["scene.element0.layer0.phase.npy"]
