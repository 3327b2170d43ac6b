#!/bin/sh
# Runs explorer, workbench and report in a real browser, in a throwaway environment of its own.
# WHEEL=dist/... is a wheel that is built already.
# usage: tools/try_browser.sh PYTHON [PYTEST ARGUMENTS...]; needs chromium (Debian's package) and node on the PATH
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
python=$1
shift
cannot() { echo "cannot be tried: $1" >&2; exit 77; }
command -v chromium >/dev/null || command -v chromium-browser >/dev/null ||
    cannot "no chromium on the PATH; apt-get install chromium, say"
command -v node >/dev/null || cannot "no node on the PATH; apt-get install nodejs, say"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export OPENBLAS_NUM_THREADS=1 PIP_DISABLE_PIP_VERSION_CHECK=1
"$python" -m venv "$scratch/browser"
# Under 25.1 pip knows no groups; the group is read as the project writes it.
packages=$("$scratch/browser/bin/python" -c 'import sys, tomllib
print(*tomllib.load(open(sys.argv[1], "rb"))["dependency-groups"]["browser"], sep="\n")' "$root/pyproject.toml")
echo "$packages" | tr '\n' '\0' | xargs -0 "$scratch/browser/bin/python" -m pip install --quiet --quiet ||
    cannot "its packages cannot be installed here"
"$scratch/browser/bin/python" -m pip install --quiet --quiet "${WHEEL:-$root}"
# A skip is a failure: here everything is there.
(cd "$root" && "$scratch/browser/bin/python" -m pytest -q -rs -p no:cacheprovider -m "slow or not slow" "$@" \
    tests/unit/test_app.py tests/unit/test_explorer.py tests/unit/test_markup.py) > "$scratch/out" 2>&1 || {
    cat "$scratch/out"; exit 1; }
tail -n 3 "$scratch/out"
! grep "SKIPPED" "$scratch/out" || { echo "skipped, which it must not be here"; exit 1; }
