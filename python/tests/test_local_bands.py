"""A hybrid lens of full size, which only local bands carry: its field and its gradient."""

from __future__ import annotations

import numpy as np

import raylet

SIDE = 100


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
