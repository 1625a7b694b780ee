"""Results as tables of pandas and xarray, which are imported on first use."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas
    import xarray

    from ._arguments import Floats
    from ._base import AnyMachine


def needed(module: str, what: str) -> Any:
    """Imports an optional module.

    Raises
    ------
    ImportError
        If the module is not installed; the message has the command that installs it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise ImportError(f"{what} requires {module}, which is not installed: `pip install {module}`") from None


def frame(columns: Mapping[str, Any], t: Floats) -> pandas.DataFrame:
    """Returns a DataFrame over times."""
    module = needed("pandas", "to_pandas")
    found: pandas.DataFrame = module.DataFrame(dict(columns), index=module.Index(t, name="time"))
    return found


def dataset(machine: AnyMachine, columns: list[str], values: Floats, t: Floats) -> xarray.Dataset:
    """Returns the columns of a motion as a Dataset over times."""
    module = needed("xarray", "to_xarray")
    parts = {name: ("time", values[:, k]) for k, name in enumerate(columns)}
    time = module.Variable("time", t, {"units": "s"})
    found: xarray.Dataset = module.Dataset(parts, coords={"time": time}, attrs={"machine": machine.name})
    return found
