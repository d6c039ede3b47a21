"""Words that arguments are, for checkers of types."""

from __future__ import annotations

import os
from typing import Literal, Union

__all__ = ["Angles", "Duplicates", "Layout", "Motion", "Only", "Prior", "Robust", "Scalar", "Verdict"]

Angles = Literal["deg", "rad"]
Duplicates = Literal["refuse", "skip"]
Layout = Literal["bare", "cmake", "platformio", "arduino"]
Motion = Literal["auto", "off"]
Only = Literal["parameters"]
#: A file is given as a ``pathlib.Path``, so that a word that is none is found before it is run.
Prior = Union[Literal["tight", "cad", "free"], "os.PathLike[str]"]
Robust = Literal["huber", "tukey"]
Scalar = Literal["f64", "f32", "fixed32"]
Verdict = Literal["none", "named", "class", "absorbed", "unexplained", "too_short", "unusable"]
