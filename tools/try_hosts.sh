#!/bin/sh
# Runs the joint in other people's programs, each in a throwaway environment of its own on top of
# one that has microslip and what it needs.
# WHEEL=dist/... is a wheel that is built already.
# usage: tools/try_hosts.sh PYTHON [HOST...], of opensees, fmu, lsdyna, jax, torch, octave, calculix
# PAGE=docs/hosts.md writes what was run, and what came, into the table between the page's markers.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
python=$1
shift
hosts=${*:-opensees fmu lsdyna jax torch octave calculix}
scratch=$(mktemp -d)
touch "$scratch/rows"
trap 'rm -rf "$scratch"' EXIT
export OPENBLAS_NUM_THREADS=1 PIP_DISABLE_PIP_VERSION_CHECK=1
cannot() { echo "cannot be tried: $name, $1" >&2; left=77; }
left=0
try() {  # NAME TESTS PACKAGES...
    name=$1
    tests=$2
    shift 2
    echo "== $name"
    [ "$name" != calculix ] || command -v ccx >/dev/null ||
        { cannot "no ccx on the PATH; apt-get install calculix-ccx, say"; return; }
    [ "$name" != octave ] || command -v mkoctfile >/dev/null ||
        { cannot "no mkoctfile on the PATH; apt-get install octave-dev, say"; return; }
    "$python" -m venv "$scratch/$name"
    site=$("$scratch/$name/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    echo "$below" > "$site/below.pth"
    [ $# -eq 0 ] || "$scratch/$name/bin/python" -m pip install --quiet --quiet "$@" ||
        { cannot "its packages cannot be installed here"; return; }
    [ "$name" != opensees ] || "$scratch/$name/bin/python" -c 'import openseespy.opensees' 2>/dev/null ||
        { cannot "openseespy does not load here; apt-get install libblas3 liblapack3, say"; return; }
    # -rs, and a skip is a failure: here everything is installed.
    (cd "$root" && "$scratch/$name/bin/python" -m pytest -q -rs -p no:cacheprovider -m "slow or not slow" $tests) \
        > "$scratch/out" 2>&1 || { cat "$scratch/out"; exit 1; }
    tail -n 3 "$scratch/out"
    package=${1:-microslip}
    version=$("$scratch/$name/bin/python" -m pip freeze 2>/dev/null | grep -i "^${package%%[=<>]*}==" | head -n 1) || version=
    [ "$name" != calculix ] || version="CalculiX $(ccx -v 2>/dev/null | grep -oE '[0-9]+\.[0-9]+' | head -n 1)"
    [ "$name" != octave ] || version="Octave $(octave-config -p VERSION)"
    counted=$(grep -oE "[0-9]+ passed" "$scratch/out" | tail -n 1)
    echo "| $name | $(echo "$version" | sed 's/==/ /') | $("$python" -c 'import platform; print(platform.python_version())') | $counted, none skipped |" >> "$scratch/rows"
    ! grep -q "SKIPPED" "$scratch/out" || { echo "$name: skipped, which it must not be here"; exit 1; }
    rm -rf "${scratch:?}/$name"
}
"$python" -m venv "$scratch/below"
"$scratch/below/bin/python" -m pip install --quiet --quiet pytest hypothesis "${WHEEL:-$root}"
below=$("$scratch/below/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
for host in $hosts; do
    case $host in
    opensees) try opensees tests/physics/test_hosts_opensees.py "openseespy==3.5.1.12" ;;  # Python 3.11
    fmu) try fmu tests/physics/test_hosts_fmu.py "fmpy>=0.3.20" ziglang ;;
    lsdyna) try lsdyna tests/physics/test_hosts_syntax.py "ansys-dyna-core>=0.12" ;;
    jax) try jax tests/physics/test_hosts_jax.py "jax>=0.4.34" ;;
    torch) try torch tests/physics/test_hosts_torch.py "torch>=2.4" ;;
    octave) try octave tests/physics/test_hosts_recipes.py ;;  # needs mkoctfile on the PATH
    calculix) try calculix tests/physics/test_hosts_calculix.py ;;  # needs ccx on the PATH
    *) echo "no host $host"; exit 2 ;;
    esac
done
[ -z "${PAGE:-}" ] || "$python" - "$root/$PAGE" "$scratch/rows" <<'END'
import pathlib, sys
page, rows = map(pathlib.Path, sys.argv[1:])
begin, end = "<!-- hosts: written by PAGE=docs/hosts.md make hosts -->", "<!-- hosts: end -->"
before, rest = page.read_text(encoding="utf-8").split(begin + "\n")
old, after = rest.split(end)
name = lambda line: line.split("|")[1].strip()
kept = {name(line): line for line in old.splitlines()[2:]}
kept |= {name(line): line for line in rows.read_text(encoding="utf-8").splitlines()}
head = ["| host | version | Python | its tests |", "| --- | --- | --- | --- |"]
page.write_text(before + "\n".join([begin, *head, *kept.values(), end]) + after, encoding="utf-8")
END
exit "$left"
