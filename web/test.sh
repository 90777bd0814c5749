#!/usr/bin/env bash
# The page of web/dist in a headless Chromium with software GL: bash web/test.sh; a picture goes to target/web.png.
# bash web/test.sh --crowd [SKATERS]: how many skaters one thread of the browser holds.
# Without Node or Chromium it is skipped, and says so; with CI=true that is a failure.
set -euo pipefail
cd "$(dirname "$0")/.."

playwright=1.65.1
folder=${CARGO_TARGET_DIR:-target}

skip() {
    echo "skipped: $1" >&2
    [[ ${CI:-} != true ]] || exit 1
    exit 0
}
find_chromium() { command -v "${CHROMIUM:-chromium}" || command -v chromium-browser || command -v google-chrome; }

command -v node >/dev/null || skip "the browser test needs Node"
[[ -f web/dist/demo_bg.wasm ]] || { echo "web/dist is not built: bash web/build.sh [--quick]" >&2; exit 1; }
if ! CHROMIUM=$(find_chromium); then
    # Debian's own package, where this user may install it.
    if [[ $(id -u) == 0 ]] && command -v apt-get >/dev/null; then
        apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium >/dev/null || true
    fi
    CHROMIUM=$(find_chromium) || skip "the browser test needs Chromium (CHROMIUM names the program)"
fi
export CHROMIUM PLAYWRIGHT=$folder/tools/playwright-core-$playwright PICTURE=$folder/web.png
[[ -d $PLAYWRIGHT/node_modules/playwright-core ]] ||
    npm install --silent --no-save --prefix "$PLAYWRIGHT" playwright-core@$playwright

if [[ ${1:-} == --crowd ]]; then
    exec node web/crowd.mjs "${@:2}"
fi
exec node --test --test-reporter=spec web/test.mjs
