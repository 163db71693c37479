"""Long calls: progress, Ctrl-C, threads, forks, and memory that stays where it is."""

from __future__ import annotations

import gc
import os
import resource
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import ROOT, noise, through_lens

import raylet


def test_progress_is_reported_and_may_end_the_call() -> None:
    system = through_lens(noise((20, 20)))
    reported: list[tuple[float, str]] = []

    class Enough(Exception):
        pass

    def progress(done: float, what: str) -> None:
        reported.append((done, what))
        if done > 0.0:
            raise Enough

    with pytest.raises(Enough):
        system.simulate(progress=progress)
    assert all(0.0 <= done <= 1.0 for done, _ in reported) and "element[3]" in reported[-1][1]
    with pytest.raises(TypeError, match="progress is str"):
        system.simulate(progress="yes")


def test_other_python_threads_go_on() -> None:
    """The lock is released: a thread counts while a run is computed."""
    system = through_lens(noise((40, 40)), pixels=(64, 64))
    count, done = 0, threading.Event()

    def work() -> None:
        system.simulate()
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        count += 1
        time.sleep(0.001)
    thread.join()
    assert count > 20


def test_calls_from_several_threads_at_once() -> None:
    """Runs and gradients of one system side by side, on threads of several numbers, give what they give alone."""
    system = through_lens(noise((10, 10)))
    linearised, alone = system.linearised("hologram"), system.simulate().field
    passage = linearised(noise((10, 10)))
    (gradient,), _ = passage.adjoint(passage.field)
    same: list[bool] = []

    def work(threads: int) -> None:
        same.append(np.array_equal(system.simulate(threads=threads, progress=False).field, alone))
        (found,), _ = passage.adjoint(passage.field)
        same.append(np.array_equal(found, gradient))

    workers = [threading.Thread(target=work, args=(1 + number % 3,)) for number in range(6)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert same == [True] * 12


def test_threads_do_not_change_a_bit() -> None:
    system = through_lens(noise((20, 20)))
    assert np.array_equal(system.simulate(threads=1).field, system.simulate(threads=3).field)


INTERRUPTED = """
    import os, signal, threading, time
    import numpy as np, raylet
    # Where the tests run in the background of a shell, Ctrl-C is ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    system = raylet.load("scenes/paper/system1.toml")
    sent = []
    def interrupt():
        time.sleep(AFTER)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=interrupt, daemon=True).start()
    try:
        CALL
        print("finished")
    except KeyboardInterrupt:
        print("after", time.monotonic() - sent[0])
    small = raylet.System(wavelength_um=0.5)
    small.add_doe(raylet.vortex(charge=1), aperture=raylet.disc(0.1), thickness_mm=5.0)
    small.add_sensor(pixels=(8, 8), pitch_um=4.0)
    print("then", abs(small.simulate().field).max() > 0.0)
"""


def run(code: str) -> str:
    """What a fresh interpreter says."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", textwrap.dedent(code)]
    return subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300, check=True
    ).stdout


@pytest.mark.parametrize(
    "call, seconds",
    [
        ("system.simulate(method='paper', target_error=1e-6)", "1.5"),
        ("system.trace(Px=np.linspace(-0.5, 0.5, 10_000_000), parts=-1, threads=1)", "0.5"),
        ("raylet.load('scenes/paper/fig5.toml').design()", "1.5"),
    ],
)
def test_ctrl_c_ends_a_call_within_half_a_second(call: str, seconds: str) -> None:
    after, then = run(INTERRUPTED.replace("CALL", call).replace("AFTER", seconds)).splitlines()
    assert float(after.split()[1]) < 0.5
    assert then == "then True"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_can_compute() -> None:
    code = """
        import os, numpy as np, raylet
        system = raylet.System(wavelength_um=0.5)
        system.add_doe(raylet.vortex(charge=1), aperture=raylet.disc(0.1), thickness_mm=5.0)
        system.add_sensor(pixels=(8, 8), pitch_um=4.0)
        here = system.simulate().field
        child = os.fork()
        if child == 0:
            os._exit(0 if np.array_equal(system.simulate().field, here) else 1)
        print(os.waitpid(child, 0)[1])
    """
    assert run(code).strip() == "0"


def resident() -> float:
    """Memory of this process now, in MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs Linux")
def test_memory_does_not_grow() -> None:
    """Nothing stays of a hundred runs, designs and gradients: each has fields of 983 kB, and most of what a call costs
    is its plan, which does not depend on their size. An eighth of a field for each call is allowed."""
    system = raylet.System(wavelength_um=0.7).settings(target_error=1e-2)
    layer = raylet.pixels(pitch_um=8.0, phase=noise((4, 4)))
    system.add_doe(layer, aperture=raylet.rectangle(0.032, 0.032), thickness_mm=20.0, name="doe")
    system.add_sensor(pixels=(256, 240), pitch_um=0.25)
    linearised, phase = system.linearised("doe"), noise((4, 4))

    def left_behind(call: object, times: int) -> float:
        """Fields for each call, when the allocator has what it keeps for itself."""
        for _ in range(times // 4):
            call()
        gc.collect()
        before = resident()
        for _ in range(times):
            call()
        gc.collect()
        return (resident() - before) / (times * 256 * 240 * 16e-6)

    def gradient() -> None:
        passage = linearised(phase)
        passage.adjoint(passage.field)

    spot = {"kind": "encircled_energy", "at_mm": [[0.0, 0.0]], "radius_mm": 0.01}
    task = {"element": [{"name": "doe"}], "loss": [spot], "iterations": 1}
    assert left_behind(gradient, 40) < 0.125
    assert left_behind(lambda: system.design(**task, progress=False), 60) < 0.125
    assert left_behind(lambda: system.simulate(progress=False), 40) < 0.125
