#!/bin/sh
# The smallest useful build: nets in a C++ host, nothing else. Its own tests must pass, and its program must hold nothing
# of the systems that were left out.
set -eu
cd "$(dirname "$0")/../.."
folder=build/lean
cmake -S . -B $folder -G Ninja -DCMAKE_BUILD_TYPE=Release -DFEDER_LUA=OFF \
  -DFEDER_WITHOUT="rigid;collide;cloth;rope;soft;fluid;couple;study;broad;narrow;constrain;sph;neighbors" >/dev/null
ninja -C $folder --quiet test_springs test_forces test_base
ctest --test-dir $folder -C map -R '^(springs|forces|base)$' --no-tests=error --output-on-failure
if nm -C $folder/tests/test_springs | grep -E 'feder::(Rigid|Collide|Cloth|Rope|Soft|Fluid)::'; then
  echo "lean: holds what was left out" >&2
  exit 1
fi
