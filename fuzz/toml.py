"""Writes trees of dictionaries and lists as TOML, also where they are no valid scene."""

from __future__ import annotations

import json
import re

BARE = re.compile(r"[A-Za-z0-9_-]+")


class Raw(str):
    """Text that goes into the file as it stands, whether or not it is TOML."""


def key(name: str) -> str:
    """A key, in quotes where it needs them."""
    return name if BARE.fullmatch(name) else string(name)


def string(text: str) -> str:
    """A basic string; its escapes are those of JSON."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def value(one: object) -> str:
    """A value in one line."""
    if isinstance(one, Raw):
        return str(one)
    if isinstance(one, bool):
        return "true" if one else "false"
    if isinstance(one, str):
        return string(one)
    if isinstance(one, dict):
        return "{" + ", ".join(f"{key(name)} = {value(inner)}" for name, inner in one.items()) + "}"
    if isinstance(one, (list, tuple)):
        return "[" + ", ".join(value(inner) for inner in one) + "]"
    return repr(one)


def document(tree: dict) -> str:
    """The whole tree: tables and lists of tables get heads of their own, what is deeper stands in lines."""
    lines: list[str] = []
    table(tree, "", lines)
    return "\n".join(lines) + "\n"


def table(tree: dict, path: str, lines: list[str]) -> None:
    """The plain keys of a table, then the tables in it."""
    inner = {name: one for name, one in tree.items() if is_table(one) or is_tables(one)}
    lines += [f"{key(name)} = {value(one)}" for name, one in tree.items() if name not in inner]
    for name, one in inner.items():
        place = f"{path}.{key(name)}" if path else key(name)
        for part in [one] if is_table(one) else one:
            lines.append(f"[{place}]" if is_table(one) else f"[[{place}]]")
            table(part, place, lines)


def is_table(one: object) -> bool:
    return isinstance(one, dict)


def is_tables(one: object) -> bool:
    return isinstance(one, list) and bool(one) and all(map(is_table, one))
