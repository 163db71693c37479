"""Random systems of one or two screens, in free space or with a lens between them or before the sensor."""

from __future__ import annotations

import numpy as np
from benches.cross_check.elements import Random, aperture, layers

import raylet

WAVELENGTH_UM = 0.5

# Share of the screens with a lens behind them.
WITH_LENS = 0.3


def lit(random: Random, across_mm: float) -> tuple[str, raylet.System]:
    """A system that has only its light."""
    system = raylet.System(wavelength_um=WAVELENGTH_UM)
    name = str(random.choice(["plane wave", "plane wave", "inclined", "point", "Gaussian"]))
    if name == "inclined":
        x, y = random.uniform(-2, 2, 2)
        system = system.plane_wave(angle_deg=(float(x), float(y)))
    if name == "point":
        system = system.point_source((float(random.uniform(-0.2, 0.2)), 0.0, -float(random.uniform(5, 30))))
    if name == "Gaussian":
        system = system.gaussian_beam(float(random.uniform(0.2, 0.6)) * across_mm * 1e3)
    return name, system


def with_lens(random: Random, system: raylet.System, across_mm: float) -> tuple[str, raylet.System]:
    """The system with a lens behind its last screen: a singlet as wide as twice the light, or a plate."""
    if random.random() < 0.3:
        system = system.add_surface(thickness_mm=0.5, glass="N-BK7", semi_aperture_mm=across_mm)
        return "plate", system.add_surface(thickness_mm=across_mm * 4, semi_aperture_mm=across_mm)
    radius = across_mm * float(random.uniform(5, 15))
    system = system.add_surface(radius_mm=radius, thickness_mm=0.5, glass="N-BK7", semi_aperture_mm=across_mm)
    distance = radius * float(random.uniform(0.5, 1.5))
    return "singlet", system.add_surface(radius_mm=-radius, thickness_mm=distance, semi_aperture_mm=across_mm)


def random_system(seed: int) -> tuple[str, raylet.System]:
    """The system of a seed, and a description of it."""
    random = np.random.default_rng(seed)
    across_mm = float(random.uniform(0.1, 0.5))
    name, system = lit(random, across_mm)
    words = [name]
    screens = int(random.choice([1, 1, 2]))
    for _ in range(screens):
        distance = across_mm * float(random.uniform(8, 50))
        opening, outline = aperture(random, across_mm)
        lens = random.random() < WITH_LENS
        thickness = 0.5 * across_mm if lens else distance
        if screens == 2 and random.random() < 0.25:
            system = system.add_stop(outline, thickness_mm=thickness)
            words.append(f"stop, {opening} of {across_mm:.2f} mm")
        else:
            what, elements = layers(random, across_mm)
            system = system.add_doe(*elements, aperture=outline, thickness_mm=thickness)
            words.append(f"{what}, {opening} of {across_mm:.2f} mm")
        if lens:
            what, system = with_lens(random, system, across_mm)
            words.append(what)
        across_mm *= float(random.uniform(0.6, 1.6))
    side = int(random.choice([16, 32]))
    pitch_um = across_mm * 1e3 / side * float(random.uniform(0.3, 1.5))
    return "; ".join(words), system.add_sensor(pixels=(side, side), pitch_um=pitch_um)
