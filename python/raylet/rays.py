"""raylet's elements in any ray tracer: two calls, each with its transpose, arrays in and arrays out.

1. :func:`scatter`: rays arrive at a diffractive element of a system and become secondary rays.
2. The other tracer follows these to the sensor, through whatever stands there.
3. :func:`beams` makes beamlets of what arrives, from the tracer's Jacobians, and :func:`gather` sums it on the sensor.

The system says where the element and the sensor stand; what lies between them is the other tracer's affair. Positions
are (rays, 3) in mm and directions (rays, 3) unit vectors in the system's global frame: right-handed, the first vertex
at the origin, +z along the axis. Optical paths (rays,) are index × length in mm; a ray carries weight · exp(ik
path). docs/rays.md has the whole account.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import column, columns, complex_column, number, numbers, real
from raylet._calls import public_call
from raylet._refusal import described

if TYPE_CHECKING:
    from raylet.system import System

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Secondary:
    """Rays that leave an element; every array has one entry for each, those of one parent together.

    Attributes
    ----------
    position, direction, path_mm, weight : as of the rays that arrived; the path is the parent's.
    window : (rays, 3) xx, xy, yy in mm⁻² of the Gaussian exp(−½uᵀWu) with which each beamlet starts.
    cosine : against the element's normal, positive.
    axes : (rays, 3, 3) x, y and z axes of the plane that touches the element where each starts.
    parent : index of the arriving ray.
    dropped : share of the field that weak modes had, which were left out.
    unevenness : of the arriving rays, near 1 where they are evenly spread; above 3 there is a gap.
    """

    position: Real
    direction: Real
    path_mm: Real
    weight: Complex
    window: Real
    cosine: Real
    axes: Real
    parent: NDArray[np.int64]
    dropped: float
    unevenness: float
    _call: tuple[Any, ...]
    _drawn: dict[str, Any]

    def __len__(self) -> int:
        return len(self.weight)

    def adjoint(self, weight_bar: Any) -> tuple[Complex | None, Complex]:
        """Cotangents ∂L/∂Re z + i ∂L/∂Im z of the element's pixels t [y, x] (None where it has no pixels of its own)
        and of the arriving weights, from those of the secondary weights. By phases: Im(t̄ t*)."""
        bar = complex_column("weight_bar", weight_bar, len(self))
        place, bundle, choices = self._call
        return _raylet.scatter_adjoint(place, bundle, choices, self._drawn, bar)

    @described
    def __repr__(self) -> str:
        parents = len(np.unique(self.parent))
        return f"<raylet.Secondary: {len(self)} rays from {parents}; left out {self.dropped:.1e} of the field>"


@dataclass(frozen=True, eq=False, repr=False)
class Beams:
    """Beamlets on a sensor: what the amplitude of each ray was multiplied by on the way (rays,), without the phase of
    its path, and the curvature xx, xy, yy (rays, 3) in 1/mm of exp(ik[p·u + ½uᵀGu]) along the sensor's axes."""

    amplitude: Complex
    curvature: Complex

    @described
    def __repr__(self) -> str:
        return f"<raylet.Beams: {np.size(self.amplitude)} beamlets>"


@dataclass(frozen=True, eq=False, repr=False)
class GatherBar:
    """Cotangents of what rays bring to a sensor, one for each: of the weight, of the optical path (1/mm), of the place
    on the sensor's axes (rays, 2) (1/mm), of the optical direction cosines there (rays, 2), and of the beamlets'
    amplitude and curvature (rays, 3)."""

    weight: Complex
    path_mm: Real
    at: Real
    cosines: Real
    amplitude: Complex
    curvature: Complex

    @described
    def __repr__(self) -> str:
        return f"<raylet.GatherBar: cotangents of {np.size(self.weight)} rays>"


def _four(name: str, values: Any) -> list[float]:
    array = real(name, values)
    if array.shape != (4,):
        raise ValueError(f"{name} has shape {array.shape}, expected four: (x_low, x_high, y_low, y_high)")
    return [float(value) for value in array]


def _place(system: System, channel: int) -> dict[str, Any]:
    return {"scene": system._compiled(), "arrays": system._arrays, "channel": system._channel(channel)}


def _bundle(position: Any, direction: Any, path_mm: Any, weight: Any) -> dict[str, Any]:
    place = columns("position", position, 3)
    rays = len(place)
    return {
        "position": place,
        "direction": columns("direction", direction, 3, rays),
        "path": column("path_mm", path_mm, rays),
        "weight": complex_column("weight", weight, rays),
    }


@public_call
def scatter(
    system: System,
    element: str,
    position: Any,
    direction: Any,
    path_mm: Any = 0.0,
    weight: Any = 1.0,
    *,
    sigma_mm: float,
    period_mm: float | None = None,
    curvature: Any = None,
    waves: bool = False,
    area_mm2: float | None = None,
    towards: tuple[float, float, float, float] | None = None,
    threshold: float = 1e-3,
    most: int | None = None,
    systematic: bool = True,
    seed: int = 1,
    channel: int = 0,
) -> Secondary:
    """Splits rays at a diffractive element of a system.

    The rays of one call are one wavefront: give them a spacing of up to 1.5 σ, and let them go on for 3 σ beyond the
    rim.

    Parameters
    ----------
    sigma_mm : width of the Gaussian window, field exp(−u²/2σ²).
    period_mm : directions are λ/period apart; 6 σ by default.
    curvature : (rays, 3) second derivatives xx, xy, yy in 1/mm of the arriving light's optical path, where it is not
        collimated.
    waves : whether what is gathered are plane waves instead of beamlets.
    area_mm2 : the area of each ray, where rays are evenly spread; by default the windows share the element.
    towards : optical cosines to follow (x_low, x_high, y_low, y_high) on the element's axes.
    threshold : modes below this share of the strongest are left out.
    most, systematic, seed : at most so many modes at each ray, drawn without or with replacement.
    """
    bundle = _bundle(position, direction, path_mm, weight)
    bent = None if curvature is None else columns("curvature", curvature, 3, len(bundle["path"]))
    choices = {
        "sigma": number("sigma_mm", sigma_mm),
        "period": 6.0 * number("sigma_mm", sigma_mm) if period_mm is None else number("period_mm", period_mm),
        "waves": bool(waves),
        "area": None if area_mm2 is None else number("area_mm2", area_mm2),
        "towards": None if towards is None else _four("towards", towards),
        "threshold": number("threshold", threshold),
        "most": most,
        "systematic": bool(systematic),
        "seed": seed,
        "curvature": bent,
    }
    call = (_place(system, channel) | {"element": element}, bundle, choices)
    made = _raylet.scatter(*call)
    drawn = {key: made[key] for key in ("parent", "mode", "times")}
    own = {key: made[key] for key in ("position", "direction", "weight", "window", "cosine", "axes", "parent")}
    rest = {"dropped": made["dropped"], "unevenness": made["unevenness"], "_call": call, "_drawn": drawn}
    return Secondary(path_mm=made["path"], **own, **rest)


@public_call
def beams(
    system: System,
    position: Any,
    direction: Any,
    *,
    jacobian: Any,
    window: Any,
    cosine: Any,
    images: Any = None,
    channel: int = 0,
) -> Beams:
    """The beamlets of rays where they meet the sensor, from what the tracer knows of their way.

    Parameters
    ----------
    jacobian : (rays, 4, 4) ∂(s, p′)/∂(u, p): rows s_x, s_y (mm), p′_x, p′_y on the sensor's axes, columns u_x, u_y,
        p_x, p_y on the axes of the plane that touches the element; p are optical cosines (index × cosine).
    window, cosine : of the secondary rays.
    images : how many images of its starting point each ray has passed, counted for both transverse directions.
    """
    bundle = _bundle(position, direction, 0.0, 1.0)
    rays = len(bundle["path"])
    matrices = real("jacobian", jacobian)
    if matrices.shape != (rays, 4, 4):
        raise ValueError(f"jacobian has shape {matrices.shape}, expected ({rays}, 4, 4)")
    passed = None if images is None else column("images", images, rays).astype(np.int64)
    ways = {
        "jacobian": matrices,
        "window": columns("window", window, 3, rays),
        "cosine": column("cosine", cosine, rays),
        "images": passed,
    }
    return Beams(*_raylet.beams(_place(system, channel), bundle, ways))


def _sum(beams: Beams | None, wavelet: str | None, tolerance: float) -> dict[str, Any]:
    chosen = wavelet or ("plain" if beams is None else "beamlet")
    held: dict[str, Any] = {"amplitude": None, "curvature": None}
    if beams is not None:
        bent = np.ascontiguousarray(numbers("curvature", beams.curvature), dtype=np.complex128)
        held = {"amplitude": complex_column("amplitude", beams.amplitude, len(bent)), "curvature": bent}
    return {"wavelet": chosen, "tolerance": number("tolerance", tolerance), **held}


@public_call
def gather(
    system: System,
    position: Any,
    direction: Any,
    path_mm: Any,
    weight: Any,
    *,
    beams: Beams | None = None,
    wavelet: str | None = None,
    tolerance: float = 1e-3,
    channel: int = 0,
) -> Complex:
    """The field [y, x] that rays bring to the pixel centres of a system's sensor, where they meet it.

    Parameters
    ----------
    beams : of these rays; without them each is a plane wave, which is right behind empty space alone.
    wavelet : "beamlet" (with beams the default), "prefactor" (plane waves with the beamlets' prefactor) or "plain".
    tolerance : beamlets end where they fall below this share of their peak; plane waves are summed to this error.
    """
    bundle = _bundle(position, direction, path_mm, weight)
    return _raylet.gather(_place(system, channel), bundle, _sum(beams, wavelet, tolerance))


@public_call
def gather_adjoint(
    system: System,
    position: Any,
    direction: Any,
    path_mm: Any,
    weight: Any,
    field_bar: Any,
    *,
    beams: Beams | None = None,
    wavelet: str | None = None,
    tolerance: float = 1e-3,
    channel: int = 0,
) -> GatherBar:
    """The transpose of :func:`gather`: cotangents of what rays bring from that of the field."""
    bundle = _bundle(position, direction, path_mm, weight)
    bar = numbers("field_bar", field_bar).astype(np.complex128, copy=False)
    if bar.ndim != 2:
        raise ValueError(f"field_bar has shape {bar.shape}, expected two axes [y, x]")
    back = _raylet.gather_adjoint(_place(system, channel), bundle, _sum(beams, wavelet, tolerance), bar)
    return GatherBar(path_mm=back.pop("path"), **back)
