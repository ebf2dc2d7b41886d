#!/bin/sh
# Fails where a file of core other than core/math/dense_algebra includes one of Eigen's decompositions: each unit that
# names one compiles it again, which takes seconds. Names file and line.
#
#   decompositions_stay_together.sh CORE
set -eu
headers='Cholesky|Dense|Eigen|Eigenvalues|LU|QR|SVD'
found=$(grep -rnE "^[[:space:]]*#[[:space:]]*include[[:space:]]*[<\"](Eigen|eigen3/Eigen)/($headers)[>\"]" \
             --include='*.?pp' "$1" | grep -v "^$1/math/dense_algebra\." || true)
[ -z "$found" ] || { echo "$found"; exit 1; }
