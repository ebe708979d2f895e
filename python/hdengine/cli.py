# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine`."""
import argparse
import sys
from pathlib import Path

from ._engine import HdengineError
from .contact import Run
from .results import Result


def _run(args):
    out = args.out or Path(args.input).with_suffix(".out").name
    keys = dict(item.split("=", 1) for item in args.assignments if "=" in item)
    with Run(args.input, out, args.force, **{k.replace(".", "__", 1): v for k, v in keys.items()}) as run:
        for step in run:
            s = step.sums
            print(f"step {s['step']:3.0f}  torque {s['torque_nm']:8.4f} N m  K_TS {step.k_ts_nm_per_rad:.4e} N m/rad", flush=True)
    return _plot(argparse.Namespace(folder=out))


def _plot(args):
    from .plot import plot_run

    result = Result(args.folder)
    print(result)
    print(f"written: {result.write_torsion()}")
    for path in plot_run(result):
        print(f"written: {path}")
    return 0


def main(argv=None):
    """Entry of the command; returns the exit code of hdengine.x."""
    parser = argparse.ArgumentParser(prog="hdengine", description=__doc__.strip(),
                                     epilog="example: hdengine run data/cd14.nml load.torque=3")
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="run a scene, then plot it", epilog="example: hdengine run data/cd14.nml --force")
    run.add_argument("input", help="namelist")
    run.add_argument("assignments", nargs="*", help="group.key=value")
    run.add_argument("--out", help="folder for the results")
    run.add_argument("--force", action="store_true", help="replace earlier results")
    run.set_defaults(action=_run)
    plot = commands.add_parser("plot", help="torsion.csv and figures of a run", epilog="example: hdengine plot cd14.out")
    plot.add_argument("folder", help="folder of a run")
    plot.set_defaults(action=_plot)
    args = parser.parse_args(argv)
    try:
        return args.action(args)
    except HdengineError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.code
