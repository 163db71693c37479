"""Scene documents as TOML text."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np


def dumps(document: Mapping[str, Any]) -> str:
    """The text of a scene document; what is None is left out."""
    plain, tables = [], []
    for key, value in document.items():
        if isinstance(value, Mapping):
            tables.append(f"\n[{key}]\n" + _lines(value, key))
        elif _is_list_of_tables(value):
            tables += [f"\n[[{key}]]\n" + _lines(table, key) for table in value]
        elif value is not None:
            plain.append(f"{_key(key)} = {_value(value, key)}\n")
    return "".join(plain + tables)


def _lines(table: Mapping[str, Any], path: str) -> str:
    given = {key: value for key, value in table.items() if value is not None}
    return "".join(f"{_key(key)} = {_value(value, f'{path}.{key}')}\n" for key, value in given.items())


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _key(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"key {key!r} is {type(key).__name__}, expected a string")
    bare = key.isascii() and key.replace("_", "a").replace("-", "a").isalnum()
    return key if bare else _text(key)


def _text(text: str) -> str:
    # TOML strings are JSON strings, but for one control character and halves of surrogate pairs.
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"{text!r} is no valid text") from error
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, path: str) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (str, os.PathLike)):
        return _text(str(os.fspath(value)))
    if isinstance(value, Mapping):
        given = ((key, item) for key, item in value.items() if item is not None)
        inside = ", ".join(f"{_key(key)} = {_value(item, f'{path}.{key}')}" for key, item in given)
        return f"{{ {inside} }}"
    if isinstance(value, np.ndarray) and value.ndim > 0:
        value = value.tolist()
    if isinstance(value, np.ndarray):
        return _value(value.item(), path)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(item, f"{path}[{i}]") for i, item in enumerate(value)) + "]"
    raise TypeError(f"{path} is {type(value).__name__}, expected a number, text, list or table")
