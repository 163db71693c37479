"""Reliefs of a lens's own material on its surfaces: into air, or into a filling resin. Grids off centre or turned.
A hybrid lens of full size, which only local bands carry: its field and its gradient. Forms of pixels beside
Rayleigh-Sommerfeld sums: by whole fields, by beamlets and by local bands, also where an edge cuts the pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import raylet

RESIN = {"nd": 1.62, "vd": 24.0}
HEIGHT_UM = 1.3
PERIOD = 20

#: Pixels along each side of the hybrid lens.
SIDE = 100


def n_bk7(wavelength_um: float) -> float:
    """The index of N-BK7 over that of air, by the Sellmeier coefficients of Schott's data sheet (2014)."""
    square = wavelength_um**2
    pairs = [(1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)]
    return float(np.sqrt(1.0 + sum(b * square / (square - c) for b, c in pairs)))


def resin(wavelength_um: float) -> float:
    """The index of the resin from nd and vd: A + B/λ² through the F and C lines about d."""
    f, d, c = (1.0 / line**2 for line in (0.4861327, 0.5875618, 0.6562725))
    slope = (RESIN["nd"] - 1.0) / RESIN["vd"] / (f - c)
    return RESIN["nd"] + slope * (1.0 / wavelength_um**2 - d)


def light(layer: dict[str, Any], side: str, filled: bool, wavelength_um: float, radius_mm: float) -> Any:
    """The field behind a plate of N-BK7 with a layer on its front or back, and resin on that side of it if filled."""
    system = raylet.System(wavelength_um=wavelength_um)
    aperture = raylet.disc(0.12)
    curved = {"radius_mm": radius_mm} if radius_mm else {}
    wide = {"semi_aperture_mm": 0.3}
    if side == "front":
        if filled:
            system.add_surface(glass=RESIN, thickness_mm=0.3, **wide)
        system.add_doe(layer, glass="N-BK7", aperture=aperture, thickness_mm=1.0, **curved)
        system.add_surface(thickness_mm=4.0, **wide)
    else:
        system.add_surface(glass="N-BK7", thickness_mm=1.0, **wide)
        system.add_doe(layer, glass=RESIN if filled else "air", aperture=aperture, thickness_mm=0.3, **curved)
        if filled:
            system.add_surface(thickness_mm=4.0, **wide)
    return system.add_sensor(pixels=(64, 48), pitch_um=3.0).simulate()


@pytest.mark.parametrize(
    ("side", "filled", "wavelength_um", "radius_mm"),
    [
        ("front", False, 0.48, 0.0),
        ("front", False, 0.65, -6.0),
        ("front", True, 0.48, -6.0),
        ("front", True, 0.65, 0.0),
        ("back", False, 0.48, 0.0),
        ("back", False, 0.65, 0.0),
        ("back", True, 0.48, -6.0),
        ("back", True, 0.65, 0.0),
    ],
)
def test_a_relief_is_the_phase_of_its_index_step(
    side: str, filled: bool, wavelength_um: float, radius_mm: float
) -> None:
    """Bars of glass on a plate: φ = k(n − n′)h with the indices of both media from their published formulas, on a plane
    and on a curved surface."""
    bars = np.broadcast_to(HEIGHT_UM * (np.arange(120) % PERIOD < PERIOD // 2), (120, 120))
    other = resin(wavelength_um) if filled else 1.0
    step = 2.0 * np.pi * (n_bk7(wavelength_um) - other) / wavelength_um
    relief = raylet.height(pitch_um=2.0, height_um=bars.copy(), glass="N-BK7")
    phase = raylet.pixels(pitch_um=2.0, phase=step * bars)
    found = light(relief, side, filled, wavelength_um, radius_mm).field
    expected = light(phase, side, filled, wavelength_um, radius_mm).field
    error = np.linalg.norm(found - expected) / np.linalg.norm(expected)
    assert error < 2e-3, error


def test_bars_on_a_plate_have_the_orders_of_a_binary_grating() -> None:
    """Bars of half a period on the back of a plate: sin²(φ/2) of the light leaves the zero order, 4/π² of it to each
    side."""
    bars = HEIGHT_UM * (np.arange(600) % PERIOD < PERIOD // 2)
    relief = raylet.height(pitch_um=2.0, height_um=np.tile(bars, (60, 1)), glass="N-BK7")
    system = raylet.System(wavelength_um=0.5).add_surface(glass="N-BK7", thickness_mm=1.0, semi_aperture_mm=0.8)
    lens = raylet.lens(focal_length_mm=20.0)
    system.add_doe(relief, lens, glass="air", aperture=raylet.rectangle(1.2, 0.12), thickness_mm=20.0, coating="ideal")
    result = system.add_sensor(pixels=(512, 64), pitch_um=2.0).simulate()
    place = (np.arange(512) - 255.5) * 2e-3
    intensity = np.abs(result.field) ** 2
    sine = 0.5e-3 / 40e-3
    first = 20.0 * np.tan(np.arcsin(sine))
    near = [intensity[:, np.abs(place - m * first) < 0.5 * first].sum() for m in (-1, 0, 1)]
    phase = 2.0 * np.pi * (n_bk7(0.5) - 1.0) * HEIGHT_UM / 0.5
    expected = np.array([4.0 / np.pi**2 * np.sin(phase / 2.0) ** 2, np.cos(phase / 2.0) ** 2] * 2)[:3]
    assert np.allclose(np.array(near) / near[1] * expected[1], expected, rtol=0.03), (near, expected)


def test_a_third_material_needs_its_side() -> None:
    layer = raylet.height(pitch_um=2.0, height_um=np.ones((10, 10)), glass=1.4)
    with pytest.raises(raylet.RayletError, match="stands_in"):
        light(layer, "back", False, 0.5, 0.0)
    placed = raylet.height(pitch_um=2.0, height_um=np.ones((10, 10)), glass=1.4, stands_in="behind")
    assert light(placed, "back", False, 0.5, 0.0).field.any()


def with_grids(row: dict[str, Any], layers: list[dict[str, Any]]) -> raylet.System:
    """A system with one element of these layers."""
    system = raylet.System(wavelength_um=0.5)
    system.add_doe(*layers, name="doe", thickness_mm=0.5, **{"aperture": raylet.disc(0.02), **row})
    return system.add_sensor(pixels=(12, 14), pitch_um=4.0)


def grids(**axes: Any) -> list[dict[str, Any]]:
    """Pixels and heights of one lattice."""
    random = np.random.default_rng(3)
    relief = raylet.height(pitch_um=6.0, height_um=random.uniform(0.0, 1.0, (8, 10)), glass=1.5, **axes)
    return [raylet.pixels(pitch_um=6.0, phase=random.uniform(0.0, 6.0, (8, 10)), **axes), relief]


def test_placed_pixels_and_heights_are_those_of_a_placed_element() -> None:
    axes = {"centre_mm": (0.012, -0.008), "rotation_deg": 25.0}
    placed = with_grids({"aperture": raylet.disc(0.02, centre_mm=axes["centre_mm"])}, grids(**axes))
    moved = {"decenter_mm": axes["centre_mm"], "tilt_deg": (0.0, 0.0, 25.0)}
    element = with_grids(moved, grids())
    result, expected = placed.simulate(), element.simulate()
    assert np.linalg.norm(result.field - expected.field) < 1e-9 * np.linalg.norm(expected.field)
    assert result.error == pytest.approx(expected.error, rel=1e-6)
    # The element itself, in a picture: dark but in the aperture, about the centre of the pixels.
    values, bounds = placed.transmission("doe")
    assert bounds == pytest.approx((-0.008, 0.032, -0.028, 0.012)) and np.abs(values[0, 0]) == 0.0
    # A design finds the same.
    loss = [{"kind": "spot", "at_mm": [(0.0, 0.0)]}]
    courses = [
        system.design(element=[{"name": "doe", "free": "phase", "start": "file"}], loss=loss, iterations=2).course
        for system in (placed, element)
    ]
    assert courses[0] == pytest.approx(courses[1], rel=1e-7) and courses[0][-1] < courses[0][0]


def test_gradients_of_placed_pixels_are_differences() -> None:
    """Of the power in half of the sensor, by pixels and by the place of the grid. The aperture stays where it is, and
    cuts other pixels at each place: the differences have an error of their own."""
    axes = {"centre_mm": (0.012, -0.008), "rotation_deg": 25.0}
    system = with_grids({}, grids(**axes)[:1])
    paths = ["element[0].layer[0].centre_mm[0]", "element[0].layer[0].rotation_deg"]
    linearised = system.linearised("doe", parameters=paths, method="beamlet")
    phase, mask = np.random.default_rng(3).uniform(0.0, 6.0, (8, 10)), np.arange(12) < 5

    def power(phase: Any, parameters: Any) -> float:
        return float(np.sum(np.abs(linearised(phase, parameters=parameters).field[:, mask]) ** 2))

    start = linearised.start
    passage = linearised(phase, parameters=start)
    by_pixels, by_place = passage.adjoint(2.0 * passage.field * mask)
    step = np.random.default_rng(4).normal(size=phase.shape)
    slope = (power(phase + 1e-4 * step, start) - power(phase - 1e-4 * step, start)) / 2e-4
    assert np.sum(by_pixels[0] * step) == pytest.approx(slope, rel=2e-6)
    for index, size in enumerate((1e-6, 1e-3)):
        change = size * np.eye(2)[index]
        slope = (power(phase, start + change) - power(phase, start - change)) / (2.0 * size)
        assert by_place[index] == pytest.approx(slope, rel=4e-3), paths[index]


def test_grids_that_cannot_be_placed_are_refused() -> None:
    aside = grids(centre_mm=(0.01, 0.0))
    with pytest.raises(raylet.RayletError, match="fill or place in one element"):
        with_grids({}, [aside[0], grids()[1]]).check()
    with pytest.raises(raylet.RayletError, match="off centre, or turned, on a curved surface"):
        with_grids({"radius_mm": 20.0}, aside).check()
    with pytest.raises(raylet.RayletError, match="a hologram in pixels that are off centre, or turned"):
        with_grids({}, aside[:1]).hologram(np.ones((4, 4)), element="doe", size_mm=(0.02, 0.02))
    ray = {"position": np.zeros((1, 3)), "direction": np.array([[0.0, 0.0, 1.0]])}
    with pytest.raises(raylet.RayletError, match="pixels that are off centre or turned on their element"):
        raylet.scatter(with_grids({}, aside), element="doe", **ray, sigma_mm=0.01)


def hybrid(phase: np.ndarray) -> raylet.System:
    """A singlet f = 20 mm with pixels of 40 µm on its curved back."""
    system = raylet.System(wavelength_um=0.5876)
    system.add_stop(raylet.disc(4.0), thickness_mm=0.5)
    system.add_surface(radius_mm=12.5, thickness_mm=2.5, glass="N-BK7", semi_aperture_mm=4.0)
    pixels = raylet.pixels(pitch_um=40.0, phase=phase)
    system.add_doe(pixels, aperture=raylet.disc(1.8), radius_mm=-76.72, glass="air", thickness_mm=18.6, name="back")
    return system.add_sensor(pixels=(12, 12), pitch_um=1.0)


def test_gradients_of_a_hybrid_lens_match_differences() -> None:
    rng = np.random.default_rng(5)
    phase = rng.uniform(-0.5, 0.5, (SIDE, SIDE))
    linearised = hybrid(phase).linearised("back", parameters=["element[1].radius_mm", "element[2].thickness_mm"])

    def loss(phase: np.ndarray, parameters: np.ndarray) -> float:
        return float(np.sum(np.abs(linearised(phase, parameters=parameters).field[3:9, 3:9]) ** 2))

    start = np.asarray(linearised.start)
    passage = linearised(phase, parameters=start)
    bar = np.zeros_like(passage.field)
    bar[3:9, 3:9] = 2.0 * passage.field[3:9, 3:9]
    (by_phase,), by_parameters = passage.adjoint(bar)
    pattern = rng.normal(size=(SIDE, SIDE))
    moves = [(pattern * 2e-2, np.zeros(2)), (np.zeros((SIDE, SIDE)), np.array([2e-6, 0.0]))]
    moves.append((np.zeros((SIDE, SIDE)), np.array([0.0, 2e-3])))
    for of_phase, of_parameters in moves:
        slope = 0.5 * (loss(phase + of_phase, start + of_parameters) - loss(phase - of_phase, start - of_parameters))
        found = np.sum(by_phase * of_phase) + np.dot(by_parameters, of_parameters)
        assert abs(found - slope) < 0.02 * abs(slope), (found, slope)


def test_whole_fields_refuse_a_hybrid_lens() -> None:
    system = hybrid(np.zeros((SIDE, SIDE))).settings(method="beamlet")
    try:
        system.simulate()
    except raylet.RayletError as refusal:
        assert "local_bands" in str(refusal)
    else:
        raise AssertionError("whole fields carried an interface")


def test_results_of_local_bands_are_described() -> None:
    result = hybrid(np.zeros((SIDE, SIDE))).simulate()
    assert result.methods == ["local_bands", "local_bands"]
    share = result.power_share[0]
    assert share is not None and 0.0 < share < 1.0
    assert f"{share:.2%} of the light on the sensor, expected field error" in repr(result)


WAVE, PITCH, COUNT, DISTANCE = 0.5e-3, 8e-3, 24, 6.0

#: A side along pixels, and one that cuts them.
WHOLE, CUT = COUNT * PITCH, 0.1773


def nodes_of(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Four Gauss nodes and their weights in each cell between some edges."""
    at, weight = np.polynomial.legendre.leggauss(4)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (1.0 + at)).ravel(), (half * weight).ravel()


def shares(form: str, x: np.ndarray) -> np.ndarray:
    """What each pixel [node, pixel] gives to the values at places."""
    place = x[:, None] / PITCH + 0.5 * (COUNT - 1) - np.arange(COUNT)
    if form == "box":
        return (abs(place) < 0.5).astype(float)
    if form == "bilinear":
        inside = np.clip(x / PITCH + 0.5 * (COUNT - 1), 0.0, COUNT - 1.0)
        return np.maximum(0.0, 1.0 - abs(inside[:, None] - np.arange(COUNT)))

    # A sinc under a window over the twelve samples around a place.
    below = np.floor(x / PITCH + 0.5 * (COUNT - 1))[:, None]
    seen = (np.arange(COUNT) > below - 6) & (np.arange(COUNT) <= below + 6)
    fall = np.exp(9.0 * (np.sqrt(np.maximum(0.0, 1.0 - (place / 6.0) ** 2)) - 1.0))
    return np.where(seen, np.sinc(place) * fall, 0.0)


def summed(transmission: np.ndarray, x: np.ndarray, weight: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The field of a transmission at nodes x and x under a plane wave, at points [y, x] of a plane."""
    k = 2.0 * np.pi / WAVE
    lit = transmission * weight[:, None] * weight
    found = np.zeros((len(points), len(points)), complex)
    for j, b in enumerate(points):
        for i, a in enumerate(points):
            r = np.sqrt((a - x) ** 2 + (b - x)[:, None] ** 2 + DISTANCE**2)
            found[j, i] = (lit * np.exp(1j * k * r) * DISTANCE / r**2 * (1.0 / r - 1j * k)).sum() / (2.0 * np.pi)
    return found


@pytest.mark.parametrize("side", [WHOLE, CUT])
@pytest.mark.parametrize("form", ["box", "gaps", "bilinear", "band_limited"])
def test_a_form_of_pixels_is_as_summed(form: str, side: float) -> None:
    rng = np.random.default_rng(5)
    phase = rng.uniform(0.0, 2.0 * np.pi, (COUNT, COUNT))
    # Edges of pixels, of their halves and of their active areas, and of the aperture.
    steps = PITCH * (np.arange(2 * COUNT + 1) / 2 - 0.5 * COUNT)
    active = PITCH * (np.arange(COUNT) - 0.5 * (COUNT - 1)) + np.array([[-0.4], [0.4]]) * PITCH
    edges = np.unique(np.clip([*steps, *active.ravel(), -0.5 * side, 0.5 * side], -0.5 * side, 0.5 * side))
    x, weight = nodes_of(edges[np.append(True, np.diff(edges) > 1e-9)])
    share = shares("box" if form == "gaps" else form, x)
    transmission = share @ np.exp(1j * phase) @ share.T
    keys: dict[str, Any] = {"pixel": "box" if form == "gaps" else form}
    if form == "gaps":
        keys |= {"fill": 0.64, "rest": "flat"}
        place = x / PITCH + 0.5 * (COUNT - 1)
        inside = abs(place - np.round(place)) < 0.4
        transmission = np.where(inside[:, None] & inside, transmission, 1.0)

    system = raylet.System(wavelength_um=1e3 * WAVE)
    system.add_doe(
        raylet.pixels(pitch_um=1e3 * PITCH, phase=phase, **keys),
        aperture=raylet.rectangle(side, side),
        thickness_mm=DISTANCE,
    ).add_sensor(pixels=(8, 8), pitch_um=40.0)
    exact = summed(transmission, x, weight, 0.04 * (np.arange(8) - 3.5))
    for method, limit in (("auto", 2e-5), ("beamlet", 8e-4), ("local_bands", 8e-4)):
        found = system.simulate(method=method)
        off = np.linalg.norm(found.field - exact) / np.linalg.norm(exact)
        assert off < limit, (method, off)
        assert off < 2.0 * found.error + 2e-5, (method, off, found.error)
