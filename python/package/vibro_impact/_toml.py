"""Dictionaries as the text of a machine's file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np


def toml(machine: Mapping[str, Any]) -> str:
    """Returns a dictionary as the text of a file: a line for each top-level value, with inline tables within it."""
    return "".join(f"{_key(name)} = {_value(str(name), value)}\n" for name, value in machine.items())


def _key(name: object) -> str:
    if not isinstance(name, str):
        raise TypeError(f"{name!r} is of type {type(name).__name__}: expected a text as a name")
    return json.dumps(name)


def _value(name: str, value: object) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(f'{name}.{k}', v)}" for k, v in value.items()) + "}"
    if hasattr(value, "toarray"):  # a sparse matrix of SciPy, which may not be installed
        value = value.toarray()
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(f"{name}[{i}]", v) for i, v in enumerate(value)) + "]"
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    raise TypeError(f"{name} is of type {type(value).__name__}: expected a number, text, boolean, list, array, sparse matrix or dictionary")
