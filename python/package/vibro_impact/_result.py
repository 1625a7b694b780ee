"""What all results have in common."""

from __future__ import annotations

import dataclasses

import numpy as np


class Result:
    """A result: a value with named parts, shown by their shapes."""

    def __repr__(self) -> str:
        parts = []
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            if not field.repr:
                continue
            value = getattr(self, field.name)
            shown = f"array{value.shape}" if isinstance(value, np.ndarray) and value.size > 8 else repr(value)
            parts.append(f"{field.name}={shown}")
        return f"{type(self).__name__}({', '.join(parts)})"
