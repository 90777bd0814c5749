#!/usr/bin/env bash
# Everything that has to hold before a change lands. Needs a C compiler and the Rust toolchain; with Node and rustup, WASM
# is checked too, with Chromium the demo's page. docs/lab/ci.md says where the time goes.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${CARGO_TARGET_DIR:-target}
host=$(rustc -vV | sed -n 's/^host: //p')
# Into an empty folder everything is built once. No traces for building again: they would be half of what lies on the disk.
# And the host's triple by name: macros and build scripts are then the same for all targets, and built once for all.
if [[ ${CI:-} == true || -d $folder/$host/debug || ! -d $folder/debug ]]; then
    export CARGO_INCREMENTAL=0 CARGO_BUILD_TARGET=$host
fi

log=$(mktemp -d)
names=() times=() began=0
# A stage ends where the next begins.
end_stage() {
    [[ ${#names[@]} == "${#times[@]}" ]] || times+=($((SECONDS - began)))
}
stage() {
    end_stage
    names+=("$1") began=$SECONDS
    printf '\n== %s (%s s)\n' "$1" "$SECONDS"
}
beside=
finish() {
    local code=$? k
    end_stage
    [[ -z $beside ]] || kill -- "-$beside" 2>/dev/null || true
    printf '\n%9s  stage\n' seconds
    for k in "${!names[@]}"; do printf '%9s  %s\n' "${times[$k]}" "${names[$k]}"; done
    [[ ! -s $log/seconds ]] || printf '%9s  %s\n' "$(<"$log/seconds")" "beside these: the release builds and the page"
    printf '%9s  in all\n' "$SECONDS"
    rm -rf "$log"
    exit "$code"
}
trap finish EXIT

stage "format"
cargo fmt --check

stage "the core alone: no engine, no command line, no inference in its tree"
tree=$(cargo tree --no-default-features --features train --edges normal --prefix none)
if grep -E '^(bevy|bevy_[a-z]+|tract[a-z-]*|clap|wgpu) v' <<<"$(grep -v '^bevy_athlete ' <<<"$tree")"; then
    echo "the core must not depend on these" >&2
    exit 1
fi

# Builds that have folders and locks of their own fill the time in which the others wait for one crate or one test.
page=
if command -v node >/dev/null && command -v rustup >/dev/null; then page=1; fi
set -m
(
    start=$SECONDS
    cargo test --locked --release --no-default-features --features train --test determinism
    bash scripts/wasm_bits.sh
    [[ -z $page ]] || bash web/build.sh --quick
    echo $((SECONDS - start)) >"$log/seconds"
) >"$log/beside" 2>&1 &
beside=$!
set +m

stage "lint: the core alone, the command line"
cargo clippy --locked --no-default-features --lib -- -D warnings
cargo clippy --locked --no-default-features --features cli --lib --bin athlete -- -D warnings

# From here clippy is the compiler of this crate: what is linted is what runs, and no dependency is compiled for the lint alone.
driver=$(rustc --print sysroot)/bin/clippy-driver
[[ -x $driver ]] || { echo "the lint needs clippy: rustup component add clippy" >&2; exit 1; }
export RUSTC_WORKSPACE_WRAPPER=$driver CLIPPY_ARGS=-Dwarnings__CLIPPY_HACKERY__

# With the features that are off by default too, in every stage: the crate and the engine are built once.
all=(--locked --features "avian gltf")
stage "lint and build: everything"
cargo build "${all[@]}" --all-targets

stage "tests: of single files, of the core and the command line, of the engine"
cargo test "${all[@]}" --lib --test core --test engine

stage "documentation, and the code of the guides"
RUSTDOC=$PWD/scripts/rustdoc.sh DOCUMENTATION=$folder/doc cargo test "${all[@]}" --doc

stage "the demo without a display"
picture=$log/storyboard.png
env -u DISPLAY -u WAYLAND_DISPLAY cargo run "${all[@]}" -- --storyboard "$picture"
test -s "$picture"

# All the while beside the others; here is what they found.
stage "the same bits in release, in a portable build and in WASM; the page"
code=0
wait "$beside" || code=$?
beside=
cat "$log/beside"
[[ $code == 0 ]] || exit "$code"

stage "the demo in a browser"
if [[ -n $page ]]; then bash web/test.sh; else echo "skipped: the page needs Node and rustup" >&2; fi
