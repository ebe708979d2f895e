#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every benchmark by name: what it measures, with which arguments, and how old its record is. Called by `./hd bench`.

Usage: bench/all.py [--quick] [--list] [--again] [NAME ...]
Without names all of them run, one after the other; a record that was made of the sources as they are is kept unless `--again` is given, so
a stopped call goes on where it was. `--quick` takes those that show every method in ten minutes. `--list` only tells.
"""
import argparse
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from common import RESULTS, ROOT, table

HERE = Path(__file__).parent


@dataclass
class Bench:
    """One script: arguments of the full and the quick call, the record it writes, roughly how many minutes it takes."""

    script: str
    what: str
    minutes: float
    full: tuple = ()
    quick: tuple = None    # None: not in the quick set
    record: str = ""       # a pattern, where it is not the script's name

    @property
    def name(self):
        """Its name on the command line."""
        return Path(self.script).stem


BENCHES = (
    Bench("pareto.py", "error over time of every family of methods", 13, quick=("--quick",)),
    Bench("stability.py", "right, refused, slow, wrong over hard parameters", 20, quick=("--quick",)),
    Bench("../court/run.py", "problems with published answers", 0.5, quick=(), record="court"),
    Bench("elements.py", "elements beside CalculiX", 2, quick=("--quick",)),
    Bench("contact_standards.py", "contact beside closed solutions", 5),
    Bench("height_peers.py", "heights beside FINUFFT and BLAS", 6),
    Bench("structure_function.py", "structure function beside numpy", 1),
    Bench("peer_hub.py", "the press-fit scene beside CalculiX", 6, record="peer_hub_*"),
    Bench("peer_drive.py", "a small whole drive beside CalculiX", 5),
    Bench("cup_shapes.py", "shapes of the cup in the whole drive", 3),
    Bench("peer_scenes.py", "press-fit scenes: iterations and results", 1),
    Bench("solver_choice.py", "matrix solvers: time and memory", 6),
    Bench("cost_over_size.py", "cost over the number of facets", 8),
    Bench("forty_scenes.py", "forty scenes in one process", 0.5, quick=()),
    Bench("mesh_orders.py", "order of convergence of a scene", 5),
    Bench("scene_tables.py", "meshes, slip torque, load steps, layers, balance", 6, record="*_study"),
    Bench("kinematics_map.py", "small against large displacements", 4),
    Bench("drive_kinematics.py", "small against large displacements of whole drives", 6),
    Bench("newton_history.py", "residual over Newton iterations", 2),
    Bench("numerical_parameters.py", "results over numerical parameters", 10),
    Bench("random_scenes.py", "random scenes: converged or refused", 5, quick=("--count", "60")),
    Bench("promised_scenes.py", "planned tolerances kept or not", 90, full=("--seed", "2716", "--count", "200", "--seconds", "5400")),
    Bench("promised_drives.py", "planned whole drives, kept or not", 60, full=("--seed", "3601", "--count", "60", "--seconds", "3600")),
    Bench("attack_files.py", "damaged files, pairs of runs, kills", 5),
    Bench("attack_api.py", "random arguments of the Python functions", 5),
    Bench("worker_threads.py", "threads of a study's workers", 1.5),
    Bench("limits.py", "breaking points of the contact solver", 2),
    Bench("coupled_law.py", "Eq. 45 beside the coupled joint", 3),
    Bench("paper_comparison.py", "the paper's figures and trends", 15),
    Bench("tooth_causes.py", "K_FTS and the catalogue", 3),
    Bench("joint_law.py", "the joint law beside boundary elements", 5, full=("judge",)),
    Bench("joint_choice.py", "theory or boundary elements: rule, few points, contacts", 25),
    Bench("joint_scenes.py", "the choice of the joint's model in scenes, beside boundary elements", 5),
    Bench("joint_causes.py", "the joint law: bias or scatter, k_T/k_N over the contact", 15),
    Bench("joint_second.py", "boundary elements beside ContactMechanics", 0.3),
    Bench("joint_shear.py", "shear with friction beside the law", 15),
    Bench("joint_measured.py", "measured joints beside the law", 0.1, quick=()),
    Bench("joint_models.py", "K_TS by each model of the joint", 8),
    Bench("which_k_ts.py", "K_TS in every reading", 10),
    Bench("explained.py", "tables of the explaining pages and of the README", 3),
    Bench("cam_orders.py", "ellipse and cosine in small and large displacements", 1),
    Bench("ring_model.py", "a shell model beside the coarsest mesh", 0.3),
    Bench("edge_cycles.py", "short edge cells: settled or in a cycle", 10),
    Bench("joint_band.py", "band of K_TS with two maps", 3),
    Bench("drive_catalogue.py", "the whole drive beside the catalogue", 11),
    Bench("tooth_gaps.py", "clearances from the tooth profile in the loop", 1),
    Bench("drive_turning.py", "angle error and ripple over a turn", 20),
    Bench("random_drives.py", "random whole drives: converged or refused", 31),
    Bench("fit_statistics.py", "fits of D and G over seeds", 3),
    Bench("blind_fit.py", "the fit told nothing, on maps not ours", 30),
    Bench("fit_bound.py", "what a map can tell of D at best", 0.1, full=("blind",)),
    Bench("lay.py", "grooves beside jitter", 1),
    Bench("wrong_points.py", "wrong points, seams and jitter of maps", 12),
    Bench("regressions.py", "instructions of a dozen small runs", 2, full=("--record",), quick=()),
    Bench("page_figures.py", "figures that the package draws by itself", 0.5),
    Bench("sensitivity.py", "what K_TS depends on", 10),
    Bench("tangent_indices.py", "Sobol indices of the tangent", 15),
)


ASIDE = {  # scripts that need what the checkout lacks, or make data
    "areal_numbers": "needs measured maps and Gwyddion's libraries", "joint_patch": "needs measured maps", "measured_surfaces": "needs measured maps",
    "premises_table": "needs a tree of commit c6eee82", "joint_bem": "refits data/joint_calibration.json", "torque_record": "writes data/torque_record.csv"}


def records_of(bench):
    """Paths of a bench's records."""
    return sorted(RESULTS.glob(f"{bench.record or bench.name}.json*"))


def made_of(path):
    """Commits that a record names, the latest first, "" if none."""
    text = path.read_text()
    whole = json.loads(text.splitlines()[-1] if path.suffix == ".jsonl" else text)
    origin = whole.get("provenance", {}) if isinstance(whole, dict) else {}
    return [origin.get("commit", ""), *origin.get("earlier", {}).values()]


def changes_since(commit):
    """Commits that changed the engine or its package since one; None if it is not known here."""
    if not commit:
        return None
    done = subprocess.run(["git", "-C", ROOT, "rev-list", "--count", f"{commit.rstrip('+')}..HEAD", "--", "fortran", "python"],
                          capture_output=True, text=True)
    return int(done.stdout) if done.returncode == 0 else None


def age(bench):
    """Words on the age of a bench's oldest record."""
    commits = [commit for path in records_of(bench) for commit in made_of(path)]
    if not commits:
        return "no record"
    counts = {commit: changes_since(commit) for commit in commits}
    unknown = [commit for commit, count in counts.items() if count is None]
    if unknown:
        return f"{unknown[0][:8]}, not in this history" if unknown[0] else "commit not stated"
    commit = max(counts, key=counts.get)
    if counts[commit] == 0 and not any(c.endswith("+") for c in commits):
        return "of the present sources"
    return f"{counts[commit]} change{'s' if counts[commit] != 1 else ''} since {commit[:8]}"


def known():
    """Benchmarks by their name on the command line."""
    return {b.name if b.name != "run" else "court": b for b in BENCHES}


def ages():
    """A Markdown table of all benchmarks and how old their records are, and the scripts beside them."""
    return table(("benchmark", "what it measures", "minutes", "record"), [(name, b.what, f"{b.minutes:g}", age(b)) for name, b in known().items()]) + \
        "\n\nCalled by themselves: " + ", ".join(f"`bench/{name}.py` ({why})" for name, why in ASIDE.items()) + "."


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    for option in ("quick", "list", "again"):
        parser.add_argument(f"--{option}", action="store_true")
    options = parser.parse_args()
    for name in options.names:
        if name not in known():
            parser.error(f"no benchmark '{name}'; valid: {', '.join(known())}")
    if options.list:
        print(ages())
        return
    failed = []
    for name, bench in known().items():
        if (options.names and name not in options.names) or (options.quick and not options.names and bench.quick is None):
            continue
        if not options.names and not options.again and not options.quick and age(bench) == "of the present sources":
            print(f"{name}: its record is of the present sources")
            continue
        words = bench.quick if options.quick and bench.quick is not None else bench.full
        print(f"{name}: {bench.what}", flush=True)
        start = time.time()
        done = subprocess.run([sys.executable, HERE / bench.script, *words], cwd=ROOT, stdout=subprocess.DEVNULL)
        print(f"{name}: {'done' if done.returncode == 0 else 'FAILED'} in {time.time() - start:.0f} s", flush=True)
        failed += [name] if done.returncode else []
    for words in (["evidence_tables.py"], ["explained.py", "--tables"]):
        subprocess.run([sys.executable, HERE / words[0], *words[1:]], cwd=ROOT)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
