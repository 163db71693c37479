"""Documents as TOML."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from raylet._toml import dumps


@pytest.mark.skipif(sys.version_info < (3, 11), reason="needs tomllib")
def test_what_is_written_is_read() -> None:
    import tomllib

    document = {
        "text": 'µ "quoted"\n\\ \x7f',
        "numbers": [1, -2.5, 1e-300, np.float64(0.1), np.int32(7)],
        "yes": True,
        "no": np.False_,
        "absent": None,
        "table": {"odd key": np.array([1.0, 2.0]), "inf": float("inf"), "zero": np.array(3.0)},
        "rows": [{"a": {"b": [{"c": 1}]}}, {"d": ()}],
    }
    read = tomllib.loads(dumps(document))
    assert read["text"] == document["text"] and read["numbers"] == [1, -2.5, 1e-300, 0.1, 7]
    assert read["yes"] is True and read["no"] is False and "absent" not in read
    assert read["table"] == {"odd key": [1.0, 2.0], "inf": float("inf"), "zero": 3.0}
    assert read["rows"] == [{"a": {"b": [{"c": 1}]}}, {"d": []}]


@pytest.mark.parametrize("value", [object(), {1: 2}, "\ud800", 1j, b"x"])
def test_what_has_no_words_is_refused(value: object) -> None:
    with pytest.raises((TypeError, ValueError)):
        dumps({"a": {"b": value}})
