#!/bin/sh
# Fails where a library outside core brings a copy of Eigen's product of large matrices: a program keeps one copy, and
# core's decompositions would run the one that was compiled for waiting, not for numbers.
#
#   products_stay_in_core.sh NM LIBRARY...
set -eu
nm=$1
shift
copies=$("$nm" -A -C --defined-only "$@" | grep 'gebp_kernel' || true)
[ -z "$copies" ] || { echo "$copies"; exit 1; }
