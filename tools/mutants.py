# SPDX-License-Identifier: GPL-3.0-or-later
"""Which one-line errors the tests see: python tools/mutants.py FOLDER [--count 160] [--seed 1] [--minutes 60] [--of FOLDER]

A copy of HEAD in FOLDER gets all mutants at once, each behind a switch, so that one build serves all: `x = a + b` becomes
`if (mutated(7)) then; x = a - b; else; x = a + b; end if`. A first pass of the tests notes which mutants each test reaches; a mutant
then runs the tests that reach it until one fails: first the quick ones, those of its subject and those that killed others. All mutants have
their first seconds of tests before one has more. Mutants are drawn by rule: every room in turn, a line at random in it, a change at random of
those that it allows. The outcome goes to tools/mutants.json; what that calls harmless is not run again. Begun again in its FOLDER it goes on.
With --of it takes the mutants of an earlier FOLDER, as far as HEAD has their lines: to see what tests written since then see.
Needs ./hd test once.
"""
import argparse
import ast
import json
import os
import random
import re
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PLACES = 4096      # mutants that the switch has room for
SLOW = {"test_house", "test_pages", "test_site", "test_regressions", "test_slurm", "test_version"}  # of sources, pages and machines
PATIENCE = 20, 100, 500, 3000   # seconds of tests of one mutant, in rounds
CHANGES = [(r" \+ ", " - "), (r" - ", " + "), (r"(?<=[\w)])\*(?=[\w(])", "/"), (r"(?<=[\w)])/(?=[\w(])", "*"), (r" < ", " <= "),
           (r" > ", " >= "), (r" <= ", " < "), (r" >= ", " > "), (r" == ", " /= "), (r" /= ", " == "), (r"\.and\.", ".or."),
           (r"\.or\.", ".and."), (r"\bmin\(", "max("), (r"\bmax\(", "min("), (r"\bsin\(", "cos("), (r"\bcos\(", "sin("),
           (r"\.true\.", ".false."), (r"\.false\.", ".true."), (r"\b(\d+\.\d*(?:e-?\d+)?_dp)", r"(1.1_dp*\1)")]
PAIRS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.Lt: "<=", ast.Gt: ">=", ast.LtE: "<", ast.GtE: ">", ast.Eq: "!=",
         ast.NotEq: "==", ast.And: "or", ast.Or: "and"}
SWITCH_F90 = """module hd_mutants
  use, intrinsic :: iso_c_binding, only: c_bool, c_int
  implicit none
  interface
    pure logical(c_bool) function mutated(n) bind(c, name='hd_mutated')
      import :: c_bool, c_int
      integer(c_int), value, intent(in) :: n
    end function mutated
  end interface
end module hd_mutants
"""
SWITCH_C = """#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/mman.h>
static int chosen = -1;
static char *reached;
__attribute__((constructor)) static void begin(void) {
  const char *n = getenv("HDENGINE_MUTANT"), *path = getenv("HDENGINE_REACHED");
  if (n) chosen = atoi(n);
  int file = path ? open(path, O_RDWR) : -1;
  if (file >= 0) reached = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (reached == MAP_FAILED) reached = NULL;
}
bool hd_mutated(int n) { if (reached) reached[n] = 1; return n == chosen; }
"""
SWITCH_PY = """import mmap, os
_chosen, _file = int(os.environ.get("HDENGINE_MUTANT", -1)), os.environ.get("HDENGINE_REACHED")
_reached = mmap.mmap(os.open(_file, os.O_RDWR), 4096) if _file else None
def mutated(n):
    if _reached is not None:
        _reached[n] = 1
    return n == _chosen
"""

REACHED_PY = """import json, mmap, os, pytest
_first, _setup, _found = set(), {}, []
_all = mmap.mmap(os.open(os.environ["HDENGINE_REACHED"], os.O_RDWR), 4096) if "HDENGINE_REACHED" in os.environ else None
def taken():
    found = {n for n in range(4096) if _all[n]}
    _all[:] = bytes(4096)
    return found
if _all is not None:
    def pytest_collection_finish(session):
        _first.update(taken())  # by imports: all tests
    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_makereport(item, call):
        outcome = yield
        if call.when == "setup":  # by fixtures, which tests may share: all tests of the file
            _setup.update({n: 0 for n in taken()})
            item.seconds = call.duration
        elif call.when == "call" and outcome.get_result().passed:
            _found.append((item.nodeid, item.seconds + call.duration, taken()))
    def pytest_sessionfinish():
        told = [(name, seconds, sorted(reached | _first | set(_setup))) for name, seconds, reached in _found]
        with open(os.environ["HDENGINE_TOLD"], "w") as file:
            json.dump(told, file)
"""


def fortran_mutants(text):
    """(line, original, mutated, lines that hold both) of every change that a Fortran module allows."""
    lines, found, masked, inside = text.splitlines(), [], False, False
    for i, line in enumerate(lines):
        code = line.split("!")[0].rstrip() if "'" not in line else line
        word = code.strip()
        inside = inside or word == "contains"
        if re.match(r"(where|forall) ?\(", word) and word.endswith(")"):
            masked = True
        if re.match(r"end (where|forall)", word):
            masked = False
        if not inside or masked or "&" in code or (i and "&" in lines[i - 1]) or "'" in code or "::" in code or "!" in line \
                or re.match(r"(\w+: )?do ", word):
            continue
        block = re.fullmatch(r"(\s*)(if|else if) \((.*)\) then", code)
        plain = re.fullmatch(r"(\s*)([a-z][\w%(),: +*-]* = [^>].*)", code) or re.fullmatch(r"(\s*)(if \(.*\) (?!then).*)", code)
        if not (block or plain):
            continue
        for pattern, new in CHANGES:
            for hit in re.finditer(pattern, code):
                other = code[:hit.start()] + hit.expand(new) + code[hit.end():]
                if re.search(r"\b(\w+)( [+-] \d)?:\1 - \d", other):  # a section of no length, which compilers refuse
                    continue
                if block:
                    pad, kind, old = block.groups()
                    changed = other[block.start(3):-len(") then")]
                    both = f"{pad}{kind} (merge(1, 0, {{on}}) == 1 .and. ({changed}) .or. merge(1, 0, {{on}}) == 0 .and. ({old})) then"
                else:
                    pad = plain[1]
                    both = f"{pad}if ({{on}}) then\n{other}\n{pad}else\n{code}\n{pad}end if"
                found.append((i, code.strip(), other.strip(), both))
    return found


def python_mutants(text):
    """The same of a Python module: the expression becomes a conditional one."""
    lines, found = text.splitlines(), []
    tree = ast.parse(text)
    left_out = {id(n) for f in ast.walk(tree) if isinstance(f, (ast.JoinedStr, ast.AnnAssign)) or getattr(f, "annotation", None)
                for n in ast.walk(f if isinstance(f, ast.JoinedStr) else getattr(f, "annotation", f))}
    bodies = [f for f in ast.walk(tree) if isinstance(f, ast.FunctionDef)]
    for node in (n for f in bodies for s in f.body for n in ast.walk(s)):
        if id(node) in left_out or getattr(node, "lineno", 0) != getattr(node, "end_lineno", -1):
            continue
        if isinstance(node, ast.BinOp) and type(node.op) in PAIRS:
            ends, sign = (node.left, node.right), PAIRS[type(node.op)]
        elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in PAIRS:
            ends, sign = (node.left, node.comparators[0]), PAIRS[type(node.ops[0])]
        elif isinstance(node, ast.BoolOp) and len(node.values) == 2:
            ends, sign = tuple(node.values), PAIRS[type(node.op)]
        else:
            continue
        i, line = node.lineno - 1, lines[node.lineno - 1]
        if not line.isascii():
            continue
        old = line[node.col_offset:node.end_col_offset]
        new = f"({ast.unparse(ends[0])}) {sign} ({ast.unparse(ends[1])})"
        both = f"{line[:node.col_offset]}(({new}) if {{on}} else ({old})){line[node.end_col_offset:]}"
        found.append((i, old, new, both))
    return found


def drawn(count, seed):
    """The mutants: rooms in turn, a line and a change at random; no line twice."""
    rooms, lot = {}, random.Random(seed)
    for path in subprocess.run(["git", "ls-files", "fortran", "python"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split():
        text = (ROOT / path).read_text()
        if path.endswith(".f90") and re.search(r"^module ", text, re.M) and "/f2py_" not in path:
            found = fortran_mutants(text)
        elif path.endswith(".py") and "from __future__" in text and path != "python/typed_keys.py":  # which the build runs
            found = python_mutants(text)
        else:
            continue
        rooms.setdefault(os.path.dirname(path), {}).update({(path, m[0]): [] for m in found})
        for m in found:
            rooms[os.path.dirname(path)][path, m[0]].append(m)
    chosen, names = [], sorted(name for name in rooms if rooms[name])
    while len(chosen) < count:
        for name in names:
            if rooms[name] and len(chosen) < count:
                place = lot.choice(sorted(rooms[name]))
                chosen.append({"file": place[0], "line": place[1] + 1, **dict(zip(("old", "new", "both"), lot.choice(rooms[name].pop(place))[1:]))})
    return chosen


def found_again(folder):
    """The mutants of an earlier folder whose lines HEAD still has, each at the place nearest to its own."""
    found = []
    for m in json.loads((folder / "state.json").read_text())[2]:
        text = (ROOT / m["file"]).read_text() if (ROOT / m["file"]).exists() else ""
        same = [(abs(i + 1 - m["line"]), i + 1, both) for i, old, new, both in (fortran_mutants if m["file"].endswith(".f90") else python_mutants)(text)
                if (old, new) == (m["old"], m["new"])]
        if same:
            found.append({"file": m["file"], "line": min(same)[1], "old": m["old"], "new": m["new"], "both": min(same)[2]})
    return found


def build(folder, mutants):
    """A copy of HEAD with all mutants, installed into folder/site."""
    tree = folder / "tree"
    tree.mkdir(parents=True)
    subprocess.run(f"git archive HEAD | tar -x -C '{tree}'", shell=True, cwd=ROOT, check=True)
    by_file = {}
    for n, m in enumerate(mutants):
        by_file.setdefault(m["file"], []).append((m["line"], n, m["both"]))
    for name, places in by_file.items():
        path = tree / name
        lines = path.read_text().splitlines()
        for line, n, both in places:
            lines[line - 1] = both.replace("{on}", f"mutated({n})")
        text = "\n".join(lines) + "\n"
        head, use = ((r"^(module \w+)$", r"\1\n  use hd_mutants, only: mutated") if name.endswith(".f90") else
                     (r"^(from __future__ import annotations)$", r"\1\nfrom hdengine._mutants import mutated"))
        path.write_text(re.sub(head, use, text, count=1, flags=re.M))
    base = tree / "fortran/common/base"
    (base / "hd_mutants.f90").write_text(SWITCH_F90)
    (base / "hd_mutants_switch.c").write_text(SWITCH_C)
    with open(base / "meson.build", "a") as file:
        file.write("srcs += files('hd_mutants.f90', 'hd_mutants_switch.c')\n")
    rules = tree / "config/meson.build"
    rules.write_text(rules.read_text().replace(", '-ffree-line-length-132'", "").replace(
        "add_project_arguments(", "add_project_arguments('-ffree-line-length-none', "))
    env = os.environ | {"PATH": f"{ROOT}/.venv/bin:{os.environ['PATH']}"}
    while (done := subprocess.run([ROOT / ".venv/bin/python", "-m", "pip", "install", "-q", "--disable-pip-version-check", "--no-deps", "--no-build-isolation",
                                   "--upgrade", "--target", folder / "site", f"--config-settings=build-dir={folder}/build",
                                   "--config-settings=compile-args=-k0", tree], capture_output=True, text=True, env=env)).returncode:
        refused = set()
        for name, line in re.findall(r"/tree/(\S+\.f90):(\d+):\d+:(?:\n(?!.*/tree/).*){1,8}\n *Error:", done.stderr):
            near = "\n".join((tree / name).read_text().splitlines()[:int(line)])
            refused.add((name, int(re.findall(r"mutated\((\d+)\)", near)[-1])))
        if not refused or any("fate" in mutants[n] for _, n in refused):
            raise SystemExit(done.stderr[-3000:])
        for name, n in refused:  # a change that the compiler refuses is no mutant
            mutants[n]["fate"] = "refused"
            path = tree / name
            path.write_text(path.read_text().replace(mutants[n]["both"].replace("{on}", f"mutated({n})"), (ROOT / name).read_text().splitlines()[mutants[n]["line"] - 1]))
    subprocess.run(["ninja", "-C", folder / "build", "--quiet", "tests/fortran/hd_tester"], check=True, env=env)
    (folder / "site/hdengine/_mutants.py").write_text(SWITCH_PY)
    (folder / "mutants_reached.py").write_text(REACHED_PY)


def run(folder, tests, limit, **env):
    """The first test that fails ('' if none does), seconds, whether it may be of load alone: of the Fortran tests or of tests of Python."""
    command = [folder / "build/tests/fortran/hd_tester"] if tests == ["fortran"] else [
        ROOT / ".venv/bin/python", "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "mutants_reached",
        *([] if "HDENGINE_REACHED" in env else ["-x"]), *tests]
    start = time.monotonic()
    done = subprocess.run(["timeout", "-k", "5", str(int(limit)), *command], cwd=folder / "tree", stdout=subprocess.PIPE, errors="replace",
                          stderr=subprocess.DEVNULL, env=os.environ | {
                              "HDENGINE_EXE": f"{folder}/site/hdengine_x/hdengine.x", "PYTHONPATH": f"{folder}/site:{folder}",
                              "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"} | env)
    by = re.search(r"^(?:FAILED|ERROR) (tests/python/[\w.:]+)", done.stdout, re.M)
    return "" if done.returncode == 0 else by[1] if by else tests[0], time.monotonic() - start, re.search("Timeout|second", done.stdout) is not None


def survey(folder, count, files):
    """Of every test that passes without a mutant: its file, name, seconds, the mutants that it reaches."""
    def one(file):
        place, told = folder / f"{file}.reached", folder / f"{file}.json"
        place.write_bytes(bytes(PLACES))
        if file == "fortran":
            failed, seconds, _ = run(folder, [file], 900, HDENGINE_REACHED=str(place))
            tests = [[file, file, seconds, [n for n in range(count) if place.read_bytes()[n]]]] if not failed else []
        else:
            seconds = run(folder, [f"tests/python/{file}.py"], 900, HDENGINE_REACHED=str(place), HDENGINE_TOLD=str(told))[1]
            tests = [[file, *t] for t in json.loads(told.read_text())] if told.exists() else []
        print(f"{file}: {seconds:.0f} s, {len(tests)} tests", flush=True)
        return tests
    with ThreadPoolExecutor(2) as pool:
        # a test that closes its streams may write into the list of what is reached
        return [test for tests in pool.map(one, files) for test in tests if max(test[3], default=0) < count]


def order(m, files, kills):
    """Files of tests in the order in which they are tried: seconds over past kills, and over what the names share with the mutant's module."""
    def words(text):
        return {word[:5] for word in re.findall(r"[a-z]{3,}", text.lower())}
    subject = words(Path(m["file"]).stem)
    return sorted(files, key=lambda f: (2 + files[f][0]) / (1 + kills[f]) / (1 + 5 * len(subject & words(f" {f} ".join(files[f][1])))))


def tried(folder, n, m, tests, kills, patience, end):
    """Run what a mutant has not run yet of the tests that reach it until one kills it, none is left, or its time is over."""
    files = {}
    for file, name, seconds, reached in tests:
        if n in reached and file not in m["passed"]:
            known = files.setdefault(file, [0.0, []])
            known[0] += seconds
            known[1].append(name)
    queue = order(m, files, kills)
    while queue and m["spent"] < patience and time.monotonic() < end:
        batch, seconds = [], 0.0
        while queue and "fortran" not in batch and (not batch or queue[0] != "fortran" and seconds + files[queue[0]][0] < max(5, m["spent"])):
            seconds += files[queue[0]][0]
            batch.append(queue.pop(0))
        by, took, hurried = run(folder, [name for file in batch for name in files[file][1]], 3 * seconds + 30, HDENGINE_MUTANT=str(n))
        m["spent"] += took
        if by and not (hurried and "::" in by and run(folder, [by], 300)[0]):
            kills[Path(by.split("::")[0]).stem] += 1
            m.update(fate="killed", by=by)
            return
        if by:  # a test that fails without a mutant too, of load: without it
            for file in batch:
                files[file][1] = [name for name in files[file][1] if not name.startswith(by)]
            queue = [file for file in batch if files[file][1]] + queue
        else:
            m["passed"] += batch
    m["fate"] = "undecided" if queue else "survived"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=160)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--of", type=Path, help="folder of an earlier call")
    parser.add_argument("--draw", action="store_true", help="only print the mutants")
    args = parser.parse_args()
    folder, end = args.folder.resolve(), time.monotonic() + 60 * args.minutes
    mutants = found_again(args.of) if args.of else drawn(args.count, args.seed)
    if args.draw:
        for n, m in enumerate(mutants):
            print(f"{n} {m['file']}:{m['line']}: {m['old']}  ->  {m['new']}")
        return
    place, state = ROOT / "tools/mutants.json", folder / "state.json"
    past = json.loads(place.read_text())
    if state.exists():
        commit, tests, mutants = json.loads(state.read_text())
    else:
        commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
        build(folder, mutants)
        tests = survey(folder, len(mutants), ["fortran", *sorted(p.stem for p in (folder / "tree/tests/python").glob("test_*.py") if p.stem not in SLOW)])
        for m in mutants:
            m.update({"fate": "undecided", "spent": 0.0, "passed": []} | m)
        state.write_text(json.dumps([commit, tests, mutants]))
    kills = Counter(past["kills"])
    reasons = {(m["file"], m["old"], m["new"]): m["harmless"] for m in past["left"] if "harmless" in m}
    for m in mutants:
        if m["fate"] in ("undecided", "survived") and (told := (m["file"], m["old"], m["new"])) in reasons:
            m.update(fate="survived", harmless=reasons[told])  # by argument: no test is run

    def one(n, patience):
        m = mutants[n]
        tried(folder, n, m, tests, kills, patience, end)
        print(f"{n} {m['file']}:{m['line']}: {m['old']}  ->  {m['new']}: {m['fate']} {m.get('by', '')} {m['spent']:.0f} s", flush=True)
    for patience in PATIENCE:
        with ThreadPoolExecutor(2) as pool:
            left = [n for n, m in enumerate(mutants) if m["fate"] == "undecided" and m["spent"] < patience]
            for _ in pool.map(lambda n, patience=patience: one(n, patience), left):
                state.write_text(json.dumps([commit, tests, [dict(m) for m in mutants]]))
    mutants = [m for m in mutants if m["fate"] != "refused"]
    left = [{key: m[key] for key in ("file", "line", "old", "new", "fate", "harmless") if key in m} for m in mutants if m["fate"] != "killed"]
    fates = {fate: sum(m["fate"] == fate for m in mutants) for fate in ("killed", "survived", "undecided")}
    record = {"commit": commit, "seed": args.seed, "mutants": len(mutants), **fates, "left": left, "kills": Counter(Path(m["by"].split("::")[0]).stem for m in mutants if "by" in m)}
    place.write_text(json.dumps(record, indent=1) + "\n")
    print(f"of {len(mutants)}: {fates}")


if __name__ == "__main__":
    sys.exit(main())
