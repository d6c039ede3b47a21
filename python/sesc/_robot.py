"""Robots, and what they stand on."""

from __future__ import annotations

import os
import warnings
from typing import Any

from . import _sesc
from ._errors import ArgumentTypeError, SescError, make
from ._model import Model

__all__ = ["Robot"]


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
