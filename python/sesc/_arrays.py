"""What is taken for an array of postures: one conversion, once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Float64 = NDArray[np.float64]
else:
    Float64 = np.ndarray


def positions(given: Any, joints: list[str], name: str) -> Float64:
    """``given`` as a C-contiguous array of 64-bit floats, joints along its last axis.

    A mapping or a data frame is asked for its joints by name, whatever else it holds.
    """
    if hasattr(given, "keys") and not isinstance(given, np.ndarray):
        columns = given
    elif hasattr(given, "columns") and hasattr(given, "__getitem__"):
        columns = given
    else:
        return _floats(given, name)
    missing = [joint for joint in joints if joint not in columns]
    if missing and not hasattr(given, "keys"):
        names = list(given.columns)
        missing = [joint for joint in joints if joint not in names]
    if missing:
        raise ValueError(f"{name} has no column for {', '.join(missing)}")
    return np.stack([_floats(columns[joint], f"{name}[{joint!r}]") for joint in joints], axis=-1)


def _floats(given: Any, name: str) -> Float64:
    array = np.asarray(given)
    if array.dtype.kind not in "fiu" and array.size:
        raise TypeError(f"{name} holds {array.dtype}; give numbers (rad, m)")
    return np.require(array, dtype=np.float64, requirements=["C", "A"]).reshape(array.shape)
