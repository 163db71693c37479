"""Draws the pictures of the page on conventions: python docs/guide/pictures.py."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import raylet

HERE = Path(__file__).parent


def signs() -> None:
    """Radii and thicknesses on a lens and a mirror, a tilt on a plate."""
    system = raylet.System(wavelength_um=0.5).plane_wave(beam_radius_mm=4.0)
    system.add_surface(
        radius_mm=30.0, thickness_mm=4.0, glass=1.5, semi_aperture_mm=6.0, name="radius +30, thickness 4"
    )
    system.add_surface(radius_mm=-60.0, thickness_mm=16.0, semi_aperture_mm=6.0, name="radius −60, thickness 16")
    system.add_mirror(
        radius_mm=-50.0, thickness_mm=-10.0, semi_aperture_mm=5.0, name="mirror, radius −50, thickness −10"
    )
    system.add_sensor(pixels=(400, 400), pitch_um=10.0, name="sensor")
    fig, ax = system.draw()
    fig.set_size_inches(9.0, 4.2)
    for text, (dx, dy) in zip(ax.texts, ((-20, 6), (-44, 4), (56, 4), (-62, 8), (0, 6))):
        text.set_position((dx, dy))
    ax.set_aspect("auto")
    ax.set_ylim(-8.0, 8.5)
    ax.annotate("light starts towards +z", (-2.4, -7.4), fontsize=8)
    fig.savefig(HERE / "signs.png", dpi=110)


def arrays() -> None:
    """A phase that grows along x, over columns, and where its light lands."""
    n, pitch = 40, 4.0
    x = (np.arange(n) - (n - 1) / 2) * pitch * 1e-3
    phase = np.tile(2 * np.pi / 0.7e-3 * 0.02 * x, (n, 1))
    system = raylet.System(wavelength_um=0.7)
    layer = raylet.pixels(pitch_um=pitch, phase=phase)
    system.add_doe(layer, aperture=raylet.rectangle(0.16, 0.16), thickness_mm=4.0, name="phase[y, x] grows with x")
    system.add_sensor(pixels=(80, 80), pitch_um=4.0)
    fig, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    system.plot("phase[y, x] grows with x", left)
    system.simulate().plot("intensity", right)
    right.set_title("4 mm behind it: light at x = 0.08 mm")
    fig.savefig(HERE / "arrays.png", dpi=110)


signs()
arrays()
