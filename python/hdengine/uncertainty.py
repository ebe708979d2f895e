# SPDX-License-Identifier: GPL-3.0-or-later
"""What K_TS owes to its inputs: bands, one-at-a-time ranges (tornado), variance-based indices."""
from __future__ import annotations

import io
import warnings
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from . import _engine, torsion
from ._check import RUN, alike, checked, flag, integer
from ._check import path as a_path
from ._engine import InputError
from ._types import PathLike, Value
from .contact import read_scene
from .elastic import joint_of_scene
from .files import check_file, json_text, write_files, writing
from .results import Result, facet_stiffness
from .studies.progress import Progress
from .studies.study import Study, StudyResult
from .summary_file import check_inputs, echo_of

__all__ = ["ContactField", "analyse"]
# key: (low, high, why)
JOINT = {
    "joint.asperity_radius": (3.74e-6, 6.30e-6, "fits to boundary elements: both cut-offs, the finer one"),
    "joint.s_min": (4.9e-13, 2.4e-12, "fits to boundary elements: the coarser cut-off, both"),
    "joint.fractal_dimension": (2.5184, 2.5424, "two standard deviations of the fit, 0.006 each"),
    "joint.roughness": (2.238e-7, 2.627e-7, "two standard deviations of ln G, 0.04 each"),
    "joint.hardness": (2.3e9, 3.1e9, "2.8 sigma_y, sigma_y 835 to 1120 MPa"),
}
DRIVE = {
    "contact.friction": (0.05, 0.15, "lubricated to dry"),
    "wave_generator.w": (0.195e-3, 0.215e-3, "range of the paper"),
    "wave_generator.interference": (5e-6, 15e-6, "chosen, half to one and a half"),
    "wave_generator.eccentricity": (0.0, 10e-6, "range of the paper"),
    "geometry.bore_radius": (17.3e-3, 17.8e-3, "pitch radius less dedendum and rim"),
    "geometry.wall_thickness": (0.32e-3, 0.40e-3, "scaled estimate, 10 %"),
    "geometry.rim_thickness": (0.38e-3, 0.47e-3, "scaled estimate, 10 %"),
    "geometry.cup_length": (17e-3, 26.7e-3, "between the short and the long cup"),
    "geometry.bottom_thickness": (0.4e-3, 0.6e-3, "estimate, 20 %"),
    "geometry.ring_thickness": (0.8e-3, 1.2e-3, "estimate, 20 %"),
    "material.flexspline_e": (205e9, 213e9, "2 %"),
    "material.ring_e": (190e9, 219e9, "52100 steel in sources, and the paper"),
}
OF_ASPERITIES = ["joint.asperity_radius", "joint.s_min"]   # which the law hu2023 alone has
OF_SECTIONS = [f"geometry.{name}" for name in ("bore_radius", "wall_thickness", "rim_thickness", "cup_length", "bottom_thickness")]
SEED = 1   # of all draws
SOLVED = {"tangent": ("k_ts_bonded_nm_per_rad", "tangent K_TS"), "k2": ("k2_nm_per_rad", "K2")}   # columns of a study of the drive


def _values(scene):
    """Keys of a scene; those whose 0 stands for what others make of it have that."""
    return {**scene, "joint.s_min": scene["joint.s_min"] or np.pi * scene["joint.shortest_wavelength"]**2 / 4,
            "joint.hardness": scene["joint.hardness"] or 2.8 * scene["material.yield_strength"]}


def ranges_of(scene: Mapping, ranges: Mapping) -> dict:
    """Ranges of JOINT or DRIVE, which are those of CD-14, about the values of a scene.

    D moves with the scene's, what is of its size or its surface is in proportion to it; friction, eccentricity and moduli stay. A
    clearance takes the place of the interference, as far about its value as bore and bearing have in the mean. What cup.sections
    settle has no range, nor has what the law of the joint does not read.

    Parameters
    ----------
    scene : dict
        'group.key' to value.
    ranges : dict

    Returns
    -------
    dict
        key: (low, high, why); without those of no width.
    """
    own, known, found = _values(scene), _values(read_scene()), {}
    for key, (low, high, why) in ranges.items():
        if key == "joint.fractal_dimension":
            low, high = np.clip(np.array([low, high]) + (own[key] - known[key]), 2.001, 2.999).tolist()
        elif key == "wave_generator.interference" and own["wave_generator.clearance"] > 0:
            gap, mean = own["wave_generator.clearance"], _engine.call("fit_clearance", own["geometry.bore_radius"])
            key, low, high, why = "wave_generator.clearance", max(0.0, gap - mean), gap + mean, "ISO 286 H7, ISO 492"
        elif key.startswith(("joint.", "geometry.", "wave_generator.w", "wave_generator.interference")):
            low, high = (end * (own[key] / known[key]) for end in (low, high))
        found[key] = low, high, why
    settled = OF_SECTIONS * any(own["cup.sections_r"]) + OF_ASPERITIES * (own["joint.model"] != "hu2023")
    return {key: ends for key, ends in found.items() if ends[0] < ends[1] and key not in settled}


class ContactField:
    """Pressure and shear of one load step; K_TS for other joints without solving the contact again.

    To 0.1 % for the keys of &joint: where contact ends, points keep the means of the run's joint. Others need a new run.

    Parameters
    ----------
    result : Result
    step : int
        Row of steps.csv; default: the last.
    """

    @checked(result=RUN, step=integer(-2**31))
    def __init__(self, result: Result, step: int = -1) -> None:
        self.scene = dict(result.scene)
        self._summary = result.summary
        self._facets = c = dict(result.contact_at(step))
        self._place = np.stack([c["x_m"], c["y_m"], c["z_m"]], -1), np.stack([c["bent_n_x"], c["bent_n_y"], c["bent_n_z"]], -1)
        self.torque_nm = float(result.torque_nm[step])
        self._friction = float(result.steps["friction"][step])

    def __repr__(self) -> str:
        return f"ContactField: {len(self._facets['area_m2'])} facets at {self.torque_nm:g} N m"

    def k_ts(self, **keys: Value) -> float:
        """K_TS [N m/rad] with some keys changed ('group.key' or group__key)."""
        scene = {**self.scene, **{k.replace("__", ".", 1): v for k, v in keys.items()}}
        changed = "contact.friction" in {k.replace("__", ".", 1) for k in keys}
        check_inputs(self._summary)
        joint = joint_of_scene(scene, None if changed else self._friction)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            k_n, k_t = facet_stiffness(self._facets, joint)
            return float(torsion.torsional_stiffness(k_n, k_t, *self._place))


def joint_tornado(field: ContactField) -> dict:
    """K_TS at both ends of each input of the joint, the others at the scene's values.

    Returns
    -------
    dict
        key: (at low, at high) [N m/rad], the widest first.
    """
    ranges = ranges_of(field.scene, JOINT)
    ends = {key: (field.k_ts(**{key: low}), field.k_ts(**{key: high})) for key, (low, high, _) in ranges.items()}
    return dict(sorted(ends.items(), key=lambda item: -abs(item[1][1] - item[1][0])))


def _band(values):
    """Low end, median and high end of 95 % of some values."""
    return tuple(float(v) for v in np.quantile(values, [0.025, 0.5, 0.975]))


def _point(ranges, unit):
    """Keys at a point of the unit cube."""
    point = {}
    for (key, (low, high, _)), u in zip(ranges.items(), unit):
        point[key] = float(low * (high / low)**u) if low > 0 and high > 2 * low else float(low + (high - low) * u)
    return point


def joint_indices(field: ContactField, ranges: dict, base: int, progress: Progress | None = None) -> dict:
    """First-order and total variance-based indices of K_TS (Sobol; needs SALib: pip install 'hdengine[sensitivity]').

    Parameters
    ----------
    field : ContactField
    ranges : dict
    base : int
        Power of 2; base (n + 2) evaluations.
    progress : Progress, optional
        Ten steps of it.

    Returns
    -------
    dict
        key: (first order, its 95 % half width, total, its half width).

    Raises
    ------
    InputError
        SALib is not installed.
    """
    try:
        from SALib.analyze import sobol as analysis
        from SALib.sample import sobol as sampling
    except ImportError:
        raise InputError("variance-based indices need SALib: pip install 'hdengine[sensitivity]'") from None
    problem = {"num_vars": len(ranges), "names": list(ranges), "bounds": [[0, 1]] * len(ranges)}
    points = sampling.sample(problem, base, calc_second_order=False, seed=SEED)
    y = np.array([field.k_ts(**_point(ranges, u)) for u in _counted(points, progress, "indices")])
    s = analysis.analyze(problem, y, calc_second_order=False, seed=SEED)
    return {key: tuple(float(s[name][i]) for name in ("S1", "S1_conf", "ST", "ST_conf")) for i, key in enumerate(ranges)}


def _places(low, high):
    """Places of a range that are solved: five of numbers, both ends of names."""
    return [low, high] if isinstance(low, str) else np.linspace(low, high, 5).tolist()


def one_at_a_time(scene: PathLike, ranges: dict, fixed: dict | None = None) -> Study:
    """Study with the scene itself and five places of each range: point 0, then those of each key that differ from the scene.

    Parameters
    ----------
    scene : str or Path
        Namelist.
    ranges : dict
    fixed : dict
        Keys that differ from the scene at every point.
    """
    base = read_scene(scene, **(fixed or {}))
    points = [{key: base[key] for key in ranges}]
    for key, (low, high, _) in ranges.items():
        points += [{**points[0], key: value} for value in _places(low, high) if not alike(value, base[key])]
    columns = {key: [point[key] for point in points] for key in ranges}
    return Study(scene, together=columns, fixed=fixed or {}, rows="last", title="One at a time")


def _solved(result, key, column):
    """Value of the scene, and values by place of a key; NaN where a point failed."""
    rows = {row["point"]: row for row in result.rows}
    value = {point: row.get(column, np.nan) if row["status"] == "done" else np.nan for point, row in rows.items()}
    return value[0], {row[key]: value[point] for point, row in rows.items() if point == 0 or row[key] != rows[0][key]}


def drive_tornado(result: StudyResult, ranges: Mapping, column: str = "k_ts_nm_per_rad") -> tuple:
    """Ends of each range of the study of `one_at_a_time`.

    Returns
    -------
    base : float
    ends : dict
        key: (at low, at high); NaN where a point failed; the widest first.
    """
    base, ends = np.nan, {}
    for key, (low, high, _) in ranges.items():
        base, found = _solved(result, key, column)
        first, last = (next((y for x, y in found.items() if alike(x, end)), np.nan) for end in (low, high))
        ends[key] = first, last
    return base, dict(sorted(ends.items(), key=lambda item: -abs(np.subtract(*item[1]))))


def drive_curves(result: StudyResult, ranges: Mapping, column: str = "k_ts_nm_per_rad") -> dict:
    """K_TS over each input from the study of `one_at_a_time`, relative to that of the scene.

    Parameters
    ----------
    result : StudyResult
    ranges : dict
        Of the study.
    column : str

    Returns
    -------
    dict
        key: (places, factors), places rising, without those that failed. Names stand at -1.96 (low), 0 (scene) and
        1.96 (high).
    """
    curves = {}
    for key, (low, high, _) in ranges.items():
        base, found = _solved(result, key, column)
        points = {({low: -1.96, high: 1.96}.get(x, 0.0) if isinstance(x, str) else x): y / base for x, y in found.items()}
        places = sorted(x for x, y in points.items() if np.isfinite(y))
        curves[key] = places, [points[x] for x in places]
    return curves


def _follow(curve, at):
    """Monotone cubic through the points of a curve (Fritsch and Butland 1984), level beyond its ends."""
    x, y = np.asarray(curve[0], float), np.asarray(curve[1], float)
    if len(x) < 3:
        return np.interp(at, x, y) if len(x) else np.ones_like(at)
    h, slope = np.diff(x), np.diff(y) / np.diff(x)
    turns = slope[:-1] * slope[1:] <= 0
    weight = (2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1])
    safe = [np.where(turns, 1.0, part) for part in (slope[:-1], slope[1:])]
    inner = np.where(turns, 0.0, sum(weight) / (weight[0] / safe[0] + weight[1] / safe[1]))
    ends = []
    for h0, h1, s0, s1 in ((h[0], h[1], slope[0], slope[1]), (h[-1], h[-2], slope[-1], slope[-2])):
        end = ((2 * h0 + h1) * s0 - h0 * s1) / (h0 + h1)
        end = 0.0 if end * s0 <= 0 else end
        ends.append(3 * s0 if s0 * s1 < 0 and abs(end) > 3 * abs(s0) else end)
    d = np.r_[ends[0], inner, ends[1]]
    at = np.clip(at, x[0], x[-1])
    i = np.clip(np.searchsorted(x, at) - 1, 0, len(h) - 1)
    t = (at - x[i]) / h[i]
    return y[i] + t * h[i] * (d[i] + t * (3 * slope[i] - 2 * d[i] - d[i + 1] + t * (d[i] + d[i + 1] - 2 * slope[i])))


GROUPS = {  # of bands: keys of JOINT, beginnings of keys of DRIVE
    "D and G": (("joint.fractal_dimension", "joint.roughness"), ()),
    "joint": (tuple(JOINT), ()),
    "geometry": ((), ("geometry.", "wave_generator.")),
    "material and friction": (("joint.hardness",), ("material.", "contact.")),
    "all": (tuple(JOINT), ("geometry.", "wave_generator.", "material.", "contact.")),
}


def _counted(items, progress, label):
    """The items; after each tenth of them one step of the progress."""
    for i, item in enumerate(items, 1):
        yield item
        for _ in range(10 * i // len(items) - 10 * (i - 1) // len(items) if progress else 0):
            progress.step(label)


def bands(field: ContactField, curves: Mapping | None = None, draws: int = 500, ranges: Mapping | None = None,
          progress: Progress | None = None) -> dict:
    """95 % bands of K_TS when groups of inputs scatter over their ranges.

    Keys of the joint are evaluated on the contact field. Keys of the drive act as factors along their curves: what two of them do
    together is their product. This was checked on a cup that is held; it does not hold for a whole drive (`analyse`).

    Parameters
    ----------
    field : ContactField
    curves : dict, optional
        Of `drive_curves`; without them only groups of the joint are given.
    ranges : dict, optional
        Of joint and drive; default those of the scene.
    progress : Progress, optional
        Ten steps of it a group.

    Returns
    -------
    dict
        group: (low, median, high) [N m/rad].
    """
    ranges, found = ranges_of(field.scene, JOINT | DRIVE) if ranges is None else ranges, {}
    for name, (joint, drive) in GROUPS.items():
        keys = [k for k in curves or {} if k.startswith(drive)] if drive else []
        if drive and not keys:
            continue
        generator, values = np.random.default_rng(SEED), []
        chosen = {k: ranges[k] for k in joint if k in ranges}
        for _ in _counted(range(draws), progress, name):
            value = field.k_ts(**_point(chosen, generator.random(len(chosen))))
            for key in keys:
                low, high = ranges[key][:2]
                value *= float(_follow((curves or {})[key], low + (high - low) * generator.random()))
            values.append(value)
        found[name] = _band(values)
    return found


DRIVE_GROUPS = {"joint": ("joint.",), "friction": ("contact.friction",), "geometry": ("geometry.", "wave_generator."),
                "Young's moduli": ("material.",), "all": ("",)}


def table_ranges(scene: dict, folder: PathLike) -> dict:
    """Range of a joint's table from its own band: its low and its high columns as two tables in a folder.

    Parameters
    ----------
    scene : dict
        'group.key' to value.
    folder : path-like

    Returns
    -------
    dict
        joint.table_file: (low, high, why); empty where the joint is no table or has no band.
    """
    path = scene.get("joint.table_file", "")
    if scene.get("joint.model") not in ("table", "boundary_elements") or not Path(path).is_file():
        return {}
    table = np.genfromtxt(path, delimiter=",", names=True)
    names = table.dtype.names or ()
    if "k_n_pa_per_m_low" not in names:
        return {}
    with writing(folder):
        Path(folder).mkdir(parents=True, exist_ok=True)
    ends = []
    for side in ("low", "high"):
        factor = table[f"k_n_pa_per_m_{side}"] / table["k_n_pa_per_m"]
        k_t = table["k_t_pa_per_m"] if "k_t_pa_per_m" in names else None
        columns = {"pressure_pa": table["pressure_pa"], "k_n_pa_per_m": table["k_n_pa_per_m"] * factor}
        columns |= {} if k_t is None else {"k_t_pa_per_m": k_t * factor}
        end = Path(folder).resolve() / f"joint_{side}.csv"
        text = io.StringIO()
        np.savetxt(text, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
        write_files({end: text.getvalue()})
        ends.append(str(end))
    return {"joint.table_file": (*ends, "95 % band of its table")}


def drive_factors(curves: dict, ranges: dict, draws: int = 4000) -> dict:
    """Factors on K_TS of every input, drawn over its range.

    A number is drawn evenly over its range and acts along its curve, a monotone cubic. The band of a table is drawn as a normal
    error whose 95 % are its ends.

    Parameters
    ----------
    curves : dict
        Of `drive_curves`. Beyond a place that failed a curve is level; a key of which no place but the scene's was solved has none.
    ranges : dict
        Of the same keys.

    Returns
    -------
    dict of ndarray
    """
    generator, found = np.random.default_rng(SEED), {}
    for key, curve in curves.items():
        if len(curve[0]) < 2:
            continue
        low, high = ranges[key][:2]
        at = generator.standard_normal(draws) if isinstance(low, str) else low + (high - low) * generator.random(draws)
        found[key] = np.maximum(_follow(curve, at), 1e-9)
    return found


def drive_bands(factors: dict, base: float) -> tuple[dict, dict]:
    """95 % bands of K_TS by group of inputs, and each input's share of the variance of ln K_TS.

    As if inputs were factors, so that shares of first order are the total ones. In a whole drive they are not (`analyse`).

    Returns
    -------
    bands : dict
        group: (low, median, high) [N m/rad].
    shares : dict
        key: share, the largest first.
    """
    bands = {}
    for name, starts in DRIVE_GROUPS.items():
        use = [v for key, v in factors.items() if key.startswith(starts)]
        if use:
            bands[name] = _band(base * np.prod(use, axis=0))
    variances = {key: float(np.var(np.log(v))) for key, v in factors.items()}
    total = sum(variances.values()) or 1.0
    return bands, {key: v / total for key, v in sorted(variances.items(), key=lambda item: -item[1])}


@checked(folder=a_path, drive=flag, draws=integer(1), sobol=integer(0), show=flag, force=flag)
def analyse(folder: PathLike, drive: bool = False, draws: int = 500, sobol: int = 128, show: bool = True,
            force: bool = False) -> dict:
    """Tornado, bands and indices of a finished run, into its folder.

    Inputs of a whole drive are no factors: of 200 drives of size 14 drawn over the ranges 95 % had a tangent of 20 to 42 kN m/rad,
    the product of factors said 26 to 48. It gets shares of inputs one at a time, and no band of them.

    Parameters
    ----------
    folder : str or Path
        Of the run.
    drive : bool
        Also solve the contact anew at five places of each range of DRIVE (kept in drive.out, and taken from there later).
    draws : int
        Of the bands.
    sobol : int
        Base of the indices, a power of 2; 0: none. Left out where SALib is missing.
    show : bool
        Progress on stderr.
    force : bool
        Solve what `drive` keeps anew, as where the run was replaced.

    Returns
    -------
    dict
        What sensitivity.json holds. Figures: tornado_joint.png, but of a table; of the drive tornado_drive.png (Eq. 45) and
        tornado_tangent.png, of a whole drive tornado_k2.png.
    """
    from .figures.sensitivity import plot_tornado
    from .results import Result
    from .views.run import reference_step

    result = Result(folder)
    check_file(result.folder / "sensitivity.json", force=True)
    field = ContactField(result, reference_step(result))
    if not field.k_ts() > 0:
        raise InputError(f"K_TS of '{folder}' by Eq. 45 is {field.k_ts():g}: nothing to vary; valid: above 0. "
                         "Take joint.model='spectrum', or a load under which the faces touch")
    figures: dict = {}
    notes: list[str] = []
    found: dict[str, Any]
    whole = _engine.supported(result.scene, "loop")
    curves, found = None, {"run": result.summary["checksum"], "torque_nm": field.torque_nm, "k_ts_nm_per_rad": field.k_ts(),
                           "joint": {}}
    table = result.scene["joint.model"] in ("table", "boundary_elements")   # no key of the joint moves it
    of_joint = ranges_of(result.scene, JOINT)
    ranges: dict = ranges_of(result.scene, DRIVE)
    if not table:
        found["joint"] = joint_tornado(field)
        figures["tornado_joint.png"] = plot_tornado(field.k_ts(), found["joint"], of_joint, "Joint, contact field kept")
    if drive or (result.folder / "drive.out/study.json").is_file():
        ranges |= table_ranges(result.scene, result.folder / "tables")
        scene = echo_of(result.folder, result.summary)
        study = one_at_a_time(scene, ranges).run(result.folder / "drive.out", force=force, show=show)
        base, every = drive_tornado(study, ranges)
        curves = None if whole else {k: curve for k, curve in drive_curves(study, ranges).items() if k != "joint.table_file"}
        figures["tornado_drive.png"] = plot_tornado(base, every, ranges, "Drive, contact solved anew, Eq. 45")
        found |= {"drive_base_nm_per_rad": base, "drive": every, "drive_failed": len(study.failures)}
        for name, (column, words) in SOLVED.items():
            middle, ends = drive_tornado(study, ranges, column)
            if not middle > 0:
                continue
            figures[f"tornado_{name}.png"] = plot_tornado(middle, ends, ranges, f"{words}, contact solved anew", words)
            bands_of, shares = drive_bands(drive_factors(drive_curves(study, ranges, column), ranges), middle)
            found[name] = {"base_nm_per_rad": middle, "drive": ends, "bands_95_nm_per_rad": {} if whole else bands_of,
                           "shares_of_variance": shares}
    groups = [name for name, (_, of_drive) in GROUPS.items() if curves or not of_drive]
    indexed = sobol > 0 and not table and find_spec("SALib") is not None
    progress = Progress(10 * (len(groups) + indexed), show=show)
    found["bands_95_nm_per_rad"] = {name: band for name, band in bands(
        field, curves, draws, of_joint | ranges, progress).items()
                                    if band[0] < band[2]}
    try:
        found["indices"] = joint_indices(field, of_joint, sobol, progress) if sobol and not table else {}
    except InputError as why:
        found["indices"], notes = {}, [str(why)]
    if table:
        notes.append("the joint is a table: its own band counts, with --drive, and no key of &joint")
    if "drive" in found and whole:
        notes.append("no band of geometry, material, friction: no factors in a whole drive; take run.band, run.tolerances")
    if not all(min(ends) > 0 for ends in (*found["joint"].values(), *found["bands_95_nm_per_rad"].values())):
        notes.append("K_TS of 0: there joint.s_min is fully plastic and no spot has stiffness; a run refuses such keys")
    if notes:
        found["note"] = "; ".join(notes)
    found["figures"] = sorted(figures)
    write_files({result.folder / name: content for name, content in (*figures.items(), ("sensitivity.json", json_text(found)))})
    return found
