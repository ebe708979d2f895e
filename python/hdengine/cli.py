# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine`."""
from __future__ import annotations

import argparse
import contextlib
import importlib.util
import logging
import os
import re
import signal
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import _engine, completion, drive
from ._engine import EngineMemoryError, FileError, HdengineError, NotConvergedError, StoppedError
from .catalogue import UNITS
from .contact import Run, doubts, given_keys, heard, read_scene
from .export import command as export_command
from .files import check_file, check_folder
from .prediction import command as joint_command
from .results import Result
from .studies import planner
from .summary_file import check_one, read_summary
from .surfaces.command import add_options, run_surface
from .surfaces.run import SurfaceResult
from .surfaces.run import _run as _run_surface_alone
from .table_file import read_csv
from .teeth import command as teeth_command

__all__: list[str] = []


class _Explain(argparse.Action):
    """Print what a key means, and end."""

    def __call__(self, parser, namespace, values, option_string=None):
        try:
            print(_engine.call_text("explain_text", values))
        except HdengineError as error:
            parser.exit(error.code, f"{_line(error)}\n")
        parser.exit()


def _line(error):
    """Message of an error as stderr shows it."""
    text = str(error)
    return text if text.startswith("error: ") else f"error: {text}"


def _folder(path):
    """Default folder for the results of an input."""
    return f"{Path(path).stem or 'results'}.out"


def _count(text):
    """A number of worker processes, or of draws."""
    try:
        if int(text) >= 1:
            return int(text)
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' must be a whole number of 1 or more")


def _run(args):
    out, keys = args.out or _folder(args.input), given_keys(args.assignments)
    if args.check or args.plan:  # a run says them at its end, with the others
        for line in doubts(args.input, **keys):
            print(f"warning: {line}", file=sys.stderr)
    if args.check:
        read_scene(args.input, **keys)
        print(f"{args.input} is valid")
        return 0
    if args.plan:
        print(planner.plan(args.input, None, keys))
        return 0
    if _run_surface_alone(args.input, out, args.force, keys):
        return _finish(out)
    try:
        with contextlib.nullcontext() if args.quiet else heard(_ToScreen()), \
                Run(args.input, out, args.force, args.resume, args.allow_implausible, **keys) as run:
            told = 0
            for step in run:
                if args.verbose:
                    told = _tell_iterations(out, told)
                if args.quiet:
                    continue
                s = step.sums
                phase = "torque  " if s["in_torque"] else "assembly"
                print(f"step {s['step']:3.0f}  {phase} {s['torque_nm']:8.4f} N m  normal force {s['normal_force_n']:8.1f} N  "
                      f"{step.stiffness}  {s['iterations']:3.0f} iterations", flush=True)
    except (NotConvergedError, StoppedError):
        print(f"the steps that were solved are kept: hdengine plot {out}, hdengine report {out}", file=sys.stderr)
        raise
    return _finish(out)


class _ToScreen(logging.Handler):
    """Lines of the log that say what a run will take, as they come: the plan, mesh and matrix solver, first guesses."""

    def emit(self, record):
        if record.getMessage().lstrip().startswith(("plan ", "trial ", "mesh ", "solver ", "start ")):
            print(record.getMessage(), flush=True)


def _tell_iterations(out, told):
    """Print the rows of history.csv that are new; returns how many there are."""
    rows = read_csv(Path(out) / "history.csv")
    for row in rows[told:]:
        print(f"  step {row['step']:3d}  iteration {row['iteration']:3d}  residual {row['residual']:9.2e}  open {row['open']:5d}  "
              f"stick {row['stick']:5d}  slip {row['slip']:5d}")
    return len(rows)


def _plan(args):
    print(planner.plan(args.input, args.tolerance, given_keys(args.assignments)))
    return 0


def _completion(args):
    print(completion.script(make_parser(), args.shell))
    return 0


def _study(args):
    from .studies import shard
    from .studies.study import Study

    study = Study.read(args.input)
    if args.check:
        study.check()
        print(f"{args.input} is valid: {study}")
        return 0
    out = args.out or _folder(args.input)
    if args.shard is not None:
        number, shards = shard.number_of(args.shard)
        points, failed = shard.run_shard(study, out, number, shards, args.jobs, args.force, args.retry, not args.quiet)
        print(f"shard {args.shard}: {points} points, {failed} failed, in {out}/part-{number}.jsonl; after the last shard: "
              f"hdengine study {args.input} --collect --out {out}")
        return 0
    if args.collect:
        return _finish(out, shard.collect(study, out, args.force))
    study.run(out, args.jobs, args.force, args.retry, show=not args.quiet, other_version=args.other_version)
    return _finish(out)


def _finish(folder, result=None):
    """Results and figures of what was just solved; a machine that computes only may lack matplotlib."""
    if importlib.util.find_spec("matplotlib"):
        return _plot(argparse.Namespace(folder=folder, debug=False, result=result))
    print(f"written: {folder}; figures need matplotlib: pip install 'hdengine[plot]'", file=sys.stderr)
    return 0


def _plot(args):
    folder = Path(args.folder)
    result: Any
    check_one(folder)
    if (folder / "study.json").is_file():
        from .figures.study import plot_study
        from .studies.study import StudyResult, columns_of, read_rows, read_study_summary

        table = folder / "study.csv"
        result = getattr(args, "result", None) or StudyResult(folder, read_rows(table, columns_of(read_study_summary(folder))))
        paths = [table]
        paths += plot_study(result)
    elif (folder / "summary.json").is_file() and read_summary(folder).get("kind") == "surface":
        result = SurfaceResult(folder)
        paths = result.plot()
    elif (folder / "summary.json").is_file():
        from .figures.run import plot_run

        result = Result(folder)
        paths = [result.write_torsion(), *plot_run(result, args.debug)]
    else:
        raise FileError(f"'{folder}' holds neither a run (summary.json) nor a study (study.json); "
                        "valid: a folder that hdengine.x or hdengine study wrote")
    print(result)
    for path in paths:
        print(f"written: {path}")
    return 0


def _report(args):
    from .report import write_pdf, write_report

    check_file(args.out, args.force)
    if args.pdf and args.out:
        check_file(Path(args.out).with_suffix(".pdf"), args.force)
    path = write_report(args.folder, args.out, args.picture, args.animation)
    print(f"written: {path}")
    if args.pdf:
        print(f"written: {write_pdf(path)}")
    return 0


def _export(args):
    check_file(args.out, args.force)
    print(f"written: {export_command.export(Result(args.folder), args.to, args.out)}")
    return 0


def _sensitivity(args):
    from .uncertainty import SOLVED, analyse

    found = analyse(args.folder, args.drive, args.draws, force=args.force)
    print(f"K_TS by Eq. 45 {found['k_ts_nm_per_rad']:.4g} N m/rad at {found['torque_nm']:g} N m")
    for name, (low, median, high) in found["bands_95_nm_per_rad"].items():
        print(f"  {name:28s} 95 % band {low:.4g} to {high:.4g}, median {median:.4g}")
    for key, (first, _, total, _) in found["indices"].items():
        print(f"  {key:28s} share of the variance {first:.2f}, with interactions {total:.2f}")
    if "note" in found:
        print(f"  {found['note']}")
    for solved, (_, words) in SOLVED.items():
        if solved not in found:
            continue
        print(f"{words} {found[solved]['base_nm_per_rad']:.4g} N m/rad")
        for name, (low, median, high) in found[solved]["bands_95_nm_per_rad"].items():
            print(f"  {name:28s} 95 % band {low:.4g} to {high:.4g}, median {median:.4g}")
        for key, share in found[solved]["shares_of_variance"].items():
            print(f"  {key:28s} share of the variance {share:.2f}")
    shares = read_summary(args.folder, "results")["results"].get("band_shares")
    if args.drive and shares:
        most = max(shares, key=shares.get)
        print(f"Teeth, spline and balls are not among these: of all inputs {most} makes most of K2 (band_shares of summary.json)")
    for name, made in (("sensitivity.json", True), ("tornado_joint.png", found["joint"]), ("tornado_drive.png", "drive" in found),
                       *((f"tornado_{solved}.png", solved in found) for solved in SOLVED)):
        if made:
            print(f"written: {Path(args.folder) / name}")
    return 0


def _record(args):
    from .record import ARCSEC, DRIFT, Record

    out = args.out or _folder(args.input)
    check_folder(out, Record.FILES, args.force)
    record = Record.read(args.input, torque_error_nm=args.torque_error, angle_error_rad=args.angle_error * ARCSEC)
    print(record)
    numbers = record.numbers(UNITS[args.size], args.rated_torque)
    for name, values in numbers.items():
        scale, unit = (1 / ARCSEC, "arcsec") if not name.startswith("k") else (1, "N m/rad")
        value, low, high = (scale * v for v in values)
        if np.isnan(value):
            print(f"  {name.removesuffix('_nm_per_rad'):12s} beyond the torques of the record")
            continue
        short = name.removesuffix("_nm_per_rad").removesuffix("_rad")
        print(f"  {short:12s} {value:9.1f}  95 % band {low:9.1f} to {high:9.1f}  {unit}")
    for i, end in ((1, UNITS[args.size].t1_nm), (2, UNITS[args.size].t2_nm)):
        if np.isfinite(numbers[f"k{i}_nm_per_rad"][0]) and record.torque_nm.max() < end:
            print(f"  warning: the record ends at {record.torque_nm.max():.4g} N m, below T{i} = {end:g} N m of size {args.size}: "
                  f"K{i} is the chord to there, a catalogue's is not")
    value, low, high = numbers["closing_rad"]
    if low * high > 0 and abs(value) > DRIFT * numbers["hysteresis_rad"][0]:
        print("  warning: the loop does not close, and hysteresis holds half of what it lacks: let the drive creep first, or take "
              "the drift out of the angles")
    for path in record.write(out, numbers, args.input, args.size, args.force):
        print(f"written: {path}")
    return 0


def _command(commands, name, action, text, example):
    """A subcommand whose help ends with an example."""
    parser = commands.add_parser(name, help=text, description=text, epilog=f"example: hdengine {example}",
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(action=action)
    return parser


def make_parser() -> argparse.ArgumentParser:
    """The command with its subcommands."""
    parser = argparse.ArgumentParser(prog="hdengine", description="The command `hdengine`.",
                                     epilog="example: hdengine run data/cd14.nml load.torque=3")
    parser.add_argument("--version", action="version", version=f"hdengine {_engine.version()}")
    commands = parser.add_subparsers(dest="command", required=True)
    run = _command(commands, "run", _run, "run a scene or a surface, then plot it", "run data/cd14.nml load.torque=3 --force")
    run.add_argument("input", help="namelist")
    plan = _command(commands, "plan", _plan, "mesh, load steps, time and memory for a tolerance, without running",
                    "plan data/cd14.nml --tolerance 0.05")
    plan.add_argument("input", help="namelist of a scene, or a study")
    plan.add_argument("--tolerance", type=float, help=f"relative error (default: that of the scene, else {planner.TOLERANCE})")
    for sub in (run, plan):
        sub.add_argument("assignments", nargs="*", metavar="group.key=value", help="keys that differ from the file")
    run.add_argument("--check", action="store_true", help="read and check the input, then stop")
    run.add_argument("--plan", action="store_true", help="print what run.tolerance needs, with time and memory, then stop")
    run.add_argument("--explain", metavar="KEY", action=_Explain, help="meaning, unit and default of a key (group.key, group, all)")
    run.add_argument("-q", "--quiet", action="store_true", help="no line per load step")
    run.add_argument("-v", "--verbose", action="store_true", help="also a line per Newton iteration")
    run.add_argument("--allow-implausible", action="store_true", help="solve also where a value is some thousand times off")
    run.add_argument("--resume", action="store_true", help="go on with a stopped run of the same input")
    study = _command(commands, "study", _study, "solve a scene at many points; an unfinished study is continued",
                     "study data/fig13_w.toml --jobs 2")
    study.add_argument("input", help="study (TOML)")
    study.add_argument("--jobs", type=_count, default=1, help="worker processes (default: this process alone)")
    study.add_argument("--check", action="store_true", help="check the study and the scene of a point, then stop")
    study.add_argument("-q", "--quiet", action="store_true", help="no progress")
    study.add_argument("--retry", action="store_true", help="solve failed points again")
    part = study.add_mutually_exclusive_group()
    part.add_argument("--shard", metavar="I/N", help="solve shard I of N into part-I.jsonl: each on a machine of its own")
    part.add_argument("--collect", action="store_true", help="one table of all parts")
    part.add_argument("--other-version", action="store_true", help="keep rows that another version of hdengine solved")
    for sub in (run, study):
        sub.add_argument("--out", help="folder for the results")
        sub.add_argument("--force", action="store_true", help="replace earlier results")
    plot = _command(commands, "plot", _plot, "tables and figures of a run or a study", "plot cd14.out")
    plot.add_argument("folder", help="folder of a run or a study")
    plot.add_argument("--debug", action="store_true", help="also what is read to mend a run: iterations, pressures of every torque")
    report = _command(commands, "report", _report, "one self-contained HTML file of a run or a study", "report cd14.out")
    report.add_argument("folder", help="folder of a run or a study")
    report.add_argument("--out", help="file (default: report.html in the folder)")
    report.add_argument("--pdf", action="store_true", help="also a PDF beside it (needs WeasyPrint: hdengine[pdf])")
    report.add_argument("--picture", action="store_true", help="with a 3-D picture (needs PyVista: hdengine[report])")
    report.add_argument("--animation", action="store_true", help="with the pressure step by step, as a GIF")
    export = _command(commands, "export", _export, "a run for another program: the drive as a joint, or a deck",
                      "export drive14.out --to mujoco --out joint.xml")
    export_command.add_options(export)
    for sub in (report, export):
        sub.add_argument("--force", action="store_true", help="replace the file that --out names")
    sensitivity = _command(commands, "sensitivity", _sensitivity, "tornado, bands and shares of the variance of K_TS of a run",
                           "sensitivity cd14.out --drive")
    sensitivity.add_argument("folder", help="folder of a run")
    sensitivity.add_argument("--drive", action="store_true", help="also geometry, material, wave generator (solved anew)")
    sensitivity.add_argument("--draws", type=_count, default=500, help="of the bands")
    sensitivity.add_argument("--force", action="store_true", help="solve anew what --drive solved for an earlier run")
    record = _command(commands, "record", _record, "stiffness, hysteresis and lost motion from a torque-angle record",
                      "record data/torque_record.csv --size 14")
    record.add_argument("input", help="CSV with columns torque_nm and angle_rad or angle_arcsec, a whole loop")
    record.add_argument("--size", type=int, choices=tuple(UNITS), default=14, help="size whose T1 and T2 are used")
    record.add_argument("--rated-torque", type=float, help="lost motion is read at 4 %% of it [N m] (default: of ratio 100)")
    record.add_argument("--torque-error", type=float, default=0.05, help="of the bench [N m]")
    record.add_argument("--angle-error", type=float, default=2.0, help="of the bench [arcsec]")
    record.add_argument("--out", help="folder for record.json, curve.csv, record.png, scene.nml (default: the record's stem.out)")
    record.add_argument("--force", action="store_true", help="replace earlier results")
    add_options(_command(commands, "surface", run_surface, "read height maps, fit D and G, judge, plot",
                         "surface data/specimen_flexspline.sdf data/specimen_bearing.sdf --pair --ridges 5e-4,1e-6,10,1.5"))
    joint_command.add_options(_command(commands, "joint", joint_command.run_joint,
                                       "stiffness over pressure of the joint of one or two measured surfaces",
                                       "joint data/specimen_flexspline.sdf data/specimen_bearing.sdf --out joint.out"))
    new = _command(commands, "new", drive.write_drive, "the input of a whole drive of a size and a ratio, as it is built",
                   "new 20 geometry.wall_thickness=0.5e-3 --ratio 120 --out mine.nml")
    drive.add_options(new)
    teeth_command.add_options(_command(commands, "teeth", teeth_command.run_teeth,
                                       "clearance of every pair of teeth from their profile",
                                       "teeth data/drive14.nml --profile involute --module 0.1778e-3 --out teeth.out"))
    shell = _command(commands, "completion", _completion, "print a completion script for the shell",
                     "completion bash > ~/.local/share/bash-completion/completions/hdengine")
    shell.add_argument("shell", choices=completion.SHELLS)
    return parser


def _arguments(argv):
    """Parsed arguments; keys may also stand behind options, where argparse does not look for them."""
    parser = make_parser()
    args, rest = parser.parse_known_args(argv)
    keys = [word for word in rest if "=" in word and not word.startswith("-")]
    if keys != rest or (keys and not hasattr(args, "assignments")):
        why = "" if hasattr(args, "assignments") or keys != rest else f" (keys have no place in 'hdengine {args.command}')"
        parser.error(f"unrecognized arguments: {' '.join(rest)}{why}")
    if keys:
        args.assignments += keys
    return args


@contextlib.contextmanager
def _orderly():
    """Signals that end hdengine.x in order (of a batch system, `kill`, a closed terminal) end the command as Ctrl-C does; ignored
    ones stay so."""
    taken = [s for s in _engine.stop_signals() if signal.getsignal(s) == signal.SIG_DFL]
    if threading.current_thread() is not threading.main_thread():
        taken = []
    for s in taken:
        signal.signal(s, signal.default_int_handler)
    try:
        yield
    finally:
        for s in taken:
            signal.signal(s, signal.SIG_DFL)


def _for_the_shell(message):
    """Advice in Python's words as options: unit="um" becomes --unit um."""
    message = re.sub(r'unit=\("(\w+)", "(\w+)"\)', r"--unit \1,\2", message)
    return re.sub(r'unit=["\']([^"\']+)["\']', r"--unit \1", message)


class _Stream:
    """A standard stream that takes every letter and, closed or full, every line: the work goes on, and its end tells the fault."""

    def __init__(self, stream):
        self._stream, self.fault = stream, None

    def write(self, text):
        """As of a file; letters that the stream does not know are written as escapes."""
        if self._stream is not None:
            coding = getattr(self._stream, "encoding", None) or "utf-8"
            self._try(self._stream.write, text.encode(coding, "backslashreplace").decode(coding))
        return len(text)

    def flush(self):
        """As of a file."""
        if self._stream is not None:
            self._try(self._stream.flush)

    def isatty(self):
        """As of a file."""
        return self._stream is not None and self.fault is None and self._stream.isatty()

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def _try(self, action, *args):
        if self.fault is None:
            try:
                action(*args)
            except (OSError, ValueError) as fault:   # full, its reader gone; closed
                self.fault = fault

    def drop(self):
        """What the stream still holds goes nowhere: Python would try it again as it ends."""
        with contextlib.suppress(OSError, ValueError, AttributeError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())


def _fill_streams():
    """Standard streams that are closed lead nowhere: the next file opened would get their place."""
    with contextlib.suppress(OSError):
        while (file := os.open(os.devnull, os.O_RDWR)) <= 2:
            os.set_inheritable(file, True)
        os.close(file)


def main(argv: Sequence[str] | None = None) -> int:
    """Entry of the command; returns the exit code of hdengine.x."""
    _fill_streams()
    os.environ["MPLBACKEND"] = "agg"   # figures are files; one that the environment names may not load, and no import says so well
    out, err, left = _Stream(sys.stdout), _Stream(sys.stderr), None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = _obey(argv)
        except SystemExit as end:   # --help, --version, a wrong option
            left, code = end, end.code
        out.flush()
        if out.fault is not None:
            out.drop()
            if not code:
                code, left = FileError.code, None
                why = getattr(out.fault, "strerror", None) or out.fault
                print(f"error: cannot write the standard output: {why}; files of results are not concerned", file=err)
        err.flush()
        if err.fault is not None:
            err.drop()
    if left is not None:
        raise left
    return code


def _obey(argv):
    """Do what is asked."""
    args = _arguments(argv)
    try:
        with _orderly():
            return args.action(args)
    except HdengineError as error:
        print(_for_the_shell(_line(error)), file=sys.stderr)
        return error.code
    except OSError as error:  # a table or figure that cannot be written
        print(f"error: '{error.filename}': {error.strerror}" if error.filename else f"error: {error}", file=sys.stderr)
        return FileError.code
    except MemoryError as error:
        print(f"error: not enough memory: {error}", file=sys.stderr)
        return EngineMemoryError.code
    except KeyboardInterrupt:
        print("error: interrupted; what was solved is kept: the same command goes on with a study, with --resume also with a run",
              file=sys.stderr)
        return StoppedError.code
