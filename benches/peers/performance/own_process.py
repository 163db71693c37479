"""Figures of runs that each have a process of their own, so that the memory of one does not hide that of another."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Figures:
    """What a run took, and what it returned."""

    seconds: float
    processor_seconds: float
    megabytes: float
    found: Any


def in_own_process(prepare: Callable[..., Callable[[], Any]], *arguments: Any, runs: int = 3) -> Figures:
    """The least times of several calls of what `prepare` returns in a new process, and the most memory that it took.

    Memory counts from what the process holds when it begins to call, modules and inputs, to the most that it holds.
    """
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(measured, partial(prepare, *arguments), runs).result()


def measured(prepare: Callable[[], Callable[[], Any]], runs: int) -> Figures:
    run = prepare()
    before = status("VmRSS")
    # The most that was held is counted anew.
    Path("/proc/self/clear_refs").write_text("5")
    figures = []
    for _ in range(runs):
        begin, processor = time.perf_counter(), time.process_time()
        found = run()
        figures.append((time.perf_counter() - begin, time.process_time() - processor))
        if len(figures) < runs:
            del found
    least = [min(column) for column in zip(*figures, strict=True)]
    return Figures(least[0], least[1], (status("VmHWM") - before) / 1e3, found)


def status(name: str) -> float:
    """A figure of this process in kB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith(name))
