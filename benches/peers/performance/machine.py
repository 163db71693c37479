"""The machine at hand: its name, and the most that one of its cores does."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]

#: Rows of the matrices whose product is timed, and numbers of the arrays that are copied.
MATRIX, COPIED = 2000, 30_000_000

#: Prints the operations of a product of matrices and the bytes of a copy, each second, in 1e9.
LIMITS = f"""
import time, numpy as np
def best(run):
    seconds = []
    for _ in range(7):
        begin = time.perf_counter(); run(); seconds.append(time.perf_counter() - begin)
    return min(seconds)
a = np.random.default_rng(0).random(({MATRIX}, {MATRIX})); out = np.empty_like(a)
print(2 * {MATRIX}**3 / best(lambda: np.matmul(a, a, out=out)) / 1e9)
x = np.ones({COPIED}); y = np.zeros_like(x)
print(16 * {COPIED} / best(lambda: np.copyto(y, x)) / 1e9)
"""


def name() -> str:
    """The processor with its vector instructions."""
    processor = Path("/proc/cpuinfo").read_text()
    model = re.search(r"model name\s*: (.*)", processor)
    machine = model[1] if model else platform.processor()
    widest = next((name for name in ("avx512_vnni", "avx2") if f" {name} " in processor), "sse2")
    return f"{machine} with {widest}"


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0))


def limits() -> tuple[float, float]:
    """What one core does each second, in 1e9: operations of NumPy's product of matrices in double precision, and bytes
    that a copy reads and writes."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    command = [sys.executable, "-c", LIMITS]
    printed = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout
    operations, copied = map(float, printed.split())
    return operations, copied
