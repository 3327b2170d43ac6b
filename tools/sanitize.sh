#!/bin/sh
# Runs the attack on the compiled kernel under the address and undefined-behaviour sanitizers of gcc.
# usage: tools/sanitize.sh PYTHON [arguments of the attack]
set -eu
cd "$(dirname "$0")/.."
python=$1
shift
library=$(cc -print-file-name=libasan.so)
[ -e "$library" ] || { echo "No address sanitizer beside this compiler: nothing is tried."; exit 0; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp -R src tools setup.py pyproject.toml README.md LICENSE "$scratch"
rm -f "$scratch"/src/microslip/_core/kernels/_compiled*.so
(
    cd "$scratch"
    CFLAGS="-g -O1 -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined" \
        LDFLAGS="-fsanitize=address,undefined" "$python" setup.py -q build_ext --inplace
)
# Python keeps what it has until it ends, which is no leak of the kernel.
ASAN_OPTIONS=detect_leaks=0:abort_on_error=0 LD_PRELOAD="$library" \
    PYTHONPATH="$scratch/src:tests:benchmarks" PYTHONMALLOC=malloc OPENBLAS_NUM_THREADS=1 \
    "$python" -m attack "$@"
