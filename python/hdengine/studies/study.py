# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: one scene at many points, results in one table."""
from __future__ import annotations

import csv
import difflib
import functools
import hashlib
import io
import itertools
import json
import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import _engine, torsion
from .._check import MOST_BYTES, alike, checked, fields, flag, input_file, integer, mapping, number, package, text
from .._check import folder as a_folder
from .._check import path as a_path
from .._engine import FileError, FolderLock, HdengineError, InputError
from .._types import PathLike, Value
from ..contact import read_scene
from ..files import check_folder, json_text, read_json, write_files, writing
from ..results import preformatted
from ..views.labels import LOOP, SHOWN
from .progress import Progress

__all__ = ["Study", "StudyResult"]
ROWS = ("torque", "last", "all")
FIGURES = ("series", "catalogue")
FILES = ("study.csv", "study.json", "study.png")
NO_TEXTS: dict[str, tuple[Any, str]] = {"torque": ((int, float), "numbers"), "relative": (object, "")}   # of a figure
MOST_POINTS = 10**6
CLEARANCE = "load.tooth_clearance"
# keys in which a cup against its teeth differs from its contact, which does not feel the others
OF_TEETH = ("load.support", "contact.mode", "wave_generator.ring_tangent", CLEARANCE, "load.tooth_gaps", "load.tooth_gaps_back",
            "load.tooth_stiffness")
TABLES = ("joint.table_file", "joint.spectrum_file", "joint.from_fit", "wave_generator.cam_file")   # keys that name files
WRITES_APART = 20   # from one writing of the table to the next, in durations of a writing: a long table costs a twentieth of all


def _plain(key):
    """A key as scenes have it; group__key stands for 'group.key'."""
    return key.replace("__", ".", 1).strip().lower() if isinstance(key, str) else key


@dataclass
class Study:
    """A scene and the points at which it is solved.

    Parameters
    ----------
    scene : str or Path
        Namelist of the scene; '' for the default scene.
    grid : dict
        'group.key' to a list of values; every combination is a point, the last key changes fastest.
    together : dict
        'group.key' to lists of one length that change side by side: one more axis, the slowest.
    fixed : dict
        'group.key' to a value that differs from the scene at every point.
    rows : str
        Load steps in the table: 'torque' (end of the assembly and torque steps), 'last', 'all'.
    title : str
    figure : dict
        x, y (list), lines: columns; torque (list) [N m]: those only; relative: change against the first x in per cent;
        panels (list): swept keys, one panel of the first y for each combination of their values.
        kind = 'series': K_TS and K_FTS in series (Eq. 46) over the torque, from points without and with support 'teeth';
        'catalogue': K_FTS over the size (bore radius) beside K1, K2, K3 of the catalogue.

    Examples
    --------
    >>> study = Study(grid={"wave_generator.w": [0.19e-3, 0.20e-3]}, fixed={"mesh.divisions": 16, "mesh.band_facets": 3})
    >>> len(study.points)
    2
    """

    scene: PathLike = ""
    grid: dict = field(default_factory=dict)
    together: dict = field(default_factory=dict)
    fixed: dict = field(default_factory=dict)
    rows: str = "torque"
    title: str = ""
    figure: dict = field(default_factory=dict)

    def __post_init__(self) -> None:
        fields(self, scene=a_path, grid=mapping, together=mapping, fixed=mapping, rows=text, title=text, figure=mapping)
        for name, keys in (("grid", self.grid), ("together", self.together), ("fixed", self.fixed)):
            setattr(self, name, {_plain(k): v for k, v in keys.items()})
            if len(getattr(self, name)) < len(keys):
                raise InputError(f"[{name}] has a key twice: {', '.join(keys)}")
        for name, keys in (("grid", self.grid), ("together", self.together)):
            for key, values in keys.items():
                if isinstance(values, (np.ndarray, range)):
                    keys[key] = values = list(values.tolist() if isinstance(values, np.ndarray) else values)
                if not isinstance(values, (list, tuple)):
                    raise InputError(f"'{key}' in {name} = {values!r}: must be a list of values")
                keys[key] = [self._in_si(key, v) for v in values]
        if self.rows not in ROWS:
            raise InputError(f"study.rows has no choice '{self.rows}'; valid: {', '.join(ROWS)}")
        lengths = {key: len(v) for key, v in self.together.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"lists in [together] differ in length: {lengths}")
        for name, keys in (("grid", self.grid), ("together", self.together)):
            for key, values in keys.items():
                if len(values) == 0:
                    raise InputError(f"'{key}' in [{name}] has no value")
                if key in self.fixed or (name == "grid" and key in self.together):
                    raise InputError(f"'{key}' stands in two groups of the study")
        self._check_figure()
        count = math.prod(len(v) for v in self.grid.values()) * max([1, *lengths.values()])
        if count > MOST_POINTS:
            raise InputError(f"the study has {count} points; valid: up to {MOST_POINTS}")

    def _check_figure(self):
        """Refuse what no table can be drawn by."""
        swept = (*self.together, *self.grid)
        columns = (*swept, *self._columns()) if self.figure.keys() & {"x", "y", "lines"} else swept
        for name, value in self.figure.items():
            of, what = NO_TEXTS.get(name, (str, "text"))
            for v in value if isinstance(value, (list, tuple)) and name in ("y", "torque", "panels") else [value]:
                if not isinstance(v, of):
                    raise InputError(f"figure.{name} = {value!r}: must be {what}")
                choices = {"kind": FIGURES, "panels": swept, "torque": (v,), "relative": (v,)}.get(name) or columns
                if v not in choices:
                    near = " or ".join(difflib.get_close_matches(v, choices, 2))
                    raise InputError(f"figure.{name} = '{v}': {f'did you mean {near}? It ' if near else ''}must be one of "
                                     f"{', '.join(choices) or 'the swept keys'}")

    def _columns(self):
        """Columns that the table can have besides the swept keys; those of a loop only if a point may be a whole drive."""
        names = [name for name in _engine.names("step") if name not in ("iterations", "seconds")]
        places = [f"{what}_long_{i}_pa" for i in (1, 2, 3) for what in ("pressure", "shear")]
        swept = self.grid | self.together
        try:
            of = swept.get("load.support") or [read_scene(self.scene, **self.fixed)["load.support"]]
            loop = any(str(support) in _engine.names("support_loop") for support in of)
        except HdengineError:   # it is reported for its point
            loop = True
        return ("point", "status", *names, "k_ts_normal_nm_per_rad", *places, *(LOOP if loop else ()))

    def _in_si(self, key, value):
        """A number with its unit as the number that the engine takes it for; all else as it is."""
        if not isinstance(value, str) or not any(c.isdigit() for c in value):
            return value
        try:
            found = read_scene(self.scene, **{**self.fixed, key: value})[key]
        except HdengineError:   # it is reported for its point
            return value
        return found if isinstance(found, (int, float)) else value

    @classmethod
    @checked(path=a_path)
    def read(cls, path: PathLike) -> Study:
        """Study of a file (TOML); the scene's path is relative to it, and those of tables that are not found from here.

        Raises
        ------
        InputError, FileError
            With file and line, or with the valid names.
        """
        from . import study_file

        groups = study_file.read(path)
        if not groups:
            raise InputError(f"'{path}' holds no study: it has none of the tables [{'], ['.join(study_file.GROUPS)}]")
        folder = Path(path).parent
        for values in (groups.get(group, {}) for group in ("grid", "together", "fixed")):
            for key in values.keys() & set(TABLES):
                values[key] = [_found(folder, v) for v in values[key]]
        head = {key: v[0] for key, v in groups.get("study", {}).items()}
        figure = {key: v if key in ("y", "torque", "panels") else v[0] for key, v in groups.get("figure", {}).items()}
        scene = str(folder / head["scene"]) if head.get("scene") else ""
        fixed = {key: v[0] if len(v) == 1 else v for key, v in groups.get("fixed", {}).items()}
        try:
            return cls(scene, groups.get("grid", {}), groups.get("together", {}), fixed, head.get("rows", "torque"),
                       head.get("title", Path(path).stem), figure)
        except InputError as error:
            raise InputError(f"{error}\n  --> {path}{study_file.line_of(path, str(error))}") from None

    @property
    def points(self) -> list:
        """Keys and values of every point, a list of dict."""
        side = [dict(zip(self.together, values)) for values in zip(*self.together.values())] or [{}]
        return [{**s, **dict(zip(self.grid, values))} for s in side for values in itertools.product(*self.grid.values())]

    def __str__(self) -> str:
        keys = ", ".join([*self.together, *self.grid]) or "the torque alone"
        scene = self.scene or "the default"
        return f"Study {self.title!r}: {len(self.points)} points over {keys}; scene {scene}, rows {self.rows!r}"

    def identity(self) -> dict[str, Any]:
        """What a table must have been made from to be continued."""
        text = input_file(self.scene, MOST_BYTES).read_bytes() if self.scene else b""
        identity = {"scene_sha256": hashlib.sha256(text).hexdigest(), "grid": list(self.grid.items()),
                    "together": list(self.together.items()), "fixed": self.fixed, "rows": self.rows}
        given = [*self.grid.items(), *self.together.items(), *((key, [value]) for key, value in self.fixed.items())]
        first = self.first_valid()[1]
        names = {str(v) for key, values in given if key in TABLES for v in values}
        names |= {str(first[key]) for key in TABLES if first.get(key)}
        if files := sorted(name for name in names if Path(name).is_file()):
            identity["tables_sha256"] = {name: hashlib.sha256(Path(name).read_bytes()).hexdigest() for name in files}
        return json.loads(json_text(identity))

    def check(self) -> dict:
        """Let the engine read the scene of every point.

        Returns
        -------
        dict
            Keys of the first valid point.

        Raises
        ------
        InputError
            No point is valid: the message of the first.
        """
        return self.first_valid()[1]

    def first_valid(self) -> tuple[dict, dict]:
        """The first valid point, and all keys of its scene.

        Raises
        ------
        InputError
            No point is valid: the message of the first.
        """
        first: Exception = InputError("the study has no point")
        for i, point in enumerate(self.points):
            try:
                return point, read_scene(self.scene, **{**self.fixed, **point})
            except HdengineError as error:
                if i == 0:
                    first = error
        raise first

    @checked(out=a_folder, jobs=integer(1, 4096), force=flag, retry=flag, show=flag, other_version=flag)
    def run(self, out: PathLike, jobs: int = 1, force: bool = False, retry: bool = False,
            show: bool = True, other_version: bool = False) -> StudyResult:
        """Solve all points that the table in `out` does not hold yet.

        Parameters
        ----------
        out : str or Path
            Folder for study.csv and study.json; an unfinished study in it is continued.
        jobs : int
            Worker processes with one thread each; 1: in this process. A script that asks for more needs no main guard.
        force : bool
            Start again, also where the folder holds another study.
        retry : bool
            Solve failed points again.
        show : bool
            Progress on stderr, in a notebook as a bar.
        other_version : bool
            Keep rows that another version of hdengine solved.

        Returns
        -------
        StudyResult

        Raises
        ------
        InputError
            No point is valid. Failing points raise nothing: their reason is in the table.
        FileError
            The folder holds another study, rows of another version, or tables that are not as a study left them; or another
            process is at work in it.
        StoppedError
            Worker processes were stopped from outside; their points are left to do, all others are in the table.
        """
        from .workers import solve_all  # multiprocessing, which takes a tenth of the time of import hdengine

        out = Path(out)
        scene = self.check()
        identity = self.identity()
        with writing(out):
            out.absolute().parent.mkdir(parents=True, exist_ok=True)
        with FolderLock(out):
            check_free(out, force)
            rows, versions = ({}, []) if force else self._earlier(out, identity, retry, other_version)
            versions = [v for v in versions if v != _engine.version()] + [_engine.version()]
            points = self.points
            todo = [i for i in range(len(points)) if i not in rows]
            progress = Progress(len(points), len(points) - len(todo), show)
            self._write(out, identity, scene, rows, versions)
            tasks = [(i, self.scene, {**self.fixed, **points[i]}, self.rows) for i in todo]
            due = 0.0
            try:
                for i, result in solve_all(tasks, jobs):
                    rows[i] = result
                    start = time.monotonic()
                    if start >= due:
                        self._write(out, identity, scene, rows, versions)
                        due = time.monotonic() + WRITES_APART * (time.monotonic() - start)
                    changed = [f"{k} = {v:.6g}" if isinstance(v, float) else f"{k} = {v}"
                               for k, v in points[i].items() if v != points[0][k]]
                    more = [f"and {len(changed) - 3} more"] if len(changed) > 3 else []
                    progress.step(", ".join(changed[:3] + more) or "first point", result[-1]["status"] == "failed")
            finally:
                self._write(out, identity, scene, rows, versions)
            return StudyResult(out)

    def _earlier(self, out: Path, identity: dict, retry: bool = False, other_version: bool = False) -> tuple[dict, list]:
        """Rows of finished points in an earlier table of the same study, by point, and the versions that solved them."""
        if not (summary := self._described(out, identity, other_version)):
            return {}, []
        rows: dict[int, list] = {}
        for row in read_rows(out / "study.csv"):
            rows.setdefault(row["point"], []).append(row)
        return {i: r for i, r in rows.items() if not (retry and r[-1]["status"] == "failed")}, summary["versions"]

    def _described(self, out, identity, other_version=False):
        """Description of an earlier table of the same study; empty where there is none."""
        if not (out / "study.json").is_file():
            return {}
        summary = read_study_summary(out)
        if "checksum" not in summary:
            raise FileError(f"'{out}/study.json' is of an earlier hdengine: add --force to solve all points anew")
        if summary["identity"] != identity:
            raise FileError(f"'{out}' holds another study: add --force to replace it, or choose another folder")
        if summary["hdengine"] != _engine.version() and not other_version:
            raise FileError(f"'{out}' holds rows of hdengine {summary['hdengine']}, this is {_engine.version()}: add --force to "
                            "solve all points anew, or --other-version to keep those rows")
        return summary

    def _write(self, out: Path, identity: dict, scene: dict, rows: Mapping[int, list], versions: list,
               heads: dict | None = None, kept: list | None = None) -> None:
        """Table and its description, each under a temporary name first; the description holds checksums of both.

        `heads` is what `head_of` finds for each point, where that is known before; `kept` gets the rows that a figure needs.
        """
        points, places = self.points, sorted(rows)
        heads = heads or {i: head_of(rows[i]) for i in places}
        names, failed = dict.fromkeys(["point", *self.together, *self.grid]), sum(bad for _, bad in heads.values())
        for i in places:   # the order of the columns is that of the points, whoever solved them first
            names |= dict.fromkeys(heads[i][0])
        columns, digest = sorted(names, key=lambda name: name == "reason"), hashlib.sha256()
        shown = columns_of({"figure": self.figure, "swept": [*self.together, *self.grid]})
        shown = columns if shown is None else [k for k in columns if k in shown]

        def table():
            """Bytes of the table, point by point."""
            for i in [-1, *places]:
                own = {"point": str(i), **{k: str(v) for k, v in points[i].items()}}
                whole = [{**row, **own} for row in rows[i]] if i >= 0 else [dict(zip(columns, columns))]
                lines = (_csv_line([*map(row.get, columns, itertools.repeat(""))]) for row in whole)
                data = "".join(lines).encode("utf-8", "replace")
                if kept is not None and i >= 0:
                    kept.extend({k: _number(str(row[k])) for k in shown if k in row} for row in whole)
                digest.update(data)
                yield data

        def description():
            summary = {"kind": "study", "status": "complete" if len(rows) == len(points) else "unfinished", "title": self.title,
                       "hdengine": _engine.version(), "versions": versions, "points": len(points), "done": len(rows),
                       "failed": failed, "swept": [*self.together, *self.grid], "figure": self.figure, "identity": identity,
                       "scene": scene, "table_sha256": digest.hexdigest()}
            summary = json.loads(json_text(summary))
            yield json_text(summary | {"checksum": _checksum(summary)}).encode()
        write_files({out / "study.csv": table(), out / "study.json": description()})


def check_free(out: Path, force: bool = False) -> None:
    """Raise FileError where a folder holds what another command wrote, or, without `force`, files of a study and no study."""
    begun = any((out / name).exists() for name in ("study.json", "study.json.part"))
    check_folder(out, FILES, force or begun)


def columns_of(summary: dict) -> list | None:
    """Columns of the table that its figure is drawn from; None: all."""
    figure = summary["figure"]
    if figure.get("kind") in FIGURES:
        return None
    ys = figure.get("y") or [*LOOP[:4], "k_ts_bonded_nm_per_rad", "k_ts_nm_per_rad", *SHOWN]
    return ["point", "status", "reason", "torque_nm", *summary["swept"], *(figure[k] for k in ("x", "lines") if k in figure),
            *(y + end for y in ([ys] if isinstance(ys, str) else ys) for end in ("", "_low", "_high"))]


def head_of(rows: list) -> tuple:
    """Names in the rows of a point, and whether it failed."""
    return tuple(dict.fromkeys(itertools.chain(*rows))), rows[-1]["status"] == "failed"


def _csv_line(cells):
    """A line as csv.writer writes it, which takes longer: it is asked for numbers that are no text yet and for quotes."""
    try:
        line = ",".join(cells)
        if line.count(",") == len(cells) - 1 and '"' not in line and "\n" not in line and "\r" not in line:
            return line + "\r\n"
    except TypeError:
        pass
    text = io.StringIO(newline="")
    csv.writer(text).writerow(cells)
    return text.getvalue()


def _checksum(summary):
    """SHA-256 of all that a description holds but this."""
    rest = {k: v for k, v in summary.items() if k != "checksum"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def _found(folder, name):
    """The name of a table, from here or in a folder."""
    beside = os.path.join(folder, str(name))
    return beside if name and os.path.exists(beside) and not os.path.exists(str(name)) else name


def read_study_summary(folder: PathLike) -> dict[str, Any]:
    """Description of a study whose table is as the study left it.

    A study that was killed between the two files left the new description under its temporary name.

    Parameters
    ----------
    folder : str or Path

    Returns
    -------
    dict

    Raises
    ------
    FileError
        There is no study, or its files were changed or cut.
    """
    folder = Path(folder)
    if not (folder / "study.json").is_file():
        raise FileError(f"'{folder}' holds no study: study.json is missing")
    digest = hashlib.sha256()
    with open(input_file(folder / "study.csv"), "rb") as file:
        while part := file.read(2**20):
            digest.update(part)
    table = digest.hexdigest()
    cause = "study.json"
    for name in ("study.json", "study.json.part"):
        try:
            summary = read_json(folder / name)
            if summary.get("checksum", _checksum(summary)) == _checksum(summary):
                if summary.get("table_sha256", table) == table:
                    return summary
                cause = "study.csv"
        except FileError:
            pass
    raise FileError(f"'{folder / cause}' is not as the study left it (its checksum differs): add --force to solve all points anew")


@functools.lru_cache(4096)
def _number(text):
    for convert in (int, float) if text[-1:].isdigit() and "." not in text else (float,):
        try:
            return convert(text)
        except ValueError:
            pass
    return text


def read_rows(path: PathLike, columns: Sequence[str] | None = None) -> list:
    """Rows of a CSV table as dicts, numbers converted, empty cells left out; only the columns named, where they are."""
    input_file(path)
    try:
        with open(path, newline="", encoding="utf-8") as file:
            table = csv.reader(file)
            wanted = [(i, name) for i, name in enumerate(next(table, [])) if columns is None or name in columns]
            return [{name: _number(row[i]) for i, name in wanted if i < len(row) and row[i] != ""} for row in table if row]
    except OSError as e:
        raise FileError(f"'{path}' cannot be read: {e}") from None


class StudyResult:
    """A study read from its folder.

    Parameters
    ----------
    folder : str or Path
    rows : list of dict, optional
        Rows of the table, or what is needed of them: it is not read then.

    Attributes
    ----------
    folder : Path
    summary : dict
        study.json.
    rows : list of dict
        One per load step of each point; a failed point ends with a row of status 'failed', its reason and its last
        converged state.
    """

    @checked(folder=a_folder)
    def __init__(self, folder: PathLike, rows: list | None = None) -> None:
        self.folder = Path(folder)
        self.summary = read_study_summary(self.folder)
        self.rows = read_rows(self.folder / "study.csv") if rows is None else rows

    @checked(name=text)
    def column(self, name: str, rows: Sequence[Mapping] | None = None) -> np.ndarray:
        """A column as an array; NaN where a row has no value. InputError: no row has such a column."""
        rows = self.rows if rows is None else rows
        self._check_columns(name)
        values = [row.get(name, np.nan) for row in rows]
        return np.array(values, dtype=object if any(isinstance(v, str) for v in values) else float)

    @checked(torque_nm=number(optional=True))
    def select(self, torque_nm: float | None = None, **keys: Value) -> list:
        """Solved rows with the given values; group__key stands for 'group.key'. InputError: no row has such a column."""
        keys = {_plain(k): v for k, v in keys.items()}
        self._check_columns(*keys)
        if torque_nm is not None:
            keys["torque_nm"] = torque_nm
        keys = {k: v if isinstance(v, str) else number()(k, v) for k, v in keys.items()}
        return [r for r in self.rows if r["status"] == "done" and all(alike(r.get(k), v) for k, v in keys.items())]

    def _check_columns(self, *names):
        known = dict.fromkeys(name for row in self.rows for name in row)
        for name in names:
            if known and name not in known:
                near = " or ".join(difflib.get_close_matches(name, known, 2))
                raise InputError(f"column '{name}': {f'did you mean {near}? It ' if near else ''}must be one of {', '.join(known)}")

    @property
    def failures(self) -> list:
        """Rows of the failed points."""
        return [row for row in self.rows if row["status"] == "failed"]

    def series(self) -> list:
        """K_TS, K_FTS and both in series (Eq. 46) at every torque, for each point against the teeth.

        A point against the teeth goes with the one of the contact that has its values of all other swept keys.

        Returns
        -------
        list of dict
            tooth_clearance_m, torque_nm, k_ts_nm_per_rad, k_fts_nm_per_rad (torque over rotation), k_wts_nm_per_rad; the swept
            keys that both have.
        """
        done = [r for r in self.rows if r["status"] == "done" and r["torque_nm"] > 0]
        both = [k for k in self.summary["swept"] if k not in OF_TEETH]
        against, rows = _engine.names("support_against_teeth"), []
        for r in done:
            contact = [c["k_ts_nm_per_rad"] for c in done if c.get("load.support") not in against
                       and all(alike(c.get(k), r.get(k)) for k in (*both, "torque_nm"))]
            if r.get("load.support") in against and contact:
                k = r["k_fe_secant_nm_per_rad"]
                rows.append({"tooth_clearance_m": r.get(CLEARANCE, self.summary["scene"][CLEARANCE]), "torque_nm": r["torque_nm"],
                             "k_ts_nm_per_rad": contact[0], "k_fts_nm_per_rad": k,
                             "k_wts_nm_per_rad": torsion.series(contact[0], k), **{key: r[key] for key in both}})
        return rows

    def frame(self) -> Any:
        """The table as a pandas.DataFrame (needs pandas)."""
        return package("pandas", "a frame", "tables").read_csv(self.folder / "study.csv")

    def dataset(self) -> Any:
        """Solved rows as an xarray.Dataset over the swept keys and the torque (needs pandas and xarray).

        Keys that change side by side make no grid: they become coordinates along the dimension `point`. With rows = 'last' the
        torque is a variable, as every point has one; so it is of whole drives, whose loop passes a torque twice.
        """
        package("xarray", "a dataset", "tables")
        varied = [k for k in self.summary["swept"] if len({str(r.get(k)) for r in self.rows}) > 1]
        frame = self.frame().query("status == 'done'").drop(columns=["reason", "code", "status"], errors="ignore")
        frame["torque_nm"] = frame["torque_nm"].round(9)
        rows = self.summary["identity"]["rows"]
        if len(frame.columns.intersection(LOOP)):
            frame, rows = frame[~frame["point"].isin([r["point"] for r in self.failures])].groupby("point").tail(1), "last"
        if rows == "all":
            frame = frame[(frame["in_torque"] == 1) | (frame["load_factor"] == 1)]
        grid = np.prod([frame[k].nunique() for k in varied], dtype=int) == self.summary["points"]
        first = frame.groupby("point").first()
        table = frame.set_index([*(varied if grid else ["point"]), *([] if rows == "last" else ["torque_nm"])]).to_xarray()
        return table if grid else table.drop_vars(varied).assign_coords({k: ("point", first[k]) for k in varied})

    def _repr_html_(self):
        return preformatted(self)

    def __repr__(self) -> str:
        s = self.summary
        lines = [f"{s['title'] or 'study'}: {s['status']}", f"  {s['done']} of {s['points']} points, {s['failed']} failed, "
                 f"{len(self.rows)} rows over {', '.join(s['swept']) or 'torque'}"]
        lines += [f"  point {r['point']} failed: {str(r['reason']).splitlines()[0]}" for r in self.failures[:8]]
        return "\n".join(lines + ([f"  and {len(self.failures) - 8} more, see study.csv"] if len(self.failures) > 8 else []))
