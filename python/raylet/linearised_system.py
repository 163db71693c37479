"""A system as a function of pixels and parameters, with its gradient: for any framework, or none."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from raylet import _raylet
from raylet._arrays import Grid, grid, numbers, real
from raylet._document import element_names
from raylet._refusal import RayletError, described, shown
from raylet.layers import pixel_shape

if TYPE_CHECKING:
    from raylet.system import System

Field = NDArray[np.complex128]


class Passage:
    """A forward pass through a linearised system: its field, and gradients of losses of it.

    Attributes
    ----------
    field : complex field at the sensor's pixels, [y, x], or [wavelength, y, x] for a system made for a list of them.
    """

    def __init__(self, field: Field, fields: list[Field], passage: _raylet.Passage, threads: int | None) -> None:
        self.field = field
        self._shapes = [one.shape for one in fields]
        self._passage, self._threads = passage, threads

    def adjoint(self, field_bar: Any) -> tuple[list[Grid], NDArray[np.float64]]:
        """The gradient of a real loss L from its cotangent ∂L/∂Re U + i ∂L/∂Im U, shaped like :attr:`field`.

        Returns one array for each element, float64 by its phases where these were given, complex128 ∂L/∂Re t + i
        ∂L/∂Im t by its transmissions where those were; and the derivatives by the parameters.
        """
        bar = numbers("field_bar", field_bar)
        if bar.shape != self.field.shape:
            raise ValueError(f"field_bar has shape {bar.shape}, expected {self.field.shape}")
        bars = [bar] if bar.ndim == 2 else list(bar)
        pixels, parameters = self._passage.adjoint([grid("field_bar", one) for one in bars], self._threads)
        return pixels, np.array(parameters, dtype=np.float64)

    @described
    def __repr__(self) -> str:
        return f"<raylet.linearised_system.Passage, field {' x '.join(map(str, self.field.shape))}>"


class LinearisedSystem:
    """Frozen plans of a system whose pixels and parameters vary; made by :meth:`raylet.System.linearised`.

    Calling it with an array for each element (phases, or complex transmissions) and the parameters sends light through.
    What is differentiated is one fixed, smooth function: no mode is dropped for being weak, as :meth:`raylet.System.
    simulate` may do within its target error. After large changes of the parameters make a new one: the plans
    are those for the values that it was made with.

    Attributes
    ----------
    elements : names of the elements whose pixels vary.
    names : names of the parameters; of a radius the curvature varies, "1/….radius_mm".
    start : the parameters as the system has them.
    shape : of the field.
    """

    def __init__(
        self,
        system: System,
        elements: Sequence[str],
        parameters: Sequence[str],
        threads: int | None,
        scene: _raylet.Scene,
    ) -> None:
        self.elements = tuple(elements)
        self._scene, self._arrays, self._threads = scene, system._arrays, threads
        self._several = isinstance(system._document["wavelength_um"], list)
        try:
            self._inner = _raylet.LinearisedSystem(self._scene, self._arrays, list(elements), list(parameters), threads)
        except RayletError as error:
            # The library counts the parameters, and calls elements screens.
            named = re.sub(r"\bparameter (\d+)\b", lambda at: f"parameter {shown(parameters[int(at[1])])}", str(error))
            if named != str(error):
                error.args = (f"System.linearised: {named.replace('screen', 'element')}",)
            raise
        self.start: NDArray[np.float64] = np.array(self._inner.parameters(), dtype=np.float64)
        rows = dict(zip(element_names(system._document), system._document["element"]))
        self._shapes = [pixel_shape(rows.get(name, {}).get("layer") or []) for name in elements]
        nx, ny = system._document["element"][-1]["pixels"]
        waves = len(system.wavelength_um)
        self.shape: tuple[int, ...] = (waves, ny, nx) if self._several else (ny, nx)
        inverse = [path.rsplit(".", 1)[-1].startswith("radius") for path in parameters]
        self.names = tuple(f"1/{path}" if turned else path for path, turned in zip(parameters, inverse))

    def __call__(self, *pixels: Any, parameters: Any = None) -> Passage:
        """Light through the system with these pixels and parameters."""
        self._check_count(len(pixels))
        given = [grid(f"pixels of '{name}'", array) for name, array in zip(self.elements, pixels)]
        values = self.start if parameters is None else np.atleast_1d(real("parameters", parameters))
        self._check([array.shape for array in given], values.shape)
        fields, passage = self._inner.forward(self._scene, self._arrays, given, values.tolist(), self._threads)
        field = np.stack(fields) if self._several else fields[0]
        return Passage(field, fields, passage, self._threads)

    def _check_count(self, given: int) -> None:
        if given != len(self.elements):
            raise TypeError(f"{given} arrays of pixels, expected {len(self.elements)}: for {self.elements}")

    def _check(self, pixels: Sequence[tuple[int, ...]], parameters: tuple[int, ...]) -> None:
        """Refuses arrays of other shapes than the system's."""
        for name, shape, expected in zip(self.elements, pixels, self._shapes):
            if expected is not None and len(shape) == 2 and tuple(shape) != expected:
                raise ValueError(f"pixels of '{name}' have shape {tuple(shape)}, expected {expected}")
        if tuple(parameters) != self.start.shape:
            raise ValueError(f"parameters has shape {tuple(parameters)}, expected {self.start.shape}: for {self.names}")

    @described
    def __repr__(self) -> str:
        varying = [*(f"pixels of '{name}'" for name in self.elements), *self.names]
        return f"<raylet.LinearisedSystem, varying {', '.join(varying) or 'nothing'}>"
