#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Run the blocks of docs/start/install.md that take too long for the tests, each in a fresh clone of HEAD: tools/prove_install.sh [ROOT]
# ROOT: a folder with another Debian that has the packages of ./hd and a way to PyPI; as root. Writes into tools/prove_install.json
# when, on which system and from which commit they passed.
set -eu
cd "$(dirname "$0")/.."
here=$PWD root=${1:-} work=$(mktemp -d "${1:-}/tmp/XXXXXX")
commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain --untracked-files=no)" ] || commit=$commit+
block=$(sed -n '/<!-- run by tools\/prove_install.sh -->/,/^```$/p' docs/start/install.md | sed '/^<!--/d; /^```/d')
[ -n "$block" ]
git clone -q --no-hardlinks "$here" "$work/hdengine"
inside() { ${root:+chroot "$root"} env -u PYTHONPATH HOME="${work#"$root"}" sh -e -c "cd ${work#"$root"}/hdengine; $1"; }
start=$(date +%s)
inside "$block"
seconds=$(($(date +%s) - start))
k_ts=$(inside '.venv/bin/hdengine.x data/cd14.nml --out ../o' | sed -n 's/^K_TS *//p')
[ -n "$k_ts" ]
python3 - "$(. "$root/etc/os-release" && echo "$PRETTY_NAME")" "$(echo "$block" | paste -sd ';' | sed 's/;/; /g')" commit "$commit" date "$(date -u +%Y-%m-%d)" \
  python "$(inside '.venv/bin/python -V')" gfortran "$(inside 'gfortran -dumpfullversion')" seconds "$seconds" k_ts "$k_ts" <<'END'
import json
import sys
name = "tools/prove_install.json"
system, commands, *pairs = sys.argv[1:]
proved = json.load(open(name))
if proved["commands"] != commands:
    proved = {"commands": commands}
proved[system] = dict(zip(pairs[::2], pairs[1::2]))
open(name, "w").write(json.dumps(proved, indent=2) + "\n")
END
cat tools/prove_install.json
rm -rf "$work"
