"""Single rays: signs, units, fates and derivatives."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import raylet


def singlet() -> raylet.System:
    return (
        raylet.System(wavelength_um=0.7)
        .add_surface(radius_mm=25.8, thickness_mm=5.3, glass=1.5, semi_aperture_mm=12.7)
        .add_surface(thickness_mm=46.5, semi_aperture_mm=12.7)
        .add_sensor(pixels=(8, 8), pitch_um=10.0)
    )


def test_snell_by_hand() -> None:
    """One ray through a sphere and a plane, by the textbook."""
    rays = singlet().trace(Px=0.4)
    h, radius, thick = 0.4 * 12.7, 25.8, 5.3
    n = 1.5
    inside = np.arcsin(h / radius) - np.arcsin(h / radius / n)
    sag = radius - np.sqrt(radius**2 - h**2)
    at_back = h - (thick - sag) * np.tan(inside)
    assert rays.x[2, 0] == pytest.approx(at_back, abs=1e-12)
    assert rays.L[2, 0] == pytest.approx(-n * np.sin(inside), abs=1e-12)
    assert rays.opl_mm[2, 0] == pytest.approx(sag + n * (thick - sag) / np.cos(inside), abs=1e-12)


def test_ideal_diffractive_focus_has_one_optical_path() -> None:
    """Fermat: the phase adds φ/k to the path, so all paths to the focus are alike."""
    system = (
        raylet.System(wavelength_um=0.5)
        .add_doe(raylet.lens(focal_length_mm=10.0), aperture=raylet.disc(4.0), thickness_mm=10.0)
        .add_sensor(pixels=(3, 3), pitch_um=1.0)
    )
    rays = system.trace(Px=np.linspace(-1.0, 1.0, 9))
    assert np.ptp(rays.opl_mm[-1]) < 1e-12 and np.abs(rays.x[-1]).max() < 1e-12
    # At the focus sin θ is exactly that of the grating equation.
    assert rays.L[0, -1] == pytest.approx(-4.0 / np.hypot(4.0, 10.0), abs=1e-12)


def test_positive_orders_turn_towards_plus_x_and_fields_tilt_towards_plus() -> None:
    system = (
        raylet.System(wavelength_um=0.5)
        .add_doe(raylet.grating(period_um=5.0), aperture=raylet.disc(1.0), thickness_mm=10.0)
        .add_sensor(pixels=(3, 3), pitch_um=1.0)
    )
    rays = system.trace(Hy=[0.0, 1.0], field_deg=2.0)
    assert rays.L[0] == pytest.approx([0.1, 0.1]) and rays.y[-1, 1] > 0.3
    assert rays.M[0, 1] == pytest.approx(np.sin(np.radians(2.0)))


def test_lost_rays_are_reported() -> None:
    rays = singlet().trace(Px=[0.0, 0.9, 2.1], Py=[0.0, 0.9, 0.0])
    assert list(rays.fate) == [0, 1, 1] and np.isnan(rays.x[-1, 1:]).all()
    assert "1 arrived, 2 clipped" in repr(rays)


def test_derivatives_are_refused_where_elements_turn_rays() -> None:
    system = raylet.System(wavelength_um=0.7)
    system.add_doe(raylet.lens(focal_length_mm=5.0), aperture=raylet.disc(0.1), thickness_mm=4.0, name="lens")
    system.add_sensor(pixels=(3, 3), pitch_um=1.0)
    with pytest.raises(raylet.RayletError, match="element 'lens' turns"):
        system.trace(Px=0.5, derivatives="element[0].thickness_mm")
    with pytest.raises(IndexError, match="channel is -1, expected from 0 to 0"):
        system.trace(Px=0.5, channel=-1)


def test_derivatives_match_differences() -> None:
    paths = ["element[0].radius_mm", "element[0].thickness_mm"]
    rays = singlet().trace(Px=[0.3, 0.5], Hy=0.5, field_deg=5.0, derivatives=paths)

    def landing(curvature: float, thickness: float) -> np.ndarray:
        system = singlet()
        system._document["element"][0].update(radius_mm=1 / curvature, thickness_mm=thickness)
        moved = system.trace(Px=[0.3, 0.5], Hy=0.5, field_deg=5.0)
        return np.stack([moved.x[-1], moved.y[-1], moved.L[-1], moved.M[-1], moved.opl_mm[-1]])

    for path, step in zip(paths, ([1e-6, 0.0], [0.0, 1e-4])):
        here = np.array([1 / 25.8, 5.3])
        slope = (landing(*(here + step)) - landing(*(here - step))) / (2 * sum(step))
        assert rays.derivatives[path] == pytest.approx(slope, rel=2e-7, abs=1e-7)


@pytest.mark.parametrize("flat", [False, True])
def test_gradients_of_a_loss_are_sums_of_derivatives(flat: bool) -> None:
    """By many rays at once, and by single rays for the curvature of a plane; some rays are lost."""
    system = raylet.System(wavelength_um=0.7)
    system.add_surface(radius_mm=25.8, thickness_mm=5.3, glass=1.5, semi_aperture_mm=12.7)
    system.add_surface(radius_mm=float("inf"), thickness_mm=46.5, semi_aperture_mm=12.7)
    system.add_sensor(pixels=(8, 8), pitch_um=10.0)
    paths = [f"element[{flat:d}].radius_mm", "element[0].thickness_mm"]
    random = np.random.default_rng(5)
    rays = system.trace(*random.uniform(-1.2, 1.2, (4, 700)), field_deg=3.0, derivatives=paths)
    assert 100 < rays.arrived.sum() < 700
    weights = random.normal(size=(5, 700))
    weights[:, ~rays.arrived] = np.nan
    gradient = rays.adjoint(paths, **dict(zip(("x", "y", "L", "M", "opl_mm"), weights)))
    for path, found in zip(paths, gradient):
        products = (weights * rays.derivatives[path])[:, rays.arrived]
        assert found == pytest.approx(products.sum(), abs=1e-11 * np.abs(products).sum())
    assert rays.adjoint(paths[1], opl_mm=1.0)[0] == pytest.approx(
        rays.derivatives[paths[1]][4, rays.arrived].sum(), rel=1e-11
    )
    again = pickle.loads(pickle.dumps(rays)).adjoint(paths, x=weights[0])
    assert np.array_equal(again, rays.adjoint(paths, x=weights[0]))


def test_threads_change_no_bit_of_a_gradient() -> None:
    Px, Py = np.random.default_rng(5).uniform(-0.7, 0.7, (2, 9000))
    found = [
        singlet().trace(Px=Px, Py=Py, threads=threads).adjoint("element[0].radius_mm", x=Px, opl_mm=Py)
        for threads in (1, 3)
    ]
    assert found[0] == found[1]


def test_gradients_are_of_the_system_that_was_traced() -> None:
    system = singlet()
    rays = system.trace(Px=[0.1, 0.3])
    before = rays.adjoint("element[0].radius_mm", x=[1.0, -1.0])
    system._document["element"][0].update(radius_mm=40.0)
    system._scene = None
    assert np.array_equal(before, rays.adjoint("element[0].radius_mm", x=[1.0, -1.0]))


def test_what_no_loss_has_is_refused() -> None:
    rays = singlet().trace(Px=[0.1, 0.3])
    with pytest.raises(ValueError, match=r"y has shape \(3,\), expected \(2,\), or one number"):
        rays.adjoint("element[0].radius_mm", y=[1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="L holds numbers that are not finite for rays that arrived"):
        rays.adjoint("element[0].radius_mm", L=[1.0, np.nan])
    with pytest.raises(raylet.RayletError, match=r"^Rays.adjoint: found 'element\[9\].radius_mm', expected the path"):
        rays.adjoint("element[9].radius_mm", x=1.0)


def test_fields_need_a_scale() -> None:
    system = singlet()
    with pytest.raises(ValueError, match="Hx, Hy need a scale, expected field_deg"):
        system.trace(Hy=1.0)
    with pytest.raises(ValueError, match=r"System.trace: field_deg has shape \(2,\), expected one number"):
        system.trace(Hy=1.0, field_deg=(14.0, 0.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="go together"):
        system.trace(Px=[0.0, 1.0], Py=[0.0, 1.0, 2.0])


def test_waves_and_rays_have_the_direction_of_the_source() -> None:
    """In one place, for both: light at 3° lands 20 mm · tan 3° aside. Elsewhere it is refused."""
    system = raylet.System(wavelength_um=0.5).plane_wave(angle_deg=(3.0, 0.0))
    system.add_doe(raylet.lens(focal_length_mm=20.0), aperture=raylet.disc(0.5), thickness_mm=20.0)
    system.add_sensor(pixels=(31, 31), pitch_um=4.0, decenter_mm=(20.0 * np.tan(np.radians(3.0)), 0.0))
    field = system.simulate().intensity
    assert np.unravel_index(field.argmax(), field.shape) == (15, 15)
    assert system.trace().x[-1, 0] == pytest.approx(20.0 * np.tan(np.radians(3.0)), abs=2e-3)
    for keys in ({"field_deg": 14.0}, {"field_deg": (14.0, 0.0)}, {"field_mm": 1.0}):
        with pytest.raises(TypeError, match=r"System has no argument 'field_\w+'; the .* for waves and rays"):
            raylet.System(0.5, **keys)


def test_rays_start_at_points_in_mm_with_cosines() -> None:
    """The ray of the pupil that starts 3 mm earlier has the same course and 3 mm more of path."""
    system = singlet()
    pupil = system.trace(Px=0.4)
    rays = system.trace(start_mm=[0.4 * 12.7, 0.0, -3.0], cosines=[0.0, 0.0, 1.0])
    for name in ("x", "y", "z", "L", "M", "N"):
        assert getattr(rays, name) == pytest.approx(getattr(pupil, name), abs=1e-12)
    assert rays.opl_mm - pupil.opl_mm == pytest.approx(3.0, abs=1e-12)
    none = system.trace(start_mm=np.zeros((0, 3)), cosines=[0.0, 0.0, 1.0])
    assert none.x.shape == (len(none.names), 0) and none.fate.shape == (0,)
    fan = system.trace(start_mm=[0.0, 1.0, -50.0], cosines=[[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, 0.0, -1.0]])
    assert [raylet.trace.FATES[fate] for fate in fan.fate] == ["arrived", "clipped", "missed"]
    tilted = system.trace(start_mm=[0.0, 0.0, -10.0], cosines=[0.0, 0.06, np.sqrt(1.0 - 0.06**2)])
    assert tilted.y[0, 0] == pytest.approx(10.0 * 0.06 / np.sqrt(1.0 - 0.06**2), abs=1e-12)


def test_starts_are_refused_that_are_none() -> None:
    system = singlet()
    straight, start = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]
    refused: list[tuple[type[Exception], str, dict[str, object]]] = [
        (TypeError, "together", {"start_mm": start}),
        (TypeError, "in place of", {"start_mm": start, "cosines": straight, "Px": 0.3}),
        (ValueError, "length 2", {"start_mm": start, "cosines": [0.0, 0.0, 2.0]}),
        (ValueError, r"shape \(2,\)", {"start_mm": [0.0, 1.0], "cosines": straight}),
        (ValueError, "2 start_mm for 3 cosines", {"start_mm": [start] * 2, "cosines": [straight] * 3}),
        (ValueError, "not finite", {"start_mm": [0.0, 0.0, np.nan], "cosines": straight}),
    ]
    for kind, words, given in refused:
        with pytest.raises(kind, match=words):
            system.trace(**given)


def test_rays_at_chosen_parts() -> None:
    """Names, numbers, and numbers from the end; several parts may have one name."""
    system = singlet()
    everywhere = system.trace(Px=np.linspace(-0.9, 0.9, 1001), Py=0.1)
    for parts, numbers in ((-1, [3]), ("element[0]", [1]), ([0, "element[1]", -1], [0, 2, 3]), ([], [])):
        rays = system.trace(Px=np.linspace(-0.9, 0.9, 1001), Py=0.1, parts=parts)
        assert rays.names == [everywhere.names[number] for number in numbers]
        for key in ("x", "y", "z", "L", "M", "N", "opl_mm"):
            assert np.array_equal(getattr(rays, key), getattr(everywhere, key)[numbers], equal_nan=True)
        assert np.array_equal(rays.fate, everywhere.fate)
    for wrong in ("sensor", 4, -5, [True], [1.0]):
        with pytest.raises(ValueError, match="System.trace: parts holds"):
            system.trace(parts=wrong)  # type: ignore[arg-type]
