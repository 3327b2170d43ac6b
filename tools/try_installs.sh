#!/bin/sh
# Installs a wheel where users put things, and runs it the ways they run Python.
# usage: tools/try_installs.sh WHEEL PYTHON, where PYTHON has the packages that the wheel needs
set -eu
wheel=$1
python=$2
scratch=$(mktemp -d)
trap 'chmod -R u+w "$scratch"; rm -rf "$scratch"' EXIT
place="$scratch/two words, é and ü"
mkdir "$place"
"$python" -m zipfile -e "$wheel" "$place/site packages"  # what installing does, wherever there is no pip
export PYTHONPATH="$place/site packages" PYTHONDONTWRITEBYTECODE=1
chmod -R a-w "$place/site packages"
cat > "$place/études.toml" <<'STUDY'
schema = 1
title = "Étude"

[material.al]
young_modulus = "69 GPa"
poisson_ratio = 0.33

[surface]
law = "greenwood-williamson"
materials = ["al", "al"]
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"
heights = { kind = "gaussian", std = "0.5 um" }

[joint]
friction_coefficient = 0.55
normal_load = "2 kN"

[excitation]
amplitudes = ["0.1 um", "1 um"]
STUDY
cd "$place"
count=0
run() {
    count=$((count + 1))
    "$@" >"$scratch/out" 2>&1 || { echo "failed: $*"; cat "$scratch/out"; exit 1; }
}
code='import microslip as ms
pair = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material(69e9, 0.33))
surface = ms.GreenwoodWilliamson(pair, ms.Gaussian(5e-7), radius=1e-3, density=1e8, area=2e-4)
joint = ms.Interface(surface, 0.55, normal_load=2000.0)
value = float(joint.loss_factor(3e-7))
if abs(value - 0.304693) > 1e-5 or "site packages" not in ms.__file__:
    raise SystemExit(f"{value} from {ms.__file__}")'
for options in "" "-O" "-OO" "-bb" "-W error" "-X dev" "-s -B"; do
    # shellcheck disable=SC2086 - options are words
    run "$python" $options -c "$code"
    # shellcheck disable=SC2086
    run "$python" $options -m microslip check études.toml
done
for locale in C POSIX C.UTF-8 tr_TR.UTF-8; do
    run env LC_ALL="$locale" "$python" -W error -m microslip check études.toml
    run env LC_ALL="$locale" PYTHONUTF8=0 "$python" -m microslip check études.toml
done
run env -u HOME "$python" -m microslip predict études.toml -o résultat
run env -u HOME HOME=/nowhere MPLCONFIGDIR=/nowhere/too "$python" -m microslip predict études.toml -o "un autre"
[ -s "résultat/summary.json" ] && [ -s "un autre/summary.json" ]
echo "$count runs of the installed wheel are as they should be."
