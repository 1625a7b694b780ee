"""Tables of many motions: arrays by name."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union, overload

import numpy as np

from ._measures import Row, spread_of, unsettled
from ._show import Line, lines, shades
from ._result import Result
from ._tables import needed

if TYPE_CHECKING:
    import pandas
    import xarray
    from numpy.typing import NDArray



@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Table(Result):
    """Measures of many motions: ``table["amplitude.box.s"]`` is an array; ``table[3]`` is a dictionary, and so is each row in a loop.

    An array is masked where no number exists: for a motion that was refused, or a measure that is undefined.
    """

    parameters: dict[str, NDArray[Any]]
    "Varied parameters, each of the table's shape, in SI."
    values: dict[str, NDArray[Any]]
    "Measures, each of the table's shape; ``class`` is an array of texts."
    spreads: dict[str, NDArray[Any]]
    """Scatter of each measure from one window of the motion to the next: the standard error for a mean, rounding if the motion
    repeats. ``table["impacts.spread"]`` is ``table.spreads["impacts"]``."""
    unsettled: NDArray[Any]
    "Name of a measure that was still drifting while it was measured, or ``the motion``; None if all had settled."
    error: Optional[NDArray[Any]]
    "Reason why a motion has no measures, if ``errors='row'`` is given; otherwise None."
    axes: Optional[tuple[str, ...]]
    "For a sweep, the parameter that varies along each dimension."
    units: dict[str, str] = dataclasses.field(repr=False)
    "SI unit of each column."
    shape: tuple[int, ...]
    "Shape of all arrays."

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """All arrays by name."""
        spreads = {spread_of(name): column for name, column in self.spreads.items()}
        error = {} if self.error is None else {"error": self.error}
        return {**self.parameters, **self.values, **spreads, "unsettled": self.unsettled, **error}

    @overload
    def __getitem__(self, name: str) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, name: int) -> dict[str, Any]: ...
    def __getitem__(self, name: Union[str, int]) -> Any:
        columns = self.columns
        if isinstance(name, str):
            if name not in columns:
                raise KeyError(f"{name}: no such column; expected one of {', '.join(columns)}")
            return columns[name]
        return {key: _plain(column.reshape(-1)[name]) for key, column in columns.items()}

    def __len__(self) -> int:
        return int(np.prod(self.shape))

    def __iter__(self) -> Iterator[dict[str, Any]]:
        lists = {name: column.reshape(-1).tolist() for name, column in self.columns.items()}
        return (dict(zip(lists, row)) for row in zip(*lists.values())) if lists else iter([{} for _ in range(len(self))])

    def to_pandas(self) -> pandas.DataFrame:
        """Returns a pandas DataFrame with a row for each motion; requires pandas."""
        found: pandas.DataFrame = needed("pandas", "to_pandas").DataFrame(list(self), columns=list(self.columns))
        return found

    def to_xarray(self) -> xarray.Dataset:
        """Returns an xarray Dataset of the table's shape, for a sweep with its parameters as coordinates and NaN for masked numbers; requires xarray."""
        module = needed("xarray", "to_xarray")
        dims = self.axes or tuple(f"dim_{k}" for k in range(len(self.shape)))
        across = [tuple(slice(None) if i == k else 0 for i in range(len(dims))) for k in range(len(dims))]
        coords = {name: (dims[k], self.parameters[name][across[k]], {"units": self.units[name]}) for k, name in enumerate(self.axes or ())}
        shown = {name: column for name, column in self.columns.items() if name not in coords}
        parts = {name: (dims, _filled(column), {"units": self.units.get(name, "1")}) for name, column in shown.items()}
        found: xarray.Dataset = module.Dataset(parts, coords=coords)
        return found

    def to_parquet(self, path: Union[str, os.PathLike[str]]) -> Path:
        """Writes the rows as a Parquet file, with the units as metadata, and returns its path; requires pyarrow."""
        arrow, parquet = needed("pyarrow", "to_parquet"), needed("pyarrow.parquet", "to_parquet")
        columns = {name: arrow.array(column.reshape(-1).tolist()) for name, column in self.columns.items()}
        table = arrow.table(columns).replace_schema_metadata(self.units)
        parquet.write_table(table, os.fspath(path), compression="zstd")
        return Path(path)

    def _picture(self) -> str:
        numbers = {name: values for name, values in self.values.items() if values.dtype.kind == "f"}
        given = list(self.parameters.items())
        if not numbers or not given:
            return ""
        name, values = next(iter(numbers.items()))
        if self.axes is not None and len(self.shape) == 2 and min(self.shape) > 1:
            (up, rows), (across, columns) = given
            edges = (float(columns.min()), float(columns.max()), float(rows.min()), float(rows.max()))
            return shades(values, edges, across, up, name)
        order = np.argsort(given[0][1].reshape(-1), kind="stable")
        return lines([Line(given[0][1].reshape(-1)[order], values.reshape(-1)[order], dots=len(given) > 1)], given[0][0], f"{name}, SI")


def _plain(value: Any) -> Any:
    """Converts a number of an array to a Python number; None if it is masked."""
    return None if value is np.ma.masked else value.item() if isinstance(value, np.generic) else value


def _filled(column: NDArray[Any]) -> NDArray[Any]:
    """Returns a column for xarray, with NaN for masked numbers."""
    return column.filled(np.nan) if isinstance(column, np.ma.MaskedArray) and column.dtype.kind == "f" else np.asarray(column)


def table_of(
    parameters: Mapping[str, NDArray[Any]],
    names: list[str],
    rows: list[Row],
    in_rows: bool,
    units: Mapping[str, str],
    shape: tuple[int, ...],
    axes: Optional[tuple[str, ...]] = None,
) -> Table:
    """Returns a table from rows of measures, in the order of its elements."""
    values: dict[str, NDArray[Any]] = {}
    spreads: dict[str, NDArray[Any]] = {}

    def text(found: list[Any]) -> NDArray[Any]:
        return np.array(found, dtype=object).reshape(shape)

    for k, name in enumerate(names):
        if name == "class":
            values[name] = text([kind for _, _, kind, _, _ in rows])
            continue
        found = [row[0][k] if row[4] is None else None for row in rows]
        missing = np.array([x is None for x in found], dtype=bool).reshape(shape)
        errors = [row[1][k] if x is not None else None for row, x in zip(rows, found)]
        for kept, numbers in ((values, found), (spreads, errors)):
            array = np.array([0.0 if x is None else x for x in numbers], dtype=np.float64).reshape(shape)
            kept[name] = np.ma.MaskedArray(array, missing) if missing.any() else array
    error = text([row[4] for row in rows]) if in_rows else None
    given = {name: values.reshape(shape) for name, values in parameters.items()}
    known = {name: units.get(name, "1") for name in [*given, *names]}
    known.update({spread_of(name): known[name] for name in spreads})
    return Table(given, values, spreads, text([unsettled(names, row) for row in rows]), error, axes, known, shape)
