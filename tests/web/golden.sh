#!/usr/bin/env bash
# Writes the golden values of the native core, golden.sh [FILE]; without one to tests/data/golden_wasm.json.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
out=$(realpath -m "${1:-../data/golden_wasm.json}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${CXX:-g++}" -std=c++20 -O2 -ffp-contract=off -fno-math-errno -fno-trapping-math -Wall -Wextra -Wno-psabi -I../../core \
    golden.cpp golden_gas.cpp -o "$work/golden"
"$work/golden" >"$out"
