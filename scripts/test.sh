#!/usr/bin/env bash
# Everything that has to hold before a change lands. Needs a C compiler and the Rust toolchain; with Node and rustup, WASM
# is checked too, with Chromium the demo's page.
set -euo pipefail
cd "$(dirname "$0")/.."
# A machine that builds once needs no traces for building again; they would be half of what the build leaves on the disk.
[[ ${CI:-} != true ]] || export CARGO_INCREMENTAL=0

stage() { printf '\n== %s (%s s)\n' "$1" "$SECONDS"; }

stage "format"
cargo fmt --check

stage "the core alone: no engine, no command line, no inference in its tree"
tree=$(cargo tree --no-default-features --features train --edges normal --prefix none)
if grep -E '^(bevy|bevy_[a-z]+|tract[a-z-]*|clap|wgpu) v' <<<"$(grep -v '^bevy_athlete ' <<<"$tree")"; then
    echo "the core must not depend on these" >&2
    exit 1
fi
cargo clippy --locked --no-default-features --lib -- -D warnings

stage "core and command line: lint and tests"
cargo clippy --locked --no-default-features --features cli --all-targets -- -D warnings
cargo test --locked --no-default-features --features cli

stage "the same bits in release"
cargo test --locked --release --no-default-features --features train --test determinism

stage "the same bits in a portable build and in WASM"
bash scripts/wasm_bits.sh

# With the features that are off by default too, in every stage: the engine is built once.
engine=(--locked --features "avian gltf")
stage "with the engine: lint, docs"
cargo clippy "${engine[@]}" --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc "${engine[@]}" --no-deps

stage "with the engine: tests, examples, the code of the guides"
cargo test "${engine[@]}" --lib --examples --test engine
cargo test "${engine[@]}" --doc

stage "the demo without a display"
picture=$(mktemp --suffix .png)
env -u DISPLAY -u WAYLAND_DISPLAY cargo run "${engine[@]}" -- --storyboard "$picture"
test -s "$picture"
rm -f "$picture"

stage "the demo in a browser"
if command -v node >/dev/null && command -v rustup >/dev/null; then
    bash web/build.sh --quick
    bash web/test.sh
else
    echo "skipped: the page needs Node and rustup" >&2
fi

stage "done"
