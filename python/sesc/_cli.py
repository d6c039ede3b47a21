"""The ``sesc`` command that comes with the package: the same program, from its library."""

from __future__ import annotations

import sys

from . import _sesc

__all__ = ["main"]


def main() -> int:
    """Run the command line of this process; gives the exit code."""
    return _sesc.command(["sesc", *sys.argv[1:]])


if __name__ == "__main__":
    raise SystemExit(main())
