"""Conversion between frames and arrays."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import RideError

if TYPE_CHECKING:
    import pandas
    import polars

Doubles = NDArray[np.float64]
Columns = list[tuple[str, Doubles]]
FrameKind = Literal["pandas", "polars", "arrays"]


def is_record(source: object) -> bool:
    """Whether this is one logger's record: a frame, or a mapping of names to values."""
    if isinstance(source, Mapping):
        return not any(isinstance(value, str | os.PathLike) or is_record(value) for value in source.values())
    return hasattr(source, "columns")


def items(source: Any) -> Iterable[tuple[str, Any]]:
    """Names and values. A named index of pandas is a column."""
    if isinstance(source, Mapping):
        return ((str(name), values) for name, values in source.items())
    names = getattr(getattr(source, "index", None), "names", [])
    if any(name is not None for name in names):
        source = source.reset_index()
    return ((str(name), source[name]) for name in source.columns)


def columns(source: Any) -> tuple[Columns, float | None]:
    """Columns of doubles, and the epoch (s) of their time 0 where a column holds dates."""
    out: Columns = []
    epoch_s = None
    for name, given in items(source):
        values, first_s = doubles(name, given)
        epoch_s = epoch_s if first_s is None else first_s
        out.append((name, values))
    return out, epoch_s


def doubles(name: str, values: ArrayLike) -> tuple[Doubles, float | None]:
    """Values as doubles. Durations are in seconds; dates are in seconds after the first, whose epoch (s) is returned."""
    array = np.asarray(values)
    if array.ndim != 1:
        raise RideError(f"{name} has {array.ndim} dimensions, expected one", column=name)
    if array.dtype.kind == "M":
        stamps = array.astype("datetime64[ns]")
        there = stamps[~np.isnat(stamps)]
        if not there.size:
            return np.full(array.size, np.nan), None
        epoch_s = there[0].astype(np.int64) / 1e9
        return seconds(stamps - there[0]), float(epoch_s)
    if array.dtype.kind == "m":
        return seconds(array), None
    if array.dtype.kind not in "fiub":
        return numbers(name, array), None
    return np.ascontiguousarray(array, dtype=np.float64), None


def seconds(durations: NDArray[Any]) -> Doubles:
    whole = durations.astype("timedelta64[ns]")
    return np.where(np.isnat(whole), np.nan, whole.astype(np.int64) / 1e9)


def numbers(name: str, array: NDArray[Any]) -> Doubles:
    """Objects and strings as numbers, None as a missing value. A column without any number becomes all missing."""
    out = np.full(array.size, np.nan)
    wrong = None
    for row, value in enumerate(array):
        try:
            out[row] = np.nan if value is None or value == "" else float(value)
        except (TypeError, ValueError):
            wrong = row if wrong is None else wrong
    if wrong is not None and not np.isnan(out).all():
        message = f"sample {wrong + 1}, column {name}: {array[wrong]!r} is not a number, expected one or None"
        raise RideError(message, kind="not-a-number", row=wrong, column=name)
    return out


def frame(columns: Mapping[str, Any], kind: FrameKind) -> pandas.DataFrame | polars.DataFrame | dict[str, Any]:
    """Columns as a frame of the requested kind; as arrays, a dict."""
    if kind == "pandas":
        import pandas

        return pandas.DataFrame(dict(columns))
    if kind == "polars":
        import polars

        return polars.DataFrame(dict(columns))
    return {name: np.asarray(values) for name, values in columns.items()}


def table(rows: list[dict[str, Any]], names: list[str], kind: FrameKind) -> Any:
    """Rows as a frame, with these columns even if there is no row."""
    return frame({name: [row.get(name) for row in rows] for name in names}, kind)


def csv(source: Any) -> bytes:
    """A record as a file, every number with all its digits; dates are seconds since 1970."""
    names, cells = [], []
    for name, given in items(source):
        values, epoch_s = doubles(name, given)
        values = values + (epoch_s or 0.0)
        names.append(name)
        cells.append(["" if np.isnan(v) else repr(float(v)) for v in values])
    lengths = sorted({len(column) for column in cells})
    if len(lengths) > 1:
        raise RideError(f"columns of {lengths[0]} and {lengths[-1]} rows, expected equal lengths")
    lines = [",".join(names), *map(",".join, zip(*cells, strict=True))]
    return ("\n".join(lines) + "\n").encode()
