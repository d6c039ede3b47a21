"""Centre of mass by the statically equivalent serial chain.

Fast functions of any URDF's centre of mass, parameters identified from posture logs, and the
names of effects that a simulation misses. Arrays in and out are numpy's, in SI units and in
the support frame.

    >>> robot = sesc.Robot(urdf)
    >>> model = robot.on("foot")
    >>> model.com([0.0]).tolist()
    [0.1, 0.0, 1.0]
"""

from ._errors import (
    FitError,
    InternalError,
    LogError,
    ModelFileError,
    PartError,
    PlanError,
    PriorError,
    SescError,
    SupportError,
    UrdfError,
)
from ._model import Model
from ._robot import Robot
from ._sesc import __version__

__all__ = [
    "FitError",
    "InternalError",
    "LogError",
    "Model",
    "ModelFileError",
    "PartError",
    "PlanError",
    "PriorError",
    "Robot",
    "SescError",
    "SupportError",
    "UrdfError",
    "__version__",
]
