"""Postures to be taken: plans, experiments, simulations."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _run, _sesc
from ._arrays import Float64, array_of, positions
from ._errors import LogError, PlanError, check_first
from ._found import Found
from ._log import Log
from ._model import Model, Robot
from ._run import Progress
from ._words import Angles, Motion, Prior

__all__ = ["Plan", "Postures", "plan", "predict", "simulate"]


#: Postures that a notebook shows.
SHOWN = 10


class Postures:
    """Postures of a robot on a support, one a row.

    Attributes:
        q: joint positions, rad (prismatic: m), shape (n, dof); its own memory.
        experiment: which experiment they belong to, such as ``turned``; None where to none.

    Example:
        >>> sesc.Postures(model, np.zeros((4, 1)))
        <sesc.Postures on foot: 4 postures of 1 joints>
    """

    q: Float64
    experiment: str | None

    def __init__(self, model: Model, q: Float64, experiment: str | None = None) -> None:
        self._model, self.q, self.experiment = model, q, experiment
        #: The number of each row's posture.
        self._numbers = np.arange(len(q))

    @property
    def joints(self) -> list[str]:
        """Names of the columns.

        Example:
            >>> postures.joints
            ['hip']
        """
        return self._model.joints

    @property
    def support(self) -> str:
        """The link on the ground.

        Example:
            >>> postures.support
            'foot'
        """
        return self._model.support

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a posture file (.csv, .csv.gz or .parquet) with its sidecar.

        Raises:
            PlanError: a file that cannot be written, or of another ending (of the system, an ``OSError``, too).

        Example:
            >>> postures.save(folder / "next.csv")
            >>> sesc.Log(folder / "next.csv").settings["support"]
            'foot'
        """
        q = np.ascontiguousarray(self.q, dtype=np.float64)
        numbers = self._numbers.tolist()
        _sesc.write_postures(self._model, q, numbers, os.fspath(path), self.experiment, self._other_foot())

    def _other_foot(self) -> str | None:
        return None

    def to_dict(self) -> dict[str, Any]:
        """Support, experiment, joints and postures, for JSON.

        Example:
            >>> postures.to_dict()["q"]
            [[0.0], [0.5]]
        """
        return {
            "support": self.support,
            "experiment": self.experiment,
            "joints": self.joints,
            "q": self.q.tolist(),
        }

    def columns(self) -> dict[str, Any]:
        """Columns by name, ``pose`` first: for ``polars.DataFrame``, ``pandas.DataFrame``.

        Example:
            >>> list(postures.columns())
            ['pose', 'hip']
        """
        columns = {joint: self.q[:, k] for k, joint in enumerate(self.joints)}
        return {"pose": self._numbers, **columns}

    def __len__(self) -> int:
        return len(self.q)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Float64:
        return np.array(self.q, dtype=dtype) if copy or dtype else self.q

    @property
    def shape(self) -> tuple[int, int]:
        """(n, dof)

        Example:
            >>> postures.shape
            (2, 1)
        """
        return self.q.shape[0], self.q.shape[1]

    def __repr__(self) -> str:
        return f"<sesc.{type(self).__name__} on {self.support}: {len(self)} postures of {self.shape[1]} joints>"

    def _repr_html_(self) -> str:
        from ._html import pictures, table

        q = np.ascontiguousarray(self.q[:SHOWN], dtype=np.float64)
        drawn = _sesc.draw_postures(self._model.robot, self._model, q)
        rows = [tuple(f"{x:.4f}" for x in row) for row in self.q[:SHOWN]]
        return pictures(drawn, 112) + table(repr(self)[1:-1], tuple(self.joints), rows)


class Plan(Found, Postures):
    """Postures that tell most about the parameters. ``str(plan)`` is what ``sesc plan`` prints,
    with calls for command lines.

    Its rows are those of its file: with ``revisits=10`` the last ten reach postures once again,
    under their numbers in ``plan.columns()["pose"]``. Every key of the command's JSON is an
    attribute too: ``plan.expected_error``.

    Example:
        >>> plan.poses == len(plan)
        True
    """

    def __init__(self, model: Model, rows: tuple[Any, Float64], state: dict[str, Any]) -> None:
        Postures.__init__(self, model, rows[1])
        self._numbers = rows[0]
        Found.__init__(self, state)

    def _other_foot(self) -> str | None:
        both = self._found.get("both_feet") or {}
        found: str | None = both.get("other_foot")
        return found

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page of ``sesc plan --report``.

        Raises:
            SescError: a file that cannot be written; it is an ``OSError`` too.

        Example:
            >>> plan.report(folder / "plan.html")
            >>> (folder / "plan.html").exists()
            True
        """
        _run.written(path, self._state["page"])

    def __str__(self) -> str:
        return str(self._state["text"])

    def _repr_html_(self) -> str:
        from ._html import framed

        return framed(self._state["page"], str(self))

    def __reduce__(self) -> tuple[Any, ...]:
        return Plan, (self._model, (self._numbers, self.q), self._state)


def plan(
    robot: Robot,
    support: str,
    *,
    poses: int,
    model: str | os.PathLike[str] | Model | None = None,
    cop_box: float | None = None,
    sole: str | os.PathLike[str] | Any = None,
    margin: float = 0.0,
    sigmas: float = 2.0,
    limits: str | os.PathLike[str] | Mapping[str, tuple[float, float]] | None = None,
    candidates: int | None = None,
    prior: Prior = "cad",
    noise: float | None = None,
    clearance: float = 0.005,
    seed: int = 1,
    revisits: int | None = None,
    data: Any = None,
    both_feet: bool = False,
    other_foot: str | None = None,
    progress: Progress = False,
) -> Plan:
    """Choose postures that tell most about the parameters, balanced and clear, in a short order.

    Args:
        robot: the robot.
        support: link on the ground.
        poses: how many.
        model: parameters to balance with; CAD unless given.
        cop_box: keep |x| and |y| of the CoP within this, m; unless
            ``sole`` is given, the inner part of the sole where the URDF has collision shapes of
            the support, else 0.023.
        sole: keep the CoP within the hull of these points, m: an array (n, 2), or a file.
        margin: keep the CoP so far from the edge, m.
        sigmas: safety margin of the CoP in standard deviations of its prediction.
        limits: narrower joint limits: ``{joint: (lower, upper)}``, rad or m, or a CSV file.
        candidates: candidates to choose from; 20 per posture, 2000 to 20000 unless given.
        prior: how far the later fit trusts CAD.
        noise: standard deviation of a single reading on one axis, m; 0.0005, or as ``data`` has
            it, unless given.
        clearance: least height of everything but the support body, m.
        seed: seed of the candidates.
        revisits: so many rows more at the end, which reach postures once again under their own
            number: what visits of one posture differ by shows in them. Unless given, five are named where ``data`` does
            not know it, and none is written.
        data: a log of this robot (a :class:`Log` or what one is made of): its noise and what its
            visits differ by are taken for those to come.
        both_feet: both soles are flat on one floor in every posture; the CoP is that of both.
        other_foot: the link that is the other sole; by its name unless given.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Raises:
        PlanError: fewer postures than asked for; the message says why and what would help.
        LogError: ``data`` that cannot be used.

    Example:
        >>> sesc.plan(robot, "foot", poses=5, cop_box=0.3, sigmas=0.0, candidates=50)
        <sesc.Plan on foot: 5 postures of 1 joints>
    """
    check_first(robot, Robot, "a robot")
    if data is not None and noise is not None:
        raise PlanError("`data` knows the noise: leave out `noise`, or the log")
    standing = robot.on(support, model)
    if sole is not None and not isinstance(sole, (str, os.PathLike)):
        points = np.asarray(sole, dtype=float)
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
            raise PlanError(f"`sole` has the shape {points.shape}; give x and y of three points or more, m")
        sole = "; ".join(f"{float(x)!r},{float(y)!r}" for x, y in points)
    ranges = None
    if isinstance(limits, Mapping):
        ranges = [(str(joint), (float(low), float(high))) for joint, (low, high) in limits.items()]
        limits = None
    options = {
        "poses": poses,
        "cop_box": cop_box,
        "sole": None if sole is None else os.fspath(sole),
        "margin": margin,
        "sigmas": sigmas,
        "limits": None if limits is None else os.fspath(limits),
        "ranges": ranges,
        "candidates": candidates,
        "prior": os.fspath(prior),
        "noise": 5e-4 if noise is None else noise,
        "clearance": clearance,
        "seed": seed,
        "revisits": revisits,
        "both_feet": both_feet,
        "other_foot": other_foot,
    }
    log = None if data is None else _run.one_log(data, PlanError)._inner
    with _run.showing(progress) as show:
        rows, said = _sesc.plan_postures(robot, standing, log, options, show)
    return Plan(standing, rows, said)


def simulate(
    model: Model,
    poses: int | Postures | Float64 | Any,
    *,
    range: float | None = None,
    noise: float = 0.0,
    rate: float | None = None,
    motion: Motion = "auto",
    seed: int = 1,
    hide: Mapping[str, float | str | tuple[float | str, ...] | None] | list[str] | tuple[str, ...] = (),
    progress: Progress = False,
) -> Log:
    """A posture log of an ideal robot, with CoP noise.

    Args:
        model: the robot with the parameters that it really has.
        poses: how many postures to draw, or the postures: (n, dof), or a plan.
        range: draw revolute joints within ± this of zero, rad; else within their limits.
        noise: standard deviation of the CoP noise, m.
        rate: let the robot move through the ranges of its joints and log so many rows per second,
            Hz, with a column ``t`` (s); postures at rest unless given.
        motion: ``"auto"`` logs the ZMP of a robot that moves, ``"off"`` the CoP of standing
            postures.
        seed: seed of postures and noise.
        hide: effects that the robot shall have: ``{"joint_offset:r_knee": 0.026}`` in SI units
            (a tuple where an effect has several parameters, None where none; a text has its
            unit: ``"1.5deg"``), or strings as of the command line:
            ``["joint_offset:r_knee=1.5deg"]``. A size that was hardly meant in SI units is refused.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Raises:
        LogError: a request that makes no sense: postures and ``rate`` together, no such effect.

    Example:
        >>> sesc.simulate(model, 100, noise=1e-4, hide={"joint_offset:hip": 0.02})
        <sesc.Log simulation: 6 columns, 100 rows>
    """
    check_first(model, Model, "a model")
    postures = numbers = None
    is_table = isinstance(poses, (Postures, Mapping)) or hasattr(poses, "columns")
    if not is_table and array_of(poses, "poses").ndim == 0:
        count = _run.whole("poses", poses, 0, LogError)
    else:
        given = poses
        if isinstance(poses, Postures):
            given, numbers = poses.q, poses._numbers.tolist()
        postures = positions(given, model.joints, "poses").reshape(-1, model.dof)
        count = len(postures)
    if isinstance(hide, Mapping):
        hidden = [_effect(name, value) for name, value in hide.items()]
    else:
        hidden = _run.strings([hide] if isinstance(hide, str) else hide)
    options = {
        "poses": count,
        "postures": postures,
        "numbers": numbers,
        "range": range,
        "noise": noise,
        "seed": seed,
        "rate": rate,
        "motion": _run.motion(motion),
        "hide": hidden,
    }
    with _run.showing(progress) as show:
        log = _sesc.simulate_log(model, options, show)
    return Log._of(log, model.robot)


def _effect(name: str, value: Any) -> str:
    if value is None:
        return name
    values = value if isinstance(value, (tuple, list)) else (value,)
    return f"{name}={','.join(one if isinstance(one, str) else repr(float(one)) for one in values)}"


def predict(
    model: Model, log: Any, *, angles: Angles | None = None, motion: Motion = "auto", progress: Progress = False
) -> dict[str, Any]:
    """CoM and CoP of every row of a log, as ``sesc predict`` prints them.

    Args:
        model: the robot with the parameters to predict with.
        log: a :class:`Log` or what one is made of; readings are not needed.
        angles: ``"deg"`` where revolute joints are in degrees.
        motion: ``"auto"`` predicts the ZMP where a log with times knows accelerations, ``"off"``
            the CoP of standing postures.
        progress: print how far it is, or a function of what is done, how much, and of how much.

    Returns:
        ``{"pose": (n,), "com": (n, 3), "cop": (n, 2)}``, m, in the support frame, under the
        gravity of the log.

    Raises:
        LogError: a log that cannot be used.

    Example:
        >>> sesc.predict(model, {"hip": [0.0]})["cop"].tolist()
        [[0.1, 0.0]]
    """
    check_first(model, Model, "a model")
    one = _run.one_log(log, LogError)
    with _run.showing(progress) as show:
        units, moves = _run.degrees(angles), _run.motion(motion)
        pose, com, cop = _sesc.predict_log(
            model.robot, model.support, model, one._inner, units, moves, show
        )
    return {"pose": pose, "com": com, "cop": cop}
