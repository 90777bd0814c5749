#!/usr/bin/env bash
# Builds the demo for the web into web/dist, a folder that any static server can host: bash web/build.sh [--quick]
# --quick: the profile web-quick, neither shrunk nor compressed, for the browser test.
# Needs Rust (rustup), a C compiler and Node. wasm-bindgen is kept beside cargo's own programs, the other tools in target/.
set -euo pipefail
cd "$(dirname "$0")/.."

quick=
case "${1:-}" in
    "") ;;
    --quick) quick=1 ;;
    *) echo "unknown option $1; valid: --quick" >&2; exit 2 ;;
esac

binaryen=132.0.0
target=wasm32-unknown-unknown
folder=${CARGO_TARGET_DIR:-target}
dist=web/dist
profile=web
[[ -z $quick ]] || profile=web-quick

stage() { printf '\n-- %s (%s s)\n' "$1" "$SECONDS"; }

if ! compgen -G "$(rustc --print target-libdir --target $target)/libstd-*.rlib" >/dev/null; then
    stage "the Rust target $target"
    rustup target add $target
fi

# The JavaScript side and the wasm side of wasm-bindgen have to be of one version.
bindgen=$(sed -n '/^name = "wasm-bindgen"$/{n;s/^version = "\(.*\)"$/\1/p}' Cargo.lock)
wasm_bindgen=$(command -v wasm-bindgen || true)
if [[ -z $wasm_bindgen || $("$wasm_bindgen" --version) != "wasm-bindgen $bindgen" ]]; then
    tools=${CARGO_HOME:-$HOME/.cargo}/tools/wasm-bindgen-$bindgen
    wasm_bindgen=$tools/bin/wasm-bindgen
fi
if [[ ! -x $wasm_bindgen ]]; then
    stage "wasm-bindgen $bindgen"
    # It runs for seconds: little optimised it is built in half of the time. Where a crate of its lock file is not to be
    # had, one that fits takes its place.
    export CARGO_PROFILE_RELEASE_OPT_LEVEL=1
    cargo install --quiet --locked --root "$tools" --version "=$bindgen" wasm-bindgen-cli ||
        cargo install --quiet --root "$tools" --version "=$bindgen" wasm-bindgen-cli
    unset CARGO_PROFILE_RELEASE_OPT_LEVEL
fi

stage "the program, profile $profile"
# RUSTFLAGS would replace what .cargo/config.toml asks for: simd128.
# The library is compiled for speed; what is linked with it, for size.
[[ -n $quick ]] || link=(-- -C opt-level=z)
env -u RUSTFLAGS cargo rustc --locked --profile $profile --target $target --no-default-features --features app \
    --bin bevy_athlete ${link[@]+"${link[@]}"}

stage "its JavaScript"
rm -rf $dist
mkdir -p $dist
program=$folder/$target/$profile/bevy_athlete.wasm
"$wasm_bindgen" --target web --no-typescript --out-dir $dist --out-name demo "$program"

if [[ -z $quick ]]; then
    shrinker=$folder/tools/binaryen-$binaryen
    wasm_opt=$shrinker/node_modules/.bin/wasm-opt
    if [[ ! -x $wasm_opt ]]; then
        stage "wasm-opt"
        npm install --silent --no-save --prefix "$shrinker" binaryen@$binaryen
    fi
    stage "shrinking"
    "$wasm_opt" -Oz --strip-debug --strip-producers $dist/demo_bg.wasm -o $dist/demo_bg.wasm
fi

stage "the page and its assets"
cp web/index.html $dist/
bytes=$(wc -c <$dist/demo_bg.wasm)
sed "s/^const WASM_BYTES = 0;$/const WASM_BYTES = ${bytes// /};/" web/load.js >$dist/load.js
grep -q "^const WASM_BYTES = ${bytes// /};$" $dist/load.js
mkdir $dist/assets
cp -r assets/characters assets/skills $dist/assets/
# The program holds the stroking control; nothing on the page performs the two-foot glide.
rm -r $dist/assets/skills/skating/two_foot_glide $dist/assets/skills/skating/stroking/stroking.control.ron

if [[ -z $quick ]]; then
    stage "compressing"
    node web/pack.mjs $dist
fi
stage "done: node web/serve.mjs shows it"
