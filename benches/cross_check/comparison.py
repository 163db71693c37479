"""One system by several methods, each beside the one that is taken for exact."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from benches.cross_check.systems import random_system

import raylet

METHODS = ("local_bands", "beamlet")

# The target of the run that others are compared with.
EXACT = 1e-5


@dataclass(frozen=True)
class Row:
    """A system by one method."""

    seed: int
    system: str
    method: str
    expected: float
    """The error that the run expects."""
    error: float
    """‖U − U₀‖/‖U₀‖ on the sensor, U₀ the field of the run for comparison."""
    known_to: float
    """The error that the run for comparison expects."""
    seconds: float
    """Processor time."""
    refused: str = ""
    """Why there is no run, if there is none."""

    def is_known(self) -> bool:
        """Whether the run for comparison is exact enough to tell the error."""
        return not self.refused and self.known_to < 0.3 * max(self.error, self.expected)

    def ratio(self) -> float:
        """The error over the expected one."""
        return self.error / self.expected


def compared(seed: int) -> list[Row]:
    """The rows of a seed."""
    warnings.simplefilter("ignore")
    words, system = random_system(seed)
    try:
        exact = system.simulate(target_error=EXACT, threads=1)
    except raylet.RayletError as error:
        return [Row(seed, words, "auto", np.nan, np.nan, np.nan, np.nan, str(error))]
    return [beside(exact, system, seed, words, method) for method in METHODS]


def beside(exact: Any, system: raylet.System, seed: int, words: str, method: str) -> Row:
    """The row of a method."""
    begin = time.process_time()
    try:
        found = system.simulate(method=method, threads=1)
    except raylet.RayletError as error:
        return Row(seed, words, method, np.nan, np.nan, exact.error, np.nan, str(error))
    error = float(np.linalg.norm(found.field - exact.field) / np.linalg.norm(exact.field))
    return Row(seed, words, method, found.error, error, exact.error, time.process_time() - begin)
