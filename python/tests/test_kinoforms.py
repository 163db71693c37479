"""Kinoforms: blazed and stepped profiles with their diffraction orders."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import raylet

PERIOD, LEVELS = 50, 5


def behind(layer: dict[str, Any], method: str) -> Any:
    """The field 10 mm behind an element at 0.45 µm."""
    system = raylet.System(wavelength_um=0.45).add_doe(layer, aperture=raylet.disc(0.2), thickness_mm=10.0)
    return system.add_sensor(pixels=(41, 31), pitch_um=5.0).simulate(method=method).field


@pytest.mark.parametrize("method", ["auto", "local_bands"])
def test_orders_of_a_stepped_grating_are_its_pixels(method: str) -> None:
    """A grating of 50 µm in five steps, made for 0.5 µm, is the same as pixels of 1 µm that make these steps."""
    number = (np.arange(400) % PERIOD) * LEVELS // PERIOD
    phase = np.broadcast_to(2.0 * np.pi * (0.5 / 0.45) * number / LEVELS, (400, 400))
    exact = behind(raylet.pixels(pitch_um=1.0, phase=phase), "auto")
    own = {"orders": range(-12, 13), "levels": LEVELS, "wavelength_um": 0.5}
    found = behind(raylet.kinoform([raylet.grating(period_um=PERIOD)], **own), method)
    error = np.linalg.norm(found - exact) / np.linalg.norm(exact)
    assert error < 2e-3, error


def hybrid(orders: list[int]) -> Any:
    """A lens of 6 mm with a kinoform on its back, at a wavelength for which it is not made."""
    kinoform = raylet.kinoform(
        [raylet.lens(focal_length_mm=60.0)],
        orders=orders,
        wavelength_um=0.55,
        glass={"nd": 1.49, "vd": 57.0},
        stands_in="behind",
    )
    system = raylet.System(wavelength_um=0.5)
    system.add_stop(raylet.disc(0.7), thickness_mm=0.5)
    system.add_surface(radius_mm=4.0, glass="N-BK7", thickness_mm=1.0, semi_aperture_mm=1.0)
    system.add_doe(kinoform, glass="air", aperture=raylet.disc(0.4), thickness_mm=6.4, name="back")
    return system.add_sensor(pixels=(48, 48), pitch_um=0.5)


def test_orders_on_a_lens_add() -> None:
    """Light is linear: that of three orders is the sum of the three, each carried on its own."""
    together = hybrid([0, 1, 2]).simulate()
    alone = [hybrid([order]).simulate().field for order in (0, 1, 2)]
    assert together.methods[-1] == "local_bands"
    error = np.linalg.norm(together.field - sum(alone)) / np.linalg.norm(together.field)
    assert error < 1e-3, error
    shares = [np.linalg.norm(field) ** 2 for field in alone]
    assert shares[1] > 50.0 * max(shares[0], shares[2])


def test_rays_follow_the_strongest_order() -> None:
    all_orders, first = hybrid([0, 1, 2]).trace(Px=0.3), hybrid([1]).trace(Px=0.3)
    assert all_orders.x[-1] == pytest.approx(first.x[-1], abs=1e-12)
    assert abs(hybrid([2]).trace(Px=0.3).x[-1] - first.x[-1]) > 1e-3


def test_what_no_profile_does_is_refused() -> None:
    axicon = raylet.kinoform([raylet.axicon(angle_deg=1.0)])
    with pytest.raises(
        raylet.RayletError, match=r"layer\[0\].layer\[0\].kind: found a layer that is no analytic phase"
    ):
        behind(axicon, "auto")
    with pytest.raises(raylet.RayletError, match=r"levels: found 1, expected from 2 to 65536 steps"):
        behind(raylet.kinoform([raylet.vortex(charge=1)], levels=1), "auto")
