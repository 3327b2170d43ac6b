#!/bin/sh
# Runs the joint in other people's programs, each in a throwaway environment of its own.
# usage: tools/try_hosts.sh PYTHON [HOST...], of opensees, fmu, nastran, lsdyna, pyharm, calculix
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
python=$1
shift
hosts=${*:-opensees fmu nastran lsdyna pyharm calculix}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export OPENBLAS_NUM_THREADS=1 PIP_DISABLE_PIP_VERSION_CHECK=1
try() {  # NAME TESTS PACKAGES...
    name=$1
    tests=$2
    shift 2
    echo "== $name"
    "$python" -m venv "$scratch/$name"
    "$scratch/$name/bin/python" -m pip install --quiet --quiet "$root" pytest hypothesis "$@"
    # -rs, and a skip is a failure: here everything is installed.
    (cd "$root" && "$scratch/$name/bin/python" -m pytest -q -rs -p no:cacheprovider -m "slow or not slow" $tests) \
        > "$scratch/out" 2>&1 || { cat "$scratch/out"; exit 1; }
    tail -n 3 "$scratch/out"
    ! grep -q "SKIPPED" "$scratch/out" || { echo "$name: skipped, which it must not be here"; exit 1; }
    rm -rf "${scratch:?}/$name"
}
for host in $hosts; do
    case $host in
    opensees) try opensees tests/physics/test_hosts_opensees.py "openseespy==3.5.1.12" ;;  # Python 3.11
    fmu) try fmu tests/physics/test_hosts_fmu.py "fmpy>=0.3.20" ;;
    nastran) try nastran "tests/physics/test_hosts_syntax.py -k nastran" "pyNastran>=1.4" ;;
    lsdyna) try lsdyna "tests/physics/test_hosts_syntax.py -k lsdyna" "ansys-dyna-core>=0.12" ;;
    pyharm) try pyharm tests/physics/test_hosts_pyharm.py "pyHarm-os>=1.2,<1.3" ;;
    calculix) try calculix tests/physics/test_hosts_calculix.py ;;  # needs ccx on the PATH
    *) echo "no host $host"; exit 2 ;;
    esac
done
