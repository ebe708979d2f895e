# SPDX-License-Identifier: GPL-3.0-or-later
"""hdengine.x, and the command that becomes it: apart from the package, which would import numpy first."""
import os
import sys

PROGRAM = os.path.join(os.path.dirname(os.path.abspath(__file__)), "hdengine.x")


def main() -> None:
    """Become hdengine.x; it finds the command `hdengine` beside this one."""
    os.environ["PATH"] = os.environ.get("PATH", os.defpath) + os.pathsep + os.path.dirname(os.path.abspath(sys.argv[0]))
    os.execv(PROGRAM, ["hdengine.x", *sys.argv[1:]])
