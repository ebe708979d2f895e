#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Prove the first block of README.md on a bare Debian 12: tools/prove_fresh.sh FOLDER [COMMAND ...]  (as root; default: its commands)
# FOLDER gets a debootstrap minbase system with this machine's apt and pip configuration: no git, no compiler, no /sys. The sources
# are an archive of HEAD, without .git. All commands run as root, who installs Debian's packages, and again as an ordinary user in a
# folder of his own. The two commands take some 20 minutes a turn on two cores.
set -euo pipefail
[ $# -gt 0 ] || { sed -n '3,6s/^# //p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
target=$(cd "$1" && pwd)
shift
[ $# -gt 0 ] || mapfile -t commands < <(awk '/^```/{n++; next} n==1' "$here/README.md")
[ $# -eq 0 ] || commands=("$@")

if [ ! -d "$target/usr" ]; then
  mirror=$(cat /etc/apt/sources.list /etc/apt/sources.list.d/*.sources 2>/dev/null | awk '/^(URIs:|deb )/ {print $2; exit}' || true)
  debootstrap --variant=minbase bookworm "$target" "$mirror" >/dev/null
  rm -f "$target/etc/apt/sources.list"
  for f in /etc/apt /usr/share/keyrings /etc/ssl/certs /usr/local/share/ca-certificates /etc/pip.conf /etc/resolv.conf /etc/hosts \
    "${PIP_CERT:-}" "${PIP_FIND_LINKS:-}"; do
    if [ -e "$f" ]; then echo "${f#/}"; fi
  done | tar -C / -chf - -T - | tar -C "$target" -xf -
  chroot "$target" useradd -m user
fi
mount -t proc proc "$target/proc"
mount --rbind /dev "$target/dev"
mount --make-rslave "$target/dev"
trap 'umount -l "$target/proc" "$target/dev"' EXIT

for who in root user; do
  home=$(chroot "$target" sh -c "echo ~$who")
  rm -rf "$target$home/hdengine"
  git -C "$here" archive --prefix=hdengine/ HEAD | tar -x -C "$target$home"
  chroot "$target" chown -R "$who:" "$home/hdengine"
  for command in "${commands[@]}"; do
    start=$SECONDS
    chroot --userspec="$who:$who" "$target" env -u PYTHONPATH HOME="$home" PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin sh -c "cd $home/hdengine && $command" </dev/null
    echo "== $who: $command: $((SECONDS - start)) s"
  done
done
