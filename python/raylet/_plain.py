"""Scene documents as plain values (dictionaries, lists, texts, numbers, true and false), and as TOML text for files."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from raylet._refusal import RayletError, check_level, cut, shown, type_name

#: The most numbers and texts in a document, arrays apart.
_MOST_VALUES = 200_000


def plain(document: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a document with plain values of Python alone; what is None is left out of tables."""
    return _Walk().table(document, "", 0)


class _Walk:
    """Takes the values of one document, and counts them."""

    def __init__(self) -> None:
        self._left = _MOST_VALUES

    def table(self, table: Mapping[str, Any], path: str, level: int) -> dict[str, Any]:
        dot = "." if path else ""
        given = ((_key(key), item) for key, item in table.items() if item is not None)
        return {key: self.value(item, f"{path}{dot}{key}", level + 1) for key, item in given}

    def value(self, value: Any, path: str, level: int) -> Any:
        check_level(level, path)
        if isinstance(value, np.ndarray) and value.ndim > 0:
            self._check_room(value.size, path)
            value = value.tolist()
        if isinstance(value, np.ndarray):
            return self.value(value.item(), path, level + 1)
        self._check_room(1, path)
        self._left -= 1
        if isinstance(value, (bool, np.bool_)):
            return bool(value)
        if isinstance(value, (int, np.integer)):
            return _integer(int(value), path)
        if isinstance(value, (float, np.floating)):
            return float(value)
        if isinstance(value, (str, os.PathLike)):
            return _text(str(os.fspath(value)))
        if isinstance(value, Mapping):
            return self.table(value, path, level)
        if isinstance(value, (list, tuple)):
            return [self.value(item, f"{path}[{i}]", level + 1) for i, item in enumerate(value)]
        raise TypeError(f"{cut(path)} is {type_name(value)}, expected a number, text, list or table")

    def _check_room(self, count: int, path: str) -> None:
        """Refuses more values than a scene has that somebody wrote."""
        if count > self._left:
            raise RayletError(
                f"{cut(path)} brings the system to more than {_MOST_VALUES} numbers, expected fewer: arrays belong "
                "under keys that hold them, such as phase"
            )


def _key(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"key {shown(key)} is {type_name(key)}, expected a string")
    return _text(key)


def _text(text: str) -> str:
    # Halves of surrogate pairs are no characters.
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"{shown(text)} is no valid text") from error
    return text


def _integer(number: int, path: str) -> int:
    # Python refuses to write thousands of digits; the library takes 64 bits.
    if abs(number) >= 1 << 64:
        raise RayletError(f"{cut(path)} is a whole number beyond 64 bits, expected a smaller one")
    return number


def dumps(document: Mapping[str, Any]) -> str:
    """A scene document as TOML text; what is None is left out."""
    values, tables = [], []
    for key, value in plain(document).items():
        if isinstance(value, dict):
            tables.append(f"\n[{_toml_key(key)}]\n" + _lines(value))
        elif _is_list_of_tables(value):
            tables += [f"\n[[{_toml_key(key)}]]\n" + _lines(table) for table in value]
        else:
            values.append(f"{_toml_key(key)} = {_written(value)}\n")
    return "".join(values + tables)


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _lines(table: Mapping[str, Any]) -> str:
    return "".join(f"{_toml_key(key)} = {_written(value)}\n" for key, value in table.items())


def _written(value: Any) -> str:
    """A plain value in one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _toml_text(value)
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_toml_key(key)} = {_written(item)}' for key, item in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(_written(item) for item in value)}]"
    return repr(value)


def _toml_key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "a").replace("-", "a").isalnum()
    return key if bare else _toml_text(key)


def _toml_text(text: str) -> str:
    # TOML strings are JSON strings, but for one control character.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
