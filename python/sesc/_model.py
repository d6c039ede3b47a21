"""A robot on its support, ready to compute."""

from __future__ import annotations

import json
import os
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _sesc
from ._arrays import Float64

if TYPE_CHECKING:
    from ._robot import Robot

__all__ = ["Model"]


class Model(_sesc.Model):
    """The functions of a robot on its support link, with CAD's parameters or identified ones.

    Made by :meth:`sesc.Robot.on`. Positions ``q`` have the order of :attr:`joints` along their
    last axis, rad (prismatic: m): ``(dof,)`` for one posture, ``(n, dof)`` for many. Lists,
    other types of floats, strided and Fortran-ordered arrays are converted once; a data frame
    or dict is asked for its joints by name. NaN in one posture is NaN in its results alone.

    ``out=`` takes a C-contiguous array of 64-bit floats and is given back; ``threads=`` shares
    a batch out to so many threads, which end with the call. The interpreter's lock is free in
    batches of 64 postures and more: do not write to ``q`` meanwhile.
    """

    robot: Robot

    def __new__(cls, robot: Robot, support: str, model: str | os.PathLike[str] | Model | None = None) -> Model:
        file: str | None
        text: str | None
        if isinstance(model, _sesc.Model):
            file, text = "model", model.model_file
        else:
            file, text = (None if model is None else os.fspath(model)), None
        self = super().__new__(cls, robot, support, file, text)
        self.robot = robot
        return self

    @cached_property
    def limits(self) -> Float64:
        """Lower and upper limit of each joint, rad (prismatic: m), shape (dof, 2)."""
        limits = np.array(self.bounds, dtype=np.float64).reshape(self.dof, 2)
        limits.flags.writeable = False
        return limits

    def to_dict(self) -> dict[str, Any]:
        """What ``sesc inspect --json`` prints: bodies, parameters, what no data can see,
        operation counts, proven rounding bounds."""
        found: dict[str, Any] = json.loads(self.inspection())
        return found

    def __repr__(self) -> str:
        joints = f"{self.dof} joint{'s' * (self.dof != 1)}"
        return (
            f"<sesc.Model {self.robot.name} on {self.support}: {joints}, {self.total_mass:.4g} kg, "
            f"{len(self.param_names)} parameters>"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (self.robot, self.support, self.model_file)


def _restore(robot: Robot, support: str, text: str | None) -> Model:
    model = _sesc.Model.__new__(Model, robot, support, text and "model", text)
    model.robot = robot
    return model
