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
objects=$(mktemp -d)
trap 'rm -rf "$objects"' EXIT
clang=("${CLANG:-clang++-19}" --target=wasm32-wasi)
object() { # object NAME SOURCE FLAG...
    "${clang[@]}" -std=c++20 -msimd128 -fno-exceptions -fno-rtti -fno-threadsafe-statics -ffp-contract=off \
        -fno-math-errno -Wall -Wextra -I../core "${@:3}" -c "$2" -o "$objects/$1.o"
}
module() { # module NAME OBJECT EXPORT...: a WebAssembly module that asks nothing of its host
    local file=$out/$1 object=$objects/$2.o
    shift 2
    "${clang[@]}" -nostartfiles "$object" "$objects/runtime.o" -o "$file" \
        -Wl,--no-entry,--strip-all,-z,stack-size=262144 "${@/#/-Wl,--export=}"
    chmod 644 "$file"
    node -e '
const module = new WebAssembly.Module(require("fs").readFileSync(process.argv[1]));
const imports = WebAssembly.Module.imports(module);
if (imports.length > 0) throw new Error("the module imports " + imports.map((i) => i.name).join());' "$file"
}
object runtime runtime.cpp -Os
# What the first page needs, and the same with all that plots and maps need besides, which is loaded afterwards.
object columns ../bindings/wasm.cpp -Os
drop="column_buffer reply_buffer scratch solve contacts_of row_size sample rebound_heights final_velocities compare_models
    records record_ranges outcome_message"
module core.wasm columns $drop
module maps.wasm columns $drop agreement_gaps scan_points scan_timeline
gas="gas_setting gas_fields gas_place gas_heat gas_duration gas_compression gas_deepest gas_start gas_advance gas_observe
    gas_state gas_take_log gas_log gas_outcome gas_rule law_rate law_fluid law_of_error law_errors law_largest law_measured"
# Smooth disks; those with friction, loaded when they are chosen.
object gas ../bindings/wasm_gas.cpp -Oz
module gas.wasm gas $gas
object gas_friction ../bindings/wasm_gas.cpp -Oz -DHARDLIMIT_GAS_RUBS
module gas_friction.wasm gas_friction $gas

npx tsc
node build.mjs "$out"
