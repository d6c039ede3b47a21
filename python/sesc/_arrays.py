"""What is taken for an array of postures: one conversion, once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import ArgumentError, ArgumentTypeError

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
        return floats(given, name)
    missing = [joint for joint in joints if joint not in columns]
    if missing and not hasattr(given, "keys"):
        names = list(given.columns)
        missing = [joint for joint in joints if joint not in names]
    if missing:
        raise ArgumentError(f"{name} has no column for {', '.join(missing)}")
    return np.stack([floats(columns[joint], f"{name}[{joint!r}]") for joint in joints], axis=-1)


def array_of(given: Any, name: str) -> Any:
    """``given`` as an array of numpy, with its mask if it has one."""
    try:
        return np.asanyarray(given)
    except ValueError:
        what = "give every posture the same number of values"
        raise ArgumentError(f"{name} has rows of different lengths; {what}") from None


def unmasked(array: Any) -> Any:
    """An array without its mask: masked numbers are NaN, of other things nothing is masked."""
    if not isinstance(array, np.ma.MaskedArray):
        return array
    if array.dtype.kind not in "fiu":
        return array.filled()
    numbers = np.array(np.ma.getdata(array), dtype=np.float64)
    numbers[np.ma.getmaskarray(array)] = np.nan
    return numbers


def floats(given: Any, name: str) -> Float64:
    """``given`` as a C-contiguous array of 64-bit floats; NaN where a mask covers one."""
    array = unmasked(array_of(given, name))
    if array.dtype.kind not in "fiu" and array.size:
        raise ArgumentTypeError(f"{name} holds {array.dtype}; give numbers (rad, m)")
    return np.require(array, dtype=np.float64, requirements=["C", "A"]).reshape(array.shape)
