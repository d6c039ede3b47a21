"""Checks and look-ups: functions against the reference, two models, the effects."""

from __future__ import annotations

import json
import os
from typing import Any, NamedTuple, Union

from . import _run, _sesc
from ._diagnose import Diagnosis
from ._errors import FitError, ModelFileError, check_first
from ._fit import Fit
from ._found import Found
from ._model import Model, Robot
from ._run import Progress

__all__ = ["Comparison", "Effect", "Verification", "compare", "effects", "verify"]

#: What holds identified parameters: a model file, or what one is made of.
Identified = Union[str, "os.PathLike[str]", Fit, Diagnosis, Model]


class Effect(NamedTuple):
    """An effect that a diagnosis can name.

    Attributes:
        name: as in reports and model files: ``joint_offset``.
        target: what it acts on: ``joint``, ``joint or all``, ``two joints``, ``link``, ``cell``,
            one of a few words, or ``-`` where it has no target.
        parameters: unit of each parameter by its name: ``rad``, ``m``, ``kg``; ``1`` of a number.
        sentence: what it is.
        page: its equation, what imitates it and what tells it apart; Markdown.

    Example:
        >>> sesc.effects()["joint_offset"].parameters["offset_rad"]
        'rad'
    """

    name: str
    target: str
    parameters: dict[str, str]
    sentence: str
    page: str

    def to_dict(self) -> dict[str, Any]:
        """What ``sesc effects --json`` prints of it.

        Example:
            >>> sesc.effects()["backlash"].to_dict()["name"]
            'backlash'
        """
        parameters = [{"name": name, "unit": unit} for name, unit in self.parameters.items()]
        return {**self._asdict(), "parameters": parameters}

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [("acts on", self.target), *self.parameters.items(), ("what it is", self.sentence)]
        return table(self.name, ("", ""), rows)


def effects() -> dict[str, Effect]:
    """The effects that a diagnosis knows, by name, as ``sesc effects`` lists them.

    Example:
        >>> "backlash" in sesc.effects()
        True
    """
    found = {}
    for about in json.loads(_sesc.effects_about()):
        parameters = {one["name"]: one["unit"] for one in about["parameters"]}
        found[about["name"]] = Effect(**{**about, "parameters": parameters})
    return found


class Comparison(Found):
    """Two models of one robot, held against each other. ``str(found)`` is what ``sesc compare``
    prints, with calls for command lines.

    Example:
        >>> found = sesc.compare(sesc.fit(robot, log, noise=1e-5), sesc.fit(robot, log, noise=1e-5))
        >>> found.changed
        False
    """

    @property
    def changed(self) -> bool:
        """Whether anything differs by more than chance.

        Example:
            >>> sesc.compare(fit, fit).changed
            False
        """
        return bool(self._found["changed"])

    @property
    def chance(self) -> float | None:
        """Chance of a difference of the parameters like this one where nothing changed, 0 to 1;
        None where neither model has deviations.

        Example:
            >>> sesc.compare(fit, fit).chance > 0.01
            True
        """
        chance: float | None = self._found["chance"]
        return chance

    @property
    def sentence(self) -> str:
        """The result in sentences.

        Example:
            >>> len(sesc.compare(fit, fit).sentence) > 10
            True
        """
        return str(self._found["sentence"])

    @property
    def effects(self) -> list[dict[str, Any]]:
        """Effects of either model: ``effect``, ``target``, ``change`` (``appeared``, ``gone``,
        ``changed``, ``same``, ``unknown``) and ``parameters``, in the units of their names.

        Example:
            >>> sesc.compare(fit, fit).effects
            []
        """
        found: list[dict[str, Any]] = self.to_dict()["effects"]
        return found

    @property
    def parameters(self) -> list[dict[str, Any]]:
        """Base parameters of either model: ``name``, ``before``, ``after``, ``std``, m, and
        ``deviations``, the difference in standard deviations.

        Example:
            >>> sesc.compare(fit, fit).parameters[0]["name"] in model.param_names
            True
        """
        found: list[dict[str, Any]] = self.to_dict()["parameters"]
        return found

    def __str__(self) -> str:
        return str(self._state["text"])

    def __repr__(self) -> str:
        said = "changed" if self.changed else "no change beyond chance"
        return f"<sesc.Comparison of {self._found['robot']} on {self._found['support']}: {said}>"

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page of ``sesc compare --report``.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> sesc.compare(fit, fit).report(folder / "compare.html")
            >>> (folder / "compare.html").exists()
            True
        """
        _run.written(path, self._state["page"])

    def _repr_html_(self) -> str:
        from ._html import framed

        return framed(self._state["page"], str(self))


class Verification(Found):
    """What a comparison of the functions with the independent reference found; true where every
    difference is within its bound.

    Example:
        >>> bool(sesc.verify(model, samples=20))
        True
    """

    @property
    def passed(self) -> bool:
        """Whether every difference is within its bound.

        Example:
            >>> sesc.verify(model, samples=20).passed
            True
        """
        return bool(self._found["pass"])

    @property
    def samples(self) -> int:
        """Postures that were compared.

        Example:
            >>> sesc.verify(model, samples=20).samples >= 20
            True
        """
        return int(self._found["samples"])

    @property
    def worst_error(self) -> dict[str, float]:
        """Largest difference of each function, in the unit of :attr:`units`.

        Example:
            >>> "com" in sesc.verify(model, samples=20).worst_error
            True
        """
        return dict(self._found["worst_error"])

    @property
    def bound(self) -> dict[str, float]:
        """What rounding, snapped right angles and springs may explain, in the same units.

        Example:
            >>> sesc.verify(model, samples=20).bound["com"] < 1e-14
            True
        """
        return dict(self._found["bound"])

    @property
    def units(self) -> dict[str, str]:
        """The unit of each function's error; regressor rows are compared by the CoM they give, m.

        Example:
            >>> sesc.verify(model, samples=20).units["com"]
            'm'
        """
        return dict(self._state["units"])

    def __bool__(self) -> bool:
        return self.passed

    def __repr__(self) -> str:
        said = "pass" if self.passed else "FAIL"
        return f"<sesc.Verification: {said} on {self.samples} postures>"

    def _repr_html_(self) -> str:
        from ._html import steps, table

        bound, units = self.bound, self.units
        rows = [(name, f"{x:.2e}", f"{bound[name]:.2e}", units[name]) for name, x in self.worst_error.items()]
        said = table(repr(self)[1:-1], ("function", "worst error", "allowed", "unit"), rows)
        return said + steps(self._found["next_steps"])


def compare(before: Identified, after: Identified) -> Comparison:
    """Say what changed between two models of one robot, and whether it is more than chance.

    Args:
        before: the robot as it was: a :class:`Fit`, a :class:`Diagnosis`, a :class:`Model` with
            identified parameters, or a model file.
        after: the same robot on the same support as it is.

    Raises:
        ModelFileError: a model with CAD's parameters, a file with faults, or two robots.

    Example:
        >>> monday, friday = (sesc.fit(robot, log, noise=s) for s in (1e-5, 2e-5))
        >>> sesc.compare(monday, friday)
        <sesc.Comparison of pole on foot: no change beyond chance>
    """
    robots = (robot for robot in map(_robot_of, (after, before)) if robot is not None)
    found, text, page = _sesc.compare_models(
        _given(before, "before"), _given(after, "after"), next(robots, None)
    )
    return Comparison({"json": found, "text": text, "page": page})


def _robot_of(model: Identified) -> Robot | None:
    if isinstance(model, (Fit, Diagnosis)):
        model = model.model
    return model.robot if isinstance(model, Model) else None


def _given(model: Any, name: str) -> tuple[str | None, str, str]:
    """Text or path of a model file, what messages call it, and what next steps call it."""
    expression = name
    if isinstance(model, (Fit, Diagnosis)):
        model, expression = model.model, f"{name}.model"
    if not isinstance(model, _sesc.Model):
        path = os.fspath(model)
        return None, path, path
    text = model.model_file
    if text is None:
        raise ModelFileError(f"`{name}` has CAD's parameters; give a fit, a diagnosis or a model file")
    return text, name, expression


def verify(model: Model, *, samples: int | None = None, seed: int = 1, progress: Progress = False) -> Verification:
    """Compare the functions of a model with the independent reference, which sums link by link.

    Args:
        model: the robot on its support; effects of its model file are part of the functions, the
            parameters are CAD's.
        samples: random postures, besides the corners of the joint limits; 10,000 unless given,
            and beyond 100 joints a million joint angles in all.
        seed: seed of the postures.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Raises:
        SescError: the reference cannot read the URDF, or has no such effect.
        FitError: fewer postures than one.
        KeyboardInterrupt: Ctrl-C, within 0.2 s.

    Example:
        >>> sesc.verify(model, samples=100).worst_error["com"] < 1e-14
        True
    """
    check_first(model, Model, "a model")
    samples = None if samples is None else _run.whole("samples", samples, 1, FitError)
    seed = _run.whole("seed", seed, 0, FitError)
    with _run.showing(progress) as show:
        found, units = _sesc.verify_model(model.robot, model, samples, seed, show)
    return Verification({"json": found, "units": dict(units)})
