"""Values that no system has are refused in few words, and nothing that is shown fails."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import raylet
import raylet.rays
from raylet._refusal import MOST_SHOWN, shown

#: More than any message has that shows 200 characters of each value it names.
LONGEST = 1500


def small() -> raylet.System:
    system = raylet.System(wavelength_um=0.7)
    layer = raylet.pixels(pitch_um=4.0, phase=np.zeros((4, 5)))
    system.add_doe(layer, aperture=raylet.disc(0.008), thickness_mm=3.0, name="doe")
    return system.add_sensor(pixels=(3, 4), pitch_um=5.0)


def itself() -> list[Any]:
    """A list that contains itself."""
    held: list[Any] = []
    held.append(held)
    return held


def deep(levels: int) -> list[Any]:
    """A list that lies so deep in lists."""
    held: list[Any] = []
    for _ in range(levels):
        held = [held]
    return held


LARGE = np.zeros(3_000_000)

#: Values that lie too deep, or are too large to stand in a scene.
ODD: list[Callable[[], Any]] = [
    itself,
    lambda: deep(100),
    lambda: deep(100_000),
    lambda: LARGE,
    lambda: [0.0] * 300_000,
]


@pytest.mark.parametrize("odd", ODD)
@pytest.mark.parametrize(
    "call",
    [
        lambda odd: small().simulate(memory_limit_mb=odd),
        lambda odd: small().simulate(target_error=odd),
        lambda odd: small().settings(sigma_um=odd).simulate(),
        lambda odd: small().add("stop", aperture=odd).to_toml(),
        lambda odd: raylet.System(wavelength_um=0.7, title=odd).to_toml(),
        lambda odd: small().design(variable=odd),
        lambda odd: small().hologram(np.ones((3, 4)), size_mm=odd),
        lambda odd: small().with_pixels("doe", phase=np.zeros((4, 5))).settings(step=odd).check(),
    ],
)
def test_odd_values_are_refused_in_few_words(call: Callable[[Any], Any], odd: Callable[[], Any]) -> None:
    value = odd()
    clock = time.monotonic()
    with pytest.raises(raylet.RayletError) as caught:
        call(value)
    assert len(str(caught.value)) < LONGEST
    assert time.monotonic() - clock < 10.0


@pytest.mark.parametrize("odd", [itself, lambda: deep(100), lambda: deep(100_000)])
def test_deep_lists_are_no_arrays(odd: Callable[[], Any]) -> None:
    for call in (
        lambda: raylet.pixels(pitch_um=4.0, phase=odd()),
        lambda: small().trace(Hx=odd()),
        lambda: raylet.scatter(small(), "doe", odd(), [[0.0, 0.0, 1.0]], sigma_mm=0.01),
        lambda: raylet.System(wavelength_um=odd()),
        lambda: small().linearised("doe")(odd()),
        lambda: small().linearised("doe")(np.zeros((4, 5))).adjoint(odd()),
        lambda: small().trace(Hx=[0.1], field_deg=odd()),  # type: ignore[arg-type]
    ):
        with pytest.raises(raylet.RayletError) as caught:
            call()
        assert len(str(caught.value)) < LONGEST


def test_whole_numbers_beyond_all_limits_are_refused() -> None:
    huge = 10**400

    def seen(index: int) -> str:
        return raylet.System(0.7, ambient=index).add_sensor(pixels=(1, 1), pitch_um=1.0).to_toml()  # type: ignore[arg-type]

    for call in (
        lambda: seen(huge),
        lambda: small().add_doe(raylet.height(pitch_um=1.0, glass=huge, size=(2, 2)), thickness_mm=1.0).to_toml(),
        lambda: small().add_doe(raylet.vortex(charge=huge), thickness_mm=1.0).to_toml(),
        lambda: small().trace(Hx=[0.1], field_deg=huge),
    ):
        with pytest.raises((raylet.RayletError, TypeError)) as caught:
            call()
        assert len(str(caught.value)) < LONGEST


def test_large_values_are_shown_by_their_type() -> None:
    class Many(list[int]):
        """A list of another type."""

    class Name(str):
        """A string of another type."""

    for value, text in [
        (bytes(10**8), "<bytes of 100000000 values>"),
        ([bytes(10**8)], "[<bytes of 100000000 values>]"),
        (Many(range(10**6)), "<Many of 1000000 values>"),
        (1 << 20_000, "<whole number of 20001 bits>"),
        (-12, "-12"),
        (True, "True"),
        (Name("doe"), "'doe'"),
    ]:
        assert shown(value) == text
    assert len(shown(Name("n" * 10**7))) <= MOST_SHOWN


def test_messages_show_few_characters_of_names(tmp_path: Path) -> None:
    name = "n" * 1_000_000
    odd = type(name, (), {})()
    for refused in (
        lambda: small().add("stop", aperture=odd).to_toml(),
        lambda: small().transmission(odd),
        lambda: small().simulate(threads=odd),
        lambda: raylet.load(name),
        lambda: small().save(name),
        lambda: small().simulate().save(tmp_path / name),
    ):
        with pytest.raises((ValueError, TypeError, OSError)) as caught:
            refused()
        assert len(str(caught.value)) < LONGEST
    for call in (
        lambda: small().transmission(name),
        lambda: small().with_pixels(name, phase=np.zeros((4, 5))),
        lambda: small().linearised(name),
        lambda: small().linearised("doe", parameters=[name]),
        lambda: small().linearised("doe", parameters=name),
        lambda: small().simulate(method=name),
        lambda: small().simulate(memory_limit_mb=name),
        lambda: small().add_sensor(pixels=(3, 4), pitch_um=1.0, **{name: 1}).to_toml(),
        lambda: raylet.System(wavelength_um=0.7, ambient=name).add_sensor(pixels=(1, 1), pitch_um=1.0).to_toml(),
        lambda: raylet.gather(small(), [[0.0, 0.0, 3.0]], [[0.0, 0.0, 1.0]], 0.0, 1.0, wavelet=name),
        lambda: raylet.scatter(small(), name, np.zeros((1, 3)), [[0.0, 0.0, 1.0]], sigma_mm=0.01),
        lambda: raylet.pixels(pitch_um=4.0, phase=name),
    ):
        with pytest.raises((ValueError, TypeError)) as caught:
            call()
        assert len(str(caught.value)) < LONGEST
    assert len(shown(name)) < MOST_SHOWN + 40
    assert len(shown(itself())) < MOST_SHOWN + 40


@pytest.mark.parametrize("number", [1e155, 1e308, -1e308, 9.2e18, float("nan"), float("inf"), 2**63 - 1])
def test_absurd_numbers_are_refused(number: float) -> None:
    def doe(pitch_um: float = 4.0, thickness_mm: float = 3.0, radius_mm: float = 0.008) -> raylet.System:
        layer = raylet.pixels(pitch_um=pitch_um, phase=np.zeros((4, 5)))
        system = raylet.System(wavelength_um=0.7)
        return system.add_doe(layer, aperture=raylet.disc(radius_mm), thickness_mm=thickness_mm).add_sensor(
            pixels=(3, 4), pitch_um=5.0
        )

    for key in ("pitch_um", "thickness_mm", "radius_mm"):
        with pytest.raises(raylet.RayletError, match=f": {key}: found "):
            doe(**{key: number})
    with pytest.raises(raylet.RayletError):
        small().simulate(target_error=number)
    rays = {"position": np.zeros((1, 3)), "direction": [[0.0, 0.0, 1.0]]}
    for keys in ({"sigma_mm": number}, {"sigma_mm": 0.01, "weight": number}, {"sigma_mm": 0.01, "area_mm2": number}):
        with pytest.raises((ValueError, TypeError)):
            made = raylet.scatter(small(), "doe", **rays, **keys)
            assert np.isfinite(made.weight).all()
            raise ValueError("what came out is finite")
    with pytest.raises(ValueError):
        small().trace(Px=number)


def test_results_are_finite_or_refused() -> None:
    system = small()
    bright = np.full((4, 5), 1e200, dtype=complex)
    with pytest.raises(raylet.RayletError):
        system.with_pixels("doe", transmission=bright).simulate()
    with pytest.raises(raylet.RayletError):
        system.linearised("doe")(bright)
    passage = system.linearised("doe")(np.zeros((4, 5)))
    with pytest.raises(raylet.RayletError):
        passage.adjoint(np.full(passage.field.shape, 1e308))


def test_repr_never_raises() -> None:
    levels = sys.getrecursionlimit() + 100

    def holding(key: str, odd: Any) -> raylet.System:
        """A system that holds what no call gives it."""
        system = small()
        system._document[key] = odd
        return system

    odd_waves = ("red", None, {}, object(), 1j, float("nan"))
    systems = [holding("wavelength_um", odd) for odd in odd_waves]
    broken = small()
    broken._document["element"] = None
    empty = small()
    del empty._document
    systems += [
        holding("title", itself()),
        holding("title", deep(levels)),
        holding("element", [{"kind": "stop", "aperture": itself()}]),
        broken,
        empty,
    ]
    result, design, linearised = (
        small().simulate(),
        small().hologram(np.ones((3, 4)), size_mm=(0.01, 0.01)),
        small().linearised("doe"),
    )
    del result.report, design.scores, linearised.elements
    hollow = type("Hollow", (), {"__repr__": lambda self: 1 / 0})()
    parts = [raylet.Beams(hollow, None), raylet.rays.GatherBar(*[hollow] * 6)]  # type: ignore[arg-type]
    many = raylet.System(np.linspace(0.4, 0.7, 100_000))
    for thing in [*systems, result, design, linearised, *parts, many]:
        text = repr(thing)
        assert "raylet" in text and len(text) < LONGEST, text[:300]
