"""What long calls share: logs in any form, progress, folders."""

from __future__ import annotations

import inspect
import operator
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Union

from ._errors import ArgumentError, ArgumentTypeError
from ._log import Log
from ._words import Angles, Motion

#: ``True`` prints how far a call is; a function receives what is done, how much, and of how much,
#: and how many seconds are left if it takes that, too.
Progress = Union[
    bool,
    Callable[[str, int, Union[int, None]], object],
    Callable[[str, int, Union[int, None], Union[float, None]], object],
]


def logs(given: Any) -> list[Log]:
    """One log or many, each a :class:`Log` or what one is made of."""
    if isinstance(given, (list, tuple)):
        return [one if isinstance(one, Log) else Log(one) for one in given]
    return [given if isinstance(given, Log) else Log(given)]


def one_log(given: Any, error: type[Exception], further: str = "") -> Log:
    """The one log of a call that takes no more."""
    found = logs(given)
    if len(found) != 1:
        raise error(f"one log is asked for, not {len(found)}{further}")
    return found[0]


def whole(name: str, given: Any, least: int, error: type[Exception]) -> int:
    """A whole number."""
    try:
        number = operator.index(given)
    except TypeError:
        raise ArgumentTypeError(f"`{name}` {given!r}: give a whole number") from None
    if not least <= number < 1 << 63:
        raise error(f"`{name}` {number}: give a whole number, {least or 'zero'} or more")
    return number


def number(name: str, given: Any) -> float | None:
    """A number, or nothing; what it may be is the library's to say."""
    if given is None:
        return None
    if isinstance(given, str) or not (hasattr(given, "__float__") or hasattr(given, "__index__")):
        raise ArgumentTypeError(f"`{name}` {given!r}: give a number")
    return float(given)


def shown(progress: Progress) -> Callable[[str, int, int | None], object] | None:
    """The function that is told how far a call is."""
    if progress is False or progress is None:
        return None
    show: Any = _print if progress is True else progress
    if not _takes_four(show):
        return show  # type: ignore[no-any-return]
    clock = _Clock()
    return lambda what, done, total: show(what, done, total, clock.left(what, done, total))


def _takes_four(show: Callable[..., object]) -> bool:
    """Whether a function has four arguments of its own; ``print`` takes any number, and has none."""
    try:
        given = inspect.signature(show).parameters.values()
    except (TypeError, ValueError):
        return False
    return sum(one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD) for one in given) >= 4


class _Clock:
    """Estimates the end of a call: what is left goes as the last tenth went."""

    def __init__(self) -> None:
        self._what = ""
        #: Since when, from how much on, and how long one took before that.
        self._from = (0.0, 0)
        self._each: float | None = None

    def left(self, what: str, done: int, total: int | None) -> float | None:
        now = time.monotonic()
        if what != self._what or done < self._from[1]:
            self._what, self._from, self._each = what, (now, done), None
        if not total:
            return None
        since, first = self._from
        if done > first and (10 * (done - first) >= total or self._each is None):
            self._each = (now - since) / (done - first)
            if 10 * (done - first) >= total:
                self._from = (now, done)
        return None if self._each is None else self._each * max(total - done, 0)


def _print(what: str, done: int, total: int | None, left: float | None) -> None:
    if sys.stdout is None:  # of services, and of programs without a console
        return
    part = f"{done / total:4.0%}" if total else f"{done}"
    end = "" if left is None else f", {_time(left)} left"
    sys.stdout.write(f"\r{what} {part}{end}  ")
    sys.stdout.flush()


def _time(seconds: float) -> str:
    """``40 s``, ``3 min``, ``2 h 10 min``."""
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"


@contextmanager
def showing(progress: Progress) -> Iterator[Callable[[str, int, int | None], object] | None]:
    """The function that is told how far a call is; the line of :func:`_print` is cleared in the end."""
    try:
        yield shown(progress)
    finally:
        if progress is True and sys.stdout is not None:
            sys.stdout.write("\r" + " " * 60 + "\r")
            sys.stdout.flush()


def degrees(angles: Angles | None) -> bool | None:
    """The unit of revolute joints."""
    if angles not in (None, "deg", "rad"):
        raise ArgumentError(f"`angles` {angles!r}: give 'deg' or 'rad'")
    return None if angles is None else angles == "deg"


def motion(motion: Motion) -> bool:
    """Whether the motion of the joints counts where a log knows it."""
    if motion not in ("auto", "off"):
        raise ArgumentError(f"`motion` {motion!r}: give 'auto' or 'off'")
    return motion == "auto"


def written(path: str | os.PathLike[str], text: str) -> None:
    """Write ``text`` to ``path``, whole or not at all."""
    from . import _sesc

    _sesc.write_text(os.fspath(path), text)


def strings(given: Iterable[Any]) -> list[str]:
    return [str(one) for one in given]
