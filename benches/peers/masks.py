"""Files for foundries, read by other programs: masks by gdstk, KLayout and ezdxf, reliefs by trimesh.

    python -m venv /tmp/peers && /tmp/peers/bin/pip install numpy gdstk klayout ezdxf trimesh
    cargo build --release -p raylet-cli
    /tmp/peers/bin/python benches/peers/masks.py

Prints time and memory of each export, and of each layer the number of polygons and the area as the other program finds
them, beside what the array says.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import ezdxf
import gdstk
import klayout.db as kdb
import numpy as np
import trimesh

RAYLET = Path(__file__).parents[2] / "target/release/raylet"

#: A program that runs another one, and prints its time and the most memory that it took.
MEASURED = """
import resource, subprocess, sys, time
start = time.perf_counter()
done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(f"{time.perf_counter() - start:.2f} s, {used.ru_utime + used.ru_stime:.2f} s of processor, "
      f"{used.ru_maxrss * 1e-3:.0f} MB at most")
sys.exit(done.returncode)
"""


def export(*arguments: object) -> None:
    """Runs `raylet export` and prints what it took."""
    words = [str(word) for word in arguments]
    print("  raylet export", *(Path(word).name if os.sep in word else word for word in words))
    command = [sys.executable, "-c", MEASURED, str(RAYLET), "export", *words, "--overwrite"]
    print("   ", subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip())


def by_gdstk(path: Path) -> tuple[dict[tuple[int, int], tuple[int, float]], object]:
    """Polygons and area in µm² of each layer, and the bounding box, of the whole element."""
    read = gdstk.read_oas if path.suffix == ".oas" else gdstk.read_gds
    top = read(path, unit=1e-6).top_level()[0]
    found: dict[tuple[int, int], tuple[int, float]] = {}
    for polygon in top.get_polygons():
        count, area = found.get((polygon.layer, polygon.datatype), (0, 0.0))
        found[polygon.layer, polygon.datatype] = count + 1, area + polygon.area()
    return found, top.bounding_box()


def by_klayout(path: Path) -> tuple[dict[tuple[int, int], tuple[int, float]], object]:
    """The same by KLayout, whose regions join what overlaps: an overlap would lessen the area."""
    layout = kdb.Layout()
    layout.read(str(path))
    top, found = layout.top_cell(), {}
    for layer in layout.layer_indexes():
        info = layout.get_info(layer)
        region = kdb.Region(top.begin_shapes_rec(layer))
        count = sum(1 for _ in region.each())
        found[info.layer, info.datatype] = count, region.merged().area() * layout.dbu**2
    box = top.dbbox()
    return found, ((box.left, box.bottom), (box.right, box.top))


def by_ezdxf(path: Path) -> dict[str, tuple[int, float]]:
    """The same of a DXF file by ezdxf, by the names of its layers."""
    drawing = ezdxf.readfile(path).modelspace()
    found: dict[str, tuple[int, float]] = {}
    for entity in drawing:
        parts = (
            [inner for one in entity.multi_insert() for inner in one.virtual_entities()]
            if hasattr(entity, "multi_insert")
            else [entity]
        )
        for part in parts:
            corners = np.array([tuple(corner)[:2] for corner in part.vertices()])
            x, y = corners.T
            count, area = found.get(part.dxf.layer, (0, 0.0))
            size = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
            found[part.dxf.layer] = count + 1, area + size
    return found


def masks(folder: Path) -> None:
    """Small patterns of all kinds in three formats, read by three programs."""
    rng = np.random.default_rng(1)
    tile = rng.integers(0, 4, (6, 10))
    for name, levels in {"random": rng.integers(0, 4, (300, 400)), "repeated": np.tile(tile, (50, 40))}.items():
        np.save(folder / f"{name}.npy", levels)
        pitch, cell = "0.5,0.75", 0.5 * 0.75
        for kind in ("each", "binary", "dose"):
            wanted = {
                "each": {(level, 0): np.sum(levels == level) for level in (1, 2, 3)},
                "binary": {(mask, 0): np.sum(((3 - levels) >> (2 - mask)) & 1) for mask in (1, 2)},
                "dose": {(1, level): np.sum(levels == level) for level in (1, 2, 3)},
            }[kind]
            source = folder / f"{name}.npy"
            options = ["--quantity", "level", "--levels", 4, "--pitch-um", pitch, "--masks", kind]
            counts = set()
            for ending in ("gds", "oas"):
                path = folder / f"{name}_{kind}.{ending}"
                export(source, "-o", path, *options)
                for reader, (found, box) in {"gdstk": by_gdstk(path), "klayout": by_klayout(path)}.items():
                    for layer, cells in sorted(wanted.items()):
                        count, area = found[layer]
                        assert abs(area - cells * cell) < 1e-6 * cells * cell, (reader, layer, area, cells * cell)
                        print(f"    {reader:8} layer {layer}: {count} polygons, {area:.3f} µm² of {cells * cell:.3f}")
                    print(f"    {reader:8} from {box[0]} to {box[1]} µm")
                    counts.add(tuple(sorted((layer, count) for layer, (count, _) in found.items())))
            path = folder / f"{name}_{kind}.dxf"
            export(source, "-o", path, *options)
            drawn = by_ezdxf(path)
            for layer, cells in sorted(wanted.items()):
                count, area = drawn[str(layer[1] or layer[0])]
                assert abs(area - cells * cell) < 1e-6 * cells * cell, (layer, area, cells * cell)
                print(f"    ezdxf    layer {layer}: {count} polygons, {area:.3f} µm² of {cells * cell:.3f}")
            counts.add(tuple((layer, drawn[str(layer[1] or layer[0])][0]) for layer in sorted(wanted)))
            assert len(counts) == 1, counts


def joined(folder: Path) -> None:
    """Masks that KLayout has joined into few polygons with holes, read back by raylet."""
    levels = np.random.default_rng(4).integers(0, 3, (70, 90))
    np.save(folder / "joined.npy", levels)
    masks, again, back = folder / "joined.gds", folder / "again.gds", folder / "back.npy"
    options = ["--quantity", "level", "--levels", 3, "--pitch-um", 0.5]
    export(folder / "joined.npy", "-o", masks, *options)
    layout = kdb.Layout()
    layout.read(str(masks))
    count = 0
    for layer in layout.layer_indexes():
        region = kdb.Region(layout.top_cell().begin_shapes_rec(layer)).merged()
        layout.top_cell().shapes(layer).clear()
        layout.top_cell().shapes(layer).insert(region)
        count += region.count()
    layout.write(str(again))
    export(again, "-o", back, *options, "--size", "90,70")
    print(f"    {count} polygons; read back equal: {np.array_equal(np.load(back), levels)}")


def relief(folder: Path) -> None:
    """A relief of 1000 × 1000 random heights, read by trimesh."""
    heights = np.random.default_rng(2).integers(0, 8, (1000, 1000)) * 0.125
    np.save(folder / "heights.npy", heights)
    for top in ("stairs", "smooth"):
        path = folder / f"{top}.stl"
        options = ["--quantity", "height", "--pitch-um", 2, "--micrometres", "--top", top]
        export(folder / "heights.npy", "-o", path, *options)
        mesh = trimesh.load(path)
        expected = 4.0 * float(np.sum(heights + 10.0))
        print(f"    {len(mesh.faces)} triangles, watertight {mesh.is_watertight}, normals {mesh.is_winding_consistent}")
        print(f"    volume {mesh.volume:.1f} µm³; sum of heights × area {expected:.1f} µm³")


def outlines(folder: Path) -> None:
    """The aperture of a scene on its own layer, and a biased etch, read by all programs."""
    levels = np.random.default_rng(5).integers(0, 4, (200, 200))
    np.save(folder / "phase.npy", levels * (np.pi / 2))
    scene = folder / "scene.toml"
    scene.write_text(
        "version = 1\nwavelength_um = 0.5\n[source]\nkind = 'plane'\n[[element]]\nkind = 'doe'\nname = 'plate'\n"
        "thickness_mm = 5\naperture = { annulus = { inner_radius_mm = 0.02, outer_radius_mm = 0.1 } }\n"
        "[[element.layer]]\nkind = 'pixels'\npitch_um = 1\nphase = 'phase.npy'\n"
        "[[element]]\nkind = 'sensor'\npixels = [4, 4]\npitch_um = 5\n"
    )
    place = np.arange(200) - 99.5
    radius = np.hypot(place, place[:, None])
    inside = (radius <= 100.0) & (radius >= 20.0)
    options = ["--aperture-layer", 9, "--etch-bias-um", 0.1]
    for ending in ("gds", "oas", "dxf"):
        path = folder / f"outline.{ending}"
        export(scene, "-o", path, *options)
        if ending == "dxf":
            drawing = ezdxf.readfile(path).modelspace()
            rings = [line for line in drawing if line.dxf.layer.startswith("APERTURE")]
            print("    ezdxf   ", [(line.dxf.layer, line.is_closed, len(line)) for line in rings])
            continue
        for reader, (found, _) in {"gdstk": by_gdstk(path), "klayout": by_klayout(path)}.items():
            for key, exact in {(9, 0): np.pi * 100**2, (9, 1): np.pi * 20**2}.items():
                print(f"    {reader:8} layer {key}: {found[key][0]} polygons, {found[key][1] / exact - 1:.1e} off π r²")
            # A cell alone is 0.8 x 0.8 µm; where two cells touch, the strip between them is drawn too.
            for level in (1, 2, 3):
                drawn = np.pad((levels == level) & inside, 1)
                x, y = drawn[:, 1:] & drawn[:, :-1], drawn[1:] & drawn[:-1]
                corners = x[1:] & x[:-1]
                area = 0.64 * drawn.sum() + 0.16 * (x.sum() + y.sum()) + 0.04 * corners.sum()
                assert abs(found[level, 0][1] - area) < 1e-6 * area, (reader, level, found[level, 0][1], area)
                print(f"    {reader:8} level {level}: {found[level, 0][1]:.3f} µm² of {area:.3f}")


def large(folder: Path) -> None:
    """Ten million random cells of four levels."""
    np.save(folder / "large.npy", np.random.default_rng(3).integers(0, 4, (3200, 3200)) * (np.pi / 2))
    for kind in ("each", "binary", "dose"):
        path = folder / f"large_{kind}.gds"
        export(folder / "large.npy", "-o", path, "--pitch-um", 0.5, "--masks", kind)
        print(f"    {path.stat().st_size * 1e-6:.0f} MB")
    for ending in ("oas", "dxf"):
        path = folder / f"large_each.{ending}"
        export(folder / "large.npy", "-o", path, "--pitch-um", 0.5)
        print(f"    {path.stat().st_size * 1e-6:.0f} MB")
    for ending in ("gds", "oas"):
        start = time.perf_counter()
        layout = kdb.Layout()
        layout.read(str(folder / f"large_each.{ending}"))
        areas = []
        for layer in layout.layer_indexes():
            shapes = layout.top_cell().shapes(layer)
            areas.append((shapes.size(), sum(shape.area() for shape in shapes.each()) * layout.dbu**2))
        used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1e-3
        print(f"    KLayout reads .{ending} in {time.perf_counter() - start:.1f} s, {used:.0f} MB: {sorted(areas)}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        for part in (masks, outlines, joined, relief, large):
            print(part.__doc__)
            part(Path(name))
