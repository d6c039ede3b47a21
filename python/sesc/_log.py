"""Posture logs: files, streams, tables and arrays."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _arrow, _sesc
from ._arrays import Float64, unmasked
from ._errors import ArgumentTypeError, LogError
from ._found import Finding
from ._words import Angles

if TYPE_CHECKING:
    from ._model import Robot

__all__ = ["Log"]


class Log:
    """A posture log: joint positions of many postures, and what the foot measured.

    Args:
        data: a path (CSV, gzip, Parquet, MCAP), an open binary file, bytes, a table (anything
            with ``__arrow_c_stream__``: pandas, Polars, pyarrow, DuckDB) or a mapping of names
            to arrays. Columns are named as in a log file: joints as in the URDF (rad, m),
            ``cop_x, cop_y`` (m), ``fsr_1 …`` (N) or ``l_fx … l_mz`` (N, N m) of ``sensors``,
            optional ``pose``, ``t`` (s), ``support``, ``fz`` (N).
        support: link on the ground in rows that do not say.
        angles: ``"deg"`` where revolute joints are in degrees.
        columns: ``{"name in the log": "our name"}``.
        name: what messages call the log.
        robot: whose log it is; :attr:`health` then knows more.
        sensors: where wrenches are measured, ``{"l": {"frame": "l_sole"}}``, as in the sidecar.
        readings_per_pose, cells, gravity, both_feet, other_foot, topic, joints_topic, experiment: as in the sidecar of a log file,
            over which all of these win.

    A table is copied: later changes of it do not reach the log.

    Raises:
        LogError: what cannot be read as a log; a missing file is a ``FileNotFoundError`` too.

    Example:
        >>> sesc.Log({"hip": [0.0, 0.1], "cop_x": [0.1, 0.2], "cop_y": [0.0, 0.0]}, support="foot")
        <sesc.Log table: 3 columns, 2 rows>
    """

    def __init__(
        self,
        data: Any,
        *,
        support: str | None = None,
        angles: Angles | None = None,
        columns: Mapping[str, str] | None = None,
        name: str | None = None,
        robot: Robot | None = None,
        readings_per_pose: int | None = None,
        cells: Sequence[Sequence[float]] | Float64 | None = None,
        gravity: Sequence[float] | Float64 | None = None,
        both_feet: bool | None = None,
        other_foot: str | None = None,
        topic: str | None = None,
        joints_topic: str | None = None,
        experiment: str | None = None,
        sensors: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> None:
        settings = {
            "support": support,
            "angles": angles,
            "readings_per_pose": readings_per_pose,
            "cells": _numbers("cells", cells, "x and y of each cell, m"),
            "gravity": _numbers("gravity", gravity, "its three components in the support frame, m/s²"),
            "both_feet": both_feet,
            "other_foot": other_foot,
            "topic": topic,
            "joints_topic": joints_topic,
            "experiment": experiment,
            "columns": None if columns is None else dict(columns),
            "sensors": None if sensors is None else {name: dict(own) for name, own in sensors.items()},
        }
        given = {key: value for key, value in settings.items() if value is not None}
        self._robot = robot
        self._settings = json.dumps(given) if given else None
        self._inner = _opened(data, name, self._settings)

    @classmethod
    def _of(cls, inner: _sesc.Log, robot: Robot | None) -> Log:
        log = cls.__new__(cls)
        log._robot, log._settings, log._inner = robot, None, inner
        return log

    @property
    def name(self) -> str:
        """What messages call the log.

        Example:
            >>> log.name
            'table'
        """
        return self._inner.name

    @property
    def settings(self) -> dict[str, Any]:
        """What its sidecar says, or the arguments that win over it.

        Raises:
            LogError: a sidecar that is gone or faulty by now.

        Example:
            >>> log.settings["support"]
            'foot'
        """
        found: dict[str, Any] = json.loads(self._inner.settings)
        return found

    @property
    def health(self) -> list[Finding]:
        """What is wrong with the data themselves, before any fit; empty where nothing is.

        Rows that were copied, channels that end at one value, cells that are unplugged; with
        ``robot=`` also encoders that are stuck, readings of the other foot, a dead axis of the
        CoP, shuffled rows, readings outside the sole.

        Raises:
            LogError: a file that is no log, with its line and column.

        Example:
            >>> isinstance(log.health, list)
            True
        """
        return [Finding(*found) for found in self._inner.health(self._robot)]

    def to_dict(self) -> dict[str, Any]:
        """Name, settings and health, for JSON.

        Raises:
            LogError: a file that is no log, with its line and column.

        Example:
            >>> log.to_dict()["name"]
            'table'
        """
        health = [finding._asdict() for finding in self.health]
        return {"name": self.name, "settings": self.settings, "health": health}

    def columns(self) -> dict[str, Any]:
        """The columns of a log in memory, by name: for ``polars.DataFrame``, ``pandas.DataFrame``.

        Raises:
            ArgumentTypeError: the log is a file, whose columns were not read.

        Example:
            >>> list(log.columns())
            ['hip', 'cop_x', 'cop_y']
        """
        columns = self._inner.columns()
        if columns is None:
            raise ArgumentTypeError(f"{self.name} is a file; read its columns with the tool that it is for")
        return columns

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a simulated log to ``path`` (.csv, .csv.gz or .parquet) with its sidecar.

        Raises:
            LogError: a log that was not simulated, or a file that cannot be written (an ``OSError``, too).

        Example:
            >>> sesc.simulate(model, 10).save(folder / "log.csv")
            >>> sorted(path.name for path in folder.glob("log.csv*"))
            ['log.csv', 'log.csv.toml']
        """
        self._inner.write(os.fspath(path))

    def __len__(self) -> int:
        size = self._inner.size
        if size is None:
            raise ArgumentTypeError(f"{self.name} is a file; its rows are counted when it is read")
        return size[1]

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        size = self._inner.size
        if size is None:
            return f"<sesc.Log {self.name}>"
        return f"<sesc.Log {self.name}: {size[0]} columns, {size[1]} rows>"

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [(finding.kind, finding.target, finding.sentence) for finding in self.health]
        return table(repr(self)[1:-1], ("finding", "where", "what"), rows or [("none", "", "")])

    def __reduce__(self) -> tuple[Any, ...]:
        columns = self._inner.columns()
        if columns is None and self._inner.content() is None:
            return _restore, (self.name, None, self._inner.settings if self._settings else None, self._robot)
        content = self._inner.content() if columns is None else columns
        return _restore, (self.name, content, self._inner.settings, self._robot)


def _restore(name: str, content: Any, settings: str | None, robot: Robot | None) -> Log:
    return Log._of(_opened(name if content is None else content, name, settings), robot)


def _opened(data: Any, name: str | None, settings: str | None) -> _sesc.Log:
    if isinstance(data, (str, os.PathLike)):
        return _sesc.Log.file(os.fspath(data), settings)
    if isinstance(data, (bytes, bytearray, memoryview)):
        return _sesc.Log.bytes(name or "bytes", bytes(data), settings)
    if hasattr(data, "read"):
        content = data.read()
        content = content.encode() if isinstance(content, str) else content
        return _sesc.Log.bytes(name or str(getattr(data, "name", "stream")), content, settings)
    return _sesc.Log.table(name or "table", _columns(data), settings)


def _columns(data: Any) -> list[tuple[str, Any]]:
    """Columns of a table, in types that a log knows."""
    if isinstance(data, Mapping):
        named = [(str(name), column) for name, column in data.items()]
    elif hasattr(data, "__arrow_c_stream__") and not _is_pandas(data):
        named = _arrow.columns(data)
    elif hasattr(data, "collect"):
        raise ArgumentTypeError(f"collect() the {type(data).__name__} first: a log is read more than once")
    elif hasattr(data, "columns") and hasattr(data, "__getitem__"):
        named = [(str(name), data[name]) for name in data.columns]
    else:
        raise ArgumentTypeError(f"a log is a path, a file, bytes, a table or a dict of arrays, not {type(data).__name__}")
    return [(name, _column(name, column)) for name, column in named]


#: Units of times that Arrow has, s.
_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def _seconds(times: Any) -> Float64:
    """Durations, or times since 1970 (UTC), s; NaN where there is none. As from Arrow."""
    unit, count = np.datetime_data(times.dtype)
    if unit not in _UNITS or count != 1:
        unit = "ns"
        times = times.astype(f"{times.dtype.kind}8[ns]")
    seconds = times.astype(np.int64).astype(np.float64) * _UNITS[unit]
    seconds[np.isnat(times)] = np.nan
    return np.ascontiguousarray(seconds)


def _datetimes(values: list[Any]) -> Any:
    """Times of Python, with a zone or in UTC, as those of numpy; None where others are among them."""
    if not any(isinstance(x, datetime) for x in values):
        return None
    if not all(isinstance(x, datetime) or _is_missing(x) for x in values):
        return None
    plain = [None if _is_missing(x) else x.astimezone(timezone.utc) if x.tzinfo else x for x in values]
    return np.array([None if x is None else x.replace(tzinfo=None) for x in plain], dtype="datetime64[us]")


def _is_missing(x: Any) -> bool:
    """None, NaN, NaT, and pandas' NA, which is nothing that it is compared with."""
    try:
        return x is None or bool(x != x)
    except TypeError:
        return True


def _numbers(name: str, given: Any, what: str) -> Any:
    try:
        return None if given is None else np.asarray(given, dtype=float).tolist()
    except (TypeError, ValueError):
        raise LogError(f"`{name}` {given!r}: give {what}") from None


def _of_column(name: str, what: str) -> LogError:
    error = LogError(f"column `{name}`: {what}")
    error.column = name
    return error


def _is_pandas(data: Any) -> bool:
    # Its own columns are numpy's already; its Arrow stream needs pyarrow.
    return type(data).__module__.split(".")[0] == "pandas"


def _column(name: str, column: Any) -> Any:
    if isinstance(column, _sesc.Unusable):
        return column
    try:
        if getattr(getattr(column, "dt", None), "tz", None) is not None:
            column = column.dt.tz_convert("UTC").dt.tz_localize(None)
        array = column.to_numpy() if hasattr(column, "to_numpy") else np.asanyarray(column)
    except ValueError as wrong:
        raise _of_column(name, str(wrong)) from None
    if array.ndim > 1:
        raise _of_column(name, f"its shape is {array.shape}; give one value a row")
    array = unmasked(array)
    if name == "support" or array.dtype.kind in "UST":
        return ["" if _is_missing(text) else str(text) for text in array.tolist()]
    if array.dtype.kind == "O":
        values = array.tolist()
        times = _datetimes(values)
        if times is not None:
            return _seconds(times)
        try:
            array = np.array([np.nan if _is_missing(x) else x for x in values], dtype=np.float64)
        except (TypeError, ValueError):
            return [str(x) for x in values]
        if array.ndim > 1:
            return _sesc.Unusable(len(values), "lists")
    if array.dtype.kind in "mM":
        return _seconds(array)
    if array.dtype.kind in "iub" and name == "pose":
        return np.ascontiguousarray(array, dtype=np.int64)
    if array.dtype.kind not in "fiub":
        return _sesc.Unusable(len(array), f"values of the type {array.dtype}")
    return np.ascontiguousarray(array, dtype=np.float64)
