"""What the command line says in its own words, in those of Python: options are keywords, command
lines are calls."""

from __future__ import annotations

import html
import json
import re
import shlex
from collections.abc import Sequence
from typing import Any

__all__ = ["found_in_python", "in_python", "page_in_python"]

#: What options of the command line that write files are in Python.
_WRITTEN = {"--next": "next_postures().save", "--out": "save", "--report": "report", "--urdf": "correct_urdf().save"}
#: Where what was left out is.
_ELSEWHERE = {
    "see --json": "see `.to_dict()`",
    "named by --json, --report": "named by `.to_dict()`, `.report(…)`",
    "`--lang rust` for Rust": "`model.rust(…)` for Rust",
}
#: Options whose values are numbers.
_NUMBERS = {"--poses"}
#: Models that a call was given as objects: what next steps call them.
_OBJECTS = {f"{name}{end}" for name in ("before", "after") for end in ("", ".model")}
_COMMAND = re.compile(r"^( +)(sesc \w+ .*)$", re.MULTILINE)


def in_python(text: str) -> str:
    """``text`` of a command, in which next steps are calls and hints name what Python has."""
    for theirs, ours in _ELSEWHERE.items():
        text = text.replace(theirs, ours)
    return _COMMAND.sub(lambda line: line[1] + _call(line[2]), text)


def found_in_python(text: str) -> dict[str, Any]:
    """The JSON of a command as a dict, in which next steps are calls."""
    found: dict[str, Any] = json.loads(text)
    for step in found.get("next_steps", []):
        step["why"] = in_python(step["why"])
        if "command" in step:
            step["command"] = _call(step["command"])
    return found


def page_in_python(page: str) -> str:
    """The page of a report, in which next steps are calls."""
    for theirs, ours in _ELSEWHERE.items():
        theirs, ours = (re.sub("`([^`]*)`", r"<code>\1</code>", words) for words in (theirs, ours))
        page = page.replace(theirs, ours)
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
    _, name, first, *words = shlex.split(line)
    if name == "compare":
        logs = (f"sesc.diagnose(robot, {_said(log)})" for log in (first, words[0]))
        return f"sesc.compare({', '.join(logs)})"
    if name in ("generate", "verify"):
        return _of_a_model(name, words)
    arguments, written = ["robot"], ""
    for option, value in zip(words[::2], words[1::2]):
        said = value if option in _NUMBERS else _said(value)
        if option == "--data":
            arguments.insert(1, said)
        elif option in _WRITTEN:
            written = f".{_WRITTEN[option]}({said})"
        else:
            arguments.append(f"{option.lstrip('-').replace('-', '_')}={said}")
    return f"sesc.{name}({', '.join(arguments)}){written}"


def _of_a_model(name: str, words: Sequence[str]) -> str:
    """Commands that are methods of a model, or take one."""
    snapped = "--no-snap" not in words
    given = dict(zip(words[::2], words[1::2])) if snapped else dict(zip(words[:-1:2], words[1:-1:2]))
    model = given.get("--model")
    of = "" if model is None else f", model={model if model in _OBJECTS else _said(model)}"
    robot = "robot" if snapped else 'sesc.Robot("URDF", snap=False)'
    on = f"{robot}.on({_said(given['--support'])}{of})"
    return f"{on}.c99({_said(given['--out'])})" if name == "generate" else f"sesc.verify({on})"


def _said(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)
