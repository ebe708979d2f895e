# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run, read from its folder."""
from __future__ import annotations

import base64
import functools
import html
import io
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from . import _engine, torsion
from ._check import checked, flag, integer, integers, package, seen
from ._check import folder as a_folder
from ._check import text as a_text
from ._engine import FileError, InputError, NotConvergedError
from ._types import PathLike
from .elastic import ElasticJoint, joint_of_scene
from .files import write_files
from .joint import Joint
from .summary_file import check_inputs, check_same_run, echo_of, has_table, read_summary, written
from .table_file import read_csv
from .views.labels import LOOP

__all__ = ["Result", "load"]
_GRADIENT = "run.gradient=.true.\nrun.tolerance=0\nrun.band=.false.\nturning.positions=0\noutput.vtu=none\n" \
            "load.tangent_steps=needed"   # of the run that is solved again for its derivatives
_OF_FACETS = ("step", "facet", "i_theta", "i_z", "area_m2", "pressure_pa")   # without which contact.csv says nothing
KEPT = 8    # steps of contact.csv that a result holds besides the whole


def _number(value):
    """Four digits; JSON's null as a dash."""
    return "-" if value is None else f"{value:.4g}"


_UNITS = (("_n_per_m", "N/m"), ("_m2", "m^2"), ("_pa", "Pa"), ("_m", "m"))  # the end of a column's name, its unit


def _described(name):
    """Unit and name in words of a column of contact.csv."""
    end, unit = next((end, unit) for end, unit in _UNITS if name.endswith(end))
    words = {"k_n": "normal stiffness of the joint", "k_t": "tangential stiffness of the joint", "x": "x of the facet",
             "y": "y of the facet", "z": "axial place of the facet from the opening", "traction_theta": "shear along theta",
             "traction_z": "shear along the axis", "slip_theta": "slip along theta", "slip_z": "slip along the axis"}
    short = name.removesuffix(end)
    return {"units": unit, "long_name": words.get(short, short.replace("_", " "))}


def preformatted(thing: object) -> str:
    """What `print` shows, for notebooks."""
    return f'<pre style="line-height:1.3">{html.escape(str(thing))}</pre>'


def _known(limit: Any) -> Any:
    """A limit, NaN for what is not promised of a list."""
    return [np.nan if v is None else v for v in limit] if isinstance(limit, list) else limit


def row_edges(area: np.ndarray, shape: tuple[int, int], band_length: float) -> np.ndarray:
    """Ends of the facet rows, from the front edge of the band [m]; rows may be shorter towards its edges (mesh.edge_length)."""
    share = area.reshape(shape).sum(axis=0)
    return band_length * np.concatenate([[0.0], np.cumsum(share) / share.sum()])


def facet_stiffness(facets: Mapping[str, np.ndarray], joint: Joint | ElasticJoint) -> tuple[np.ndarray, np.ndarray]:
    """K_N and K_T of facets for a joint as the engine forms them, the means of the corners' [N/m].

    Parameters
    ----------
    facets : mapping of ndarray (...)
        Columns of contact.csv.
    joint : Joint

    Returns
    -------
    k_n, k_t : ndarray (...)
    """
    pressure, shear = (np.stack([facets[f"{name}_{i}_pa"] for i in (1, 2, 3, 4)], -1) for name in ("pressure", "shear"))
    return tuple(k.mean(-1) for k in joint.stiffness(pressure, shear, facets["area_m2"][..., None]))


def long_axis(facets: Mapping[str, np.ndarray], shape: tuple[int, int], positions: Sequence[float], band_length: float) -> dict:
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

    _reporter: ClassVar[Callable[..., Path]]  # hdengine.report, which stands above; the package sets it

    @checked(folder=a_folder)
    def __init__(self, folder: PathLike) -> None:
        self.folder = Path(folder).absolute()  # a program may go elsewhere
        self.summary = read_summary(folder, "title", "status", "scene", "results", "model", "joint", "warnings")
        self._whole: set[str] = set()   # tables that are known to be as the run left them
        self.steps = self._table("steps", "step", "torque_nm", "load_factor")
        self.history = self._table("history", "iteration", "residual")
        self._facets: dict[int, dict] = {}   # of the steps that were asked for alone
        #: rows of steps.csv whose facets contact.csv holds
        self._held = range(len(self.steps))
        if self.scene.get("output.contact") == "last":
            row = int(np.flatnonzero(self.steps["step"] == self._table("contact", "step")["step"][-1])[0])
            self._held = range(row, row + 1)
        last = self.contact_at(self._held[-1])
        self.shape = int(last["i_theta"][-1]), int(last["i_z"][-1])

    def _table(self, name, *needed, step=None):
        """A table of the run, which is as the run left it; nothing writes into it."""
        path = self.folder / f"{name}.csv"
        check_same_run(self.folder, self.summary)
        if not has_table(self.summary, name):
            own = ", ".join(file[:-4] for file in self.summary["checksums"] if file.endswith(".csv"))
            raise FileError(f"'{self.folder}' has no {name}.csv: a run of its keys writes none; valid: {own}")
        if name not in self._whole:
            written(self.folder, path.name, self.summary)
            self._whole.add(name)
        table = read_csv(path, *needed, step=step)
        table.flags.writeable = False
        return table

    @functools.cached_property
    def contact(self) -> dict:
        """Columns of contact.csv, (steps, facets) each; read when they are first asked for.

        Raises
        ------
        InputError
            It holds one step alone (output.contact = 'last').
        """
        facets = self.shape[0] * self.shape[1]
        if len(self._held) < len(self.steps):
            raise InputError(f"'{self.folder / 'contact.csv'}' holds one load step (output.contact = 'last'): valid is "
                             f"contact_at({self._held[0]})")
        table = self._table("contact", *_OF_FACETS)
        return {name: table[name].reshape(-1, facets) for name in table.dtype.names or ()}

    def _row(self, step):
        """Row of a load step, counted from 0, or back from the end where negative."""
        rows = range(len(self.steps))
        if not -len(rows) <= step < len(rows):
            raise InputError(f"step = {step}: the run has {len(rows)} load steps, counted from 0")
        return rows[step]

    @checked(step=integer(-2**31))
    def contact_at(self, step: int) -> Mapping[str, np.ndarray]:
        """Columns of contact.csv of one load step, counted from 0, (facets,) each; the other steps are not read.

        Raises
        ------
        InputError
            There is no such step, or contact.csv does not hold it.
        """
        step = self._row(step)
        if "contact" in self.__dict__:
            return {name: column[step] for name, column in self.contact.items()}
        if step not in self._held:
            raise InputError(f"step = {step}: contact.csv holds step {self._held[0]} alone (output.contact = 'last')")
        if step not in self._facets:
            if len(self._facets) == KEPT:
                self._facets.clear()
            number = int(self.steps["step"][step])
            table = self._table("contact", *_OF_FACETS, step=number)
            self._facets[step] = {name: table[name] for name in table.dtype.names or ()}
        return self._facets[step]

    @property
    def scene(self) -> dict:
        """All keys of the scene, 'group.key'."""
        return self.summary["scene"]

    @property
    def complete(self) -> bool:
        """The run reached its last load step."""
        return self.summary["status"] == "complete"

    @property
    def against_teeth(self) -> bool:
        """The cup turns against the teeth, ring bonded: K_FTS is asked for, and Eq. 45 says nothing."""
        return _engine.supported(self.scene, "against_teeth")

    @property
    def teeth(self) -> np.ndarray:
        """Force, share and closing of every flank of the teeth and torque step (teeth.csv), a structured array."""
        return self._table("teeth")

    @property
    def loop(self) -> np.ndarray:
        """Torque, angle, energies and largest forces of every step of the whole drive (loop.csv), a structured array."""
        return self._table("loop")

    @property
    def balls(self) -> np.ndarray | None:
        """Force, share and closing of every ball and step (balls.csv), a structured array; None without balls."""
        return self._table("balls") if has_table(self.summary, "balls") else None

    @property
    def fatigue(self) -> np.ndarray:
        """Mean, amplitude and safety of the points of the flexspline's meridian (fatigue.csv), a structured array."""
        return self._table("fatigue", "torque_nm", "safety")

    @property
    def turning(self) -> np.ndarray | None:
        """Turn and stiffness at each place of the wave generator (turning.csv), a structured array; None where it stands."""
        return self._table("turning") if has_table(self.summary, "turning") else None

    @property
    def torque_nm(self) -> np.ndarray:
        """Torque of each step [N m]."""
        return self.steps["torque_nm"]

    def vectors(self, *names: str) -> np.ndarray:
        """Columns stacked as (steps, facets, len(names))."""
        wrong = [name for name in names if name not in self.contact]
        if wrong or not names:
            raise InputError(f"columns {', '.join(map(seen, wrong)) or 'of no name'}: valid are those of contact.csv, "
                             f"{', '.join(self.contact)}")
        return np.stack([self.contact[name] for name in names], axis=-1)

    def secant_stiffness(self) -> np.ndarray:
        """Torque over FE rotation of each step [N m/rad]: K_FTS against the teeth; NaN without torque.

        Returns
        -------
        ndarray (steps,)
        """
        turn = self.steps["rotation_rad"]
        return np.divide(self.torque_nm, turn, out=np.full(len(turn), np.nan), where=(self.torque_nm != 0) & (turn != 0))

    def torsional_stiffness(self) -> tuple:
        """K_TS of each step (Eq. 45): default [N m/rad] and as printed [N].

        Returns
        -------
        k_nm_per_rad, paper_n : ndarray (steps,)
        """
        c, s = self.contact, self.scene
        k = torsion.torsional_stiffness(c["k_n_n_per_m"], c["k_t_n_per_m"], self.vectors("x_m", "y_m", "z_m"),
                                        self.vectors("bent_n_x", "bent_n_y", "bent_n_z"))
        paper = torsion.torsional_stiffness_paper(
            c["k_n_n_per_m"], c["k_t_n_per_m"], c["theta_rad"][0], s["geometry.bore_radius"], s["wave_generator.w"],
            np.tan(np.radians(s["wave_generator.cone_angle_deg"])))
        return k, paper

    def row_edges(self) -> np.ndarray:
        """Ends of the facet rows, from the front edge of the band [m]."""
        return row_edges(self.contact_at(self._held[0])["area_m2"], self.shape, self.scene["geometry.band_length"])

    @checked(steps=integers((None,), -2**31, optional=True, empty=True))
    def rows(self, steps: Sequence[int] | None = None) -> list:
        """One dict per load step, of all or those listed from 0, with the columns of a study's table.

        Raises
        ------
        InputError
            There is no such step.
        """
        found = []
        for i in range(len(self.steps)) if steps is None else map(self._row, steps):
            row = {name: self.steps[name][i].item() for name in self.steps.dtype.names or ()}
            if i in self._held:
                place = self.scene["output.positions"], self.scene["geometry.band_length"]
                row |= long_axis(self.contact_at(i), self.shape, *place)
            if i == len(self.steps) - 1:
                row |= {name: value for name in LOOP if (value := self.summary["results"].get(name)) is not None}
            found.append(row)
        return found

    @checked(table=a_text)
    def frame(self, table: str = "steps") -> Any:
        """A table of the run as a pandas.DataFrame (needs pandas).

        Parameters
        ----------
        table : str
            'steps' with the pressures at Positions I-III; or a CSV file of the folder without its suffix: 'loop', 'balls', 'teeth',
            'fatigue', 'history', 'contact', 'turning'.

        Raises
        ------
        FileError
            The run has no such table.
        """
        pandas = package("pandas", "a frame", "tables")
        return pandas.DataFrame(self.rows() if table == "steps" else self._table(table))

    def dataset(self) -> Any:
        """The contact fields as an xarray.Dataset over step, theta_rad and band_z_m (needs xarray).

        band_z_m is the distance from the front edge of the band; z_m is the axial place of a facet from the opening, as in
        contact.csv. Every variable has units and a long_name.
        """
        xarray = package("xarray", "a dataset", "tables")
        theta, edges = np.arange(self.shape[0]) + 0.5, self.row_edges()
        axes = ("step", "theta_rad", "band_z_m")
        fields = {name: (axes, column.reshape(-1, *self.shape), _described(name)) for name, column in self.contact.items()
                  if name.endswith(("_pa", "_m", "_m2", "_per_m"))}
        return xarray.Dataset(fields, {
            "step": self.steps["step"], "torque_nm": ("step", self.torque_nm, {"units": "N m", "long_name": "torque"}),
            "theta_rad": ("theta_rad", 2 * np.pi * theta / self.shape[0], {"units": "rad", "long_name": "angle from long axis"}),
            "band_z_m": ("band_z_m", 0.5 * (edges[1:] + edges[:-1]), {
                "units": "m", "long_name": "distance of the row from the front edge of the band"})},
            {"title": self.summary["title"], "status": self.summary["status"]})

    def _repr_html_(self):
        found = self.summary["results"]
        rows = [(f"K{i} / (kN m/rad)", k / 1e3) for i, k in enumerate((self.k1, self.k2, self.k3), 1) if np.isfinite(k)]
        rows += [(f"{name.replace('_', ' ')} / arcmin", np.degrees(60 * found[f"{name}_rad"]))
                 for name in ("hysteresis", "lost_motion") if found.get(f"{name}_rad") is not None]
        rows += [("K_TS, tangent / (MN m/rad)", self.k_ts / 1e6), ("normal force / N", found["normal_force_n"]),
                 ("torque / N m", found.get("reference_torque_nm", self.torque_nm[-1]))]
        cells = "".join(f"<tr><td>{html.escape(name)}</td><td>{value:.4g}</td></tr>" for name, value in rows)
        picture, buffer = "", io.BytesIO()
        if _engine.supported(self.scene, "loop") and has_table(self.summary, "loop"):
            from .figures.drive import plot_loop

            plot_loop(self).savefig(buffer, format="png", dpi=70)
            picture = f'<img alt="loop" src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">'
        notes = "".join(f"<p>warning: {html.escape(w)}</p>" for w in self.summary["warnings"])
        title = html.escape(f"{self.summary['title'] or self.folder}: {self.summary['status']}")
        return f"<table><caption>{title}</caption>{cells}</table>{picture}{notes}"

    def _reading(self, name):
        """A number of the summary's results, NaN where it has none."""
        value = self.summary["results"].get(name)
        return float("nan") if value is None else float(value)

    @property
    def k1(self) -> float:
        """K1 of a whole drive: chord of its loop from 0 to T1 [N m/rad]; NaN where the run has none."""
        return self._reading("k1_nm_per_rad")

    @property
    def k2(self) -> float:
        """K2 of a whole drive: chord from T1 to T2 [N m/rad]; NaN where the run has none."""
        return self._reading("k2_nm_per_rad")

    @property
    def k3(self) -> float:
        """K3 of a whole drive: chord from T2 to the largest torque [N m/rad]; NaN where the run has none."""
        return self._reading("k3_nm_per_rad")

    @property
    def k_ts(self) -> float:
        """Torsional stiffness of the contact, the tangent beside bonded faces [N m/rad]; NaN where the run has none."""
        return self._reading("k_ts_bonded_nm_per_rad")

    @checked(debug=flag)
    def plot(self, debug: bool = False) -> list:
        """Make the run's figures in its folder; returns their paths.

        Parameters
        ----------
        debug : bool
            Also what is read to mend a run.
        """
        from .figures.run import plot_run

        return plot_run(self, debug)

    def report(self, path: PathLike | None = None, **options: bool) -> Path:
        """Write the run's report, one HTML file; returns its path.

        Parameters
        ----------
        path : str or Path, optional
            Default: report.html in the folder.
        **options
            picture, animation: of `hdengine.report.write_report`.
        """
        check_same_run(self.folder, self.summary)
        return Result._reporter(self.folder, path, **options)

    @property
    def joint(self) -> Joint | ElasticJoint:
        """The Joint that the run computed the stiffness of its last step with."""
        return self.joint_at(-1)

    @checked(step=integer(-2**31))
    def joint_at(self, step: int) -> Joint | ElasticJoint:
        """The Joint of a load step: its shear is capped by the friction of that step (contact.torque_friction under a torque)."""
        check_inputs(self.summary)
        return joint_of_scene(self.scene, float(self.steps["friction"][self._row(step)]))

    def gradient(self) -> dict[str, dict[str, float]]:
        """Derivatives of the results by every number of the drive that is in use.

        The results are K1 to K3, hysteresis, lost motion, largest forces of balls and teeth, least safety of the cup, K_TS by
        Eq. 45 and tangent, normal force, largest stress and line load of the edge; without a loop the last five and the rotation.

        They are those of a run with `run.gradient`; another run is solved once more with it, from its echo.nml. Each is found by
        adjoint differentiation back along the load steps, contact states kept: where a change turns one it holds on one side.

        Returns
        -------
        dict of dict
            result: {'group.key': derivative}, in SI units; by a list of numbers where all change alike. NaN: no such result;
            stress and edge load by the eccentricity of a centred cam; one that would not be in proportion to all forces and
            stiffnesses, for a change of state has spoilt its derivatives: it is named in the warnings of the summary.

        Raises
        ------
        InputError
            Large displacements, the teeth alone, `load.tooth_friction`, or `loop.history` 'turned'.
        FileError
            The folder holds another run by now, or echo.nml or a table that a key names has changed.
        NotConvergedError
            The equations behind the derivatives could not be solved.
        """
        if "gradient" not in self.summary:
            check_same_run(self.folder, self.summary)
            check_inputs(self.summary)
            echo = echo_of(self.folder, self.summary)
            with tempfile.TemporaryDirectory() as folder:
                handle = _engine.call("run_open", str(echo), _GRADIENT, f"{folder}/r", 1, 0, 1)
                try:
                    while not _engine.call("run_advance", handle):
                        pass
                finally:
                    _engine.call("run_close", handle, 0)
                found = read_summary(f"{folder}/r", "warnings")
            lost = [w for w in found["warnings"] if w.startswith("no gradient: ")]
            if "gradient" not in found:
                raise NotConvergedError(lost[0])
            self.summary["warnings"] += lost
            self.summary["gradient"] = found["gradient"]
        return {result: {key: np.nan if value is None else value for key, value in by_key.items()}
                for result, by_key in self.summary["gradient"].items()}

    def write_torsion(self) -> Path:
        """Write torsion.csv: torque, K_TS by both forms, FE rotation. Returns its path."""
        k, paper = self.torsional_stiffness()
        path = self.folder / "torsion.csv"
        text = io.StringIO()
        rows = np.column_stack([self.steps["step"], self.torque_nm, k, paper, self.steps["rotation_rad"]])
        np.savetxt(text, rows, delimiter=",", comments="", fmt=["%d"] + ["%.17g"] * 4,
                   header="step,torque_nm,k_ts_nm_per_rad,k_ts_paper_n,rotation_rad")
        write_files({path: text.getvalue()})
        return path

    @property
    def limits(self) -> dict:
        """What a planned run promises of its last step: limits of fine meshes.

        Returns
        -------
        dict
            (limit, its estimated relative error, mesh over limit) by column of steps.csv: k_ts_bonded_nm_per_rad, rotation_rad,
            normal_force_n, pressure_mid_mean_pa, k_fe_secant_nm_per_rad (K_FTS) and pressure_mid_max_pa. Limit and mesh over limit
            are lists for k_ts_tangent_steps_nm_per_rad (K_TS after the assembly and in each torque step; NaN: not promised) and for
            pressure_field_pa (mean pressures of 16 x 4 equal patches, along the band first); their error is the largest, or that of
            the norm. K1, K2, K3 and hysteresis of a whole drive. Without those that the scene has no value of, empty where nothing
            was planned.
        """
        plan = self.summary.get("plan", {})
        names = zip(_engine.names("promise_columns"), _engine.names("promise_names"))
        return {key: (_known(plan[key]), plan[f"estimated_error_{n}"], plan[f"mesh_over_limit_{n}"])
                for key, n in names if key in plan}

    def __repr__(self) -> str:
        r = self.summary["results"]
        if self.against_teeth:
            stiffness = "K_FTS: no torque"
            if self.torque_nm[-1] != 0:
                share = 100 * self.teeth["share"][self.teeth["step"] == self.steps["step"][-1]]
                stiffness = f"K_FTS (torque over rotation) {self.secant_stiffness()[-1]:.4g} N m/rad   shares of the pairs " \
                            f"{share.min():.1f} to {share.max():.1f} %"
        else:
            k = r["k_ts_bonded_nm_per_rad"]
            whole = self.summary["status"] == "complete"
            stiffness = "K_TS none: " + ("these faces have no tangent" if whole else "the run ended early")
            if k is not None:
                stiffness = f"K_TS {_number(k)} N m/rad, the tangent beside bonded faces"
        lines = [
            f"{self.summary['title'] or self.folder}: {self.summary['status']}",
            f"  {r['steps']} load steps, {r['iterations']} Newton iterations, {self.summary['model']['dof']} dof, "
            f"{self.summary['model']['facets']} facets",
            f"  torque {r.get('reference_torque_nm', self.torque_nm[-1]):.4g} N m   normal force {r['normal_force_n']:.4g} N   "
            f"peak {r['pressure_max_pa'] / 1e6:.4g} MPa (node)   rotation {r['rotation_rad']:.3e} rad",
            f"  {stiffness}",
        ]
        if any(r.get(f"k{i}_nm_per_rad") is not None for i in (1, 2, 3)):
            bands = [[r.get(f"k{i}_nm_per_rad{end}") for end in ("", "_low", "_high")] for i in (1, 2, 3)]
            k = ", ".join(f"K{i} {_number(k)}" + (f" ({low:.4g} to {high:.4g})" if low and high else "")
                          for i, (k, low, high) in enumerate(bands, 1) if k is not None)
            widths = "".join(f"; {name.replace('_', ' ')} {np.degrees(60 * r[f'{name}_rad']):.3g}'"
                             for name in ("hysteresis", "lost_motion") if r.get(f"{name}_rad") is not None)
            lines.append(f"  drive: {k} N m/rad{widths}")
        for key, name in (("k_ts_bonded_nm_per_rad", "tangent K_TS"), *((f"k{i}_nm_per_rad", f"K{i}") for i in (1, 2, 3))):
            if key in self.limits:
                k, error, mesh = self.limits[key]
                lines.append(f"  limit of fine meshes: {name} {k:.4g} N m/rad within {100 * error:.2g} % "
                             f"(this mesh {100 * (mesh - 1):+.2g} %)")
        return "\n".join(lines + [f"  warning: {w}" for w in self.summary["warnings"]])


def load(folder: PathLike) -> Result:
    """Result of a run folder."""
    return Result(folder)
