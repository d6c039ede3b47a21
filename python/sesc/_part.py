"""Parts: what logs contribute to a fit, as values that merge and travel."""

from __future__ import annotations

import json
import os
from typing import Any

from . import _run, _sesc
from ._errors import PartError, check_first, unreadable
from ._found import Finding
from ._model import Robot
from ._run import Progress
from ._words import Angles, Motion, Prior, Robust

__all__ = ["Part", "gather", "options_of"]


class Part:
    """What logs contribute to a fit, as a value: small, mergeable, free of the logs themselves.

    Made by :func:`sesc.gather`; ``a | b`` are both together, ``bytes(a)`` go to files and other
    machines and come back by :meth:`from_bytes`. Merging in any order gives the same fit up to
    rounding. Parts of two robots, of two units, or gathered with other options are refused, and
    so is a log that is in both (``sesc.fit(parts, duplicates="skip")`` leaves it out).

    Example:
        >>> a = sesc.gather(robot, log)
        >>> sesc.Part.from_bytes(bytes(a)) == a
        True
    """

    def __init__(self, inner: _sesc.Part) -> None:
        self._inner = inner
        self._about: dict[str, Any] = json.loads(inner.about())

    @classmethod
    def from_bytes(cls, data: bytes) -> Part:
        """The part that ``bytes(part)`` are of.

        Raises:
            PartError: bytes of something else, or damaged.

        Example:
            >>> sesc.Part.from_bytes(bytes(part)) == part
            True
        """
        return cls(_sesc.Part.parse(bytes(data)))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Part:
        """The part in a file, of :meth:`save` or ``sesc fit --partial``.

        Raises:
            PartError: a file that cannot be read (an ``OSError`` too), or is no part.

        Example:
            >>> part.save(folder / "monday.part")
            >>> sesc.Part.load(folder / "monday.part") == part
            True
        """
        try:
            with open(path, "rb") as file:
                data = file.read()
        except OSError as error:
            raise unreadable("PartError", os.fspath(path), error) from error
        return cls.from_bytes(data)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it to ``path`` (ending in .part, for the command line), whole or not at all.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> part.save(folder / "monday.part")
            >>> (folder / "monday.part").read_bytes() == bytes(part)
            True
        """
        _sesc.write_bytes(os.fspath(path), bytes(self))

    @property
    def postures(self) -> int:
        """Postures of all logs.

        Example:
            >>> part.postures
            30
        """
        return int(self._about["postures"])

    @property
    def support(self) -> str:
        """Link whose parameters the sums are about.

        Example:
            >>> part.support
            'foot'
        """
        return str(self._about["support"])

    @property
    def supports(self) -> list[str]:
        """All links that postures stood on.

        Example:
            >>> part.supports
            ['foot']
        """
        return list(self._about["supports"])

    @property
    def robot_hash(self) -> str:
        """Hash of the URDF.

        Example:
            >>> part.robot_hash == robot.hash
            True
        """
        return str(self._about["robot_hash"])

    @property
    def unit(self) -> str | None:
        """The robot of its type that the logs are of; None where nobody said.

        Example:
            >>> sesc.gather(robot, log, unit="r07").unit
            'r07'
        """
        unit: str | None = self._about["unit"]
        return unit

    @property
    def options(self) -> dict[str, Any]:
        """The options that shaped the sums: ``motion``, ``stays``, ``robust``.

        Example:
            >>> part.options["motion"]
            'auto'
        """
        return dict(self._about["options"])

    @property
    def logs(self) -> list[dict[str, Any]]:
        """The logs in it: name, hash of the content, rows.

        Example:
            >>> part.logs[0]["rows"]
            30
        """
        return [{key: log[key] for key in ("file", "hash", "rows")} for log in self._about["logs"]]

    @property
    def health(self) -> list[Finding]:
        """What is wrong with the logs themselves.

        Example:
            >>> isinstance(part.health, list)
            True
        """
        return [Finding(f["kind"], f["target"], f["sentence"]) for f in self._about["health"]]

    @property
    def warnings(self) -> list[str]:
        """What was odd about the logs, a sentence each.

        Example:
            >>> isinstance(part.warnings, list)
            True
        """
        return list(self._about["warnings"])

    def to_dict(self) -> dict[str, Any]:
        """Its properties, for JSON.

        Example:
            >>> part.to_dict()["postures"]
            30
        """
        names = ("postures", "support", "supports", "robot_hash", "unit", "options", "logs", "warnings")
        health = [finding._asdict() for finding in self.health]
        return {name: getattr(self, name) for name in names} | {"health": health}

    def __or__(self, other: Part) -> Part:
        if not isinstance(other, Part):
            return NotImplemented
        return Part(self._inner.merged(other._inner))

    def __bytes__(self) -> bytes:
        return self._inner.to_bytes()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Part) and bytes(self) == bytes(other)

    def __hash__(self) -> int:
        return hash(bytes(self))

    def __repr__(self) -> str:
        logs = len(self.logs)
        unit = f" of unit {self.unit}" if self.unit is not None else ""
        return f"<sesc.Part{unit} on {self.support}: {self.postures} postures of {logs} log{'s' * (logs != 1)}>"

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [(log["file"], log["rows"], log["hash"]) for log in self.logs]
        return table(repr(self)[1:-1], ("log", "rows", "hash"), rows)

    def __reduce__(self) -> tuple[Any, ...]:
        return Part.from_bytes, (bytes(self),)


def gather(
    robot: Robot,
    log: Any,
    *,
    support: str | None = None,
    angles: Angles | None = None,
    prior: Prior = "cad",
    noise: float | None = None,
    robust: Robust | None = None,
    folds: int | None = None,
    motion: Motion = "auto",
    settle: float | None = None,
    unit: str | None = None,
    progress: Progress = False,
) -> Part:
    """What logs contribute to a fit, to be fitted later, with others, or elsewhere.

    Keywords are those of :func:`fit`; those that are settled here cannot differ later. ``unit``
    names the robot of its type, such as by its serial number: parts of two are never merged.

    Raises:
        PartError: logs that cannot be used.
        LogError: a log that cannot be read.

    Example:
        >>> sesc.gather(robot, log)
        <sesc.Part on foot: 30 postures of 1 log>
    """
    check_first(robot, Robot, "a robot")
    options = options_of(support, angles, prior, noise, robust, folds, None, False, motion, settle, unit)
    logs = _run.logs(log)
    if not logs:
        raise PartError("no logs to gather; give one or more")
    with _run.showing(progress) as show:
        inner = _sesc.Part.gather(robot, [one._inner for one in logs], options, show)
    return Part(inner)


def options_of(
    support: str | None,
    angles: Angles | None,
    prior: Prior,
    noise: float | None,
    robust: Robust | None,
    folds: int | None,
    range: float | None,
    physical: bool,
    motion: Motion,
    settle: float | None,
    unit: str | None,
) -> dict[str, Any]:
    """Keywords that fits and parts share, as the compiled module takes them."""
    return {
        "support": support,
        "degrees": _run.degrees(angles),
        "prior": os.fspath(prior),
        "noise": noise,
        "robust": robust,
        "folds": folds,
        "range": range,
        "physical": physical,
        "motion": _run.motion(motion),
        "settle": settle,
        "unit": unit,
        "duplicates": "refuse",
        "offset": None,
    }
