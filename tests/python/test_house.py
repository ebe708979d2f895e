# SPDX-License-Identifier: GPL-3.0-or-later
"""The layout keeps its own rules."""
import ast
import re
import shutil
import subprocess
import sys
import warnings

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))
import made_pages  # noqa: E402

# Wings, with the wings that each may use (the build gives it no others), and in each its rooms, lowest first.
WINGS = {"common": (), "surface": ("common",), "contact": ("common",), "drive": ("common", "surface", "contact")}
ROOMS = {"common": [["base"], ["io", "lib"]], "surface": [["generate", "fit"], ["run"]],
         "contact": [["elements"], ["interface"], ["problem"], ["solvers"], ["solid"]],
         "drive": [["joint", "scene"], ["model"], ["results"], ["run"], ["plan"]]}
FLOOR = {(wing, room): floor for wing, floors in ROOMS.items() for floor, rooms in enumerate(floors) for room in rooms}
MOST_FILES, MOST_LINES = 15, 450
PACKAGE = ROOT / "python/hdengine"
PYTHON_FLOORS = [["_engine", "_types", "_keys"], ["_check"], ["files"], ["torsion", "table_file", "summary_file", "catalogue", "smoothing", "mesh"], ["paper", "solid", "views"], ["figures"], ["joint"],
                 ["elastic"], ["results"], ["contact", "record"], ["surfaces", "studies", "teeth"], ["prediction", "drive"],
                 ["uncertainty", "completion"], ["report", "export"], ["cli"], ["__main__"],
                 ["__init__"]]
PYTHON_FLOOR = {room: floor for floor, rooms in enumerate(PYTHON_FLOORS) for room in rooms}
SOURCES = sorted((ROOT / "fortran").rglob("*.f90"))


def place(path):
    """Wing and room of a source."""
    return path.relative_to(ROOT / "fortran").parts[:-1]


def looks_down(here, there):
    """What stands here may use what stands there: in its room, on a lower floor of its wing, in a wing below; app and bindings all."""
    if here[0] != there[0]:
        return here[0] not in WINGS or there[0] in WINGS[here[0]]
    return here == there or FLOOR[there] < FLOOR[here]


ROOM = {p.stem: place(p) for p in SOURCES} | {"hd_version": ("common", "base")}
ALL = SOURCES + sorted((ROOT / "fortran").rglob("*.c")) + sorted((ROOT / "python").rglob("*.py"))


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.stem)
def test_floors_look_down(path):
    """A module uses its own room, lower floors of its wing and wings below; rooms of one floor never use each other."""
    for used in re.findall(r"^\s*use\s+(hd_\w+)", path.read_text(), re.M):
        assert looks_down(place(path), ROOM[used]), f"{path.name} uses {used} ({ROOM[used]})"


@pytest.mark.parametrize("path", [p for p in (ROOT / "fortran").rglob("*") if p.suffix in (".c", ".h", ".inc", ".f90")],
                         ids=lambda p: p.name)
def test_includes_look_down(path):
    """An included file of the project stands in the same room, on a lower floor or in a wing below."""
    for used in re.findall(r"""^\s*#?include\s+["']([^"']+)["']""", path.read_text(), re.M):
        other = (path.parent / used).resolve()
        if other.exists():
            assert looks_down(place(path), place(other)), f"{path.name} includes {used}"


def python_room(path):
    """Folder of a module of the package, or the module itself where it stands in none."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imports(path):
    """Imports from the package in a module, inside of functions too; not those of names that stand in annotations alone."""
    tree = ast.parse(path.read_text())
    typed = {node for branch in tree.body if isinstance(branch, ast.If) and ast.unparse(branch.test) == "TYPE_CHECKING" for node in branch.body}
    return [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level and node not in typed]


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: "/".join(p.relative_to(PACKAGE).parts))
def test_python_looks_down(path):
    """A Python module imports from lower floors and its own folder alone, inside of functions too."""
    room, here = python_room(path), ("hdengine", *path.relative_to(PACKAGE).parts[:-1])
    for node in imports(path):
        base = [*here[:len(here) - node.level + 1], *(node.module.split(".") if node.module else [])]
        for target in base[1:2] or [alias.name for alias in node.names]:
            if target not in (room, "_hdengine"):
                assert PYTHON_FLOOR[target] < PYTHON_FLOOR[room], f"{path.name} ({room}) imports {target}"


def imported(path):
    """Modules of its own folder that a module imports."""
    names = set()
    for node in imports(path):
        if node.level == 1:
            names |= {node.module.split(".")[0]} if node.module else {alias.name for alias in node.names}
    return {name for name in names if (path.parent / f"{name}.py").exists()}


@pytest.mark.parametrize("folder", [p for p in PACKAGE.rglob("*") if (p / "__init__.py").exists()], ids=lambda p: p.name)
def test_no_circle_inside_a_folder(folder):
    """Modules of one folder import each other one way."""
    below = {p.stem: imported(p) for p in folder.glob("*.py")}
    while free := {name for name, needs in below.items() if not needs & set(below)}:
        below = {name: needs for name, needs in below.items() if name not in free}
    assert not below, f"a circle through {', '.join(sorted(below))}"


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: "/".join(p.relative_to(PACKAGE).parts))
def test_public_functions_say_their_types(path):
    """Every public function and method of the package annotates its arguments and what it gives; `Any` only what is passed on."""
    if path.stem.startswith("_") and path.stem != "_engine":
        return
    tree = ast.parse(path.read_text())
    public = [node for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
    for owner in (tree, *public):
        for f in owner.body:
            if isinstance(f, ast.FunctionDef) and (not f.name.startswith("_") or f.name == "__init__"):
                given = [*f.args.posonlyargs, *f.args.args, *f.args.kwonlyargs, f.args.vararg, f.args.kwarg]
                bare = [a.arg for a in given if a and a.annotation is None and a.arg not in ("self", "cls")]
                assert f.returns is not None and not bare, (f.name, bare)
                vague = [a.arg for a in given if a and a is not f.args.kwarg and a.annotation is not None
                         and ast.unparse(a.annotation) == "Any"]
                assert not vague, f"{f.name} says nothing about {', '.join(vague)}"


def test_sizes_are_told():
    """A room of more than fifteen modules and a module of more than 450 lines are worth a look: warnings, no failures, for a module
    is one noun, whatever its length."""
    rooms = [PACKAGE, *(p for p in PACKAGE.iterdir() if (p / "__init__.py").exists()), *(p.parent for p in SOURCES)]
    for room in sorted(set(rooms)):
        count = len([p for p in room.iterdir() if p.suffix in (".py", ".f90", ".c", ".inc")])
        if count > MOST_FILES + 2 * (room == PACKAGE):  # __init__ and __main__
            warnings.warn(f"{room.relative_to(ROOT)} holds {count} modules", stacklevel=1)
    for path in ALL:
        if (count := len(path.read_text().splitlines())) > MOST_LINES:
            warnings.warn(f"{path.relative_to(ROOT)} has {count} lines", stacklevel=1)
    assert len(set(rooms)) > 10 and len(ALL) > 200


@pytest.mark.parametrize("path", ALL, ids=lambda p: p.stem)
def test_files_are_licensed(path):
    """Each file names its licence, none has a line above 132 characters."""
    lines = path.read_text().splitlines()
    assert "SPDX-License-Identifier: GPL-3.0-or-later" in lines[0]
    assert max(map(len, lines)) <= 132


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.stem)
def test_uses_name_what_they_take(path):
    """Every `use` has its `only` list."""
    for line in re.findall(r"^\s*use\b.*", path.read_text(), re.M):
        assert "only:" in line, line


@pytest.mark.parametrize("path", [p for p in SOURCES if place(p)[0] == "surface"],
                         ids=lambda p: p.stem)
def test_points_of_maps_are_counted_in_64_bits(path):
    """No size or count of a whole map is a default integer, which overflows above 2^31 points."""
    assert not re.findall(r"\b(?:size|count)\((?:z|flat|map|good|hole|bad|all_bad|known|mask|raw|mock|heights)\)", path.read_text())


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.stem)
def test_procedures_are_short(path):
    """No procedure takes more than 80 lines, from its first to its last."""
    begun = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if re.match(r"\s*end\s+(subroutine|function)\b", line):
            name, first = begun.pop()
            assert number - first < 80, f"{name}: {number - first + 1} lines"
        elif found := re.match(r"\s*(?:[a-z][\w()=,* ]*\s)?(?:subroutine|function)\s+(\w+)\s*(?:\(|$)", line):
            begun.append((found[1], number))
    assert begun == []


def test_types_have_names_of_their_own():
    """No two modules define a type of one name."""
    names = [name for path in SOURCES for name in re.findall(r"^\s*type(?:\s*,[^:\n]*)?\s*::\s*(\w+)$", path.read_text(), re.M)]
    assert len(names) > 100 and len(names) == len(set(names)), sorted(name for name in set(names) if names.count(name) > 1)


COMMON = (0, 0.5, 1, 2)   # numbers that need no name


def compared(path):
    """Real numbers that stand in comparisons of a source: beside the sign in Fortran, anywhere between in Python."""
    if path.suffix == ".py":
        found = [c for x in ast.walk(ast.parse(path.read_text())) if isinstance(x, ast.Compare) for c in ast.walk(x) if isinstance(c, ast.Constant)]
        return [c.value for c in found if isinstance(c.value, float)]
    text = re.sub(r"'[^'\n]*'|\"[^\"\n]*\"|!.*", "", path.read_text())
    return [float(x) for x in re.findall(r"(?:[<>]=?|[/=]=)\s*((?:\d+\.\d*|\.\d+|\d+(?=e))(?:e[-+]?\d+)?)", text)]


@pytest.mark.parametrize("path", [p for p in ALL if p.suffix != ".c" and p.parent.name not in ("figures", "report")],
                         ids=lambda p: "/".join(p.relative_to(ROOT).parts[1:]))
def test_bounds_have_names(path):
    """A real number that something is compared with has a name, and a reason beside it; drawings measure by eye."""
    assert [x for x in compared(path) if x not in COMMON] == []


def test_supports_are_asked():
    """Python asks the engine what holds of a support (hd_support) and compares no names of supports."""
    for path in (ROOT / "python").rglob("*.py"):
        assert not re.search(r"""load\.support["'][\])]*,? *(==|!=|(not )?in [\["'(])""", path.read_text()), path


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.stem)
def test_formats_hold_no_small_i(path):
    """Integers are written by I: the compiler's library compares capitals, and in a Turkish locale that of i is another letter."""
    assert not re.findall(r"'\([^']*[(,\d]i\d", path.read_text())


def test_main_is_short():
    """The main program stays under 50 lines."""
    assert len((ROOT / "fortran/app/main.f90").read_text().splitlines()) < 50


@pytest.mark.parametrize("path", [p for p in SOURCES if p.parent.name != "app"], ids=lambda p: p.stem)
def test_library_neither_stops_nor_prints(path):
    """Only the application stops, prints or reads arguments; the log is the one place that writes to the screen."""
    text = re.sub(r"!.*", "", path.read_text())
    assert not re.search(r"^\s*(error\s+)?stop\b|^\s*print\b|get_command_argument", text, re.M | re.I)
    assert "output_unit" not in text and not re.search(r"write\s*\(\s*(\*|6)\s*,", text)


def test_foreign_headers_stay_in_lib():
    """MUMPS and METIS are named in their adapters only."""
    for path in SOURCES:
        if path.parent.name != "lib":
            assert "dmumps_struc" not in path.read_text() and "METIS_NodeND" not in path.read_text()


def test_only_the_engine_module_imports_the_extension():
    """One door to the Fortran code."""
    for path in PACKAGE.rglob("*.py"):
        if path.name != "_engine.py":
            assert "import _hdengine" not in path.read_text()


def test_readme_opens_with_two_commands():
    """The first code block of the README holds exactly the two commands that .ci/run and a new user call."""
    block = re.search(r"```\w*\n(.*?)```", (ROOT / "README.md").read_text(), re.S).group(1)
    assert block.splitlines() == ["./hd run", "./hd test"]
    assert "./hd test" in (ROOT / ".ci/run").read_text()


@pytest.mark.skipif(not all(shutil.which(p) for p in ("gcc", "gfortran")), reason="needs the compilers")
def test_hd_names_what_another_linux_lacks(tmp_path):
    """Without dpkg `./hd` ends with code 2 and names what it does not find, libraries that are there left out, and how four kinds of
    systems install it."""
    for name in ("sh", "dirname", "cat", "gcc", "gfortran", "as", "ld", "python3"):
        (tmp_path / name).symlink_to(shutil.which(name))
    for flags, missing in (("", "pkg-config"), ("-m32", "pkg-config MUMPS(sequential) metis openblas fftw3 fftw3f")):
        done = subprocess.run([ROOT / "hd", "setup"], env={"PATH": str(tmp_path), "LDFLAGS": flags}, capture_output=True, text=True)
        assert done.returncode == 2 and f"error: not found: {missing}. Install" in done.stderr, done.stderr
        assert all(f"\n  {system} " in done.stderr for system in ("Fedora", "SUSE", "conda", "modules"))


@pytest.mark.parametrize("page", sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").rglob("*.md")
                                        if p.parent.name not in ("start", "howto")))
def test_python_blocks_run(page, tmp_path, monkeypatch):
    """Every Python block of the docs runs as it stands; those of README, start and howto in test_pages.py."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").symlink_to(ROOT / "data")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)
    space = {}
    for block in blocks:
        exec(compile(block, page, "exec"), space)


def test_links_lead_somewhere():
    """Every relative link in the README and in the docs names a file that exists, or one that the build of the site writes: it checks
    those."""
    made = [ROOT / "docs/gallery", ROOT / "docs/reference/api", *(made_pages.FOLDER / f"{name}.md" for name in made_pages.PAGES)]
    for page in (ROOT / "README.md", *(p for p in (ROOT / "docs").rglob("*.md") if not set(made) & set(p.parents))):
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            path = (page.parent / target).resolve()
            assert target.startswith("http") or path.exists() or set(made) & {path, *path.parents}, (page.name, target)


def test_every_equation_has_its_procedure():
    """Eq. 1 to 46 of the paper are each tagged at a procedure that computes them."""
    import equation_map
    assert sorted(equation_map.places()) == list(range(1, 47))
    assert [n for part in equation_map.WHAT for n in equation_map.numbers(part)] == list(range(1, 47))


def test_every_test_says_what_it_requires():
    """Every Python test says in its docstring what it requires, in sentences."""
    found = [(path.name, f.name, ast.get_docstring(f) or "") for path in (ROOT / "tests/python").glob("test_*.py")
             for f in ast.parse(path.read_text()).body if isinstance(f, ast.FunctionDef) and f.name.startswith("test_")]
    assert len(found) > 400
    assert [(file, name) for file, name, said in found if not (said.endswith(".") and len(said.split()) > 3)] == []
