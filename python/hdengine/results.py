# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run, read from its folder."""
import json
import os
import warnings
from pathlib import Path

import numpy as np

from . import torsion
from ._engine import FileError
from .joint import Joint, JointWarning


def read_csv(path):
    """A CSV table as a structured array with the header's names."""
    try:
        return np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8"))
    except OSError as e:
        raise FileError(f"'{path}' cannot be read: {e}") from None


def read_summary(folder):
    """summary.json of a finished run.

    Raises
    ------
    FileError
        There is none.
    """
    path = Path(folder) / "summary.json"
    if not path.is_file():
        raise FileError(f"'{folder}' holds no finished run: summary.json is missing")
    return json.loads(path.read_text())


def row_edges(area, shape, band_length):
    """Ends of the facet rows, from the front edge of the band [m]; rows may be shorter towards its edges (mesh.edge_length)."""
    share = area.reshape(shape).sum(axis=0)
    return band_length * np.concatenate([[0.0], np.cumsum(share) / share.sum()])


def facet_stiffness(facets, joint, sheared=True):
    """K_N and K_T of facets for a joint as the engine forms them, the means of the corners' [N/m].

    Parameters
    ----------
    facets : mapping of ndarray (...)
        Columns of contact.csv.
    joint : Joint
    sheared : bool
        False: as if there were no shear.

    Returns
    -------
    k_n, k_t : ndarray (...)
    """
    pressure, shear = (np.stack([facets[f"{name}_{i}_pa"] for i in (1, 2, 3, 4)], -1) for name in ("pressure", "shear"))
    return tuple(k.mean(-1) for k in joint.stiffness(pressure, shear * sheared, facets["area_m2"][..., None]))


def long_axis(facets, shape, positions, band_length):
    """Mean pressure and shear of the two facets beside theta = 0 in the rows next to Positions I-III [Pa]."""
    edges = row_edges(facets["area_m2"], shape, band_length)
    z = 0.5 * (edges[1:] + edges[:-1])
    values = {}
    for i, place in enumerate(positions, 1):
        row = int(np.argmin(abs(z - place)))
        for name, label in (("pressure_pa", "pressure"), ("traction_theta_pa", "shear")):
            values[f"{label}_long_{i}_pa"] = float(facets[name].reshape(shape)[[0, -1], row].mean())
    return values


class Result:
    """A finished run.

    Attributes
    ----------
    folder : Path
    summary : dict
        summary.json.
    steps, history : structured ndarray
        One row per load step, per Newton iteration.
    contact : dict of ndarray (steps, facets)
        Columns of contact.csv.
    shape : tuple
        Facets round the circumference, facets along the band.
    """

    def __init__(self, folder):
        self.folder = Path(folder)
        self.summary = read_summary(folder)
        self.steps = read_csv(self.folder / "steps.csv")
        self.history = read_csv(self.folder / "history.csv")
        table = read_csv(self.folder / "contact.csv")
        facets = int(table["facet"].max())
        self.contact = {name: table[name].reshape(-1, facets) for name in table.dtype.names}
        self.shape = int(table["i_theta"].max()), int(table["i_z"].max())

    @property
    def scene(self):
        """All keys of the scene, 'group.key'."""
        return self.summary["scene"]

    @property
    def complete(self):
        """The run reached its last load step."""
        return self.summary["status"] == "complete"

    @property
    def against_teeth(self):
        """The cup turns against the teeth, ring bonded: K_FTS is asked for, and Eq. 45 says nothing."""
        return self.scene["load.support"] == "teeth"

    @property
    def teeth(self):
        """Force, share and closing of every pair of teeth and torque step (teeth.csv), a structured array."""
        return read_csv(self.folder / "teeth.csv")

    @property
    def torque_nm(self):
        """Torque of each step [N m]."""
        return self.steps["torque_nm"]

    def vectors(self, *names):
        """Columns stacked as (steps, facets, len(names))."""
        return np.stack([self.contact[name] for name in names], axis=-1)

    def secant_stiffness(self):
        """Torque over FE rotation of each step [N m/rad]: K_FTS against the teeth; NaN without torque.

        Returns
        -------
        ndarray (steps,)
        """
        turn = self.steps["rotation_rad"]
        return np.divide(self.torque_nm, turn, out=np.full(len(turn), np.nan), where=(self.torque_nm != 0) & (turn != 0))

    def torsional_stiffness(self):
        """K_TS of each step (Eq. 45): default [N m/rad] and as printed [N].

        Returns
        -------
        k_nm_per_rad, paper_n : ndarray (steps,)
        """
        c, s = self.contact, self.scene
        k = torsion.torsional_stiffness(c["k_n_n_per_m"], c["k_t_n_per_m"], self.vectors("x_m", "y_m", "z_m"),
                                        self.vectors("n_x", "n_y", "n_z"))
        paper = torsion.torsional_stiffness_paper(c["k_n_n_per_m"], c["k_t_n_per_m"], c["theta_rad"][0],
                                                  s["geometry.bore_radius"], s["wave_generator.w"])
        return k, paper

    def row_edges(self):
        """Ends of the facet rows, from the front edge of the band [m]."""
        return row_edges(self.contact["area_m2"][0], self.shape, self.scene["geometry.band_length"])

    def rows(self):
        """One dict per load step with the columns of a study's table."""
        k, paper = self.torsional_stiffness()
        steps = [{name: row[name].item() for name in self.steps.dtype.names} for row in self.steps]
        for i, row in enumerate(steps):
            facets = {name: column[i] for name, column in self.contact.items()}
            row.update(k_ts_nm_per_rad=float(k[i]), k_ts_paper_n=float(paper[i]), **long_axis(
                facets, self.shape, self.scene["output.positions"], self.scene["geometry.band_length"]))
        return steps

    def frame(self):
        """The load steps as a pandas.DataFrame (needs pandas)."""
        import pandas

        return pandas.DataFrame(self.rows())

    def dataset(self):
        """The contact fields as an xarray.Dataset over step, theta [rad] and z [m, from the band's front edge] (needs xarray)."""
        import xarray

        theta, edges = np.arange(self.shape[0]) + 0.5, self.row_edges()
        fields = {name: (("step", "theta_rad", "z_m"), column.reshape(-1, *self.shape)) for name, column in self.contact.items()
                  if name.endswith(("_pa", "_m", "_m2", "_per_m")) and name != "z_m"}
        return xarray.Dataset(fields, {"step": self.steps["step"], "torque_nm": ("step", self.torque_nm),
                                       "theta_rad": 2 * np.pi * theta / self.shape[0], "z_m": 0.5 * (edges[1:] + edges[:-1])})

    @property
    def joint(self):
        """The Joint that the run computed its stiffness with."""
        s, j = self.scene, self.summary["joint"]
        return Joint(
            e1=s["material.flexspline_e"], nu1=s["material.flexspline_nu"], e2=s["material.ring_e"], nu2=s["material.ring_nu"],
            nu_soft=s["material.flexspline_nu"], hardness=j["hardness_pa"], fractal_dimension=s["joint.fractal_dimension"],
            roughness=s["joint.roughness"], gamma=s["joint.gamma"], asperity_radius=j["asperity_radius_m"],
            friction=s["contact.friction"], s_min=j["s_min_m2"], reference_area=j["reference_area_m2"],
            paper=j["closure"] == "paper")

    def torsional_band(self, *, level=0.95, **errors):
        """K_TS of each step (Eq. 45) with a band from the standard errors of D and G.

        Parameters
        ----------
        level : float
            Probability inside the band.
        **errors
            d_error, ln_g_error and the rest of `Joint.samples`.

        Returns
        -------
        ndarray (3, steps)
            Low, median, high [N m/rad].
        """
        place, normal = self.vectors("x_m", "y_m", "z_m"), self.vectors("n_x", "n_y", "n_z")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", JointWarning)
            values = [torsion.torsional_stiffness(*facet_stiffness(self.contact, joint), place, normal)
                      for joint in self.joint.samples(**errors)]
        return np.quantile(values, [(1 - level) / 2, 0.5, (1 + level) / 2], axis=0)

    def write_torsion(self):
        """Write torsion.csv: torque, K_TS by both forms, FE rotation. Returns its path."""
        k, paper = self.torsional_stiffness()
        path = self.folder / "torsion.csv"
        rows = np.column_stack([self.steps["step"], self.torque_nm, k, paper, self.steps["rotation_rad"]])
        part = path.with_suffix(".part")
        np.savetxt(part, rows, delimiter=",", comments="", fmt=["%d"] + ["%.17g"] * 4,
                   header="step,torque_nm,k_ts_nm_per_rad,k_ts_paper_n,rotation_rad")
        os.replace(part, path)
        return path

    @property
    def limits(self):
        """What a planned run promises of its last step: limits of fine meshes.

        Returns
        -------
        dict
            k_ts_nm_per_rad, normal_force_n, pressure_mid_mean_pa: (limit, its estimated relative error, mesh over limit); empty
            where nothing was planned.
        """
        plan = self.summary.get("plan", {})
        names = {"k_ts_nm_per_rad": "k_ts", "normal_force_n": "normal_force", "pressure_mid_mean_pa": "mid_band_pressure"}
        return {key: (plan[key], plan[f"estimated_error_{n}"], plan[f"mesh_over_limit_{n}"])
                for key, n in names.items() if key in plan}

    def __repr__(self):
        r = self.summary["results"]
        if self.against_teeth:
            stiffness = "K_FTS: no torque"
            if self.torque_nm[-1] != 0:
                share = 100 * self.teeth["share"][self.teeth["step"] == self.steps["step"][-1]]
                stiffness = f"K_FTS (torque over rotation) {self.secant_stiffness()[-1]:.4g} N m/rad   shares of the pairs " \
                            f"{share.min():.1f} to {share.max():.1f} %"
        else:
            k, paper = self.torsional_stiffness()
            stiffness = f"K_TS (Eq. 45) {k[-1]:.4g} N m/rad   as printed {paper[-1]:.4g} N"
        lines = [
            f"{self.summary['title'] or self.folder}: {self.summary['status']}",
            f"  {r['steps']} load steps, {r['iterations']} Newton iterations, {self.summary['model']['dof']} dof, "
            f"{self.summary['model']['facets']} facets",
            f"  torque {self.torque_nm[-1]:.4g} N m   normal force {r['normal_force_n']:.4g} N   "
            f"peak {r['pressure_max_pa'] / 1e6:.4g} MPa (node)   rotation {r['rotation_rad']:.3e} rad",
            f"  {stiffness}",
        ]
        if self.limits and not self.against_teeth:
            k, error, mesh = self.limits["k_ts_nm_per_rad"]
            lines.append(f"  limit of fine meshes: K_TS {k:.4g} N m/rad within {100 * error:.2g} % "
                         f"(this mesh {100 * (mesh - 1):+.2g} %)")
        return "\n".join(lines + [f"  warning: {w}" for w in self.summary["warnings"]])


def load(folder):
    """Result of a run folder."""
    return Result(folder)
