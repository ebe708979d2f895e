# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs from Python: step by step with numpy arrays, or at once into a folder."""
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from . import _engine, torsion
from .results import Result

_SUMS = ("step", "in_torque", "load_factor", "torque_nm", "rotation_rad", "normal_force_n", "lobe_force_x_n",
         "contact_area_m2", "pressure_max_pa", "pressure_mid_mean_pa", "friction_torque_nm", "friction_capacity_nm",
         "torque_balance_nm", "iterations", "seconds")
_FIELDS = ("theta_rad", "x_m", "y_m", "z_m", "n_x", "n_y", "n_z", "area_m2", "gap_m", "pressure_pa", "traction_theta_pa",
           "traction_z_pa", "slip_theta_m", "slip_z_m", "state", "k_n_n_per_m", "k_t_n_per_m",
           *(f"{name}_{i}_pa" for i in (1, 2, 3, 4) for name in ("pressure", "shear")))


@dataclass
class Step:
    """A converged load step: sums as attributes of `sums`, facet fields as arrays in `facets`."""

    sums: dict
    facets: dict = field(repr=False)
    against_teeth: bool = False

    @property
    def k_ts_nm_per_rad(self):
        """Torsional stiffness of the contact (Eq. 45) [N m/rad]."""
        f = self.facets
        return float(torsion.torsional_stiffness(f["k_n_n_per_m"], f["k_t_n_per_m"],
                                                 np.stack([f["x_m"], f["y_m"], f["z_m"]], -1),
                                                 np.stack([f["n_x"], f["n_y"], f["n_z"]], -1)))

    @property
    def stiffness(self):
        """Text of what the scene is solved for: K_TS, or K_FTS against the teeth."""
        if not self.against_teeth:
            return f"K_TS (Eq. 45) {self.k_ts_nm_per_rad:.4g} N m/rad"
        torque, turn = self.sums["torque_nm"], self.sums["rotation_rad"]
        return f"K_FTS {torque / turn:.4g} N m/rad" if torque and turn else "K_FTS -"

    def __str__(self):
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

    def __init__(self, path="", out="", force=False, resume=False, **keys):
        self._handle = None
        lines = "\n".join(_assignments(keys))
        if out:
            Path(out).absolute().parent.mkdir(parents=True, exist_ok=True)
        self._handle = _engine.call("run_open", str(path), lines or " ", str(out) or " ", int(force), int(resume))
        self._teeth = read_scene(path, **keys)["load.support"] == "teeth"
        self.facets, self.axial_facets, self.dof = (int(n) for n in _engine.call("run_sizes", self._handle))
        self.done = False

    def advance(self):
        """Solve the next load step and return it as a Step.

        Raises
        ------
        NotConvergedError
            Gross slip, or no convergence after all cut-backs; `step()` still gives the last converged state.
        """
        self.done = bool(_engine.call("run_advance", self._handle))
        return self.step()

    def step(self):
        """The last converged step."""
        sums = dict(zip(_SUMS, map(float, _engine.call("run_sums", self._handle))))
        fields = _engine.call("run_facets", self._handle, self.facets)
        return Step(sums, dict(zip(_FIELDS, np.asarray(fields).T)), self._teeth)

    def __repr__(self):
        state = "closed" if self._handle is None else "solved" if self.done else "open"
        return f"Run: {self.facets} facets, {self.dof} dof, {state}"

    def __iter__(self):
        while not self.done:
            yield self.advance()

    def close(self):
        """Write the summary, if there is a folder, and give back all memory."""
        if self._handle is not None:
            handle, self._handle = self._handle, None
            _engine.call("run_close", handle)

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self.close()

    def __del__(self):
        try:
            self.close()
        except Exception:
            pass


def read_scene(path="", **keys):
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
    return json.loads(_engine.call("scene_text", str(path), "\n".join(_assignments(keys)) or " ", 0).decode())["scene"]


def forget():
    """Give back the memory of the mesh and the factors that the last run left for the next one."""
    _engine.call("model_forget")


def _assignments(keys):
    """Lines 'group.key=value' from keyword parameters."""
    for name, value in keys.items():
        if isinstance(value, dict):
            yield from (f"{name}.{key}={_text(v)}" for key, v in value.items())
        else:
            yield f"{name.replace('__', '.', 1)}={_text(value)}"


def _text(value):
    if isinstance(value, (list, tuple, np.ndarray)):
        return ",".join(_text(v) for v in value)
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)


def run(path="", out="run.out", force=False, resume=False, **keys):
    """Run a scene to its end and return its Result; Ctrl-C works between load steps.

    Parameters and errors as for Run. A run that ends early leaves its converged steps and a summary in `out`.
    """
    with Run(path, out, force, resume, **keys) as r:
        for _ in r:
            pass
    return Result(out)
