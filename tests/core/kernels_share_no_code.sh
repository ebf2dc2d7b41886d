#!/bin/sh
# Fails where an object compiled for one instruction set defines code outside that set's namespace: the linker could
# give it to a machine that cannot run it.
#
#   kernels_share_no_code.sh NM ISA OBJECT...
set -eu
nm=$1
isa=$2
shift 2
shared=$("$nm" -C --defined-only "$@" | grep -E ' [TWu] ' | grep -v " truepose::kernels::$isa::" || true)
[ -z "$shared" ] || { echo "$shared"; exit 1; }
