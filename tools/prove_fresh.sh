#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Prove the README's two commands on a fresh Debian 12: tools/prove_fresh.sh FOLDER [run test ...] (as root; default: run test)
# Makes a debootstrap minbase system in FOLDER with this machine's apt and pip configuration and a checkout of HEAD.
set -eu
target=$1
shift
[ $# -gt 0 ] || set -- run test
here=$(cd "$(dirname "$0")/.." && pwd)
mirror=$(grep -hE '^(URIs:|deb )' /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources 2>/dev/null |
  sed 's/^URIs: //; s/^deb //; s/ .*//' | head -n 1)
debootstrap --variant=minbase bookworm "$target" "$mirror"
for f in /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources /etc/apt/apt.conf.d /etc/pip.conf /usr/local/share/ca-certificates; do
  [ -e "$f" ] || continue
  mkdir -p "$target$(dirname "$f")"
  cp -rL "$f" "$target$(dirname "$f")/"
done
mkdir -p "$target/src"
git -C "$here" archive --prefix=hdengine/ HEAD | tar -x -C "$target/src"
mount --bind /proc "$target/proc" 2>/dev/null || true
mount --bind /dev "$target/dev" 2>/dev/null || true
trap 'umount "$target/proc" "$target/dev" 2>/dev/null || true' EXIT
for command in "$@"; do
  start=$(date +%s)
  chroot "$target" /bin/sh -c "cd /src/hdengine && ./hd $command"
  echo "== ./hd $command: $(($(date +%s) - start)) s"
done
