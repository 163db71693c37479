"""Random pieces of elements: apertures, layers, shapes of surfaces, glasses."""

from __future__ import annotations

from fuzz.draft import Draft

GLASSES = ["N-BK7", "N-SF11", "fused silica", "N-LAK22", {"index": 1.5}, {"index": 2.0}]


def aperture(draft: Draft, radius: float, inside: bool = True) -> dict:
    """An aperture within this radius of any outline, perhaps with parts blocked."""
    centre = {"centre_mm": draft.pair(0.3 * radius)} if draft.chance(0.15) else {}
    turn = {"rotation_deg": draft.number(-180, 180)} if draft.chance(0.5) else {}
    bend = draft.number(-0.5, 0.5) * radius
    kind = draft.weighted({"disc": 5, "rectangle": 2, "annulus": 1, "regular_polygon": 1, "polygon": 1})
    outline = {
        "disc": {"radius_mm": radius},
        "rectangle": {"width_mm": draft.number(0.5, 2) * radius, "height_mm": draft.number(0.5, 2) * radius, **turn},
        "annulus": {"inner_radius_mm": draft.number(0, 0.8) * radius, "outer_radius_mm": radius},
        "regular_polygon": {"sides": draft.whole(3, 9), "radius_mm": radius, **turn},
        "polygon": {"corners_mm": [[-radius, -radius], [radius, -radius], [0.4 * radius, bend], [0, radius]]},
    }
    found: dict = {kind: {**outline[kind], **centre}}
    if inside and draft.chance(0.15):
        found["blocked"] = [aperture(draft, 0.4 * radius, False) for _ in range(draft.whole(1, 3))]
    return found


def pixels(draft: Draft, radius: float) -> dict:
    """A layer of pixels that covers the aperture, with phase, levels of it, amplitude or both."""
    size = [draft.whole(2, 14), draft.whole(2, 14)]
    pitch = [float(f"{2000 * radius / count:.4g}") for count in size]
    layer: dict = {"kind": "pixels", "pitch_um": pitch if draft.chance(0.5) else max(pitch)}
    kind = draft.weighted({"phase": 6, "levels": 2, "amplitude": 1, "both": 1, "transmission": 1})
    if kind in ("phase", "both"):
        layer["phase"] = draft.array("phase", size, 6.3)
    elif kind == "levels":
        layer |= {"phase": draft.array("phase", size, 1), "phase_scale": draft.pick([6.2832, -3.1416, 0.5])}
    elif kind == "transmission":
        layer["transmission"] = draft.waves("transmission", size)
    if kind in ("amplitude", "both"):
        layer["amplitude"] = draft.array("amplitude", size, 1)
    if draft.chance(0.5):
        layer["size"] = size
    if draft.chance(0.3):
        layer["pixel"] = draft.pick(["box", "point", "bilinear"])
    elif draft.chance(0.2):
        layer |= {"fill": draft.number(0.2, 1), "rest": draft.pick(["dark", "flat"])}
    elif draft.chance(0.1):
        fine = float(f"{0.3 * min(pitch):.4g}")
        layer |= {draft.pick(["fly_back_um", "crosstalk_um"]): fine, "sub_pixels": 2}
    return layer | place(draft, radius)


def place(draft: Draft, radius: float) -> dict:
    """Where a grid stands on its element; now and then off centre or turned."""
    if not draft.chance(0.08):
        return {}
    aside, turn = {"centre_mm": draft.pair(0.3 * radius)}, {"rotation_deg": draft.number(-180, 180)}
    return draft.pick([aside, turn, {**aside, **turn}])


def height(draft: Draft, radius: float) -> dict:
    """A relief of some material."""
    size = [draft.whole(2, 8), draft.whole(2, 8)]
    layer = {"kind": "height", "pitch_um": float(f"{2000 * radius / min(size):.4g}"), "glass": draft.pick(GLASSES)}
    return layer | {"size": size, "height_um": draft.array("height_um", size, 1.5), **place(draft, radius)}


def blank(draft: Draft, radius: float, free: str) -> dict:
    """A layer of pixels that are still to be found; now and then a file holds what they are at first."""
    size = [draft.whole(2, 10), draft.whole(2, 10)]
    names = {"phase": ["phase"], "amplitude": ["amplitude"], "both": ["phase", "amplitude"]}[free]
    files = {name: draft.array(name, size, 1) if draft.chance(0.2) else f"found_{name}.npy" for name in names}
    return {"kind": "pixels", "pitch_um": float(f"{2000 * radius / min(size):.4g}"), "size": size, **files}


def smooth(draft: Draft, radius: float) -> dict:
    """A layer that a formula describes."""
    kind = draft.pick(["grating", "lens", "axicon", "vortex", "radial", "radial_table", "phase_grid", "zernike"])
    keys = {
        "grating": {"period_um": draft.scale(3, 300), "direction_deg": draft.number(-180, 180)},
        "lens": {"focal_length_mm": draft.signed(1, 50)},
        "axicon": {"angle_deg": draft.number(-4, 4)},
        "vortex": {"charge": draft.whole(-4, 4)},
        "radial": {"norm_radius_mm": radius, "coefficients": terms(draft, 4, 8)},
        "radial_table": {
            "radius_mm": [0, 0.3 * radius, radius, 2 * radius],
            "phase_rad": [0, *([draft.number(-8, 8)] * 3)],
        },
        "zernike": {"norm_radius_mm": radius, "coefficients": terms(draft, 6, 1)},
    }
    if kind == "phase_grid":
        keys[kind] = {"pitch_um": float(f"{1000 * radius:.4g}"), "phase": draft.array("phase", [5, 6], 6.3)}
    layer = {"kind": kind, **keys[kind]}
    if kind == "grating" and draft.chance(0.3):
        layer["order"] = draft.whole(-2, 2)
    return layer


def terms(draft: Draft, most: int, size: float) -> list[float]:
    return [draft.number(-size, size) for _ in range(draft.whole(1, most))]


def layers(draft: Draft, radius: float) -> list[dict]:
    """One or two layers, now and then a sum."""
    found = [draft.weighted({pixels: 6, smooth: 4, height: 1.5})(draft, radius)]
    if draft.chance(0.15):
        found.append(smooth(draft, radius))
    if draft.chance(0.06):
        inner = [[smooth(draft, radius)] for _ in range(2)]
        found.append(
            {
                "kind": "sum",
                "terms": inner,
                **({"weights": draft.pick([[0.5, 0.7], [0.5, [0.2, -0.7]]])} if draft.chance(0.5) else {}),
            }
        )
    return found


def curve(draft: Draft, radius: float) -> dict:
    """A shape of a surface with a clear aperture of this radius, mostly spherical."""
    bent = {"radius_mm": draft.signed(8 * radius, 60 * radius)}
    kind = draft.weighted({"plane": 2, "sphere": 6, "conic": 1, "even": 0.7, "shape": 0.6})
    if kind == "plane":
        return {}
    if kind == "conic":
        bent["conic"] = draft.number(-2, 1)
    if kind == "even":
        bent["aspheric"] = [draft.signed(1e-5, 1e-3) / radius**3]
    return shape(draft, radius, bent) if kind == "shape" else bent


def shape(draft: Draft, radius: float, bent: dict) -> dict:
    """A toroid, a cylinder or a freeform surface."""
    curves = [draft.signed(10 * radius, 60 * radius) for _ in range(2)]
    bump = {"height_um": draft.signed(0.1, 20 * radius), "sigma_mm": radius, "centre_mm": draft.pair(0.3 * radius)}
    powers = {"x": draft.whole(0, 3), "y": draft.whole(0, 3), "height_um": draft.signed(0.01, 1)}
    size = [draft.whole(4, 7), draft.whole(4, 7)]
    grid = {"pitch_um": float(f"{2200 * radius / (min(size) - 1):.4g}")}
    kind = draft.pick(["biconic", "toroid", "cylinder", "odd", "xy", "zernike", "gaussian", "grid"])
    keys: dict[str, dict] = {
        "biconic": {"radius_x_mm": curves[0], "radius_y_mm": curves[1]},
        "toroid": {"radius_mm": curves[0], "rotation_radius_mm": curves[1]},
        "cylinder": {"straight_along": draft.pick("xy"), "radius_mm": curves[0]},
        "odd": {"coefficients": [draft.signed(1e-5, 1e-3) for _ in range(draft.whole(1, 4))]},
        "xy": {"norm_radius_mm": radius, "terms": [powers]},
        "zernike": {"norm_radius_mm": radius, "coefficients_um": terms(draft, 10, 0.3)},
        "gaussian": {"bumps": [bump]},
        "grid": grid,
    }
    if kind == "grid":
        grid["height_um"] = draft.array("height_um", size, 0.5)
    own = {"shape": {"kind": kind, **keys[kind]}}
    return own if kind in ("biconic", "toroid", "cylinder") or draft.chance(0.4) else bent | own
