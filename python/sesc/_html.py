"""What a notebook shows: tables, and the pages of reports without scripts. A notebook keeps every
cell, so that one is below 200 kB: what is longer is left out, and the cell says so."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

__all__ = ["framed", "pictures", "steps", "table"]

_CODE = re.compile("`([^`]*)`")
_SCRIPT = re.compile("<script.*?</script>", re.DOTALL)
_FIGURE = re.compile("<svg.*?</svg>", re.DOTALL)

#: Bytes of a page in a cell, and of the rows of a table or the pictures above one.
_PAGE, _PIECES = 190_000, 90_000


def _first(pieces: Iterable[str]) -> tuple[list[str], int]:
    """The first of some pieces that a cell has room for, and how many there are more."""
    pieces, room = list(pieces), _PIECES
    for k, piece in enumerate(pieces):
        room -= len(piece.encode())
        if room < 0:
            return pieces[:k], len(pieces) - k
    return pieces, 0


def table(title: str, heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table; every cell is text."""
    cells = [[html.escape(str(cell)) for cell in row] for row in rows]
    lines, more = _first("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in cells)
    head, _ = _first(f"<th>{html.escape(name)}</th>" for name in heads)
    lines += [f"<tr><td colspan='{len(head)}'>and {more} more rows</td></tr>"] * (more > 0)
    return (
        f"<table><caption>{html.escape(title)}</caption><thead><tr>{''.join(head)}</tr></thead>"
        f"<tbody>{''.join(lines)}</tbody></table>"
    )


def pictures(drawn: Iterable[str], width: int) -> str:
    """Figures side by side, each ``width`` pixels wide; they bring their colours along."""
    figures, _ = _first(f'<div style="width: {width}px">{figure}</div>' for figure in drawn)
    return f'<div style="display: flex; flex-wrap: wrap; gap: 8px">{"".join(figures)}</div>'


def steps(found: Iterable[Mapping[str, str]]) -> str:
    """What to do next, a line each, with the call that does it."""
    lines = ""
    for step in found:
        call = f" <code>{html.escape(step['command'])}</code>" if "command" in step else ""
        said = _CODE.sub(r"<code>\1</code>", html.escape(f"{step['what']}: {step['why']}."))
        lines += f"<li>{said}{call}</li>"
    return f"<ol>{lines}</ol>"


def framed(page: str, text: str) -> str:
    """The page of a report in a frame of its own, without what only scripts need: the largest
    figures are left out where they have no room, and the page gives way to its ``text`` where the
    rest has none."""
    page = _SCRIPT.sub("", page)
    figures = _FIGURE.findall(page)
    room = _PAGE - len(page.encode())
    left_out = 0
    for figure in sorted(figures, key=len, reverse=True):
        if room >= 0:
            break
        page = page.replace(figure, "", 1)
        room += len(figure.encode())
        left_out += 1
    if room < 0:
        shown, more = _first(html.escape(line) + "\n" for line in text.splitlines())
        end = f"and {more} more lines" if more else ""
        return f"<pre>{''.join(shown)}{end}</pre>"
    note = "all of the page"
    if left_out:
        note = f"{left_out} of {len(figures)} figures have no room here: all of them"
    source = page.replace("&", "&amp;").replace("'", "&#x27;")
    return (
        f"<iframe srcdoc='{source}' sandbox style='width: 100%; height: 640px; border: 0'></iframe>"
        f"<p>{note}, and what moves in it, are in the file that <code>.report(\"report.html\")</code> writes</p>"
    )
