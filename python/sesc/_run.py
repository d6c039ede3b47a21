"""What long calls share: logs in any form, progress, folders."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from typing import Any, Union

from ._log import Log

#: ``True`` prints how far a call is; a function receives what is done, how much, and of how much.
Progress = Union[bool, Callable[[str, int, Union[int, None]], object]]


def logs(given: Any) -> list[Log]:
    """One log or many, each a :class:`Log` or what one is made of."""
    if isinstance(given, (list, tuple)):
        return [one if isinstance(one, Log) else Log(one) for one in given]
    return [given if isinstance(given, Log) else Log(given)]


def shown(progress: Progress) -> Callable[[str, int, int | None], object] | None:
    """The function that is told how far a call is."""
    if progress is False or progress is None:
        return None
    return _print if progress is True else progress


def _print(what: str, done: int, total: int | None) -> None:
    part = f"{done / total:4.0%}" if total else f"{done}"
    sys.stdout.write(f"\r{what} {part}  ")
    sys.stdout.flush()


def ended(progress: Progress) -> None:
    """Clear the line of :func:`_print`."""
    if progress is True:
        sys.stdout.write("\r" + " " * 60 + "\r")
        sys.stdout.flush()


def degrees(angles: str | None) -> bool | None:
    """The unit of revolute joints."""
    if angles not in (None, "deg", "rad"):
        raise ValueError(f"angles {angles!r}: give 'deg' or 'rad'")
    return None if angles is None else angles == "deg"


def motion(motion: str) -> bool:
    """Whether the motion of the joints counts where a log knows it."""
    if motion not in ("auto", "off"):
        raise ValueError(f"motion {motion!r}: give 'auto' or 'off'")
    return motion == "auto"


def written(path: str | os.PathLike[str], text: str) -> None:
    """Write ``text`` to ``path``, whole or not at all."""
    from . import _sesc

    _sesc.write_text(os.fspath(path), text)


def strings(given: Iterable[Any]) -> list[str]:
    return [str(one) for one in given]
