"""What the command line says in its own words, in those of Python: options are keywords, command
lines are calls."""

from __future__ import annotations

import html
import json
import re
import shlex

__all__ = ["in_python", "page_in_python"]

#: What options of the command line that write files are in Python.
_WRITTEN = {"--next": "next_postures().save", "--out": "save", "--report": "report", "--urdf": "correct_urdf().save"}
#: Where what was left out is.
_ELSEWHERE = {
    "see --json": "see `.to_dict()`",
    "named by --json, --report": "named by `.to_dict()`, `.report(…)`",
}
_COMMAND = re.compile(r"^( +)(sesc \w+ .*)$", re.MULTILINE)


def in_python(text: str) -> str:
    """``text`` of a command, in which next steps are calls and hints name what Python has."""
    for theirs, ours in _ELSEWHERE.items():
        text = text.replace(theirs, ours)
    return _COMMAND.sub(lambda line: line[1] + _call(line[2]), text)


def page_in_python(page: str) -> str:
    """The page of a report, in which next steps are calls."""
    first, *further = page.split("<code>sesc ")
    pieces = [first]
    for piece in further:
        line, _, rest = piece.partition("</code>")
        command = "sesc " + html.unescape(line)
        said = _call(command) if " URDF " in command else command
        pieces.append(f"<code>{html.escape(said)}</code>{rest}")
    return "".join(pieces)


def _call(line: str) -> str:
    """``sesc fit URDF --support foot --data LOG`` as ``sesc.fit(robot, "LOG", support="foot")``."""
    _, name, _, *words = shlex.split(line)
    arguments, written = ["robot"], ""
    for option, value in zip(words[::2], words[1::2]):
        said = json.dumps(value, ensure_ascii=False)
        if option == "--data":
            arguments.insert(1, said)
        elif option in _WRITTEN:
            written = f".{_WRITTEN[option]}({said})"
        else:
            arguments.append(f"{option.lstrip('-').replace('-', '_')}={said}")
    return f"sesc.{name}({', '.join(arguments)}){written}"
