#!/usr/bin/env bash
# The play lanes give the same bits in the native build, in a portable native build and in WASM with simd128.
# Builds examples/golden_bits.rs for each, runs it, prints the fingerprints and compares. What this machine cannot build
# or run is skipped, and said; bits that differ are a failure.
set -euo pipefail
cd "$(dirname "$0")/.."

target=wasm32-wasip1
host=$(rustc -vV | sed -n 's/^host: //p')
folder=${CARGO_TARGET_DIR:-target}
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

skip() { echo "skipped: $1"; }
# Every target by name: macros and build scripts are then built once for all.
build() { cargo build --locked --quiet --no-default-features --example golden_bits --target "$@"; }

echo "native, as .cargo/config.toml asks"
# The feature changes none of the bits; with it the crate is the one that the release test uses.
build "$host" --release --features train
"$folder/$host/release/examples/golden_bits" | tee "$results/native"

compare() {
    if ! diff <(tail -n +2 "$results/native") <(tail -n +2 "$results/$1") >&2; then
        echo "the bits of the $1 build differ from those of the native one" >&2
        exit 1
    fi
    echo "$1: $(tail -n +2 "$results/$1" | wc -l) fingerprints, all equal to the native ones"
}

if [[ $host == x86_64-* ]]; then
    # Hardly optimised: the level changes none of the bits either. In a folder of its own, so that it waits for nobody.
    RUSTFLAGS="-C target-cpu=x86-64" CARGO_TARGET_DIR=$folder/portable build "$host"
    "$folder/portable/$host/debug/examples/golden_bits" >"$results/portable"
    head -n 1 "$results/portable"
    compare portable
else
    skip "the portable build is for x86-64, this is $host"
fi

has_target() { compgen -G "$(rustc --print target-libdir --target $target 2>/dev/null)/libstd-*.rlib" >/dev/null; }
if ! node --eval 'require("node:wasi")' >/dev/null 2>&1; then
    skip "WASM needs node with node:wasi"
elif ! has_target && ! { command -v rustup >/dev/null && rustup target add $target && has_target; }; then
    skip "WASM needs the Rust target $target, and rustup cannot add it"
else
    build $target --release
    node --no-warnings scripts/wasi_run.mjs "$folder/$target/release/examples/golden_bits.wasm" >"$results/wasm"
    head -n 1 "$results/wasm"
    grep -q "built for simd128" "$results/wasm" || { echo "the WASM build has no simd128" >&2; exit 1; }
    compare wasm
fi
