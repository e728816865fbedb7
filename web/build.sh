#!/usr/bin/env bash
# Builds the page: the core to WebAssembly, the TypeScript to JavaScript. build.sh [FOLDER]; without one into the package.
# Needs Debian's clang-19 lld-19 wasi-libc libc++-19-dev-wasm32 libclang-rt-19-dev-wasm32, and node with `npm ci` done.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
out=$(realpath -m "${1:-../src/hardlimit/explorer/page}")
mkdir -p "$out"

if command -v wasm-opt >/dev/null; then
    echo "wasm-opt is installed: clang would run it, and the page would have other bytes" >&2
    exit 1
fi
# module NAME SOURCE EXPORT...: a WebAssembly module that asks nothing of its host.
module() {
    local file=$out/$1 source=$2
    shift 2
    "${CLANG:-clang++-19}" --target=wasm32-wasi -std=c++20 "${size:--Os}" -msimd128 -fno-exceptions -fno-rtti \
        -fno-threadsafe-statics -ffp-contract=off -fno-math-errno -Wall -Wextra -nostartfiles -I../core ${flags:-} \
        "$source" runtime.cpp -o "$file" -Wl,--no-entry,--strip-all,-z,stack-size=262144 "${@/#/-Wl,--export=}"
    chmod 644 "$file"
    node -e '
const module = new WebAssembly.Module(require("fs").readFileSync(process.argv[1]));
const imports = WebAssembly.Module.imports(module);
if (imports.length > 0) throw new Error("the module imports " + imports.map((i) => i.name).join());' "$file"
}
# What the first page needs, and the same with all that plots and maps need besides, which is loaded afterwards.
drop="column_buffer reply_buffer scratch solve contacts_of row_size sample rebound_heights final_velocities compare_models
    records record_ranges outcome_message"
module core.wasm ../bindings/wasm.cpp $drop
module maps.wasm ../bindings/wasm.cpp $drop agreement_gaps scan_points scan_timeline
gas="gas_setting gas_fields gas_place gas_heat gas_duration gas_compression gas_deepest gas_start gas_advance gas_observe
    gas_state gas_take_log gas_log gas_outcome gas_rule law_rate law_fluid law_of_error law_errors law_largest law_measured"
# Smooth disks; those with friction, loaded when they are chosen.
size=-Oz module gas.wasm ../bindings/wasm_gas.cpp $gas
size=-Oz flags=-DHARDLIMIT_GAS_RUBS module gas_friction.wasm ../bindings/wasm_gas.cpp $gas

npx tsc
node build.mjs "$out"
