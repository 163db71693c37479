"""Random valid scenes of every kind that the format has, small enough to be done in some hundredths of a second."""

from __future__ import annotations

from fuzz.draft import Draft
from fuzz.parts import GLASSES, aperture, blank, curve, layers
from fuzz.tasks import design, hologram

#: Most memory that a scene may take, in units of 10⁶ bytes.
MEMORY_LIMIT_MB = 24


def scene(draft: Draft, verb: str) -> dict:
    """A scene that this verb can do something with."""
    waves = [draft.number(0.4, 1.1) for _ in range(draft.weighted({1: 10, 2: 1}))]
    tree: dict = {"version": 1, "wavelength_um": waves if len(waves) > 1 or draft.chance(0.2) else waves[0]}
    if draft.chance(0.5):
        tree["title"] = "A small scene"
    if draft.chance(0.1):
        tree["ambient"] = draft.pick([{"index": 1.33}, "air", "fused silica"])
    if draft.chance(0.3):
        tree["seed"] = draft.whole(0, 2**40)
    designed = verb in ("hologram", "design", "gradcheck")
    radius = draft.scale(0.003, 0.005 if designed else 0.015)
    tree["source"] = source(draft)
    tree["settings"] = settings(draft)
    if designed:
        free = draft.pick(["phase", "phase", "amplitude", "both"]) if verb != "hologram" else "phase"
        tree["element"] = [
            target(draft, radius, free),
            *train(draft, radius, {nothing: 9, lens: 1 if verb == "hologram" else 0.2}, 0),
        ]
        tree["hologram"] = hologram(draft, tree["element"][-1])
    elif draft.chance(0.05):
        tree["source"]["beam_radius_mm"] = radius
        tree["element"] = train(draft, radius, {lens: 3, surfaces: 1, mirror: 1})
    else:
        tree["element"] = system(draft, radius, verb)
    if verb in ("design", "gradcheck"):
        tree["settings"] |= {"method": draft.weighted({"auto": 9, "beamlet": 1, "local_bands": 2}), "target_error": 0.3}
        tree["design"] = design(draft, tree, free)
    return tree


def source(draft: Draft) -> dict:
    """Collimated light or light from a point, even or with a taper."""
    if draft.chance(0.25):
        cone = draft.pick([{"half_angle_deg": draft.scale(1, 60)}, {"numerical_aperture": draft.scale(0.01, 0.9)}])
        taper = {"taper": cone} if draft.chance(0.2) else {}
        return {"kind": "point", "position_mm": [*draft.pair(0.5), -draft.scale(1, 100)], **taper}
    angle = {"angle_deg": draft.pair(draft.pick([0.5, 3, 15]))} if draft.chance(0.4) else {}
    beam = {"radius_mm": [draft.scale(0.001, 1), draft.scale(0.001, 1)], "order": draft.whole(1, 8)}
    taper = {"taper": {**beam, "rotation_deg": draft.number(0, 90)}} if draft.chance(0.1) else {}
    return {"kind": "plane", **angle, **taper}


def settings(draft: Draft) -> dict:
    """How it is computed: mostly roughly."""
    table: dict = {"memory_limit_mb": MEMORY_LIMIT_MB, "target_error": draft.weighted({0.3: 12, 0.1: 3})}
    rare = {
        "sigma_um": draft.scale(2, 50),
        "step": draft.number(1, 2),
        "period": draft.number(5, 12),
        "mode_threshold": draft.scale(1e-6, 1e-2),
        "footprint_threshold": draft.scale(1e-6, 1e-2),
        "correction": draft.pick(["auto", "on", "off"]),
        "nufft_tolerance": draft.scale(1e-9, 1e-2),
        "coating": draft.pick(["ideal", "fresnel", "unit"]),
    }
    table |= {name: one for name, one in rare.items() if draft.chance(0.06)}
    table["method"] = draft.weighted({"auto": 20, "beamlet": 2, "local_bands": 4, "plane": 1, "paper": 2})
    if table["method"] == "paper":
        table["paper"] = paper(draft)
    return table


def paper(draft: Draft) -> dict:
    """The settings of the random-ray method."""
    table: dict = {"rays": draft.whole(1, 60), "secondary": draft.whole(1, 30), "patch_um": draft.scale(3, 60)}
    rare = {
        "window": draft.pick(["rectangle", "hann"]),
        "padding": draft.number(1, 3),
        "orders": draft.whole(1, 3),
        "positions": draft.pick(["inside", "dilated", "jittered", "grid"]),
        "coverage": draft.chance(0.5),
        "density": draft.pick(["amplitude", "uniform"]),
        "sampler": draft.pick(["multinomial", "systematic", "all"]),
        "sag": draft.pick(["tangent", "incident", "true"]),
        "obliquity": draft.chance(0.5),
    }
    return table | {name: one for name, one in rare.items() if draft.chance(0.3)}


def system(draft: Draft, radius: float, verb: str) -> list[dict]:
    """Something with an aperture, and what light meets behind it; or a curved diffractive mirror alone."""
    if draft.chance(0.05):
        return train(draft, radius, {conformal: 1})
    elements = [opener(draft, radius)]
    if draft.chance(0.05):
        elements += [{"kind": "coordinate_break", "tilt_deg": [*draft.pair(5), 0], "decenter_mm": draft.pair(0.01)}]
    kinds = {nothing: 6, lens: 2, ideal: 3, second: 2, plate: 1, surfaces: 0.3, hybrid: 0.7, mirror: 0.3, fold: 0.1}
    simple = {nothing: 4, ideal: 1, lens: 1, plate: 1}
    return elements + train(draft, radius, simple if verb == "reference" else kinds)


def train(draft: Draft, radius: float, kinds: dict, tilts: float = 0.07) -> list[dict]:
    """One of these kinds of elements and the sensor behind it. After a mirror light runs towards smaller z."""
    elements, sign = draft.weighted(kinds)(draft, radius)
    elements[-1]["thickness_mm"] = sign * draft.scale(0.2, 3)
    return [*elements, sensor(draft, tilts)]


def target(draft: Draft, radius: float, free: str) -> dict:
    """A diffractive element that is still to be found."""
    found = {"kind": "doe", "name": "first", "thickness_mm": draft.scale(0.1, 1), "aperture": aperture(draft, radius)}
    return found | {"layer": [blank(draft, radius, free)]}


def opener(draft: Draft, radius: float) -> dict:
    """What light meets first: a diffractive element or an aperture."""
    way = {"thickness_mm": draft.scale(0.1, 2), "aperture": aperture(draft, radius)}
    if draft.chance(0.15):
        return {"kind": "stop", "name": "stop", **way}
    return placed(draft, {"kind": "doe", "name": "first", **way, "layer": layers(draft, radius)}, 0.1)


def placed(draft: Draft, element: dict, share: float) -> dict:
    """The element, sometimes tilted and shifted."""
    if draft.chance(share):
        element["tilt_deg"] = [*draft.pair(4), 0]
    if draft.chance(share):
        element["decenter_mm"] = draft.pair(0.01)
    return element


def nothing(draft: Draft, radius: float) -> tuple[list[dict], int]:
    """A way and no more."""
    return [{"kind": "coordinate_break"}], 1


def lens(draft: Draft, radius: float) -> tuple[list[dict], int]:
    """A singlet or a cemented pair."""
    rim = draft.scale(8, 40) * radius
    faces = [{**curve(draft, rim), "semi_aperture_mm": rim} for _ in range(draft.weighted({2: 4, 3: 1}))]
    for face in faces[:-1]:
        face |= {"thickness_mm": draft.number(0.3, 1) * rim + 0.05, "glass": draft.pick(GLASSES)}
    if draft.chance(0.1):
        faces[0]["coating"] = draft.pick(["ideal", "fresnel", "unit"])
    return [placed(draft, {"kind": "lens", "name": "lens", "surface": faces}, 0.15)], 1


def surfaces(draft: Draft, radius: float) -> tuple[list[dict], int]:
    """Two refracting surfaces of their own."""
    rim = 10 * radius
    first = {"kind": "surface", "glass": draft.pick(GLASSES), "thickness_mm": draft.number(0.2, 1), **curve(draft, rim)}
    return [first | {"aperture": aperture(draft, rim)}, {"kind": "surface", "semi_aperture_mm": rim}], 1


def plate(draft: Draft, radius: float) -> tuple[list[dict], int]:
    rim = {"semi_aperture_mm": draft.scale(10, 60) * radius}
    faces = [{"thickness_mm": draft.number(0.1, 2), "glass": draft.pick(GLASSES), **rim}, rim]
    return [placed(draft, {"kind": "lens", "name": "plate", "surface": faces}, 0.3)], 1


def ideal(draft: Draft, radius: float) -> tuple[list[dict], int]:
    focal = draft.signed(1, 30)
    return [{"kind": "paraxial_lens", "focal_length_mm": focal, "aperture": aperture(draft, 3 * radius)}], 1


def second(draft: Draft, radius: float) -> tuple[list[dict], int]:
    """Another aperture, or another diffractive element, plane or curved."""
    if draft.chance(0.3):
        return [{"kind": "stop", "aperture": aperture(draft, 3 * radius)}], 1
    bent = curve(draft, radius) if draft.chance(0.4) else {}
    element = {"kind": "doe", "name": "second", "aperture": aperture(draft, radius), "layer": layers(draft, radius)}
    return [element | bent], 1


def hybrid(draft: Draft, radius: float) -> tuple[list[dict], int]:
    """A lens with a diffractive element on its back, or into another medium."""
    front = {
        "kind": "surface",
        "glass": draft.pick(GLASSES),
        "thickness_mm": draft.number(0.2, 1),
        **curve(draft, 10 * radius),
    }
    back = {
        "kind": "doe",
        "name": "back",
        "glass": "air",
        "aperture": aperture(draft, radius),
        "layer": layers(draft, radius),
    }
    if draft.chance(0.3):
        back |= {"glass": draft.pick(GLASSES), "coating": draft.pick(["ideal", "fresnel", "unit"])}
    return [front | {"semi_aperture_mm": 10 * radius}, back | curve(draft, 5 * radius)], 1


def mirror(draft: Draft, radius: float) -> tuple[list[dict], int]:
    rim = draft.scale(4, 20) * radius
    return [{"kind": "mirror", "name": "mirror", **curve(draft, rim), "semi_aperture_mm": rim}], -1


def fold(draft: Draft, radius: float) -> tuple[list[dict], int]:
    """A mirror between two breaks of the axis."""
    turn = {"kind": "coordinate_break", "tilt_deg": [draft.pick([45, 30, -20]), 0, 0]}
    [element], sign = mirror(draft, 2 * radius)
    return [dict(turn), element | {"thickness_mm": 0}, dict(turn)], sign


def conformal(draft: Draft, radius: float) -> tuple[list[dict], int]:
    """A curved diffractive mirror, which light meets first."""
    element = {"kind": "doe", "name": "mirror", "reflect": True, "aperture": {"disc": {"radius_mm": radius}}}
    if draft.chance(0.2):
        element |= {"coordinates": "surface", "radius_mm": draft.signed(10 * radius, 50 * radius)}
    else:
        element |= curve(draft, radius)
    return [element | {"layer": layers(draft, radius)}], -1


def sensor(draft: Draft, tilts: float) -> dict:
    """A few pixels, sometimes tilted."""
    pitch = draft.scale(1, 8)
    element = {"kind": "sensor", "pixels": [draft.whole(3, 12), draft.whole(3, 12)], "pitch_um": pitch}
    if draft.chance(0.2):
        element |= {"name": "camera", "pitch_um": [pitch, 1.5 * pitch]}
    return placed(draft, element, tilts)
