"""Writes the page of all keys of a scene, from the schema that the library itself checks scenes by."""

from __future__ import annotations

from typing import Any

from mkdocs.structure.files import File

import raylet

HEAD = """# Keys

Every key of a scene: of its file, and of the dictionaries and keyword arguments that mean the same in Python. Made from
`raylet.schema()`.
"""


def on_files(files: Any, config: Any) -> Any:
    files.append(File.generated(config, "keys.md", content=page(raylet.schema())))
    return files


def page(schema: dict[str, Any]) -> str:
    parts = [HEAD, section("Scene", schema)]
    parts += [section(name, entry) for name, entry in schema["$defs"].items()]
    return "\n".join(parts)


def section(name: str, entry: dict[str, Any]) -> str:
    """One kind of table: its keys, its variants, or the words it may be."""
    lines = [f"## {name}", "", line(entry.get("description", "")), ""]
    variants = entry.get("oneOf") or entry.get("anyOf") or []
    lines += table(entry)
    words = [one for one in variants if "const" in one or "enum" in one]
    lines += [f"- {word(one)}" for one in words]
    for one in variants:
        if one in words:
            continue
        keys = one.get("properties", {})
        kind = keys.get("kind", {}).get("const")
        title = f'kind = "{kind}"' if kind else " / ".join(keys) or type_of(one)
        lines += ["", f"### {title}", "", line(one.get("description", "")), "", *table(one)]
    return "\n".join(lines) + "\n"


def word(one: dict[str, Any]) -> str:
    values = " or ".join(f"`{value!r}`".replace("'", '"') for value in one.get("enum", [one.get("const")]))
    return f"{values}: {line(one['description'])}" if one.get("description") else values


def table(entry: dict[str, Any]) -> list[str]:
    """The keys of a table with what they mean."""
    keys = {key: value for key, value in entry.get("properties", {}).items() if "const" not in value}
    if not keys:
        return []
    needed = set(entry.get("required", []))
    rows = ["| key | value | default | |", "| --- | --- | --- | --- |"]
    for key, value in keys.items():
        default = "needed" if key in needed else simple(value.get("default"))
        rows.append(f"| `{key}` | {type_of(value)} | {default} | {line(value.get('description', ''))} |")
    return rows


def simple(value: Any) -> str:
    """A default, where it is short."""
    text = {True: "true", False: "false"}.get(value, str(value)) if isinstance(value, bool) else str(value)
    return "" if value in (None, "", []) or isinstance(value, dict) else f"`{text}`"


def type_of(value: dict[str, Any]) -> str:
    """What a value may be."""
    if "$ref" in value:
        name = value["$ref"].rsplit("/", 1)[-1]
        return f"[{name}](#{name.lower()})"
    either = [one for one in value.get("anyOf", value.get("oneOf", [])) if one.get("type") != "null"]
    if either:
        return " or ".join(dict.fromkeys(type_of(one) for one in either))
    kinds = value.get("type", "")
    kinds = [kinds] if isinstance(kinds, str) else [kind for kind in kinds if kind != "null"]
    if "array" in kinds:
        count = value.get("minItems") if value.get("minItems") == value.get("maxItems") else None
        return f"{count or 'list of'} × {type_of(value.get('items', {}))}".replace("list of ×", "list of")
    return " or ".join({"integer": "whole number"}.get(kind, kind) for kind in kinds)


def line(text: str) -> str:
    """Words in one line of a table."""
    return " ".join(text.split()).replace("|", "\\|")
