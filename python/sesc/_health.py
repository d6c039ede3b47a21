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
    """

    kind: str
    target: str
    sentence: str
