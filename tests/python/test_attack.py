# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrong arguments end with the package's errors: never with a raw error from inside, never with the end of the process."""
import importlib
import inspect
import json
import pkgutil
import random
import re
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pytest
from api_targets import targets

import hdengine
from conftest import ROOT, solved
from hdengine import catalogue, elastic, mesh, record, roughness, solid, specimen, surface, uncertainty
from hdengine.surfaces import texture
from hdengine.teeth import rim

hypothesis = pytest.importorskip("hypothesis")
st = hypothesis.strategies


TARGETS = {name: (function, arguments) for name, function, arguments in targets()}
numbers = st.one_of(st.floats(), st.integers(-(2**70), 2**70), st.booleans(), st.sampled_from([0, 1, -1, 1e-300, 1e300, 1j]))
words = st.one_of(st.text(max_size=5), st.binary(max_size=3), st.none())
shaped = st.tuples(st.lists(st.integers(0, 4), max_size=3), st.floats(), st.sampled_from(["f8", "i4", "U1", "O", "?"])).map(
    lambda t: np.full(t[0], t[1] if t[2] in ("f8", "O") else 1).astype(t[2]))
anything = st.one_of(numbers, words, shaped, st.recursive(st.one_of(numbers, words), lambda s: st.one_of(
    st.lists(s, max_size=4), st.tuples(s, s), st.dictionaries(st.text(max_size=3), s, max_size=2)), max_leaves=8))


@hypothesis.settings(max_examples=600, deadline=None, derandomize=True, database=None,
                     suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(st.sampled_from(sorted(TARGETS)), st.randoms(use_true_random=False), anything)
def test_any_argument_ends_well(tmp_path_factory, name, random, value):
    """Every public function that gets a random object for one argument answers, or raises an error of the package."""
    function, arguments = TARGETS[name]
    arguments = dict(arguments)
    key = random.choice(sorted(arguments))
    if key in ("count", "draws", "path") and not isinstance(value, (type(None), str)):
        value = None  # an honest long loop, or a number that is a file descriptor
    if key == "*":
        arguments["*"] = (*arguments["*"][:-1], value)
    else:
        arguments[key] = value
    with warnings.catch_warnings(), np.errstate(all="ignore"), pytest.MonkeyPatch.context() as patch:
        warnings.simplefilter("ignore")
        patch.chdir(tmp_path_factory.getbasetemp())
        try:
            function(*arguments.pop("*", ()), **arguments)
        except hdengine.InternalError:
            raise
        except hdengine.HdengineError as error:
            assert len(str(error)) > 5


def test_waves_without_digits_are_refused():
    """A wave number of 1e304 per metre ends with an error that names it: its phase on the grid has no digits."""
    with pytest.raises(hdengine.InputError, match="fx"):
        surface.sum_waves([1e304, 2e4, 3e4], [1e4, 2e4, 3e4], [1e-7] * 3, [.1, .2, .3], (16, 16), 1e-6, tolerance=1e-6, method="nufft")
    with pytest.raises(hdengine.InputError, match="fx"):
        surface.sum_waves([1e304], [1.0], [1e-7], [.1], (16, 16), 1e-6, origin=(1, 1e9), tolerance=1e-6, method="nufft")


@pytest.mark.parametrize("node, says", [(-1, "node -1"), (1000000, "node 1000000"), (1, "twice")])
def test_cells_that_name_wrong_nodes_are_refused(node, says):
    """A cell with a node that does not exist, or with one node twice, is refused before anything is read past its arrays."""
    part = mesh.block([0, 1, 2], [0, 1], [0, 1])
    cells = part.cells.copy()
    cells[0, 0] = cells[0, 1] if node == 1 else node
    with pytest.raises(hdengine.InputError, match=says):
        solid.static([solid.Body(mesh.Mesh(part.points, cells), 1.0, 0.3)], np.ones((12, 3), bool))


def test_facets_out_of_range_are_refused():
    """A contact facet that names a node outside of the chart is refused with its number."""
    with pytest.raises(hdengine.InputError, match="node 99"):
        solid.Face(np.array([[0, 1, 2, 99]]), np.zeros((4, 2)))


def test_specimens_hold_what_is_checked():
    """Shapes that do not fit, holes where none may be, and words for numbers name the argument."""
    for call, says in ((lambda: hdengine.Joint(friction="dry"), "friction = 'dry'"),
                       (lambda: hdengine.Joint().stiffness([1e6, np.nan]), r"pressure\[1\] = nan"),
                       (lambda: hdengine.Joint().stiffness([1e6] * 3, [1.0] * 2), r"pressure \(3,\), shear \(2,\)"),
                       (lambda: hdengine.specimen.Specimen(np.ones((3, 3)), "um"), "spacing = 'um'"),
                       (lambda: mesh.block([0, 1], [0, 1], [0, 1]).facets([[], 1]), "chosen is no array"),
                       (lambda: hdengine.read_scene("", load={"torque": object()}), "a key takes"),
                       (lambda: elastic.ElasticJoint([1e6], [1e12], [1e12]), "two or more"),
                       (lambda: elastic.contact_from_spectrum([1e4, 1e5], [1e-14, 1e-15], [0.0], 1e11), "above 0 and below"),
                       (lambda: elastic.contact_from_spectrum([1e4, 1e5], [1e-14, 1e-15], [2e9], 1e11, 2e9), "below the hardness"),
                       (lambda: hdengine.Study(grid={"load.torque": 3}), "must be a list")):
        with pytest.raises(hdengine.InputError, match=says):
            call()
    assert "from 1 to 20 MPa" in str(elastic.ElasticJoint([1e6, 2e7], [1e12, 2e12], [1e12, 2e12]))


def test_letters_beyond_ascii(tmp_path):
    """Paths and titles with letters beyond ASCII reach the engine and come back."""
    (tmp_path / "Wälzlager.nml").write_text("&run title = 'Prüfstand µ' /\n", encoding="utf-8")
    assert hdengine.read_scene(tmp_path / "Wälzlager.nml")["run.title"] == "Prüfstand µ"
    with pytest.raises(hdengine.FileError, match="Getriebe_ü"):
        hdengine.read_scene(tmp_path / "Getriebe_ü.nml")


def objects(small_run):
    """One object of each public class whose methods take arguments."""
    part, joint, z = mesh.block([0, 1, 2], [0, 1], [0, 1]), hdengine.Joint(), np.random.default_rng(1).normal(size=(30, 24)) * 1e-8
    turn = np.concatenate([np.linspace(0, 5, 20), np.linspace(5, -5, 40), np.linspace(-5, 5, 40)])
    bench, run, made = record.Record(turn, turn / 5e3 + 1e-9 * turn**2), hdengine.load(small_run), specimen.Specimen(z, 1e-6)
    steps = np.geomspace(1e5, 1e8, 9)
    return [part, joint, bench, bench.curve(draws=2), run, uncertainty.ContactField(run), made, made.fit(), texture.texture(made),
            elastic.ElasticJoint(steps, 1e6 * steps, 1e6 * steps), hdengine.Involute(4e-4), hdengine.DoubleArc(4e-4), catalogue.UNITS[14],
            rim.Rim.read(ROOT / "data/drive14.nml"), solid.Face(part.facets(part.points[:, 2] == 1), part.points[:, :2]),
            hdengine.Study(grid={"load.torque": [1, 2]}), roughness.Ridges(1e-4, 1e-6, 10, 1.5)]


def on_page():
    """(name, object) of the page of the Python interface."""
    for name in re.findall(r"^   ([\w.]+)$", (ROOT / "docs/reference/api.md").read_text(), re.M):
        module, _, last = f"hdengine.{name}".rpartition(".")
        yield name, getattr(importlib.import_module(module), last)


def test_public_names_are_those_of_the_page():
    """What a module gives to the public (`__all__`, or all functions and classes without an underscore) stands on the page of the Python interface."""
    known = [found for _, found in on_page()]
    for told in pkgutil.walk_packages(hdengine.__path__, "hdengine."):
        if any(part[0] == "_" for part in told.name.split(".")):
            continue
        module = importlib.import_module(told.name)
        names = getattr(module, "__all__", [n for n, o in vars(module).items() if getattr(o, "__module__", None) == told.name and n[0] != "_"])
        assert all(any(getattr(module, n) is o for o in known) for n in names), (told.name, names)


def public(small_run):
    """(name, function) of the functions, classes and methods on the page of the Python interface; without those that solve or draw."""
    held = {type(o): o for o in objects(small_run)}
    for name, found in on_page():
        if isinstance(found, type) and issubclass(found, BaseException):
            continue
        if name not in ("run", "as_built", "prediction.law.predict", "report.write_pdf"):
            yield name, found
        for part, raw in vars(found).items() if isinstance(found, type) else ():
            bound = isinstance(raw, classmethod) or (callable(raw) and found in held)
            if bound and not part.startswith("_") and part not in ("run", "plot", "report", "write"):
                yield f"{name}.{part}", getattr(held.get(found, found), part)


def test_every_public_name_checks_its_arguments(small_run, tmp_path, monkeypatch):
    """Whatever a public function, class or method gets for its arguments, it answers, or raises an error of the package."""
    monkeypatch.chdir(tmp_path)
    values = [None, -1, 2**31, 1.5, np.nan, 1e300, "x", "\0", b"x", [], [[1, 2], [3]], {1: 2}, np.ones((4, 4)), np.zeros((0, 3)),
              np.full(3, np.nan), np.array("s"), object(), 1j, slice(1), "a" * 256, "\ud800"]
    lot, raw, count = random.Random(1), [], 0
    for name, function in public(small_run):
        known = [p for p in inspect.signature(function).parameters.values() if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
        for _ in range(6 if known else 0):
            given = {p.name: lot.choice(values) for p in known if p.default is p.empty or lot.random() < 0.5}
            count += 1
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                try:
                    function(**given)
                except hdengine.InternalError:
                    raise
                except hdengine.HdengineError:
                    pass
                except Exception as error:
                    raw.append((name, given, error))
    assert count > 600 and not raw


def digits(path):
    """Change the last digit of a file that is a number's: it stays one that could have been found."""
    text = path.read_text()
    at = max(i for i, c in enumerate(text) if c.isdigit() and text[i - 1] in ".0123456789")
    path.write_text(text[:at] + ("1" if text[at] == "0" else "0") + text[at + 1:])


@pytest.fixture(scope="module")
def edited_drive(exe, tmp_path_factory):
    """A drive with every table that a run can leave."""
    run = tmp_path_factory.mktemp("edited") / "d"
    solved(exe, run, ROOT / "tests/cases/pressed_drive.nml", "mesh.divisions=24", "mesh.band_facets=4", "load.torque_steps=1", "run.band=.false.",
           "turning.positions=2")
    return run


@pytest.mark.parametrize("name", ["steps", "history", "contact", "loop", "balls", "teeth", "fatigue", "turning", "summary"])
def test_a_run_that_was_edited_is_no_result(edited_drive, tmp_path, name):
    """One digit changed in a table or in the summary, a row lost or a table of another run: an error that names the file, and no report is made."""
    assert hdengine.load(edited_drive).report(tmp_path / "right.html").exists()
    file = f"{name}.csv" if name != "summary" else "summary.json"

    def cut(path):
        lines = path.read_text().splitlines(keepends=True)
        path.write_text("".join([*lines[:1], *lines[2:]]))
    for i, edit in enumerate((digits, cut)):
        folder = shutil.copytree(edited_drive, tmp_path / f"r{i}")
        edit(folder / file)
        with pytest.raises(hdengine.FileError, match=f"{file}' is not (as the run left it|what hdengine writes)"):
            result = hdengine.load(folder)
            assert name == "contact" and result.contact or result.frame(name) is not None
        try:
            hdengine.load(folder).report(tmp_path / "r.html")
        except hdengine.FileError:
            assert not (tmp_path / "r.html").exists()
        else:
            assert name == "turning"   # of which it shows what the summary says


def test_tables_of_a_run_may_be_moved_but_not_lack_their_checksums(edited_drive, tmp_path):
    """A link in the place of a table, as of one in an archive, is read; a table that the run did not write, and a summary without checksums, are not."""
    folder = shutil.copytree(edited_drive, tmp_path / "r")
    shutil.move(folder / "contact.csv", tmp_path / "archive.csv")
    (folder / "contact.csv").symlink_to(tmp_path / "archive.csv")
    assert len(hdengine.load(folder).contact)
    found = json.loads((folder / "summary.json").read_text())
    del found["checksums"]["balls.csv"]
    (folder / "summary.json").write_text(json.dumps(found))
    with pytest.raises(hdengine.FileError, match="summary.json' is not as the run left it"):
        hdengine.load(folder)
    del found["checksum"]
    (folder / "summary.json").write_text(json.dumps(found))
    with pytest.raises(hdengine.FileError, match="has no checksums: .* run it again"):
        hdengine.load(folder)


def test_damaged_input_of_every_reader_ends_in_order():
    """`tools/fuzz.py` finds nothing in a few damaged files of each reader; so many that the suite does not wait for them."""
    done = subprocess.run([sys.executable, ROOT / "tools/fuzz.py", "--count", "52"], capture_output=True, text=True, timeout=200)
    assert done.returncode == 0 and done.stdout.endswith("52 executions of 13 readers, 0 wrong\n"), done.stdout + done.stderr


@pytest.mark.skipif(not (ROOT / "build/tests/fortran/hd_fuzz").exists(), reason="the readers stand alone in a build of this folder only")
def test_damaged_copies_in_one_process(tmp_path):
    """Of 2 000 damaged copies no Fortran reader makes a fault or an error without a word; some are read, most refused."""
    done = subprocess.run([sys.executable, ROOT / "tools/fuzz.py", "--count", "3", "--many", "2000"], capture_output=True, text=True, timeout=200, cwd=tmp_path)
    assert done.returncode == 0 and done.stdout.count(" copies, ") == 6, done.stdout + done.stderr
