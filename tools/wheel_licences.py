# SPDX-License-Identifier: GPL-3.0-or-later
"""Give a repaired wheel the copyright texts of the libraries inside, a table of their sources, and licences in its SBOM.

python tools/wheel_licences.py WHEEL FOLDER: writes the wheel into FOLDER and prints its path. The texts are those of Debian's packages.
"""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

# Debian's one text for all of GCC lists no licence by name
GCC = {"libgfortran5": ["GPL-3.0-or-later WITH GCC-exception-3.1"], "libgomp1": ["GPL-3.0-or-later WITH GCC-exception-3.1"],
       "libquadmath0": ["LGPL-2.1-or-later"]}


def said(*command):
    """What a command prints."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def common_texts(text):
    """Files of /usr/share/common-licenses that one of Debian's copyright files points to: Apache-2.0, GPL-3, LGPL."""
    return sorted(set(re.findall(r"/usr/share/common-licenses/([A-Za-z0-9]+(?:-[0-9.]*[0-9])?)", text)))


def package_of(library):
    """Debian package of a vendored library, whose name carries a hash: libscotch-7-f76822b3.0.3.so is libscotch-7.0.3.so."""
    path = min(Path("/usr/lib/x86_64-linux-gnu").rglob(re.sub("-[0-9a-f]{8}", "", library)), key=lambda p: len(p.parts)).resolve()
    for name in (str(path), str(path).removeprefix("/usr")):
        found = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    raise SystemExit(f"no Debian package holds {path}")


def main(wheel, folder):
    """Unpack, add, pack."""
    with tempfile.TemporaryDirectory() as place:
        said(sys.executable, "-m", "wheel", "unpack", wheel, "-d", place)
        root, = Path(place).iterdir()
        info, = root.glob("*.dist-info")
        texts = info / "licenses"
        texts.mkdir(exist_ok=True)
        packages = {}
        for library in sorted(p.name for p in root.glob("*.libs/*")):
            packages.setdefault(package_of(library), []).append(library)
        known = {}
        rows = ["| library | Debian package | sources | licence |", "|---|---|---|---|"]
        licences = {}
        for package, libraries in packages.items():
            source, version = said("dpkg-query", "-W", "-f", "${source:Package} ${source:Version}", package).split()
            text = Path("/usr/share/doc", package, "copyright").read_text(errors="replace")
            (texts / f"{package}.txt").write_text(text)
            for name in common_texts(text):
                (texts / f"{name}.txt").write_bytes(Path("/usr/share/common-licenses", name).read_bytes())
            names = GCC.get(package) or sorted(set(re.findall(r"^License: (\S.*)$", text, re.M)))
            licences[package] = names
            known[package] = {"type": "library", "name": package, "version": version, "purl": f"pkg:deb/debian/{package}@{version}"}
            rows.append(f"| {', '.join(libraries)} | {package} {version} | https://snapshot.debian.org/package/{source}/{version}/ | "
                        f"{', '.join(names)} |")
        (texts / "LIBRARIES.md").write_text("# Libraries inside this wheel\n\n" + "\n".join(rows) + "\n")
        bills = sorted(info.glob("sboms/*.json"))
        if not bills:
            raise SystemExit(f"{wheel} has no SBOM: auditwheel is too old")
        for bill in bills:
            told = json.loads(bill.read_text())
            listed = {part["name"] for part in told["components"]}
            told["components"] += [part for package, part in known.items() if package not in listed]
            for part in told["components"]:
                part["licenses"] = [{"license": {"name": name}} for name in licences.get(part["name"], ["GPL-3.0-or-later"])]
            bill.write_text(json.dumps(told, indent=1))
        said(sys.executable, "-m", "wheel", "pack", str(root), "-d", folder)
    print(max(Path(folder).glob("*.whl"), key=lambda p: p.stat().st_mtime))


if __name__ == "__main__":
    main(*sys.argv[1:])
