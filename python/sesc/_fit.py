"""Fits: parameters from logs, with uncertainty, observability and held-out error."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

from . import _run, _sesc
from ._arrays import Float64
from ._errors import FitError, check_first
from ._found import FoundInLogs
from ._log import Log
from ._model import Model, Robot, restored
from ._part import Part, options_of
from ._run import Progress
from ._words import Angles, Duplicates, Motion, Prior, Robust

__all__ = ["CorrectedUrdf", "Fit", "Parameter", "fit"]


class Parameter(NamedTuple):
    """One base parameter.

    Attributes:
        name: body and axis, as in :attr:`Model.param_names`.
        value: m (of a prismatic joint: a mass fraction).
        std: standard deviation, in the same unit; 1.96 of them hold 95 %. None where neither
            data nor prior say anything.
        cad: its value by the URDF.
        source: ``data`` or ``prior``, whichever tells more.

    Example:
        >>> abs(fit.parameters["top.z"].value - 1.0) < 0.01
        True
    """

    name: str
    value: float
    std: float | None
    cad: float
    source: str

    def to_dict(self) -> dict[str, Any]:
        """Its fields, as in the JSON of ``sesc fit``.

        Example:
            >>> fit.parameters["top.z"].to_dict()["name"]
            'top.z'
        """
        return self._asdict()

    def _repr_html_(self) -> str:
        from ._html import table

        return table(self.name, self._fields[1:], [self[1:]])


class CorrectedUrdf(NamedTuple):
    """A URDF with what was found in it.

    Attributes:
        text: the whole text.
        left_out: what no URDF can hold, a sentence each.

    Example:
        >>> fit.correct_urdf().robot
        <sesc.Robot pole: 2 links, 1 joint>
    """

    text: str
    left_out: list[str]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the text to ``path``, whole or not at all.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> fit.correct_urdf().save(folder / "pole.urdf")
            >>> sesc.Robot(folder / "pole.urdf").name
            'pole'
        """
        _run.written(path, self.text)

    @property
    def robot(self) -> Robot:
        """The robot that it describes.

        Raises:
            UrdfError: a text that was changed by hand and is no URDF.

        Example:
            >>> fit.correct_urdf().robot.links
            ['foot', 'top']
        """
        return Robot(self.text)

    def to_dict(self) -> dict[str, Any]:
        """The text and what it leaves out, for JSON.

        Example:
            >>> fit.correct_urdf().to_dict()["left_out"]
            []
        """
        return self._asdict()

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [(sentence,) for sentence in self.left_out] or [("nothing",)]
        return self.robot._repr_html_() + table(repr(self)[1:-1], ("what no URDF can hold",), rows)

    def __repr__(self) -> str:
        return f"<sesc.CorrectedUrdf: {len(self.text)} characters, {len(self.left_out)} left out>"


class Fit(FoundInLogs):
    """What a fit found. ``str(fit)`` is what ``sesc fit`` prints, with calls for command
    lines, a notebook shows its report.

    Every key of the command's JSON is an attribute too: ``fit.lack_of_fit``, ``fit.samples``.

    Example:
        >>> fit.rank == fit.to_dict()["rank"]
        True
    """

    def __init__(self, state: dict[str, Any], report: _sesc.FitReport | None = None) -> None:
        super().__init__(state)
        self._report = report

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """The base parameters by name, in the order of :attr:`params`.

        Example:
            >>> fit.parameters["top.z"].source
            'data'
        """
        return {p["name"]: Parameter(**p) for p in self._found["parameters"]}

    @property
    def params(self) -> Float64:
        """Values of the parameters, m, shape (p,).

        Example:
            >>> fit.params.shape
            (5,)
        """
        return self._state["params"].copy()  # type: ignore[no-any-return]

    @property
    def covariance(self) -> Float64:
        """Their covariance, m², shape (p, p); NaN where nothing is known.

        Example:
            >>> fit.covariance.shape
            (5, 5)
        """
        return self._state["covariance"].copy()  # type: ignore[no-any-return]

    @property
    def postures(self) -> int:
        """Postures of all logs.

        Example:
            >>> fit.postures
            30
        """
        return int(self._found["postures"])

    @property
    def noise_floor(self) -> float:
        """Noise of a reading on one axis, m.

        Example:
            >>> fit.noise_floor < 1e-3
            True
        """
        return float(self._found["noise_floor"])

    @property
    def held_out_rmse(self) -> float:
        """RMS error per axis on postures that the fit did not see, m.

        Example:
            >>> fit.held_out_rmse < 1e-3
            True
        """
        return float(self._found["held_out_rmse"])

    @property
    def unobservable(self) -> list[str]:
        """What the data cannot tell, a sentence each.

        Example:
            >>> any("height" in sentence for sentence in fit.unobservable)
            True
        """
        return [direction["sentence"] for direction in self._found["unobservable"]]

    @cached_property
    def model(self) -> Model:
        """The robot with the identified parameters.

        Raises:
            ModelFileError: the model file of the fit is not of its robot.

        Example:
            >>> fit.model.com([0.0]).shape
            (3,)
        """
        return _model_of(self._state)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model file, for ``Robot.on``, ``sesc generate`` and ``build.rs``.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> fit.save(folder / "model.toml")
            >>> robot.on("foot", model=folder / "model.toml")
            <sesc.Model pole on foot: 1 joint, 2 kg, 5 parameters>
        """
        _run.written(path, self._state["model_file"])

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page of ``sesc fit --report``: figures, tables, what cannot be seen.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> fit.report(folder / "fit.html")
            >>> (folder / "fit.html").exists()
            True
        """
        _run.written(path, self._page())

    def correct_urdf(self, *, total_mass: float | None = None) -> CorrectedUrdf:
        """The URDF with the identified masses: those nearest to CAD that give the parameters.

        Args:
            total_mass: what the robot weighs, kg; as in CAD unless given.

        Raises:
            FitError: no masses give the parameters.

        Example:
            >>> fit.correct_urdf(total_mass=2.1).robot.on("foot").total_mass
            2.1
        """
        total_mass = _run.number("total_mass", total_mass)
        if self._report is not None:
            return CorrectedUrdf(self._report.corrected(total_mass), [])
        state = self._state
        known = (state["params"].tolist(), state["masses"])
        text = _sesc.correct_fit(state["robot"], self._found["support"], *known, state["prior"], total_mass)
        return CorrectedUrdf(text, [])

    def _page(self) -> str:
        if self._report is not None:
            return self._report.page()
        page: str = self._state["page"]
        return page

    def _masses(self) -> list[float] | None:
        """What a corrected URDF is made of."""
        if self._report is not None:
            return self._report.masses()
        masses: list[float] | None = self._state["masses"]
        return masses

    def __repr__(self) -> str:
        return (
            f"<sesc.Fit of {self._state['robot'].name} on {self._found['support']}: {self.postures} postures, "
            f"noise {1e3 * self.noise_floor:.3g} mm, held out {1e3 * self.held_out_rmse:.3g} mm>"
        )

    def _repr_html_(self) -> str:
        from ._html import framed

        return framed(self._page(), str(self))

    def __reduce__(self) -> tuple[Any, ...]:
        return Fit, ({**self._state, "page": self._page(), "masses": self._masses()},)


def fit(
    robot: Robot | Part | Sequence[Part],
    log: Any = None,
    *,
    support: str | None = None,
    angles: Angles | None = None,
    prior: Prior = "cad",
    noise: float | None = None,
    offset: float | None = None,
    robust: Robust | None = None,
    folds: int | None = None,
    range: float | None = None,
    physical: bool = False,
    motion: Motion = "auto",
    settle: float | None = None,
    unit: str | None = None,
    duplicates: Duplicates = "refuse",
    progress: Progress = False,
) -> Fit:
    """Identify the parameters of a robot from posture logs.

    Args:
        robot: the robot; a :class:`Part`, or a list of parts, carries its own.
        log: a :class:`Log` or what one is made of, a part, or a list of these.
        support: link whose parameters are meant; the first log's own unless given.
        angles: ``"deg"`` where revolute joints are logged in degrees.
        prior: tolerances of CAD: ``"tight"`` (mass 0.2 %, CoM 0.1 mm), ``"cad"`` (10 %, 5 mm),
            ``"free"``, or a TOML file.
        noise: standard deviation of a single reading on one axis, m; from the log unless given.
        offset: how far all readings may be shifted before a log says so, standard deviation, m; 0
            for not at all, 0.003 or 0.03, whichever is likelier, unless given.
        robust: ``"huber"`` or ``"tukey"``: trust postures less that no noise explains.
        folds: folds of the cross-validation, 10 unless given.
        range: errors are expected for joints within ± this, rad; else for their limits.
        physical: fit physical masses only.
        motion: ``"auto"`` compares readings with the ZMP where a log with times knows
            accelerations; ``"off"`` takes all as those of standing postures.
        settle: take only rows of stays: stretches of at least so many seconds in which every
            joint is slower than 0.02 rad/s; each is one posture. 0 takes every row as one of a
            robot that moves.
        unit: the robot of its type that the logs are of: parts of another one are refused.
        duplicates: ``"refuse"`` a part with a log that another one has, or ``"skip"`` parts whose
            logs are all there already.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Raises:
        LogError: a log that cannot be used, with its file, line and column.
        FitError: what is asked for cannot be had, or parts that do not belong together.
        KeyboardInterrupt: Ctrl-C, within 0.2 s; nothing is written.

    Example:
        >>> found = sesc.fit(robot, log, noise=1e-5)
        >>> found.held_out_rmse < 1e-4
        True
    """
    given = [] if log is None else list(log) if isinstance(log, (list, tuple)) else [log]
    if isinstance(robot, (list, tuple)) and robot and all(isinstance(one, Part) for one in robot):
        given, robot = [*robot[1:], *given], robot[0]
    check_first(robot, (Robot, Part), "a robot or a part")
    parts = [one for one in given if isinstance(one, Part)]
    logs = _run.logs([one for one in given if not isinstance(one, Part)])
    if isinstance(robot, Part):
        parts.insert(0, robot)
    options = options_of(support, angles, prior, noise, robust, folds, range, physical, motion, settle, unit)
    options |= {"offset": offset, "duplicates": duplicates}
    with _run.showing(progress) as show:
        report = _sesc.fit_logs(
            robot if isinstance(robot, Robot) else None,
            [one._inner for one in logs],
            [one._inner for one in parts],
            options,
            show,
        )
    for one in logs:
        one._robot = one._robot or (robot if isinstance(robot, Robot) else None)
    if report.unusable is not None:
        from ._errors import LogError

        error = LogError(report.unusable)
        error.file = logs[0].name if logs else None
        raise error
    urdf, file, snap = report.robot
    if not isinstance(robot, Robot):
        robot = _sesc.Robot.__new__(Robot, file, urdf, snap)
    return Fit({**report.state(), "robot": robot, "prior": os.fspath(prior)}, report)


def _model_of(state: dict[str, Any]) -> Model:
    return restored(state["robot"], json.loads(state["json"])["support"], state["model_file"])
