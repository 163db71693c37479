"""Random tasks of a scene: holograms and designs."""

from __future__ import annotations

from fuzz.draft import Draft


def hologram(draft: Draft, sensor: dict) -> dict:
    """A target picture for the sensor, mostly not larger than that."""
    table: dict = {"target": draft.picture("target"), "element": "first", "iterations": draft.whole(1, 8)}
    pitch = sensor["pitch_um"] if isinstance(sensor["pitch_um"], list) else [sensor["pitch_um"]] * 2
    table["size_mm"] = [1e-3 * step * count * draft.number(0.3, 1.02) for step, count in zip(pitch, sensor["pixels"])]
    rare = {
        "efficiency_goal": draft.number(0.05, 0.9),
        "principal_planes": draft.chance(0.5),
        "invert": draft.chance(0.5),
        "flip_x": True,
        "flip_y": True,
    }
    return table | {name: one for name, one in rare.items() if draft.chance(0.15)}


def design(draft: Draft, tree: dict, free: str) -> dict:
    """What is free, and the losses."""
    table: dict = {"iterations": draft.whole(1, 3), "checkpoint": draft.whole(1, 2)}
    table["optimizer"] = draft.pick(["lbfgs", "adam", "momentum"])
    if table["optimizer"] != "lbfgs":
        table["rate"] = draft.scale(0.01, 1)
    views = [{"angle_deg": draft.pair(1)} for _ in range(2)]
    if tree["source"]["kind"] == "plane" and draft.chance(0.2):
        table["field"] = views
    if free != "phase" or draft.chance(0.5):
        table |= {"element": [part(draft, free)], "loss": [loss(draft) for _ in range(draft.weighted({1: 4, 2: 1}))]}
    else:
        rare = {"start": draft.pick(["spread", "random", "paraxial", "flat"]), "efficiency": draft.number(0, 0.1)}
        rare |= {"levels": draft.whole(2, 8), "block": draft.whole(1, 3)}
        table |= {name: one for name, one in rare.items() if draft.chance(0.25)}
    if draft.chance(0.35):
        table["variable"] = variables(draft, tree)
    elif table["optimizer"] != "lbfgs" and draft.chance(0.2):
        kind = draft.pick(["control_variate", "without_replacement", "multinomial", "gumbel"])
        table["estimator"] = {"kind": kind, "each": draft.whole(1, 20)}
    return table


def part(draft: Draft, free: str) -> dict:
    """The element whose pixels are designed."""
    table: dict = {"name": "first", "free": free}
    rare = {
        "start": draft.pick(["random", "flat"]),
        "levels": draft.whole(2, 8),
        "block": draft.whole(1, 3),
        "blur": draft.number(1, 3),
        "smoothness": draft.scale(1e-3, 1),
    }
    return table | {name: one for name, one in rare.items() if draft.chance(0.2)}


def loss(draft: Draft) -> dict:
    """What the light on the sensor is to be like."""
    kind = draft.pick(["likeness", "mse", "efficiency", "encircled_energy", "spot", "overlap"])
    at = {"at_mm": [draft.pair(0.003) for _ in range(draft.whole(1, 2))]}
    size = {"picture": draft.picture("wanted"), "size_mm": [draft.scale(0.003, 0.03)] * 2}
    keys = {
        "likeness": {**size, "care": draft.pick(["sensor", "outline"])},
        "mse": size | ({"scale": draft.scale(0.1, 10)} if draft.chance(0.5) else {}),
        "efficiency": {**at, "radius_mm": draft.scale(0.002, 0.02)},
        "encircled_energy": {**at, "radius_mm": draft.scale(0.002, 0.02)},
        "spot": {**at, "sharing": draft.pick(["linear", "log"]), "evenness": draft.pick([0.0, 0.5])},
        "overlap": size,
    }
    return {"kind": kind, **keys[kind], **({"weight": draft.scale(0.1, 10)} if draft.chance(0.2) else {})}


def variables(draft: Draft, tree: dict) -> list[dict]:
    """Numbers of the lens or of the way to it."""
    paths = ["element[0].thickness_mm"]
    for number, element in enumerate(tree["element"]):
        if element["kind"] == "lens":
            paths += [f"element[{number}].surface[0].{key}" for key in ("radius_mm", "conic", "thickness_mm")]
    return [{"path": draft.pick(paths), "scale": draft.scale(1e-4, 1e-2)}]
