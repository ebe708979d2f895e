# SPDX-License-Identifier: GPL-3.0-or-later
"""Shards: a study dealt over machines that share nothing but a folder, and their parts collected into its table.

Every shard deals the points by itself, from the study alone: the largest first, each to the shard with the least work so far. It
appends what it solves to part-I.jsonl, a line a point behind a head that names the study; a torn last line is solved again.
"""
from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import heapq
import json
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any

from .. import _engine
from .._check import input_file
from .._engine import FileError, FolderLock, HdengineError, InputError
from .._types import PathLike
from ..contact import read_scene
from ..files import check_folder, write_files, writing
from .progress import Progress
from .study import FILES, Study, StudyResult, check_free, head_of
from .workers import solve_all

__all__: list[str] = []
# keys that decide how long a point takes
COSTLY = ("load.assembly_steps", "load.torque_steps", "loop.torques", "mesh.divisions", "mesh.band_facets", "solver.kinematics")
GROWTH = 1.5   # of a run's time with its facets (the condensed solver: between 1.1 and 2)
LARGE = 10     # time of large displacements over that of small ones
NO_LOCKS = (errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOLCK)   # of a file system without flock
OPEN = 256     # parts open at a time
# a line of a part; numbers stay the text that the table holds, which takes half of the time
READ = json.JSONDecoder(parse_float=str, parse_constant={"NaN": "nan", "Infinity": "inf", "-Infinity": "-inf"}.get).decode


def number_of(text: str) -> tuple[int, int]:
    """(I, N) of the text 'I/N'.

    Raises
    ------
    InputError
        It is none, or I is not one of 1 to N.
    """
    found = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        raise InputError(f"--shard '{text}' must be I/N, shard I of N, as 1/8 to 8/8")
    return int(found[1]), int(found[2])


def work(study: Study) -> list[float]:
    """Predicted time of every point, relative to each other; 0 where its mesh or steps are not valid in the first valid point."""
    known: dict[tuple, float] = {}
    found = []
    first = study.first_valid()[0]
    costly = [k for k in first if k in COSTLY]
    for point in study.points:
        name = tuple(str(point[k]) for k in costly)
        if name not in known:
            try:
                s = read_scene(study.scene, **{**study.fixed, **first, **{k: point[k] for k in costly}})
                steps = s["load.assembly_steps"] + s["load.torque_steps"] * max(1, str(s.get("loop.torques", "")).count(",") + 1)
                known[name] = (steps * (s["mesh.divisions"] * s["mesh.band_facets"])**GROWTH
                               * (LARGE if s["solver.kinematics"] == "nonlinear" else 1))
            except HdengineError:
                known[name] = 0
        found.append(known[name])
    return found


def deal(study: Study, shards: int) -> list[list[int]]:
    """Points of each shard, the largest first: each point goes to the shard with the least work so far."""
    cost = work(study)
    least = [(0.0, 0, i) for i in range(shards)]
    dealt: list[list[int]] = [[] for _ in range(shards)]
    for point in sorted(range(len(cost)), key=lambda i: -cost[i]):
        done, count, shard = least[0]
        dealt[shard].append(point)
        heapq.heapreplace(least, (done + cost[point], count + 1, shard))
    return dealt


def _head(identity, shards):
    """First line of a part."""
    text = json.dumps(identity, sort_keys=True).encode()
    return {"sha256": hashlib.sha256(text).hexdigest(), "shards": shards, "hdengine": _engine.version()}


def _is_entry(entry, points):
    """Whether a line of a part is what `run_shard` writes."""
    return (entry.keys() == {"point", "rows"} and type(entry["point"]) is int and 0 <= entry["point"] < points
            and type(entry["rows"]) is list and len(entry["rows"]) > 0
            and all(type(row) is dict and row.get("status") in ("done", "failed") for row in entry["rows"]))


def _lines(path: Path, file: IO[bytes], head: dict[str, Any], points: int) -> Iterator[tuple[int, int, list]]:
    """Whole lines of a part behind its head: where each ends, its point, its rows with their numbers as the text that they are.

    Raises
    ------
    FileError
        The head is that of another study, number of shards or version; or a line is none of a study with so many points.
    """
    end = 0
    for i, line in enumerate(file):
        try:
            if not line.endswith(b"\n"):
                return
            entry = READ(line.decode())
            if i == 0:
                for key in head:
                    if entry[key] != head[key]:
                        raise FileError(f"'{path}' is of another study: its {key} is {entry[key]}, here {head[key]}; add --force "
                                        "to solve its points anew, or choose another folder")
            elif not _is_entry(entry, points):
                raise ValueError
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            entries = f'{{"point": 0 to {points - 1}, "rows": [{{"status": "done" or "failed", ...}}, ...]}}'
            valid = entries if i else "the study's head"
            raise FileError(f"'{path}' line {i + 1} is not as a shard left it (valid: {valid}): add --force to solve its points "
                            "anew") from None
        end += len(line)
        if i:
            yield end, entry["point"], entry["rows"]


def run_shard(study: Study, out: PathLike, number: int, shards: int, jobs: int = 1, force: bool = False, retry: bool = False,
              show: bool = True) -> tuple[int, int]:
    """Solve the points of one shard that its part does not hold yet.

    Parameters
    ----------
    study : Study
    out : str or Path
        Folder that all shards share; this one appends to part-`number`.jsonl in it.
    number, shards : int
        Shard `number` of 1 to `shards`.
    jobs, force, retry, show
        As for `Study.run`.

    Returns
    -------
    tuple of int
        Points of the shard, all solved, and how many of them failed.

    Raises
    ------
    FileError
        The part is of another study, number of shards or version, or another process is at work on it.
    StoppedError
        As for `Study.run`.
    """
    study.check()
    mine, points = deal(study, shards)[number - 1], study.points
    path = Path(out, f"part-{number}.jsonl")
    head = _head(study.identity(), shards)
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    check_folder(out, (*FILES, path.name), force=True)
    with writing(path), open(os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666), "r+b") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FileError(f"another process is at work on '{path}'") from None
        except OSError as e:
            if e.errno not in NO_LOCKS:
                raise
        if os.fstat(file.fileno()).st_nlink > 1:   # a copy of it by hard links stays as it is
            write_files({path: iter(lambda: file.read(2**20), b"")})
            return run_shard(study, out, number, shards, jobs, force, retry, show)
        end, failed = 0, {}
        if not force:
            for end, point, rows in _lines(path, file, head, len(points)):
                failed[point] = rows[-1]["status"] == "failed"
        file.seek(end)
        file.truncate()
        if not end:
            _append(file, head)
        todo = [i for i in mine if i not in failed or (retry and failed[i])]
        progress = Progress(len(mine), len(mine) - len(todo), show)
        for i, rows in solve_all([(i, study.scene, {**study.fixed, **points[i]}, study.rows) for i in todo], jobs):
            _append(file, {"point": i, "rows": rows})
            failed[i] = rows[-1]["status"] == "failed"
            progress.step(f"point {i}", failed[i])
    return len(mine), sum(failed[i] for i in mine)


def _append(file, entry):
    """One line, on the disk before the next point begins."""
    file.write(json.dumps(entry, default=lambda value: value.item()).encode() + b"\n")
    file.flush()
    os.fsync(file.fileno())


class _Rows(Mapping):
    """Rows by point, read from their place in the parts when they are asked for."""

    def __init__(self):
        self._places, self._files = {}, {}

    def add(self, point, path, begin, end):
        self._places[point] = path, begin, end - begin

    def __getitem__(self, point):
        path, begin, size = self._places[point]
        if path not in self._files:
            if len(self._files) == OPEN:
                self._files.pop(next(iter(self._files))).close()
            self._files[path] = open(path, "rb")   # noqa: SIM115
        self._files[path].seek(begin)
        try:
            return READ(self._files[path].read(size).decode())["rows"]
        except (ValueError, TypeError, KeyError):
            raise FileError(f"'{path}' was changed while it was collected: collect again") from None

    def __iter__(self):
        return iter(self._places)

    def __len__(self):
        return len(self._places)

    def close(self):
        for file in self._files.values():
            file.close()


def collect(study: Study, out: PathLike, force: bool = False) -> StudyResult:
    """One table of all parts, byte for byte that of a study on one machine.

    Parameters
    ----------
    study : Study
    out : str or Path
        Folder of the parts; study.csv and study.json go there.
    force : bool
        Also where the folder holds another study's table.

    Returns
    -------
    StudyResult
        With the columns that its figure needs.

    Raises
    ------
    FileError
        There is no part; parts or points are missing (the message names the shards; what there is stands in the table, whose status
        is unfinished); a part is of another study, number of shards or version.
    """
    out = Path(out)
    paths = {int(p.stem[5:]): p for p in out.glob("part-*.jsonl") if re.fullmatch("[1-9][0-9]{0,5}", p.stem[5:])}
    scene, identity, points = study.check(), study.identity(), len(study.points)
    head: dict[str, Any] = {}
    heads: dict[int, tuple] = {}
    known: dict[tuple, tuple] = {}
    kept: list[dict] = []
    with contextlib.closing(_Rows()) as rows:
        for _, path in sorted(paths.items()):
            with open(input_file(path), "rb") as file:
                if not head and (shards := _shards_of(path, file)):
                    head = _head(identity, shards)
                begin = len(file.readline())
                file.seek(0)
                for end, point, found in _lines(path, file, head, points):
                    rows.add(point, path, begin, end)
                    of = head_of(found)
                    heads[point] = known.setdefault(of, of)
                    begin = end
        if not head:
            raise FileError(f"'{out}' holds no part: run 'hdengine study ... --shard 1/N' to N/N first")
        with FolderLock(out):
            check_free(out, force)
            if not force:
                study._described(out, identity)
            study._write(out, identity, scene, rows, [_engine.version()], heads, kept)
    missing = []
    if len(heads) < points:
        for number, mine in enumerate(deal(study, head["shards"]), 1):
            if lost := sum(point not in heads for point in mine):
                missing.append(f"{number}/{head['shards']} ({lost} of {len(mine)} points)")
    if missing:
        raise FileError(f"shards are not finished: {', '.join(missing)}; submit each again with --shard, then collect")
    return StudyResult(out, kept)


def _shards_of(path, file):
    """Number of shards that the head of a part names; 0 where the shard was ended before it wrote one."""
    try:
        line = file.readline()
        shards = json.loads(line)["shards"] if line.endswith(b"\n") else 0
        if type(shards) is not int or not 0 <= shards < 10**6:
            raise ValueError
    except (ValueError, KeyError, TypeError, RecursionError):
        raise FileError(f"'{path}' line 1 is not as a shard left it: submit the shard again with --force") from None
    file.seek(0)
    return shards
