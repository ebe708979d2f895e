# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs from Python: step by step with numpy arrays, or at once into a folder."""
from __future__ import annotations

import contextlib
import json
import logging
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from . import _engine
from ._check import array, checked, flag
from ._check import folder as a_folder
from ._check import path as a_path
from ._types import PathLike, Value
from .files import writing
from .results import Result, preformatted
from .views.labels import LOOP

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._keys import SceneKeys

__all__ = ["Cam", "Run", "Step", "cam", "forget", "read_scene", "run"]
_SUMS = _engine.names("step")
_FIELDS = _engine.names("facet")


@dataclass
class Step:
    """A converged load step: sums as attributes of `sums`, facet fields as arrays in `facets`."""

    sums: dict
    facets: dict = field(repr=False)
    against_teeth: bool = False

    @property
    def k_ts_nm_per_rad(self) -> float:
        """Torsional stiffness of the contact (Eq. 45) [N m/rad]."""
        return self.sums["k_ts_nm_per_rad"]

    @property
    def stiffness(self) -> str:
        """Text of what the scene is solved for: K_TS, or K_FTS against the teeth."""
        if not self.against_teeth:
            tangent = self.sums["k_ts_bonded_nm_per_rad"]
            return f"K_TS tangent {tangent:.4g}, Eq. 45 {self.k_ts_nm_per_rad:.4g} N m/rad".replace("nan", "none")
        torque, turn = self.sums["torque_nm"], self.sums["rotation_rad"]
        return f"K_FTS {torque / turn:.4g} N m/rad" if torque and turn else "K_FTS -"

    def _repr_html_(self):
        return preformatted(self)

    def __str__(self) -> str:
        s = self.sums
        phase = "torque" if s["in_torque"] else f"assembly, {100 * s['load_factor']:.0f} %"
        return (f"Step {s['step']:.0f}: {phase}, {s['torque_nm']:.4g} N m, {s['iterations']:.0f} iterations\n"
                f"  normal force {s['normal_force_n']:.4g} N   peak {s['pressure_max_pa'] / 1e6:.4g} MPa (node)   contact area "
                f"{1e6 * s['contact_area_m2']:.4g} mm^2\n"
                f"  rotation {s['rotation_rad']:.3e} rad   {self.stiffness}")


class Run:
    """A run that is stepped from Python.

    Parameters
    ----------
    path : str, optional
        Namelist; default: the default scene.
    out : str, optional
        Folder for the results; default: nothing is written.
    force : bool
        Replace earlier results in the folder.
    resume : bool
        Go on with a stopped run of the same scene in the folder; begin it if there is none.
    allow_implausible : bool
        Solve also where a value is some thousand times off, as 17.5 for a radius in m.
    **keys
        Scene keys as group__key=value (`load__torque=3`), or one dict per group (`load={'torque': 3}`).

    Raises
    ------
    InputError
        All mistakes of the input in one message.

    Examples
    --------
    >>> with Run(mesh={"divisions": 16, "band_facets": 4}, load={"torque": 1.0, "torque_steps": 1}) as r:
    ...     steps = list(r)
    """

    _handle = None   # these are of one that could not be opened
    facets = axial_facets = dof = load_steps = 0
    done = False

    @checked(path=a_path, out=a_path, force=flag, resume=flag, allow_implausible=flag)
    def __init__(self, path: PathLike | None = "", out: PathLike | None = "", force: bool = False,
                 resume: bool = False, allow_implausible: bool = False, **keys: Value) -> None:
        self._process = os.getpid()
        lines = "\n".join(_assignments(keys))
        if out:
            with writing(out):
                out = Path(out).absolute()   # the working folder may change between two steps
                out.parent.mkdir(parents=True, exist_ok=True)
        self._handle = _engine.call("run_open", str(path), lines or " ", str(out) or " ", int(force), int(resume),
                                     int(allow_implausible))
        self._teeth = _engine.supported(read_scene(path, **keys), "against_teeth")
        self.facets, self.axial_facets, self.dof, self.load_steps = (int(n) for n in _engine.call("run_sizes", self._handle))

    def _open(self) -> int:
        """Handle of the run, which must be open."""
        if self._handle is None:
            raise _engine.InputError("this run is closed")
        return self._handle

    def __reduce__(self) -> str:
        raise _engine.InputError("a Run cannot be copied or pickled: it is what the engine solves; copy its steps, or open another")

    def advance(self) -> Step:
        """Solve the next load step and return it as a Step.

        Raises
        ------
        NotConvergedError
            Gross slip, or no convergence after all cut-backs; `step()` still gives the last converged state.
        """
        handle = self._open()
        if self._process != os.getpid():
            raise _engine.InputError(f"this run belongs to process {self._process}, of which this one is a fork: open a run here")
        self.done = bool(_engine.call("run_advance", handle))
        return self.step()

    def step(self) -> Step:
        """The last converged step."""
        handle = self._open()
        sums = dict(zip(_SUMS, map(float, _engine.call("run_sums", handle, len(_SUMS)))))
        fields = _engine.call("run_facets", handle, self.facets, len(_FIELDS))
        return Step(sums, dict(zip(_FIELDS, np.asarray(fields).T)), self._teeth)

    def loop(self) -> dict:
        """What the loop of a whole drive says so far.

        Returns
        -------
        dict
            k1_nm_per_rad and so on, as in summary.json; without what the torques do not reach, and bands that nobody asked for.
        """
        values = _engine.call("run_loop", self._open(), len(LOOP))
        return {name: float(value) for name, value in zip(LOOP, values) if not np.isnan(value)}

    def __repr__(self) -> str:
        state = "closed" if self._handle is None else "solved" if self.done else "open"
        return f"Run: {self.facets} facets, {self.dof} dof, {state}"

    def _repr_html_(self):
        return preformatted(self)

    def __iter__(self) -> Iterator:
        while not self.done:
            yield self.advance()

    @checked(interrupted=flag)
    def close(self, interrupted: bool = False) -> None:
        """Write the summary, if there is a folder, and give back all memory.

        A fork leaves that to the process of the run.
        """
        if self._handle is not None:
            handle, self._handle = self._handle, None
            if self._process == os.getpid():
                _engine.call("run_close", handle, int(interrupted))

    def __enter__(self) -> Run:
        return self

    def __exit__(self, kind: type | None = None, *exc: object) -> None:
        self.close(kind is not None and issubclass(kind, KeyboardInterrupt))

    def __del__(self) -> None:
        try:
            self.close()
        except Exception:
            pass


@checked(path=a_path)
def read_scene(path: PathLike | None = "", **keys: Value) -> dict:
    """All keys of a scene as the engine reads them, checked, without running it.

    Parameters
    ----------
    path : str, optional
        Namelist; default: the default scene.
    **keys
        As for Run.

    Returns
    -------
    dict
        'group.key' to value, SI units.

    Raises
    ------
    InputError
        All mistakes of the input in one message.
    """
    return json.loads(_engine.call_text("scene_text", str(path), "\n".join(_assignments(keys)) or " ", 0))["scene"]


@checked(path=a_path)
def doubts(path: str = "", **keys: Value) -> list:
    """Values of a scene that are valid and hardly meant, as 209 Pa for a modulus; every run's summary has them as warnings.

    Parameters
    ----------
    path, **keys
        As for `read_scene`.

    Returns
    -------
    list of str
        One line each, with the slip of units that would explain it.
    """
    return _engine.call_text("scene_doubts", str(path), "\n".join(_assignments(keys)) or " ").splitlines()


def forget() -> None:
    """Give back the memory of the mesh and the factors that the last run left for the next one."""
    _engine.ask("model_forget")


def given_keys(assignments: list[str]) -> dict:
    """Keys of a command line, 'group.key=value' each."""
    for item in assignments:
        if "." not in item.partition("=")[0] or "=" not in item:
            raise _engine.InputError(f"'{item}' is no assignment; write group.key=value, as load.torque=3")
    return dict(item.split("=", 1) for item in assignments)


def _assignments(keys):
    """Lines 'group.key=value' from keyword parameters, each key once."""
    lines: dict[str, str] = {}
    for group, value in keys.items():
        parts = {f"{group}.{k}": v for k, v in value.items()} if isinstance(value, dict) else {group.replace("__", ".", 1): value}
        for key, v in parts.items():
            name = str(key).strip().lower()
            if {"\n", "\r", "\0", "="} & set(name):
                raise _engine.InputError(f"key {key!r}: valid is group.key, as load.torque")
            if name in lines:
                raise _engine.InputError(f"'{name}' is given twice: write it once, as load__torque=3 or load={{'torque': 3}}")
            lines[name] = f"{key}={_text(v)}"
    return [*lines.values()]


def _text(value):
    """A value as the namelist has it."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple, range)):
        return ",".join(_text(v) for v in value)
    if isinstance(value, (bool, np.bool_)):
        return f".{str(bool(value)).lower()}."
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (str, int, np.integer, Path)):
        text = str(value)
        if not {"\n", "\r", "\0"} & set(text):
            return text
    raise _engine.InputError(f"value {value!r}: a key takes a number, a line of text, or a list of numbers")


def in_notebook() -> bool:
    """The process is the kernel of a notebook."""
    return "ipykernel" in sys.modules


def bar(**options: object) -> Any:
    """A bar of tqdm, in the form that notebook or terminal want; None without tqdm or standard error."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    if sys.stderr is None:
        return None
    return tqdm(file=None if in_notebook() else sys.stderr, **options)


class _ToBar(logging.Handler):
    """Lines of the log beside a bar, which counts the load steps among them."""

    def __init__(self, bar):
        super().__init__(logging.INFO)
        self.bar = bar

    def emit(self, record):
        words = record.getMessage().split()
        self.bar.set_postfix_str(" ".join(words)[:90])
        if len(words) > 1 and words[0].isdigit() and words[1] in ("assembly", "torque"):
            self.bar.update()


@contextlib.contextmanager
def heard(handler: logging.Handler) -> Iterator[None]:
    """The lines of the engine's log go to a handler."""
    logger = logging.getLogger("hdengine")
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(min(logger.getEffectiveLevel(), logging.INFO))
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)


@contextlib.contextmanager
def follow(show: bool | None = None) -> Iterator[Callable[[int], None]]:
    """A bar over the load steps of runs, with the last line of the log beside it; yields what tells it how many there are.

    Parameters
    ----------
    show : bool, optional
        Default: in notebooks.
    """
    shown = bar(desc="load steps", unit="") if (in_notebook() if show is None else show) else None
    if shown is None:
        yield lambda steps: None
        return

    def expect(steps):
        shown.total = steps
        shown.refresh()
    with contextlib.closing(shown), heard(_ToBar(shown)):
        yield expect


@checked(out=a_folder)
def run(path: PathLike | None = "", out: PathLike = "run.out", force: bool = False, resume: bool = False,
        show: bool | None = None, allow_implausible: bool = False, **keys: Unpack[SceneKeys]) -> Result:
    """Run a scene to its end and return its Result.

    Parameters
    ----------
    path : str or Path, optional
        Namelist, as data/drive14.nml; default: the default scene, ring and cup of size 14.
    out : str or Path
        Folder for tables, summary and grids.
    force : bool
        Replace earlier results in it.
    resume : bool
        Go on with a stopped run of the same scene in it; begin it if there is none.
    show : bool, optional
        A bar over the load steps, with the last line of the log (needs tqdm); default: in notebooks. The log itself goes to the
        logger `hdengine` at level INFO.
    allow_implausible : bool
        Solve also where a value is some thousand times off, as 17.5 for a radius in m.
    **keys
        Keys of the scene that differ from the file, SI units: a dict a group (`load={'torque': 3}`) or `load__torque=3`.

    Returns
    -------
    Result
        `k1`, `k2`, `k3` of a whole drive, `k_ts`, tables by `frame('loop')`, figures by `plot()`, a page by `report()`.

    Raises
    ------
    InputError
        All mistakes of the input in one message.
    FileError
        `out` holds results, or a file cannot be read.
    NotConvergedError
        Gross slip, or no convergence; the converged steps are kept in `out`.
    LinearSolverError, EngineMemoryError
        A body is not held; the mesh does not fit into the memory.
    StoppedError
        `solver.time_limit_s` or a signal ended it; `resume=True` goes on.

    Examples
    --------
    >>> import hdengine, tempfile
    >>> result = hdengine.run(out=tempfile.mkdtemp() + "/small.out", mesh={"divisions": 16, "band_facets": 4}, load={"torque": 1.0})
    >>> result.complete, result.k_ts > 1e5
    (True, True)
    """
    with follow(show) as expect, Run(path, out, force, resume, allow_implausible, **cast(Any, keys)) as r:
        expect(r.load_steps)
        for _ in r:
            pass
    return Result(out)


@dataclass(frozen=True)
class Cam:
    """A circle and the wave generator that it goes on, in the middle of the band.

    Attributes
    ----------
    theta : ndarray (n,)
        Angles of points on the circle [rad].
    field : ndarray (2, n)
        Radial and tangential displacement to first order in w, as small displacements prescribe it [m].
    points : ndarray (2, n)
        Places on the exact curve, as large displacements prescribe them [m].
    normal : ndarray (2, n)
        Outward normals there.
    curvature : ndarray (n,)
        [1/m].
    circle_m, curve_m : float
        Lengths of the circle and of the exact curve [m].
    """

    theta: np.ndarray
    field: np.ndarray
    points: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    circle_m: float
    curve_m: float


@checked(theta=array([(), (None,)]), path=a_path)
def cam(theta: ArrayLike, path: PathLike = "", **keys: Value) -> Cam:
    """Wave generator of a scene.

    Parameters
    ----------
    theta : array_like (n,)
        Angles on the circle, from the long axis [rad].
    path : str or path
        Scene; '' takes the defaults.
    **keys
        Keys of the scene by group, as in `run`.

    Returns
    -------
    Cam

    Raises
    ------
    InputError, FileError
        A key or the table of a measured cam is not valid.
    """
    theta = np.atleast_1d(theta)
    field, curve, length = _engine.call("scene_cam", str(path), "\n".join(_assignments(keys)) or " ", theta)
    return Cam(theta, np.array(field), np.array(curve[:2]), np.array(curve[2:4]), np.array(curve[4]), *map(float, length))
