"""Diagnoses: where simulation and measurement disagree, and the name of what is missing."""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from . import _run, _sesc
from ._errors import FitError, check_first
from ._fit import CorrectedUrdf
from ._found import FoundInLogs
from ._model import Model, Robot, restored
from ._postures import Postures
from ._run import Progress
from ._words import Angles, Motion, Prior, Verdict

__all__ = ["Diagnosis", "Quantity", "Step", "diagnose"]


class Quantity(NamedTuple):
    """An estimate and its standard deviation, in the unit that its name ends in.

    Example:
        >>> found.steps[0].parameters["offset_rad"].std > 0
        True
    """

    value: float
    std: float

    def to_dict(self) -> dict[str, Any]:
        """Value and deviation, as in the JSON of ``sesc diagnose``.

        Example:
            >>> sesc.Quantity(0.02, 0.001).to_dict()
            {'value': 0.02, 'std': 0.001}
        """
        return self._asdict()

    def _repr_html_(self) -> str:
        return f"{self.value:.4g} ± {self.std:.2g}"


class Step(NamedTuple):
    """One effect of the explanation.

    Attributes:
        effect: its name, such as ``joint_offset``.
        target: joint, link or cell; ``-`` where it acts on the whole.
        site: where it adds something: ``joint``, ``sensor``, ``ground``, ``load``, ``cell``, ``record``.
        function: what it adds there, as a formula.
        parameters: by name, which ends in the unit: ``offset_rad``.
        rmse_before, rmse_after: held-out error without and with it, m.
        evidence: by how much -2 log evidence rises without it.
        sentence: the step as a sentence.
        remedy: what to change about it.

    Example:
        >>> found.steps[0].rmse_after < found.steps[0].rmse_before
        True
    """

    effect: str
    target: str
    site: str
    function: str
    parameters: dict[str, Quantity]
    rmse_before: float
    rmse_after: float
    evidence: float
    sentence: str
    remedy: dict[str, Any]

    def to_dict(self) -> dict[str, Any]:
        """Its fields, as in the JSON of ``sesc diagnose``.

        Example:
            >>> found.steps[0].to_dict()["effect"] == found.steps[0].effect
            True
        """
        parameters = {name: quantity.to_dict() for name, quantity in self.parameters.items()}
        return {**self._asdict(), "parameters": parameters}

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [(name, f"{q.value:.4g}", f"{q.std:.2g}") for name, q in self.parameters.items()]
        return table(f"{self.effect}:{self.target}. {self.sentence}", ("parameter", "value", "std"), rows)


class Diagnosis(FoundInLogs):
    """What a diagnosis found. ``str(found)`` is what ``sesc diagnose`` prints, with calls for
    command lines, a notebook shows its report. Every key of the command's JSON is an attribute too: ``found.noise_floor``.

    Example:
        >>> found.noise_floor == found.to_dict()["noise_floor"]
        True
    """

    @property
    def verdict(self) -> Verdict:
        """``none``, ``named``, ``class``, ``absorbed``, ``unexplained``, ``too_short`` or ``unusable``.

        Example:
            >>> found.verdict in ("named", "class")
            True
        """
        found: Verdict = self._found["verdict"]
        return found

    @property
    def sentence(self) -> str:
        """The whole result in sentences.

        Example:
            >>> len(found.sentence) > 20
            True
        """
        return str(self._found["sentence"])

    @cached_property
    def steps(self) -> list[Step]:
        """The explanation effect by effect, in the order in which they close the gap.

        Example:
            >>> len(found.steps)
            1
        """
        steps = []
        for found in self._found["steps"]:
            parameters = {name: Quantity(**q) for name, q in found["parameters"].items()}
            steps.append(Step(**{**found, "parameters": parameters}))
        return steps

    @property
    def explanations(self) -> list[list[str]]:
        """The complete explanations that the data cannot tell apart, best first: each a list of
        ``effect`` or ``effect:target``.

        Example:
            >>> ["joint_offset:hip"] in found.explanations
            True
        """
        return [list(one) for one in self._found["indistinguishable"]]

    @cached_property
    def model(self) -> Model:
        """The robot with the identified parameters and effects: ``found.model.com(q)`` is its
        centre of mass where its encoders read ``q``.

        Raises:
            FitError: data that cannot be used.

        Example:
            >>> found.model.com([0.0]).shape
            (3,)
        """
        self._check_usable()
        return restored(self._state["robot"], self._found["support"], self._state["model_file"])

    def next_postures(self, n: int = 40) -> Postures:
        """The ``n`` postures (40 at most) that would tell most about what is still open; none
        where nothing is left to tell apart. :attr:`Postures.experiment` says what else to do.

        Raises:
            FitError: a number below zero.

        Example:
            >>> len(found.next_postures(5)) <= 5
            True
        """
        n = _run.whole("n", n, 0, FitError)
        found = self._state["next"]
        if found is None:
            model = self._state["robot"].on(self._found["support"])
            return Postures(model, np.zeros((0, model.dof)), None)
        support, experiment, q, ranks = found
        kept = np.sort(np.argsort(ranks, kind="stable")[:n]) if len(ranks) else np.arange(min(n, len(q)))
        return Postures(self._state["robot"].on(support), q[kept], experiment)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model file: parameters and effects, for ``Robot.on`` and ``sesc generate``.

        Raises:
            FitError: the data cannot be used, or the file would not predict them.

        Example:
            >>> found.save(folder / "found.toml")
            >>> robot.on("foot", model=folder / "found.toml").support
            'foot'
        """
        self._check_usable()
        on_log = self._found["model_on_log"]
        if not on_log["agrees"]:
            raise FitError(
                f"the model file would predict this log to {1e3 * on_log['predicted_rmse']:.3f} mm RMS, the "
                f"diagnosis states {1e3 * on_log['stated_rmse']:.3f} mm; record more postures, or give "
                "tolerances of the masses with `prior`"
            )
        _run.written(path, self._state["model_file"])

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page of ``sesc diagnose --report``.

        Raises:
            FitError: data that cannot be used.
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> found.report(folder / "found.html")
            >>> (folder / "found.html").exists()
            True
        """
        self._check_usable()
        _run.written(path, self._state["page"])

    def correct_urdf(self, *, total_mass: float | None = None) -> CorrectedUrdf:
        """The URDF with what was found: joint origins turned, payloads as links, masses as
        re-identified. What no URDF can hold is in ``.left_out``.

        Args:
            total_mass: what the robot without its loads weighs, kg; as in CAD unless given.

        Raises:
            FitError: data that cannot be used, or no masses that give the parameters.

        Example:
            >>> found.correct_urdf().robot.joints
            ['hip']
        """
        self._check_usable()
        total_mass, state = _run.number("total_mass", total_mass), self._state
        freed, of_the_log = state["correction"]
        prior = "cad" if freed else state["prior"]
        text, left_out = _sesc.correct_urdf(state["robot"], state["model_file"], prior, total_mass)
        return CorrectedUrdf(text, [*left_out, *of_the_log])

    def _check_usable(self) -> None:
        if self.verdict == "unusable":
            raise FitError(f"the data cannot be used: {self.sentence}")

    def __repr__(self) -> str:
        effects = ", ".join(f"{step.effect}:{step.target}" for step in self.steps) or "no effect"
        return f"<sesc.Diagnosis of {self._state['robot'].name}: {self.verdict}, {effects}>"

    def _repr_html_(self) -> str:
        from ._html import framed

        return framed(self._state["page"], str(self))


def diagnose(
    robot: Robot,
    log: Any,
    *,
    then: Any = (),
    healthy: Any = (),
    support: str | None = None,
    angles: Angles | None = None,
    prior: Prior = "tight",
    noise: float | None = None,
    offset: float | None = None,
    floor: float = 1e-4,
    motion: Motion = "auto",
    settle: float | None = None,
    servos: str | os.PathLike[str] | None = None,
    effects: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Diagnosis:
    """Find where simulation and measurement disagree, and name the missing effect.

    Args:
        robot: the robot with CAD masses.
        log: a :class:`Log` or what one is made of.
        then: logs of experiments that :meth:`Diagnosis.next_postures` asked for.
        healthy: logs of the same robot when it was healthy: the masses that they tell take the
            place of CAD's.
        support: link on the ground; the log's own unless given.
        angles: ``"deg"`` where revolute joints are logged in degrees.
        prior: tolerances of CAD: ``"tight"`` (mass 0.2 %, CoM 0.1 mm), ``"cad"`` (10 %, 5 mm),
            ``"free"``, or a TOML file: tolerances, or the model file of this robot that a fit
            wrote when it was healthy.
        noise: standard deviation of a single reading on one axis, m; from the log unless given.
        offset: how far all readings may be shifted before a log says so, standard deviation, m; 0
            for not at all, 0.003 or 0.03, whichever is likelier, unless given.
        floor: added to the noise in quadrature, m: what encoder ticks do.
        motion: ``"auto"`` compares readings with the ZMP where a log with times knows
            accelerations; ``"off"`` takes all as those of standing postures.
        settle: take only rows of stays: stretches of at least so many seconds in which every
            joint is slower than 0.02 rad/s; each is one posture. 0 takes every row as one of a
            robot that moves.
        servos: TOML file of the servos: remedies are in its ticks.
        effects: TOML file of effects of your own, each a site and a formula, that are tried beside
            the others.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Raises:
        LogError: a log that cannot be used, with its file, line and column.
        FitError: what is asked for cannot be had.
        KeyboardInterrupt: Ctrl-C, within 0.2 s; nothing is written.

    Example:
        >>> ["joint_offset:hip"] in sesc.diagnose(robot, log, noise=1e-4).explanations
        True
    """
    check_first(robot, Robot, "a robot")
    first = _run.one_log(log, FitError, "; logs of experiments are given as `then`")
    further = _run.logs(list(then) if isinstance(then, (list, tuple)) else then)
    before = _run.logs(list(healthy) if isinstance(healthy, (list, tuple)) else healthy)
    options = {
        "support": support,
        "degrees": _run.degrees(angles),
        "prior": os.fspath(prior),
        "noise": noise,
        "offset": offset,
        "floor": floor,
        "motion": _run.motion(motion),
        "settle": settle,
        "servos": None if servos is None else os.fspath(servos),
        "effects": None if effects is None else os.fspath(effects),
    }
    with _run.showing(progress) as show:
        found = _sesc.diagnose_log(
            robot,
            first._inner,
            [one._inner for one in further],
            [one._inner for one in before],
            options,
            show,
        )
    first._robot = first._robot or robot
    return Diagnosis({**found, "robot": robot, "prior": os.fspath(prior)})
