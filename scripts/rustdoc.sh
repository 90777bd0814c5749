#!/usr/bin/env bash
# rustdoc for `cargo test --doc`: writes the documentation into $DOCUMENTATION, where a warning is an error, and then runs the code
# in it. `cargo doc` would check every dependency once more.
set -euo pipefail

pages=() skip= testing=
for argument in "$@"; do
    if [[ -n $skip ]]; then skip=; continue; fi
    case $argument in
        --test) testing=1 ;;
        --test-run-directory | --test-builder | --test-args) skip=1 ;;
        --test-run-directory=* | --test-builder=* | --test-args=*) ;;
        *) pages+=("$argument") ;;
    esac
done
[[ -z $testing ]] || rustdoc "${pages[@]}" --out-dir "$DOCUMENTATION" -D warnings
exec rustdoc "$@"
