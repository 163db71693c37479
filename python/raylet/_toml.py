"""Scene documents as TOML text."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from raylet._refusal import RayletError, check_level, cut, shown

#: The most numbers and texts in a document, arrays apart.
_MOST_VALUES = 200_000


def dumps(document: Mapping[str, Any]) -> str:
    """The text of a scene document; what is None is left out."""
    writer = _Writer()
    plain, tables = [], []
    for key, value in document.items():
        if isinstance(value, Mapping):
            tables.append(f"\n[{_key(key)}]\n" + writer.lines(value, key))
        elif _is_list_of_tables(value):
            tables += [f"\n[[{_key(key)}]]\n" + writer.lines(table, key) for table in value]
        elif value is not None:
            plain.append(f"{_key(key)} = {writer.value(value, key, 0)}\n")
    return "".join(plain + tables)


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _key(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"key {shown(key)} is {type(key).__name__}, expected a string")
    bare = key.isascii() and key.replace("_", "a").replace("-", "a").isalnum()
    return key if bare else _text(key)


def _text(text: str) -> str:
    # TOML strings are JSON strings, but for one control character and halves of surrogate pairs.
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"{shown(text)} is no valid text") from error
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


class _Writer:
    """Writes the values of one document, and counts them."""

    def __init__(self) -> None:
        self._left = _MOST_VALUES

    def lines(self, table: Mapping[str, Any], path: str) -> str:
        given = {key: value for key, value in table.items() if value is not None}
        return "".join(f"{_key(key)} = {self.value(value, f'{path}.{key}', 1)}\n" for key, value in given.items())

    def value(self, value: Any, path: str, level: int) -> str:
        check_level(level, path)
        if isinstance(value, np.ndarray) and value.ndim > 0:
            self._check_room(value.size, path)
            value = value.tolist()
        if isinstance(value, np.ndarray):
            return self.value(value.item(), path, level + 1)
        self._check_room(1, path)
        self._left -= 1
        if isinstance(value, (bool, np.bool_)):
            return "true" if value else "false"
        if isinstance(value, (int, np.integer)):
            return _digits(int(value), path)
        if isinstance(value, (float, np.floating)):
            return repr(float(value))
        if isinstance(value, (str, os.PathLike)):
            return _text(str(os.fspath(value)))
        if isinstance(value, Mapping):
            given = ((key, item) for key, item in value.items() if item is not None)
            inside = (f"{_key(key)} = {self.value(item, f'{path}.{key}', level + 1)}" for key, item in given)
            return f"{{ {', '.join(inside)} }}"
        if isinstance(value, (list, tuple)):
            return "[" + ", ".join(self.value(item, f"{path}[{i}]", level + 1) for i, item in enumerate(value)) + "]"
        raise TypeError(f"{cut(path)} is {type(value).__name__}, expected a number, text, list or table")

    def _check_room(self, count: int, path: str) -> None:
        """Refuses more values than a scene has that somebody wrote."""
        if count > self._left:
            raise RayletError(
                f"{cut(path)} brings the system to more than {_MOST_VALUES} numbers, expected fewer: arrays belong "
                "under keys that hold them, such as phase"
            )


def _digits(number: int, path: str) -> str:
    # Python refuses to write thousands of digits; the library takes 64 bits.
    if abs(number) >= 1 << 64:
        raise RayletError(f"{cut(path)} is a whole number beyond 64 bits, expected a smaller one")
    return str(number)
