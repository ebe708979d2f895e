#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Lay the recipes beside the sdist that they build: packaging/lay_out.sh FOLDER   (after ./hd setup)
# hdengine has no public address yet, so each recipe takes the sdist in FOLDER and says where the address goes. Version and checksum
# are the sdist's: @version@, @sha256@, @folder@ in the recipes.
set -eu
[ $# -eq 1 ] || { sed -n 's/^# \(Lay .*\)/\1/p' "$0" >&2; exit 2; }
mkdir -p "$1"
folder=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."
PATH="$PWD/.venv/bin:$PATH" python -c 'import sys, mesonpy; mesonpy.build_sdist(sys.argv[1])' "$folder" >"$folder/log" 2>&1 ||
  { cat "$folder/log" >&2; exit 1; }
version=$(tools/version.sh)
sum=$(sha256sum "$folder/hdengine-$version.tar.gz")
for name in apptainer conda easybuild guix spack; do
  cp -R "packaging/$name" "$folder"
  find "$folder/$name" -type f -exec sed -i "s|@version@|$version|g; s|@sha256@|${sum%% *}|g; s|@folder@|$folder|g" {} +
done
