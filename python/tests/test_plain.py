"""Systems as plain values, and what the library says of those that it refuses."""

from __future__ import annotations

from pathlib import PurePath
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
def test_refusals_name_the_field(thickness: Any, found: str, expected: str) -> None:
    system = raylet.System(wavelength_um=0.7).add_stop(raylet.disc(0.1), thickness_mm=thickness)
    with pytest.raises(raylet.RayletError) as caught:
        system.add_sensor(pixels=(2, 2), pitch_um=1.0).to_toml()
    refusal = caught.value
    assert (refusal.path, refusal.found, refusal.expected) == ("element[0].thickness_mm", found, expected)
    assert str(refusal) == f"system: element[0].thickness_mm: found {found}, expected {expected}"


def test_refusals_of_unknown_keys_have_a_hint() -> None:
    system = raylet.System(wavelength_um=0.7).add_sensor(pixels=(2, 2), pitch_um=1.0).settings(sigma=1.0)
    with pytest.raises(raylet.RayletError) as caught:
        system.to_toml()
    assert (caught.value.path, caught.value.hint) == ("settings.sigma", "did you mean `sigma_um`?")


@pytest.mark.parametrize("value", [None, 1j, object(), {1: 2}, b"x"])
def test_what_is_not_plain_is_refused(value: Any) -> None:
    with pytest.raises(TypeError):
        raylet.System(wavelength_um=0.7).add("stop", aperture={"disc": [value]}).to_toml()
