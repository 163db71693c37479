"""Systems as plain values, and what the library says of those that it refuses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path, PurePath
from typing import Any

import numpy as np
import pytest

import raylet
from raylet._plain import plain


def test_values_become_plain() -> None:
    given = {
        "text": PurePath("a.npy"),
        "numbers": (np.int32(7), np.float32(0.5), np.array([1.0, 2.0]), np.array(3)),
        "truth": np.True_,
        "absent": None,
        "table": {"inside": [{"none": None}]},
    }
    wanted = {
        "text": "a.npy",
        "numbers": [7, 0.5, [1.0, 2.0], 3],
        "truth": True,
        "table": {"inside": [{}]},
    }
    made = plain(given)
    assert made == wanted and list(made) == list(wanted)
    assert [type(item) for item in made["numbers"]] == [int, float, list, int] and type(made["truth"]) is bool


@pytest.mark.parametrize(
    ("thickness", "found", "expected"),
    [
        (float("nan"), "nan", "a finite number"),
        (np.float32("inf"), "inf", "a finite number"),
        (2**63, "a whole number beyond 64 bits", "a smaller one"),
        (np.int64(-3), "-3", "zero or more: no mirror has turned the light back"),
        (1e13, "10000000000000.0", "a length of magnitude up to 1e12 mm"),
        (True, "true", "a number"),
        ("far", 'the string "far"', "a number"),
        ([1.0], "a list", "a number"),
        ({"mm": 1.0}, "a table", "a number"),
    ],
)
def test_refusals_name_the_call_the_element_and_the_argument(thickness: Any, found: str, expected: str) -> None:
    system = raylet.System(wavelength_um=0.7)
    with pytest.raises(raylet.RayletError) as caught:
        system.add_stop(raylet.disc(0.1), thickness_mm=thickness, name="iris")
    refusal = caught.value
    assert (refusal.path, refusal.found, refusal.expected) == ("thickness_mm", found, expected)
    assert refusal.call == "System.add_stop, element[0] 'iris'"
    assert str(refusal) == f"{refusal.call}: thickness_mm: found {found}, expected {expected}"
    # What is refused is not added.
    assert "0 elements" in repr(system)


def test_refusals_of_unknown_keys_have_a_hint() -> None:
    with pytest.raises(raylet.RayletError) as caught:
        raylet.System(wavelength_um=0.7).settings(sigma=1.0)
    assert (caught.value.path, caught.value.hint) == ("sigma", "did you mean `sigma_um`?")
    assert str(caught.value).startswith(
        "System.settings: sigma: found an unknown key `sigma`, expected one of `method`"
    )


def system() -> raylet.System:
    return raylet.System(wavelength_um=0.7)


def whole() -> raylet.System:
    return system().add_stop(raylet.disc(1.0), thickness_mm=1.0, name="iris").add_sensor(pixels=(1, 1), pitch_um=1.0)


LENS, DISC = raylet.lens(focal_length_mm=5.0), raylet.disc(1.0)

#: Calls with a wrong argument, and the words with which each fails where it is made.
WRONG: list[tuple[Callable[[], Any], str]] = [
    (lambda: raylet.disc("a"), 'raylet.disc: radius_mm: found the string "a", expected a number'),
    (lambda: raylet.lens(focal_length_mm="a"), 'raylet.lens: focal_length_mm: found the string "a", expected a number'),
    (lambda: raylet.pixels(pitch_um=1.0), "raylet.pixels: found no array, expected `phase`"),
    (
        lambda: raylet.pixels(pitch_um=1.0, phase=np.ones((2, 2), complex)),
        "raylet.pixels: phase is a complex array, expected real numbers",
    ),
    (
        lambda: raylet.xy(norm_radius_mm=1.0, terms=[(3, 0, 1.0), (1, 2, 3, 4)]),
        "raylet.xy: terms[1]: found (1, 2, 3, 4), expected three numbers (i, j, a)",
    ),
    (
        lambda: raylet.xy(norm_radius_mm=1.0, terms=[1, 2, 3]),
        "raylet.xy: terms[0]: found 1, expected three numbers (i, j, a)",
    ),
    (lambda: raylet.kinoform(5), "raylet.kinoform: layer: found 5, expected a list"),
    (
        lambda: raylet.superposition([LENS, "x"]),
        'raylet.superposition: terms[1]: found the string "x", expected a list',
    ),
    (lambda: raylet.obstructed(5, DISC), "raylet.obstructed: aperture: found 5, expected a table"),
    (lambda: raylet.beam_taper("a"), 'raylet.beam_taper: radius_mm: found the string "a"'),
    (lambda: raylet.System("a"), 'System: wavelength_um: found the string "a", expected a number or a list'),
    (lambda: raylet.System(0.7, title=3), "System: title: found 3, expected a string"),
    (lambda: raylet.System(0.7, seed="x"), 'System: seed: found the string "x", expected a whole number'),
    (lambda: system().plane_wave(angle_deg=14), "System.plane_wave: angle_deg: found 14, expected a list of 2 values"),
    (
        lambda: system().plane_wave(taper=0.5),
        "System.plane_wave: taper: found 0.5, expected a table\nhint: tapers are made by raylet.beam_taper",
    ),
    (
        lambda: system().field_source(np.ones(4), pitch_um=1.0, distance_mm=1.0),
        "System.field_source: samples has shape (4,), expected two axes [y, x]",
    ),
    (
        lambda: system().add_surface(radius_mm="20"),
        'System.add_surface, element[0]: radius_mm: found the string "20", expected a radius',
    ),
    (
        lambda: system().add_lens(50.0),
        "System.add_lens, element[0]: surface[0]: found 50.0, expected a table\nhint: each",
    ),
    (
        lambda: system().add_lens({"radius": 20.0}),
        "System.add_lens, element[0]: surface[0].radius: found an unknown key `radius`, expected one of `radius_mm`",
    ),
    (
        lambda: whole().add_stop("x", name="second"),
        "System.add_stop, element[2] 'second': aperture: found the string \"x\", expected a table\nhint: apertures are",
    ),
    (
        lambda: system().add_sensor(pixels=16, pitch_um=1.0),
        "System.add_sensor, element[0]: pixels: found 16, expected a list of 2 values",
    ),
    (
        lambda: system().add_mirror(semi_aperture_mm=1.0, thickness_mm=-1.0).add_stop(DISC, thickness_mm=1.0),
        "System.add_stop, element[1]: thickness_mm: found 1, expected zero or less: after an odd number of mirrors",
    ),
    (
        lambda: system().add_doe(LENS, aperture=DISC, layer=[LENS]),
        "System.add_doe: 'layer' is given twice, or stands for what is given in order",
    ),
    (
        lambda: raylet.disc(),
        "raylet.disc: missing a required argument: 'radius_mm'\nIts arguments: radius_mm, centre_mm",
    ),
    (
        lambda: raylet.disc(1.0, radius=2.0),
        "raylet.disc has no argument 'radius'; did you mean radius_mm?\nIts arguments",
    ),
    (
        lambda: system().plane_wave(polarization=1),
        "System.plane_wave has no argument 'polarization'; waves are scalar: there is no polarisation (docs/limits.md)",
    ),
    (lambda: raylet.System(0.7, polarization=1), "System has no argument 'polarization'; waves are scalar"),
    (
        lambda: system().add_doe(LENS, aperture=DISC, jones=1),
        "System.add_doe has no argument 'jones'; waves are scalar",
    ),
    (lambda: whole().simulate(coherence=1), "System.simulate has no argument 'coherence'; light is fully coherent"),
    (lambda: raylet.gather(whole(), 0, 0, 0, 0, jones=1), "raylet.gather has no argument 'jones'; waves are scalar"),
    (
        lambda: system().add_surface(glass="N-BK8", name="front", semi_aperture_mm=1.0, thickness_mm=1.0),
        "System.add_surface, element[0] 'front': glass: found no glass is named 'N-BK8'",
    ),
    (lambda: raylet.System(0.7, ambient="gls"), "System: ambient: found no glass is named 'gls'"),
]


@pytest.mark.parametrize(("call", "words"), WRONG, ids=[words.split(", expected")[0] for _, words in WRONG])
def test_wrong_arguments_fail_at_the_call(call: Callable[[], Any], words: str) -> None:
    with pytest.raises((ValueError, TypeError)) as caught:
        call()
    assert str(caught.value).startswith(words), str(caught.value)


#: Systems that only a run shows to be wrong, and the words of that run.
REFUSED: list[tuple[Callable[[], Any], str]] = [
    (lambda: system().add_stop(DISC, name="iris"), "System.add_stop, element[0] 'iris': found no `thickness_mm`"),
    (lambda: whole(), "System.simulate: element[2]: found a second sensor, expected one sensor"),
]


@pytest.mark.parametrize(("build", "words"), REFUSED)
def test_a_run_names_the_call_that_was_wrong(build: Callable[[], raylet.System], words: str) -> None:
    built = build().add_sensor(pixels=(1, 1), pitch_um=1.0)
    with pytest.raises(raylet.RayletError) as caught:
        built.simulate()
    assert str(caught.value).startswith(words), str(caught.value)


def test_a_run_names_its_own_arguments_and_those_of_files(tmp_path: Path) -> None:
    with pytest.raises(raylet.RayletError, match='^System.simulate: method: found "beam".*\nhint: did you mean'):
        whole().simulate(method="beam")
    with pytest.raises(raylet.RayletError, match="^System.simulate: found no elements"):
        system().simulate()
    with pytest.raises(raylet.RayletError, match="^System.hologram: sise_mm: found an unknown key"):
        whole().hologram(np.ones((2, 2)), sise_mm=(1.0, 1.0))
    with pytest.raises(TypeError, match=r"^System.linearised: parameters is \[3\], expected a list of paths"):
        whole().linearised(parameters=[3])  # type: ignore[list-item]
    curved = system().add_doe(LENS, aperture=DISC, radius_mm=20.0, thickness_mm=5.0, name="back")
    curved.add_sensor(pixels=(1, 1), pitch_um=1.0).settings(method="beamlet")
    with pytest.raises(raylet.RayletError, match="^System.linearised: parameter 'element.*' changes .* element 'back'"):
        curved.linearised(parameters=["element[0].radius_mm"])
    curved.settings(method="auto").linearised(parameters=["element[0].radius_mm"])
    # What a file says is at its line.
    text = whole().to_toml().replace('ambient = "air"', 'ambient = "gls"')
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(raylet.RayletError, match=r"scene.toml:\d+:\d+: ambient: found no glass"):
        raylet.load(tmp_path / "scene.toml")


def test_reliefs_that_are_to_be_found_need_a_size() -> None:
    blank = raylet.height(pitch_um=2.0, glass=1.5, size=(4, 4))
    assert "height_um" not in blank and "height_um" not in raylet.superposition([blank])["terms"][0][0]
    system().add_doe(blank, aperture=DISC, thickness_mm=1.0)
    with pytest.raises(raylet.RayletError, match="^raylet.height: found no `height_um`"):
        raylet.height(pitch_um=2.0, glass=1.5)


def test_a_layer_stands_for_a_list_of_it() -> None:
    assert raylet.kinoform(LENS) == raylet.kinoform([LENS])
    assert raylet.superposition([LENS, [LENS]]) == raylet.superposition([[LENS], [LENS]])


@pytest.mark.parametrize("value", [None, 1j, object(), {1: 2}, b"x"])
def test_what_is_not_plain_is_refused(value: Any) -> None:
    with pytest.raises(TypeError):
        raylet.System(wavelength_um=0.7).add("stop", aperture={"disc": [value]}).to_toml()


def test_warnings_are_those_of_the_line_that_calls() -> None:
    focus = system().add_doe(raylet.lens(focal_length_mm=0.5), aperture=raylet.disc(0.05), thickness_mm=0.5)
    focus.add_sensor(pixels=(3, 3), pitch_um=5.0)
    with pytest.warns(UserWarning, match="pixels") as caught:
        focus.simulate(progress=False)
    assert {warning.filename for warning in caught} == {__file__}
