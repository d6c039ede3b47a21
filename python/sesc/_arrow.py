"""Tables of other libraries, by the Arrow C stream that they give out."""

from __future__ import annotations

from typing import Any

from . import _sesc

__all__ = ["columns"]


def columns(data: Any) -> list[tuple[str, Any]]:
    """Columns of anything with ``__arrow_c_stream__``: arrays of 64-bit floats (NaN where a
    value is missing), whole numbers or texts. Times are seconds."""
    return _sesc.arrow_columns(data.__arrow_c_stream__())
