# SPDX-License-Identifier: GPL-3.0-or-later
"""hdengine: torsional stiffness of the flexspline-bearing contact of a harmonic drive."""
from ._engine import (
    EngineMemoryError,
    FileError,
    HdengineError,
    InputError,
    InternalError,
    LinearSolverError,
    NotConvergedError,
    StoppedError,
)
from ._engine import version as _version
from .contact import Cam, Run, Step, cam, forget, read_scene, run
from .drive import as_built
from .joint import Joint, JointWarning
from .results import Result, load
from .studies.study import Study, StudyResult
from .surfaces import roughness, specimen, surface
from .surfaces.run import SurfaceResult, run_surface
from .teeth.pairs import ToothGaps, tooth_gaps
from .teeth.profile import DoubleArc, Involute


def _report(*args, **options):
    """`hdengine.report.write_report`, whose libraries are loaded when it is first called."""
    from .report import write_report

    return write_report(*args, **options)


Result._reporter = staticmethod(_report)
__version__ = _version()
__all__ = [
    "Cam", "DoubleArc", "EngineMemoryError", "FileError", "HdengineError", "InputError", "InternalError", "Involute", "Joint",
    "JointWarning", "LinearSolverError", "NotConvergedError", "Result", "Run", "Step", "StoppedError", "Study", "StudyResult",
    "SurfaceResult", "ToothGaps", "as_built", "cam", "forget", "load", "read_scene", "roughness", "run", "run_surface",
    "specimen", "surface", "tooth_gaps",
]
