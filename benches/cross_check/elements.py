"""Random layers and apertures of diffractive elements."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import raylet

Random = np.random.Generator

# A description and what it describes.
Drawn = tuple[str, Any]

# Pixels along each side at most.
MOST_PIXELS = 120


def smooth_phase(random: Random, rows: int, columns: int) -> Any:
    """A random phase whose detail is four pixels wide, 4 rad as the root mean square."""
    noise = np.fft.fft2(random.normal(size=(rows, columns)))
    fy, fx = np.meshgrid(np.fft.fftfreq(rows), np.fft.fftfreq(columns), indexing="ij")
    smooth = np.fft.ifft2(noise * np.exp(-0.5 * (2 * np.pi * 4) ** 2 * (fx**2 + fy**2))).real
    return 4 * smooth / smooth.std()


def pixels(random: Random, across_mm: float) -> Drawn:
    """Pixels of any form: random or smooth, with gaps, turned, off centre or with amplitudes."""
    pitch = [float(random.uniform(2, 8))] * 2 if random.random() < 0.7 else [float(p) for p in random.uniform(2, 8, 2)]
    columns, rows = [int(np.clip(across_mm * 1e3 / p, 2, MOST_PIXELS)) for p in pitch]
    form = str(random.choice(["box", "box", "bilinear", "band_limited", "point"]))
    is_smooth = form == "band_limited" or random.random() < 0.4
    phase = smooth_phase(random, rows, columns) if is_smooth else random.uniform(0, 2 * np.pi, (rows, columns))
    given: dict[str, Any] = {}
    if form == "box" and random.random() < 0.4:
        given |= {"fill": float(random.uniform(0.4, 0.97)), "rest": str(random.choice(["dark", "flat"]))}
    if random.random() < 0.2:
        given["rotation_deg"] = float(random.uniform(-60, 60))
    if random.random() < 0.2:
        given["centre_mm"] = [float(x) for x in random.uniform(-0.1, 0.1, 2) * across_mm]
    if random.random() < 0.3:
        given["amplitude"] = random.uniform(0, 1, (rows, columns))
    layer = raylet.pixels(pitch_um=(pitch[0], pitch[1]), phase=phase, pixel=form, **given)
    words = ["smooth" if is_smooth else "random", form, "pixels", *(key.removesuffix("_mm") for key in given)]
    return " ".join(words), layer


def lens(random: Random, across_mm: float) -> Any:
    """An ideal lens that converges or diverges, f/6 to f/50."""
    return raylet.lens(focal_length_mm=float(random.choice([-1, 1])) * across_mm * float(random.uniform(6, 50)))


def numbers(random: Random, most: float, count: int) -> list[float]:
    """Coefficients of either sign."""
    return [float(x) for x in random.uniform(-most, most, count)]


def phase_grid(across_mm: float) -> Any:
    """A wavy phase on a grid."""
    x = np.linspace(-1, 1, 24)
    phase = 8 * np.sin(3 * x)[:, None] * np.cos(4 * x)[None] + 6 * x[None] ** 2
    return raylet.phase_grid(pitch_um=across_mm * 1.1e3 / 23, phase=phase)


def radial_table(across_mm: float) -> Any:
    """A lens with rings, as a table."""
    part = np.linspace(0, 1.5, 30)
    return raylet.radial_table(radius_mm=part * across_mm / 2, phase_rad=5 * np.cos(4 * part) - 20 * part**2)


def layers(random: Random, across_mm: float) -> tuple[str, list[Any]]:
    """The layers of an element of a width."""
    radius, uniform = across_mm / 2, random.uniform
    kinds: dict[str, Callable[[], list[Any]]] = {
        "lens": lambda: [lens(random, across_mm)],
        "grating": lambda: [raylet.grating(period_um=float(uniform(6, 40)), direction_deg=float(uniform(0, 360)))],
        "axicon": lambda: [raylet.axicon(angle_deg=float(uniform(0.3, 3)))],
        "vortex": lambda: [raylet.vortex(charge=int(random.integers(-3, 4)))],
        "radial": lambda: [raylet.radial(norm_radius_mm=radius, coefficients=numbers(random, 40, 3))],
        "zernike": lambda: [raylet.zernike(norm_radius_mm=1.01 * radius, coefficients=numbers(random, 5, 11))],
        "cubic": lambda: [raylet.xy(norm_radius_mm=radius, terms=cubic(random))],
        "lens + grating": lambda: [lens(random, across_mm), raylet.grating(period_um=float(uniform(8, 30)))],
        "superposition": lambda: [
            raylet.superposition(
                [lens(random, across_mm), raylet.grating(period_um=float(uniform(8, 30)))], weights=[0.8, 0.5]
            )
        ],
        "kinoform": lambda: [
            raylet.kinoform(raylet.lens(focal_length_mm=20 * across_mm), levels=int(random.choice([2, 4, 8])))
        ],
        "phase grid": lambda: [phase_grid(across_mm)],
        "radial table": lambda: [radial_table(across_mm)],
        "lens + vortex": lambda: [lens(random, across_mm), raylet.vortex(charge=2)],
    }
    name = str(random.choice(["pixels", "pixels", "pixels", "lens + pixels", *kinds]))
    if name not in kinds:
        words, layer = pixels(random, across_mm)
        return (words, [layer]) if name == "pixels" else (f"lens + {words}", [layer, lens(random, across_mm)])
    return name, kinds[name]()


def cubic(random: Random) -> list[tuple[int, int, float]]:
    """Powers of x and y with their coefficients in rad."""
    return [(3, 0, 30.0), (0, 3, float(random.uniform(-40, 40))), (1, 1, 9.0)]


def aperture(random: Random, across_mm: float) -> Drawn:
    """An opening of a width."""
    radius = across_mm / 2
    kinds: dict[str, Callable[[], Any]] = {
        "disc": lambda: raylet.disc(radius),
        "rectangle": lambda: raylet.rectangle(across_mm, across_mm * float(random.uniform(0.5, 1))),
        "annulus": lambda: raylet.annulus(0.4 * radius, radius),
        "polygon": lambda: raylet.regular_polygon(int(random.integers(3, 8)), radius),
        "spider": lambda: raylet.obstructed(
            raylet.disc(radius), raylet.disc(0.3 * radius), raylet.rectangle(across_mm, 0.08 * across_mm)
        ),
        "disc off centre": lambda: raylet.disc(0.8 * radius, centre_mm=(0.1 * radius, -0.15 * radius)),
    }
    name = str(random.choice(["disc", *kinds]))
    return name, kinds[name]()
