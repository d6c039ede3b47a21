"""What a notebook shows: tables, and the pages of reports without scripts."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

__all__ = ["framed", "pictures", "steps", "table"]

_CODE = re.compile("`([^`]*)`")


def table(title: str, heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table; every cell is text."""
    cells = [[html.escape(str(cell)) for cell in row] for row in rows]
    head = "".join(f"<th>{html.escape(name)}</th>" for name in heads)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in cells)
    return (
        f"<table><caption>{html.escape(title)}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{body}</tbody></table>"
    )


def pictures(drawn: Iterable[str], width: int) -> str:
    """Figures side by side, each ``width`` pixels wide; they bring their colours along."""
    figures = "".join(f'<div style="width: {width}px">{figure}</div>' for figure in drawn)
    return f'<div style="display: flex; flex-wrap: wrap; gap: 8px">{figures}</div>'


def steps(found: Iterable[Mapping[str, str]]) -> str:
    """What to do next, a line each, with the call that does it."""
    lines = ""
    for step in found:
        call = f" <code>{html.escape(step['command'])}</code>" if "command" in step else ""
        said = _CODE.sub(r"<code>\1</code>", html.escape(f"{step['what']}: {step['why']}."))
        lines += f"<li>{said}{call}</li>"
    return f"<ol>{lines}</ol>"


def framed(page: str) -> str:
    """The page of a report, with its figures and its own style, in a frame of its own."""
    from ._sesc import escape_html

    source = escape_html(page)
    return f'<iframe srcdoc="{source}" sandbox style="width: 100%; height: 640px; border: 0"></iframe>'
