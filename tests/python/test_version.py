# SPDX-License-Identifier: GPL-3.0-or-later
"""The version of the program: one, taken from the commit."""
import importlib.metadata
import os
import re
import shutil
import subprocess

import pytest

import hdengine
from conftest import ROOT, executable

git = pytest.mark.skipif(not shutil.which("git") or not (ROOT / ".git").exists(), reason="no git, or no checkout of it")


def said(root):
    """What the script of a checkout says."""
    return subprocess.run([root / "tools/version.sh"], capture_output=True, text=True, check=True).stdout.strip()


def test_there_is_one_version():
    """The program, the module, the package and the script of the checkout say the same version."""
    first = subprocess.run([executable(), "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    assert first == hdengine.__version__ == importlib.metadata.version("hdengine")
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.dev\d+(\+g[0-9a-f]+(\.dirty)?)?)?", first)


@git
def test_no_two_commits_share_a_version(tmp_path):
    """A commit has its hash in its version, sources that differ from it add .dirty, a tag is the version, an archive knows its commit,
    an sdist its version, and a copy without git claims none."""
    def call(*words):
        subprocess.run(["git", "-c", "user.name=n", "-c", "user.email=e@x.org", *words], cwd=tmp_path, check=True, capture_output=True)

    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "tools/version.sh", tmp_path / "tools")
    shutil.copy(ROOT / ".gitattributes", tmp_path)
    (tmp_path / "meson.build").write_text("")
    assert said(tmp_path) == "0.1.0.dev0"
    call("init", "-q")
    call("add", ".")
    call("commit", "-qm", "One")
    first = said(tmp_path)
    assert re.fullmatch(r"0\.1\.0\.dev1\+g[0-9a-f]{8}", first)
    call("commit", "-q", "--allow-empty", "-m", "Two")
    assert said(tmp_path).startswith("0.1.0.dev2+g") and said(tmp_path)[12:] != first[12:]
    (tmp_path / "meson.build").write_text("#")
    assert said(tmp_path).endswith(".dirty")
    call("checkout", "-q", "meson.build")
    archived = tmp_path / "archived"
    archived.mkdir()
    subprocess.run("git archive HEAD | tar -x -C archived", shell=True, cwd=tmp_path, check=True)
    assert said(archived)[:14] == "0.1.0.dev0+g" + said(tmp_path)[12:14]
    subprocess.run([tmp_path / "tools/version.sh", first], env=os.environ | {"MESON_DIST_ROOT": str(archived)}, check=True)
    assert said(archived) == first
    call("tag", "v0.3.0")
    assert said(tmp_path) == "0.3.0"
    subprocess.run("git archive HEAD | tar -x -C archived", shell=True, cwd=tmp_path, check=True)
    assert said(archived) == "0.3.0"
