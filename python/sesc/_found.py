"""What results share: the keys of the command's JSON, and what is wrong with data."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

__all__ = ["Finding", "Found", "FoundInLogs"]


class Finding(NamedTuple):
    """Something that is wrong with a log.

    Attributes:
        kind: one word, such as ``encoder_stuck``.
        target: joint, link, axis or cell; ``-`` where it is the whole log.
        sentence: what is wrong, and what it means.

    Example:
        >>> sesc.Finding("encoder_stuck", "hip", "it does not move").target
        'hip'
    """

    kind: str
    target: str
    sentence: str

    def to_dict(self) -> dict[str, str]:
        """Its fields, as in the JSON of the commands.

        Example:
            >>> sesc.Finding("encoder_stuck", "hip", "it does not move").to_dict()["kind"]
            'encoder_stuck'
        """
        return self._asdict()

    def _repr_html_(self) -> str:
        from ._html import table

        return table("", self._fields, [self])


class Found:
    """A result with the keys of the command's JSON as attributes; commands of next steps are
    calls."""

    def __init__(self, state: dict[str, Any]) -> None:
        self._state = state
        self._found: dict[str, Any] = json.loads(state["json"])

    def to_dict(self) -> dict[str, Any]:
        """What the command prints with ``--json``, key by key; commands of next steps are calls.

        Example:
            >>> fit.to_dict()["support"]
            'foot'
        """
        found: dict[str, Any] = json.loads(self._state["json"])
        return found

    def __getattr__(self, name: str) -> Any:
        found = self.__dict__.get("_found", {})
        if name in found:
            return found[name]
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._found})

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._state,)


class FoundInLogs(Found):
    """What a fit or a diagnosis found. Its text is that of the command, with calls for command
    lines."""

    @property
    def health(self) -> list[Finding]:
        """What is wrong with the data themselves.

        Example:
            >>> isinstance(fit.health, list)
            True
        """
        return [Finding(f["kind"], f["target"], f["sentence"]) for f in self._found["health"]]

    @property
    def warnings(self) -> list[str]:
        """What should be known before the result is used, a sentence each.

        Example:
            >>> isinstance(fit.warnings, list)
            True
        """
        return list(self._state["warnings"])

    @property
    def notes(self) -> list[str]:
        """What is to be known of the robot, a sentence each.

        Example:
            >>> isinstance(fit.notes, list)
            True
        """
        return list(self._state["notes"])

    def __str__(self) -> str:
        return str(self._state["text"])
