"""Options of functions are keywords, and have the names that the command line has."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

import sesc

#: Each command, and what has its options in Python.
COMMANDS: dict[str, list[Callable[..., Any]]] = {
    "inspect": [sesc.Robot.on],
    "generate": [sesc.Robot.on, sesc.Model.c99, sesc.Model.rust],
    "verify": [sesc.Robot.on, sesc.verify],
    "simulate": [sesc.Robot.on, sesc.simulate],
    "plan": [sesc.plan],
    "predict": [sesc.Robot.on, sesc.predict],
    "fit": [sesc.fit, sesc.gather, sesc.Log, sesc.Fit.correct_urdf],
    "diagnose": [sesc.diagnose, sesc.Log, sesc.Diagnosis.correct_urdf],
    "compare": [sesc.compare, sesc.diagnose, sesc.Log],
    "fleet": [sesc.fleet.run, sesc.fleet.Fleet.report],
}
#: What Python says in another way, and where.
OTHERWISE = {
    "no_snap": "Robot(snap=False)",
    "xacro": "Robot(xacro=True)",
    "sole_height": "the support `foot@40mm`",
    "degrees": 'angles="deg"',
    "data": "an argument",
    "long": "to_dict() has all of it",
    "lang": "Model.c99, Model.rust",
    "out": "save()",
    "urdf": "correct_urdf(); of a comparison the models' own",
    "report": "report()",
    "next": "next_postures()",
    "partial": "gather()",
    "prior_out": "save_prior()",
    "json": "to_dict()",
    "help": "help()",
    "color": "colours of a terminal",
    "quiet": "nothing is written to stderr",
    "fail_above": "the exit code of a script",
}


def options_of(command: str) -> set[str]:
    words = [sys.executable, "-m", "sesc", command, "--help"]
    text = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    found = re.findall(r"^ {2,6}(?:-\w, )?--([a-z][a-z-]*)(?= <|$|\s{2}|\[)", text, flags=re.M)
    return {option.replace("-", "_") for option in found}


@pytest.mark.parametrize("command", COMMANDS)
def test_options_have_the_names_of_the_command(command: str) -> None:
    options = options_of(command)
    assert {"json", "help"} < options
    named = {name for call in COMMANDS[command] for name in inspect.signature(call).parameters}
    assert options - named <= set(OTHERWISE), options - named - set(OTHERWISE)


#: What the package's contract lets stand without a name; other classes are made by the package.
PLACED = {
    "Robot": ["path_or_text", "snap", "xacro"],
    "Robot.on": ["self", "support", "model"],
    "Model": ["robot", "support", "model"],
    "Postures": ["model", "q", "experiment"],
    "fit": ["robot", "log"],
    "fleet.run": ["robot", "paths_or_table", "by", "store", "engine"],
    "Diagnosis.next_postures": ["self", "n"],
}


def test_options_are_keywords() -> None:
    calls: dict[str, Any] = {}
    for space, name in [(sesc, ""), (sesc.fleet, "fleet.")]:
        for own in space.__all__:
            thing = getattr(space, own)
            if inspect.isclass(thing) and not issubclass(thing, (Exception, tuple)):
                if own in ("Robot", "Model", "Log", "Postures"):
                    calls[own] = thing
                members = inspect.getmembers(thing, inspect.isfunction)
                calls |= {f"{name}{own}.{key}": value for key, value in members if not key.startswith("_")}
            elif inspect.isfunction(thing):
                calls[name + own] = thing
    assert len(calls) >= 50
    for name, call in calls.items():
        parameters = inspect.signature(call).parameters.values()
        placed = [one.name for one in parameters if one.kind is not one.KEYWORD_ONLY]
        options = [one.name for one in parameters if one.kind is not one.KEYWORD_ONLY and one.default is not one.empty]
        assert not options or placed == PLACED.get(name), f"{name}: {options}"
