#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# The version of this checkout, said here alone: that of the tag, else the next one's with the commit's number and hash, and .dirty
# where sources differ from the commit. An archive of git knows its commit, an sdist its version, a copy without git neither.
set -eu
next=0.1.0
archived='$Format:%h %D$'
cd "$(dirname "$0")/.."
if [ $# -gt 0 ]; then  # of Meson, as it makes an sdist of this version
  sed -i "s/^archived=.*/archived='sdist $1'/" "$MESON_DIST_ROOT/tools/version.sh"
  exit
fi
case $archived in
  sdist*)
    echo "${archived#sdist }"
    exit ;;
  *'tag: v'*)
    tag=${archived##*tag: v}
    echo "${tag%%,*}"
    exit ;;
  [0-9a-f]*)
    echo "$next.dev0+g${archived%% *}"
    exit ;;
esac
if [ ! -e .git ] || ! commit=$(git rev-parse --short=8 HEAD 2>/dev/null); then
  echo "$next.dev0"
  exit
fi
dirty=
git diff --quiet HEAD -- meson.build config fortran python 2>/dev/null || dirty=.dirty
if [ -z "$dirty" ] && tag=$(git describe --tags --exact-match --match 'v[0-9]*' 2>/dev/null); then
  echo "${tag#v}"
else
  echo "$next.dev$(git rev-list --count HEAD)+g$commit$dirty"
fi
