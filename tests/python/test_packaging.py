# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipes of packaging/ ask for what pyproject.toml and config/meson.build ask for; what an index and a wheel show is whole."""
import re
import shutil
import subprocess
import sys

import pytest
import yaml

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))
import wheel_licences

try:
    import tomllib
except ImportError:
    import tomli as tomllib

with open(ROOT / "pyproject.toml", "rb") as _file:
    TOLD = tomllib.load(_file)
RECIPES = {name: (ROOT / "packaging" / name / file).read_text() for name, file in (
    ("apptainer", "hdengine.def"), ("conda", "recipe.yaml"), ("easybuild", "hdengine-foss-2025b.eb"), ("guix", "hdengine.scm"),
    ("spack", "packages/hdengine/package.py"))}
# What the recipes call a requirement of pyproject.toml, {} its least version. In Apptainer pip reads them from the sdist; Guix pins
# versions itself, and its meson-python brings meson and ninja; it and EasyBuild have a Python that needs no tomli.
PYTHON = {
    "python": {"spack": '"python@{}:"', "conda": "- python\n", "easybuild": "('Python', '{}')"},
    "meson-python": {"spack": '"py-meson-python@{}:"', "conda": "- meson-python >={}\n", "easybuild": "('meson-python', '{}')", "guix": "meson-python"},
    "meson": {"spack": '"meson@{}:"', "conda": "- meson >={}\n", "easybuild": "('Meson', '{}')"},
    "ninja": {"spack": '"ninja"', "conda": "- ninja\n", "easybuild": "('Ninja', '{}')"},
    "numpy": {"spack": '"py-numpy@{}:"', "conda": "- numpy >={}\n", "easybuild": "('SciPy-bundle', '2025.07')", "guix": "python-numpy"},
    "tomli": {"spack": '"py-tomli@{}:"', "conda": "tomli >={}\n"},
}
# The same for the libraries of config/meson.build; FFTW and FlexiBLAS are in EasyBuild's toolchain.
LIBRARIES = {
    "dmumps_seq": {"apptainer": "libmumps-seq-dev", "spack": '"mumps~mpi', "conda": "- mumps-seq\n", "easybuild": "('MUMPS', '{}', '-metis-seq')", "guix": " mumps "},
    "metis": {"apptainer": "libmetis-dev", "spack": '"metis@5:"', "conda": "- metis\n", "easybuild": "('METIS', '{}')", "guix": " metis "},
    "openblas": {"apptainer": "libopenblas-dev", "spack": '"lapack"', "conda": "- openblas\n", "easybuild": "-Dlapack=flexiblas", "guix": " openblas)"},
    "fftw3": {"apptainer": "libfftw3-dev", "spack": "precision=float,double", "conda": "- fftw\n", "easybuild": "'name': 'foss'", "guix": " fftw "},
    "fftw3f": {"guix": " fftwf "},
}
COMPILERS_OWN = {"openmp", "quadmath", "m"}


def asked(recipe, pattern, least):
    """Whether a recipe asks for a pattern with a version of at least this; without {} the pattern itself."""
    if recipe != "easybuild" or "{}" not in pattern:
        return pattern.format(least) in RECIPES[recipe]
    found = re.search(re.escape(pattern).replace(r"\{\}", r"([\d.]+)"), RECIPES[recipe])
    return found and [int(n) for n in found[1].split(".")] >= [int(n) for n in (least or "0").split(".")]


def test_recipes_ask_for_the_requirements():
    """Each recipe asks for each requirement of pyproject.toml by its name there, in the version that pyproject.toml says."""
    told = [f"python{TOLD['project']['requires-python']}", *TOLD["build-system"]["requires"], *TOLD["project"]["dependencies"]]
    needed = dict(re.match(r"([\w-]+)(?:>=([\d.]+))?", requirement).groups() for requirement in told)
    assert needed.keys() == PYTHON.keys()
    for name, least in needed.items():
        for recipe, pattern in PYTHON[name].items():
            assert asked(recipe, pattern, least), f"{recipe} does not ask for {name} {least}"


def test_recipes_ask_for_the_libraries():
    """Each recipe asks for each library that the build looks for, environment.yml for conda's, Apptainer for the packages of ./hd."""
    build = (ROOT / "config/meson.build").read_text()
    found = set(re.findall(r"(?:dependency|find_library)\('(\w+)'", build)) | {re.search(r"\[\['(\w+)'", build)[1], re.search(r"lapack_name = \{'(\w+)'", build)[1]}
    assert found - COMPILERS_OWN == LIBRARIES.keys()
    for name, words in LIBRARIES.items():
        for recipe, pattern in words.items():
            assert asked(recipe, pattern, None), f"{recipe} does not ask for {name}"
    conda = {re.split(r"[ =>]", word)[0] for word in yaml.safe_load(RECIPES["conda"])["requirements"]["host"]}
    others = {"c-compiler", "fortran-compiler", "pkg-config"}  # of the recipe's build
    assert {re.split(r"[ =>]", word)[0] for word in yaml.safe_load((ROOT / "environment.yml").read_text())["dependencies"]} - others <= conda
    debian = re.search(r"^packages='(.*)'", (ROOT / "hd").read_text(), re.M)[1].split()
    assert not [package for package in debian if package not in RECIPES["apptainer"].split()]


def test_recipes_say_licence_and_commands():
    """Where a recipe has a place for the licence it is the project's; each starts both commands (Guix does by itself)."""
    said = TOLD["project"]["license"]
    assert f'license("{said}")' in RECIPES["spack"] and f"  license: {said}\n" in RECIPES["conda"] and f"License {said}\n" in RECIPES["apptainer"]
    assert said == "GPL-3.0-or-later" and "(license license:gpl3+)" in RECIPES["guix"]
    for recipe in RECIPES.keys() - {"guix", "spack"}:
        for command in TOLD["project"]["scripts"]:
            assert f"{command} --version" in RECIPES[recipe], recipe
    assert 'bin.join("hdengine.x")' in RECIPES["spack"] and "bin.hdengine)" in RECIPES["spack"]


def test_recipes_take_their_version_from_the_sdist(tmp_path):
    """No recipe has a version of hdengine; laid out they have the sdist's, with its checksum, and stay what their tools read."""
    if not (ROOT / ".git").exists() or not shutil.which("git") or not (ROOT / ".venv/bin/meson").exists():
        pytest.skip("an sdist is made by git, of a checkout that ./hd has built")
    subprocess.run([ROOT / "packaging/lay_out.sh", tmp_path], check=True)
    sdist, = tmp_path.glob("hdengine-*.tar.gz")
    version = sdist.name.removeprefix("hdengine-").removesuffix(".tar.gz")
    for recipe, text in RECIPES.items():
        assert "@version@" in text and not re.search(r"\b0\.\d+\.\d+\.dev", text), recipe
        for path in (tmp_path / recipe).rglob("*.*"):
            laid = path.read_text()
            assert not re.search("@(version|sha256|folder)@", laid)
            if path.suffix in (".py", ".eb"):
                compile(laid, path, "exec")
            if path.suffix == ".yaml":
                yaml.safe_load(laid)
    assert version in (tmp_path / "conda/recipe.yaml").read_text()
    code = re.sub(r'"[^"]*"|;.*', "", RECIPES["guix"])
    assert code.count("(") == code.count(")")


def test_texts_that_debian_points_to():
    """A wheel gets each common text that its libraries' copyright files point to: by a number, without one, at a sentence's end, in quotes."""
    text = """found in `/usr/share/common-licenses/Apache-2.0'. The GPL is in
        /usr/share/common-licenses/GPL. and its version 2 in "/usr/share/common-licenses/GPL-2". Others:
        ‘/usr/share/common-licenses/LGPL-2.1’, /usr/share/common-licenses/LGPL, /usr/share/common-licenses/CC0-1.0 and again
        /usr/share/common-licenses/GPL-2"""
    assert wheel_licences.common_texts(text) == ["Apache-2.0", "CC0-1.0", "GPL", "GPL-2", "LGPL", "LGPL-2.1"]


def test_description_has_no_relative_link():
    """What a package index shows has no picture or link that needs the checkout, and names both commands."""
    text = (ROOT / TOLD["project"]["readme"]).read_text()
    assert "![" not in text and not re.findall(r"\]\((?!https:)", text) and re.search(r"doi\.org/([^)]+)\)", text)[1] in (ROOT / "CITATION.cff").read_text()
    assert all(f"`{command} " in text for command in TOLD["project"]["scripts"])
