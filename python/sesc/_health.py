"""What is wrong with data themselves."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["Finding"]


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
