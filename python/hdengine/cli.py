# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine`."""
import argparse
import sys
from pathlib import Path

from ._engine import FileError, HdengineError
from .cli_surface import add_options, run_surface
from .contact import Run
from .results import Result


def _run(args):
    out = args.out or Path(args.input).with_suffix(".out").name
    keys = dict(item.split("=", 1) for item in args.assignments if "=" in item)
    with Run(args.input, out, args.force, args.resume, **{k.replace(".", "__", 1): v for k, v in keys.items()}) as run:
        for step in run:
            s = step.sums
            print(f"step {s['step']:3.0f}  torque {s['torque_nm']:8.4f} N m  K_TS {step.k_ts_nm_per_rad:.4e} N m/rad", flush=True)
    return _plot(argparse.Namespace(folder=out))


def _study(args):
    from .study import Study

    out = args.out or Path(args.input).with_suffix(".out").name
    Study.read(args.input).run(out, args.jobs, args.force, args.retry)
    return _plot(argparse.Namespace(folder=out))


def _plot(args):
    folder = Path(args.folder)
    if (folder / "study.json").is_file():
        from .plot_study import plot_study
        from .study import StudyResult

        result, paths = StudyResult(folder), [folder / "study.csv"]
        paths += plot_study(result)
    elif (folder / "summary.json").is_file():
        from .plot import plot_run

        result = Result(folder)
        paths = [result.write_torsion(), *plot_run(result)]
    else:
        raise FileError(f"'{folder}' holds neither a run (summary.json) nor a study (study.json)")
    print(result)
    for path in paths:
        print(f"written: {path}")
    return 0


def _report(args):
    from .report import write_report

    print(f"written: {write_report(args.folder, args.out, not args.no_picture)}")
    return 0


def _record(args):
    from .catalogue import UNITS
    from .record import ARCSEC, Record

    record = Record.read(args.input, torque_error_nm=args.torque_error, angle_error_rad=args.angle_error * ARCSEC)
    print(record)
    for name, values in record.numbers(UNITS[args.size], args.rated_torque).items():
        scale, unit = (1 / ARCSEC, "arcsec") if not name.startswith("k") else (1, "N m/rad")
        value, low, high = (scale * v for v in values)
        short = name.removesuffix("_nm_per_rad").removesuffix("_rad")
        print(f"  {short:12s} {value:9.1f}  95 % band {low:9.1f} to {high:9.1f}  {unit}")
    path = args.out or Path(args.input).with_suffix(".png").name
    record.plot().savefig(path)
    print(f"written: {path}")
    return 0


def _command(commands, name, action, text, example):
    """A subcommand whose help ends with an example."""
    parser = commands.add_parser(name, help=text, description=text, epilog=f"example: hdengine {example}")
    parser.set_defaults(action=action)
    return parser


def main(argv=None):
    """Entry of the command; returns the exit code of hdengine.x."""
    parser = argparse.ArgumentParser(prog="hdengine", description=__doc__.strip(),
                                     epilog="example: hdengine run data/cd14.nml load.torque=3")
    commands = parser.add_subparsers(dest="command", required=True)
    run = _command(commands, "run", _run, "run a scene, then plot it", "run data/cd14.nml load.torque=3 --force")
    run.add_argument("input", help="namelist")
    run.add_argument("assignments", nargs="*", help="group.key=value")
    run.add_argument("--resume", action="store_true", help="go on with a stopped run of the same input")
    study = _command(commands, "study", _study, "solve a scene at many points; an unfinished study is continued",
                     "study data/fig13_w.nml --jobs 2")
    study.add_argument("input", help="study namelist")
    study.add_argument("--jobs", type=int, default=1, help="worker processes (default: this process alone)")
    study.add_argument("--retry", action="store_true", help="solve failed points again")
    for sub in (run, study):
        sub.add_argument("--out", help="folder for the results")
        sub.add_argument("--force", action="store_true", help="replace earlier results")
    plot = _command(commands, "plot", _plot, "tables and figures of a run or a study", "plot cd14.out")
    plot.add_argument("folder", help="folder of a run or a study")
    report = _command(commands, "report", _report, "one self-contained HTML file of a run or a study", "report cd14.out")
    report.add_argument("folder", help="folder of a run or a study")
    report.add_argument("--out", help="file (default: report.html in the folder)")
    report.add_argument("--no-picture", action="store_true", help="without the 3-D picture")
    record = _command(commands, "record", _record, "stiffness, hysteresis and lost motion from a torque-angle record",
                      "record data/torque_record.csv --size 14")
    record.add_argument("input", help="CSV with columns torque_nm and angle_rad or angle_arcsec, a whole loop")
    record.add_argument("--size", type=int, choices=(14, 17, 20, 25, 32), default=14, help="size whose T1 and T2 are used")
    record.add_argument("--rated-torque", type=float, help="lost motion is read at 4 %% of it [N m]")
    record.add_argument("--torque-error", type=float, default=0.05, help="of the bench [N m]")
    record.add_argument("--angle-error", type=float, default=2.0, help="of the bench [arcsec]")
    record.add_argument("--out", help="figure")
    add_options(_command(commands, "surface", run_surface, "read height maps, fit D and G, judge, plot",
                         "surface data/specimen_flexspline.npz data/specimen_bearing.npz --pair"))
    args = parser.parse_args(argv)
    try:
        return args.action(args)
    except HdengineError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.code
