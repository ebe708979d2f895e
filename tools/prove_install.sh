#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Run the blocks of docs/start/install.md that take too long for the tests, each in a fresh clone of HEAD: tools/prove_install.sh
# Writes when, where and from which commit they passed into tools/prove_install.json.
set -eu
cd "$(dirname "$0")/.."
here=$PWD work=$(mktemp -d)
commit=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain --untracked-files=no)" ] || commit=$commit+
block=$(sed -n '/<!-- run by tools\/prove_install.sh -->/,/^```$/p' docs/start/install.md | sed '/^<!--/d; /^```/d')
[ -n "$block" ]
git clone -q --no-hardlinks "$here" "$work/hdengine"
cd "$work/hdengine"
start=$(date +%s)
env -u PYTHONPATH HOME="$work" sh -e -c "$block"
seconds=$(($(date +%s) - start))
k_ts=$(.venv/bin/hdengine.x data/cd14.nml --out "$work/o" | sed -n 's/^K_TS *//p')
[ -n "$k_ts" ]
printf '{\n  "commands": "%s",\n  "commit": "%s",\n  "date": "%s",\n  "system": "%s",\n  "python": "%s",\n  "seconds": %s,\n  "k_ts": "%s"\n}\n' \
  "$(echo "$block" | paste -sd ';' | sed 's/;/; /g')" "$commit" "$(date -u +%Y-%m-%d)" \
  "$(. /etc/os-release && echo "$PRETTY_NAME")" "$(.venv/bin/python -V)" "$seconds" "$k_ts" >"$here/tools/prove_install.json"
cat "$here/tools/prove_install.json"
rm -rf "$work"
