#!/usr/bin/env bash
# Checks of the explorer: the committed page is what its sources give, the WebAssembly core returns the native bits, and
# the page does in Chromium and in Firefox what it should. Needs clang-19, the packages named in build.sh,
# chromium-headless-shell or chromium, firefox-esr, node 20 or newer, and PYTHON, an interpreter that has hardlimit
# installed. SHOTS=FOLDER keeps screenshots; TIMES=off ignores the limits on times, for a busy machine.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

npm ci
ln -sfn ../../web/node_modules ../tests/web/node_modules
../tests/web/golden.sh "$work/golden.json" &
golden=$!
./build.sh "$work/page"
diff -r "$work/page" ../src/hardlimit/explorer/page || {
    echo "src/hardlimit/explorer/page is not what web/ and core/ give: run web/build.sh" >&2
    exit 1
}
wait $golden
cmp "$work/golden.json" ../tests/data/golden_wasm.json || {
    echo "tests/data/golden_wasm.json is not what the core gives: run tests/web/golden.sh" >&2
    exit 1
}
# Two files at a time. The one that takes times runs by itself, unless nobody looks at them.
files=$(ls ../tests/web/*.test.mjs | grep -v speed)
[ "${TIMES:-}" != off ] || files+=" ../tests/web/speed.test.mjs"
# A file that fails is run once more, and the log shows both: a browser may stall on a busy machine.
tests_of() {
    local log="$work/$(basename "$1").log"
    local failed=0
    node --test "$1" >"$log" 2>&1 || { echo "$1 failed and runs again" >>"$log" && node --test "$1" >>"$log" 2>&1; } ||
        failed=1
    cat "$log"
    return $failed
}
export -f tests_of
export work
printf '%s\n' $files | xargs -P 2 -I '{}' bash -c 'tests_of {}'
[ "${TIMES:-}" = off ] || tests_of ../tests/web/speed.test.mjs
