"""Robots, and a robot on its support, ready to compute."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _sesc
from ._arrays import Float64, floats
from ._errors import ArgumentError, ArgumentTypeError, SescError, make
from ._words import Layout, Scalar

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Model", "Robot"]


class Robot(_sesc.Robot):
    """A robot as its URDF describes it.

    Args:
        path_or_text: path of a URDF, or its text (anything with a ``<``), or an open file.
        snap: make decimals of right angles (1.5708) exact, within 1e-5 rad.
        xacro: expand the file by the program ``xacro``, as where the path ends in ``.xacro``.
            ``xacro`` runs code that stands in the file, and a ``UserWarning`` says that it ran.

    Raises:
        UrdfError: all that is wrong with the description, each with its line and a remedy.

    Example:
        >>> robot = sesc.Robot(urdf)
        >>> robot.name, robot.joints
        ('pole', ['hip'])
    """

    def __new__(cls, path_or_text: str | os.PathLike[str] | Any, snap: bool = True, xacro: bool = False) -> Robot:
        file, text = _read(path_or_text)
        if xacro and text is not None:
            raise ArgumentTypeError("`xacro` expands a file: give the path of the robot, not its text")
        robot = super().__new__(cls, file, text, snap, xacro)
        if robot._expanded:
            warnings.warn(f"{file} was expanded by xacro, which ran code of that file", stacklevel=2)
        return robot

    def on(self, support: str, model: str | os.PathLike[str] | Model | None = None) -> Model:
        """The robot with the link ``support`` on the ground; its sole is z = 0 of its frame.

        Args:
            support: name of the link; ``foot@40mm`` is the frame 40 mm below that of ``foot``.
            model: a model file, or a model, whose identified parameters and effects are taken;
                CAD's unless given.

        Raises:
            SupportError: no link of that name; the message lists those there are.
            ModelFileError: a model file with faults, or of another robot.

        Example:
            >>> sesc.Robot(urdf).on("foot")
            <sesc.Model pole on foot: 1 joint, 2 kg, 5 parameters>
        """
        if not isinstance(support, str):
            some = ", ".join(self.links[:8]) + (", …" if len(self.links) > 8 else "")
            raise ArgumentTypeError(f"`support` {support!r}: give the name of a link; the robot has {some}")
        return Model(self, support, model)

    def to_dict(self) -> dict[str, Any]:
        """Name, file, hash, links and joints.

        Example:
            >>> robot.to_dict()["joints"]
            ['hip']
        """
        names = ("name", "file", "hash", "links", "joints", "snap")
        return {name: getattr(self, name) for name in names}

    def _repr_html_(self) -> str:
        from ._html import pictures, table

        said = table(repr(self)[1:-1], ("joint",), [(joint,) for joint in self.joints])
        try:
            drawn = _sesc.draw_robot(self, self.on(self.root))
        except SescError:
            # It has joints that nothing can stand under, and can be read about all the same.
            return said
        return pictures(drawn, 320) + said

    def __repr__(self) -> str:
        count = len(self.joints)
        return f"<sesc.Robot {self.name}: {len(self.links)} links, {count} joint{'s' * (count != 1)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (self.file, self.urdf, self.snap)


def _read(given: Any) -> tuple[str, str | None]:
    """The name of a URDF, and its text where it is at hand."""
    if isinstance(given, os.PathLike):
        return os.fspath(given), None
    if isinstance(given, bytes):
        given = _decoded(given, "robot.urdf")
    if isinstance(given, str):
        return ("robot.urdf", given) if "<" in given else (given, None)
    if hasattr(given, "read"):
        text, name = given.read(), str(getattr(given, "name", "robot.urdf"))
        return name, _decoded(text, name) if isinstance(text, bytes) else text
    raise ArgumentTypeError(f"a URDF is given by its path, its text or an open file, not by {type(given).__name__}")


def _decoded(data: bytes, name: str) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError as wrong:
        line = 1 + data.count(b"\n", 0, wrong.start)
        message = f"byte 0x{data[wrong.start]:02x} is not UTF-8; save the file as UTF-8"
        raise make("UrdfError", f"{name}:{line}: {message}", (name, line, None), None, [(line, message)]) from None


def _restore(file: str, text: str, snap: bool) -> Robot:
    return _sesc.Robot.__new__(Robot, file, text, snap)


class Model(_sesc.Model):
    """The functions of a robot on its support link, with CAD's parameters or identified ones.

    Made by :meth:`sesc.Robot.on`. Positions ``q`` have the order of :attr:`joints` along their
    last axis, rad (prismatic: m): ``(dof,)`` for one posture, ``(n, dof)`` for many. Lists,
    other types of floats, strided and Fortran-ordered arrays are converted once; a data frame
    or dict is asked for its joints by name. NaN in one posture is NaN in its results alone.

    ``out=`` takes a C-contiguous array of 64-bit floats and is given back; ``threads=`` shares
    a batch out to so many threads, which end with the call. The interpreter's lock is free in
    calls of more than ten microseconds: do not write to ``q`` meanwhile. Ctrl-C stops a call.

    Example:
        >>> model.com([[0.0], [0.5]], threads=2).shape
        (2, 3)
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
        """Lower and upper limit of each joint, rad (prismatic: m), shape (dof, 2).

        Example:
            >>> model.limits.tolist()
            [[-1.0, 1.0]]
        """
        limits = np.array(self.bounds, dtype=np.float64).reshape(self.dof, 2)
        limits.flags.writeable = False
        return limits

    def reordered(
        self, q: Any, *, joints: Sequence[str] | None = None, to: Sequence[str] | None = None
    ) -> Float64:
        """Columns of ``q`` in another order of the joints: other libraries sort them by name
        or by tree.

        Args:
            q: positions, velocities or accelerations, joints along the last axis.
            joints: names of the columns of ``q``; :attr:`joints` unless given.
            to: names of the columns of the result; :attr:`joints` unless given.

        Raises:
            ArgumentError: a joint of ``to`` that ``q`` has no column for, or shapes that do not fit.

        Example:
            >>> model.reordered([[0.1, 7.0]], joints=["hip", "camera"])
            array([[0.1]])
        """
        have = self.joints if joints is None else list(joints)
        want = self.joints if to is None else list(to)
        values = floats(q, "q")
        if values.ndim == 0 or values.shape[-1] != len(have):
            raise ArgumentError(f"q has the shape {values.shape}; its last axis must hold {len(have)} joints")
        missing = [joint for joint in want if joint not in have]
        if missing:
            raise ArgumentError(f"q has no column for {', '.join(missing)}")
        return np.ascontiguousarray(values[..., [have.index(joint) for joint in want]])

    def c99(
        self,
        folder: str | os.PathLike[str],
        *,
        scalar: Scalar | None = None,
        name: str | None = None,
        layout: Layout = "bare",
        ticks: bool | None = None,
        servos: str | os.PathLike[str] | None = None,
        estimator: bool = False,
        lanes: int | None = None,
        functions: str | Iterable[str] | None = None,
    ) -> list[Path]:
        """Write the functions as C99 to ``folder``; gives the files.

        Args:
            folder: made if need be; files that would not change are left alone.
            scalar: ``"f64"``, ``"f32"`` or ``"fixed32"`` (for processors without FPU); ``"f64"`` unless
                given, of the layouts for boards (Arduino, PlatformIO) ``"f32"``.
            name: prefix of the C names; robot and support unless given.
            layout: ``"bare"``, ``"cmake"``, ``"platformio"`` or ``"arduino"``.
            ticks: functions of servo ticks; for f32 and fixed32 unless given.
            servos: TOML file of each joint's servo.
            estimator: the parameters by recursive least squares, one posture a call.
            lanes: 4, 8 or 16: functions of many postures besides, for gcc and clang on
                computers, at most so many side by side; in f64 and f32.
            functions: only these and ``com``, which is always there; all unless given.

        Raises:
            SescError: options that do not go together, or a robot that 32-bit fixed point cannot
                hold; nothing is written.

        Example:
            >>> [file.name for file in model.c99(folder, scalar="f32", name="pole")]
            ['pole.h', 'pole.c']
        """
        options = {
            "scalar": scalar,
            "name": name,
            "layout": layout,
            "ticks": ticks,
            "servos": None if servos is None else os.fspath(servos),
            "estimator": estimator,
            "lanes": lanes,
            "functions": _names(functions),
        }
        return _paths(_sesc.c_files(self, os.fspath(folder), options))

    def rust(
        self,
        folder: str | os.PathLike[str],
        *,
        name: str | None = None,
        functions: str | Iterable[str] | None = None,
    ) -> list[Path]:
        """Write the functions as a Rust module to ``folder``; gives the file.

        Args:
            folder: made if need be; a file that would not change is left alone.
            name: the module's; robot and support unless given.
            functions: only these and ``com``, which is always there; all unless given.

        Raises:
            SescError: a name that Rust does not take, a function that there is not, or a file that cannot be written (an ``OSError``, too).

        Example:
            >>> [file.name for file in model.rust(folder, name="Pole")]
            ['Pole.rs']
        """
        return _paths(_sesc.rust_files(self, os.fspath(folder), name, _names(functions)))

    def to_dict(self) -> dict[str, Any]:
        """What ``sesc inspect --json`` prints: bodies, parameters, what no data can see,
        operation counts, proven rounding bounds; next steps are calls.

        Example:
            >>> model.to_dict()["rank"]
            {'xyz': 5, 'cop': 4}
        """
        found: dict[str, Any] = json.loads(self.inspection())
        return found

    def _repr_html_(self) -> str:
        from ._html import pictures, steps, table

        limits = zip(self.joints, self.limits.tolist(), strict=True)
        rows = [(joint, f"{low:.4g}", f"{high:.4g}") for joint, (low, high) in limits]
        said = table(repr(self)[1:-1], ("joint", "lower, rad or m", "upper"), rows)
        return pictures(_sesc.draw_robot(self.robot, self), 320) + said + steps(json.loads(self.next_steps()))

    def __repr__(self) -> str:
        joints = f"{self.dof} joint{'s' * (self.dof != 1)}"
        return (
            f"<sesc.Model {self.robot.name} on {self.support}: {joints}, {self.total_mass:.4g} kg, "
            f"{len(self.param_names)} parameters>"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return restored, (self.robot, self.support, self.model_file)


def restored(robot: Robot, support: str, text: str | None) -> Model:
    """The model of a model file's text, or of CAD."""
    model = _sesc.Model.__new__(Model, robot, support, text and "model", text)
    model.robot = robot
    return model


def _names(functions: str | Iterable[str] | None) -> list[str] | None:
    if functions is None:
        return None
    return [functions] if isinstance(functions, str) else [str(one) for one in functions]


def _paths(files: list[str]) -> list[Path]:
    # A fifth of the time that importing the package would take.
    from pathlib import Path

    return [Path(file) for file in files]
