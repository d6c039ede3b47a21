"""Exceptions of the package: one class for each kind of thing that goes wrong.

Every one is a :class:`SescError` and has ``file``, ``line`` and ``column`` where they are
known. Faults of an input are also a ``ValueError``, arguments of a wrong type a ``TypeError``, too; a file that cannot be opened is also the
``OSError`` that Python has for it, such as ``FileNotFoundError``.
"""

from __future__ import annotations

from typing import Any

__all__ = [
    "ArgumentError",
    "ArgumentTypeError",
    "FitError",
    "InternalError",
    "LogError",
    "ModelFileError",
    "PartError",
    "PlanError",
    "PriorError",
    "SescError",
    "SupportError",
    "UrdfError",
]


class SescError(Exception):
    """Something that cannot be done, in a sentence that says what to do instead.

    Attributes:
        file: the file with the fault, as the caller named it; None where there is none.
        line: line (of a table: row) with the fault, from 1; None where it is not one line's.
        column: column of a log with the fault; None where it is not one column's.
    """

    file: str | None = None
    line: int | None = None
    column: str | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        errno = getattr(self, "errno", None)
        kind = next(c for c in type(self).__mro__ if c.__module__ == __name__ and c.__name__ in _CLASSES)
        place = (self.file, self.line, self.column)
        return make, (kind.__name__, str(self), place, errno, getattr(self, "complaints", []))


class ArgumentError(SescError, ValueError):
    """An argument of a call that cannot be: an array of another shape, a word that is not known."""


class ArgumentTypeError(ArgumentError, TypeError):
    """An argument of a type that cannot be taken, such as text for numbers."""


class UrdfError(SescError, ValueError):
    """A robot description that cannot be used.

    Attributes:
        complaints: all that is wrong with it: pairs of a line (or None) and a sentence.
    """

    complaints: list[tuple[int | None, str]]

    def __init__(self, *args: object) -> None:
        super().__init__(*args)
        self.complaints = []


class SupportError(SescError, ValueError):
    """A support link that the robot does not have, or cannot stand on."""


class LogError(SescError, ValueError):
    """A posture log, or its sidecar, that cannot be used."""


class PriorError(SescError, ValueError):
    """Tolerances of CAD masses that make no sense."""


class ModelFileError(SescError, ValueError):
    """A model file with faults, or of another robot."""


class FitError(SescError, ValueError):
    """A fit, a diagnosis or a check that is asked for and cannot be had."""


class PlanError(SescError, ValueError):
    """Postures that are asked for and cannot be had."""


class PartError(SescError, ValueError):
    """A part of a fit that is damaged, or does not belong to the others."""


class InternalError(RuntimeError):
    """A defect of this package; please report it with what was called."""


_CLASSES: dict[str, type[SescError]] = {
    kind.__name__: kind
    for kind in (
        SescError,
        ArgumentError,
        ArgumentTypeError,
        UrdfError,
        SupportError,
        LogError,
        PriorError,
        ModelFileError,
        FitError,
        PlanError,
        PartError,
    )
}
_OF_SYSTEM: dict[tuple[type, type], type[SescError]] = {}


def _with_system(kind: type[SescError], errno: int) -> type[SescError]:
    """``kind`` that is also Python's error of that number."""
    system = type(OSError(errno, ""))
    if (kind, system) not in _OF_SYSTEM:
        members = {"__module__": kind.__module__, "__str__": lambda self: self.args[0]}
        _OF_SYSTEM[kind, system] = type(kind.__name__, (kind, system), members)
    return _OF_SYSTEM[kind, system]


def check_first(given: Any, kinds: type | tuple[type, ...], what: str) -> None:
    """A call begins with a robot, a model or a part."""
    if not isinstance(given, kinds):
        raise ArgumentTypeError(f"{what} comes first, not {type(given).__name__}")


def unreadable(kind: str, path: str, error: OSError) -> Exception:
    """The exception of a file that Python cannot read."""
    return make(kind, f"cannot read {path}: {error.strerror}", (path, None, None), error.errno, [])


def make(
    kind: str,
    message: str,
    place: tuple[str | None, int | None, str | None],
    errno: int | None,
    complaints: list[tuple[int | None, str]],
) -> Exception:
    """The exception of an error of the library."""
    if kind == "InternalError":
        return InternalError(message)
    found = _CLASSES[kind]
    error = found(message) if errno is None else _with_system(found, errno)(message)
    error.file, error.line, error.column = place
    if isinstance(error, OSError):
        error.errno, error.filename = errno, error.file
    if isinstance(error, UrdfError):
        error.complaints = list(complaints)
    return error
