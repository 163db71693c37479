"""Scene documents as TOML text, for files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from raylet._plain import plain


def dumps(document: Mapping[str, Any]) -> str:
    """The text of a scene document; what is None is left out."""
    values, tables = [], []
    for key, value in plain(document).items():
        if isinstance(value, dict):
            tables.append(f"\n[{_key(key)}]\n" + _lines(value))
        elif _is_list_of_tables(value):
            tables += [f"\n[[{_key(key)}]]\n" + _lines(table) for table in value]
        else:
            values.append(f"{_key(key)} = {_written(value)}\n")
    return "".join(values + tables)


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _lines(table: Mapping[str, Any]) -> str:
    return "".join(f"{_key(key)} = {_written(value)}\n" for key, value in table.items())


def _written(value: Any) -> str:
    """A plain value in one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_key(key)} = {_written(item)}' for key, item in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(_written(item) for item in value)}]"
    return repr(value)


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "a").replace("-", "a").isalnum()
    return key if bare else _text(key)


def _text(text: str) -> str:
    # TOML strings are JSON strings, but for one control character.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
