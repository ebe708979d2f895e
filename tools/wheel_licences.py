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


def said(*command):
    """What a command prints."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def package_of(library):
    """Debian package of a vendored library, whose name carries a hash: libmetis-1a2b3c4d.so.5.1.0 is libmetis.so.5*."""
    stem, version = re.fullmatch(r"(.+)-[0-9a-f]{8}\.so\.?(.*)", library).groups()
    for folder in ("/usr/lib/x86_64-linux-gnu", "/lib/x86_64-linux-gnu", "/usr/lib/x86_64-linux-gnu/openblas-pthread"):
        for path in sorted(Path(folder).glob(f"{stem}.so.{version}*" if version else f"{stem}.so*")):
            for name in (path.resolve(), path):
                found = subprocess.run(["dpkg", "-S", str(name).replace("/usr", "", 1) if not name.exists() else str(name)], capture_output=True, text=True)
                if found.returncode:
                    found = subprocess.run(["dpkg", "-S", str(name).removeprefix("/usr")], capture_output=True, text=True)
                if found.returncode == 0:
                    return found.stdout.split(":")[0]
    raise SystemExit(f"no Debian package holds {library}")


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
        rows = ["| library | Debian package | sources | licence |", "|---|---|---|---|"]
        licences = {}
        for package, libraries in packages.items():
            source, version = said("dpkg-query", "-W", "-f", "${source:Package} ${source:Version}", package).split()
            text = Path("/usr/share/doc", package, "copyright").read_text(errors="replace")
            (texts / f"{package}.txt").write_text(text)
            names = sorted(set(re.findall(r"^License: (\S.*)$", text, re.M)))
            licences |= dict.fromkeys(libraries, names)
            rows.append(f"| {', '.join(libraries)} | {package} {version} | https://snapshot.debian.org/package/{source}/{version}/ | "
                        f"{', '.join(names) or f'see {package}.txt'} |")
        (texts / "LIBRARIES.md").write_text("# Libraries inside this wheel\n\n" + "\n".join(rows) + "\n")
        for bill in info.glob("sboms/*.json"):
            told = json.loads(bill.read_text())
            for part in told.get("components", []):
                near = next((names for library, names in licences.items() if part.get("name", "") in packages and library in packages[part["name"]]), None)
                part["licenses"] = [{"license": {"name": name}} for name in near or ["see licenses/LIBRARIES.md"]]
            bill.write_text(json.dumps(told, indent=1))
        said(sys.executable, "-m", "wheel", "pack", str(root), "-d", folder)
    print(max(Path(folder).glob("*.whl"), key=lambda p: p.stat().st_mtime))


if __name__ == "__main__":
    main(*sys.argv[1:])
