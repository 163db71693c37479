"""Calls with arguments that make no sense, in a process of their own: run by test_fuzz.py.

Every call either returns or raises one of the exceptions that users are promised. Prints how many did which.
"""

from __future__ import annotations

import random
import sys
import warnings
from collections import Counter

import numpy as np

import raylet

#: What a call may raise: a refusal of the library (a ValueError), or Python's own words for wrong arguments.
PROMISED = (ValueError, TypeError, IndexError, OverflowError, NotImplementedError)

NUMBERS = [0, 1, -1, 2.5, 1e-300, 1e300, float("nan"), float("inf"), 2**70, True, None, "7", b"x", 1j, [], {}, object()]


def arrays(draw: random.Random) -> object:
    """An array of any kind."""
    shape = draw.choice([(), (0,), (3,), (4, 5), (5, 4), (1, 1), (0, 4), (2, 3, 4), (4, 5)])
    kind = draw.choice(["f8", "f8", "f4", ">f8", "c16", "c8", "i8", "u1", "?", "O", "U3", "M8[s]", "V8", "f2"])
    array = np.zeros(shape, dtype=kind)
    if kind in ("f8", "f4", "c16") and array.size:
        array = np.random.default_rng(draw.randrange(99)).uniform(-9, 9, shape).astype(kind)
        if draw.random() < 0.2:
            array.flat[0] = draw.choice([np.nan, np.inf, 1e308])
    turn = draw.randrange(8)
    if turn == 0:
        array = array.T
    elif turn == 1 and array.ndim == 2:
        array = array[::-1, ::2]
    elif turn == 2:
        array.setflags(write=False)
    elif turn == 3 and kind == "f8" and array.ndim == 2 and array.size:
        raw = np.zeros(array.nbytes + 1, dtype="u1")
        array = raw[1:].view("f8").reshape(shape)
    elif turn == 4 and array.ndim:
        array = np.broadcast_to(array[..., :1], array.shape)
    elif turn == 5 and kind == "f8" and array.ndim == 2:
        packed = np.zeros(shape, dtype=[("a", "f8"), ("b", "u1")])
        array = packed["a"]
    elif turn == 6:
        return array.tolist()
    return array


def anything(draw: random.Random) -> object:
    return draw.choice(
        [draw.choice(NUMBERS), arrays(draw), draw.choice(NUMBERS), "doe", "element[0].radius_mm", (1, 2)]
    )


def usual() -> dict[str, dict[str, object]]:
    """For each call the arguments that would be right."""
    rays = {"position": np.zeros((1, 3)), "direction": np.array([[0.0, 0.0, 1.0]])}
    way = {"jacobian": np.eye(4)[None], "window": np.array([[9.0, 0.0, 9.0]]), "cosine": 1.0}
    return {
        "pixels": {"pitch_um": 4.0, "phase": np.zeros((4, 5)), "amplitude": None, "pixel": "box"},
        "system": {
            "wavelength_um": 0.7,
            "ambient": "air",
            "seed": 1,
            "radius_mm": 5.0,
            "thickness_mm": 3.0,
            "glass": 1.5,
        },
        "doe": {"phase": np.zeros((4, 5)), "pitch_um": 4.0, "radius": 0.02, "thickness_mm": 3.0, "pixels": (3, 4)},
        "simulate": {
            **{"method": "auto", "target_error": 1e-2, "threads": 1, "memory_limit_mb": 100.0, "progress": False},
            **{"fields": None, "wavelengths": None, "distances": None, "follow": False},
        },
        "trace": {
            **{"Hx": 0.0, "Hy": 0.1, "Px": 0.0, "Py": 0.0},
            **{"field_deg": 1.0, "channel": 0, "derivatives": (), "threads": 1},
        },
        "trace_from": {"start_mm": np.array([[0.0, 0.0, -1.0]]), "cosines": rays["direction"], "threads": 1},
        "linearised": {"pixels": np.zeros((4, 5)), "parameters": None, "bar": np.zeros((4, 3))},
        "with_pixels": {"element": "doe", "phase": np.zeros((4, 5)), "transmission": None},
        "scatter": {"element": "doe", **rays, "path_mm": 0.0, "weight": 1.0, "sigma_mm": 0.01, "towards": None},
        "beams": {"position": np.array([[0.0, 0.0, 3.0]]), "direction": rays["direction"], **way},
        "gather": {
            "position": np.array([[0.0, 0.0, 3.0]]),
            "direction": rays["direction"],
            "path_mm": 0.0,
            "weight": 1.0,
        },
        "hologram": {
            "target": np.ones((3, 4)),
            "element": "doe",
            "size_mm": (0.01, 0.01),
            "iterations": 2,
            "efficiency_goal": None,
            "naive": False,
            "blur": None,
        },
        "design": {
            "element": [{"name": "doe"}],
            "loss": [{"kind": "spot", "at_mm": [(0.0, 0.0)]}],
            "iterations": 1,
            "variable": None,
            "field": None,
            "threads": 1,
        },
        "adjoint": {"weight_bar": np.ones(1)},
        "look": {"element": "doe", "channel": 0},
    }


def small() -> raylet.System:
    system = raylet.System(wavelength_um=0.7)
    layer = raylet.pixels(pitch_um=4.0, phase=np.zeros((4, 5)))
    system.add_doe(layer, aperture=raylet.disc(0.008), thickness_mm=3.0, name="doe")
    return system.add_sensor(pixels=(3, 4), pitch_um=5.0)


class Stage:
    """What the calls are made on."""

    def __init__(self) -> None:
        self.system = small()
        self.linearised = self.system.linearised("doe")
        places = {"position": np.zeros((1, 3)), "direction": [[0.0, 0.0, 1.0]]}
        self.made = raylet.scatter(self.system, "doe", **places, sigma_mm=0.01)

    def call(self, name: str, given: dict) -> object:
        if name == "pixels":
            return raylet.pixels(**given)
        if name == "system":
            head = {key: given.pop(key) for key in ("wavelength_um", "ambient", "seed")}
            return (
                raylet.System(**head)
                .add_surface(semi_aperture_mm=1.0, **given)
                .add_sensor(pixels=(2, 2), pitch_um=1.0)
                .parts
            )
        if name == "doe":
            layer = raylet.pixels(phase=given["phase"], pitch_um=given["pitch_um"])
            system = raylet.System(0.7).add_doe(
                layer, aperture=raylet.disc(given["radius"]), thickness_mm=given["thickness_mm"]
            )
            return system.add_sensor(pixels=given["pixels"], pitch_um=1.0).to_toml()
        if name == "linearised":
            bar = given.pop("bar")
            return self.linearised(given.pop("pixels"), **given).adjoint(bar)
        if name == "trace_from":
            return self.system.trace(**given)
        if name == "adjoint":
            return self.made.adjoint(**given)
        if name == "look":
            return self.system.transmission(**given)
        on_system = {
            "simulate": self.system.simulate,
            "trace": self.system.trace,
            "with_pixels": self.system.with_pixels,
            "hologram": self.system.hologram,
            "design": self.system.design,
        }
        if name in on_system:
            return on_system[name](**given)
        return getattr(raylet, name)(self.system, **given)


def main(count: int, seed: int) -> None:
    warnings.simplefilter("ignore")
    draw, stage, counts = random.Random(seed), Stage(), Counter()
    for number in range(count):
        calls = usual()
        # Runs that succeed take long: they are drawn less often than calls that are refused.
        name = draw.choice(sorted(calls))
        given = calls[name]
        for key in draw.sample(sorted(given), k=min(len(given), draw.choice([1, 1, 1, 2, 3]))):
            given[key] = anything(draw)
        if name == "simulate" and draw.random() < 0.9:
            given["method"] = anything(draw)
        call = f"call {number}: {name}({', '.join(f'{key}={value!r}' for key, value in given.items())})"
        try:
            stage.call(name, given)
            counts["returned"] += 1
        except PROMISED as error:
            counts[type(error).__name__] += 1
            if not str(error) or "internal error" in str(error):
                sys.exit(f"{call}\nraised {error!r}")
        except BaseException as error:
            sys.exit(f"{call}\nraised {error!r}")
    print(dict(counts), sum(counts.values()))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
