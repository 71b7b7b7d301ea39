#!/usr/bin/env bash
# The main job on the mock rig: collect G1 and G2 over real protocol bytes, calibrate through the
# service's socket, report. Usage: scripts/demo.sh BIN_FOLDER [OUT_FOLDER]
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
bin=$(readlink -f "$1")
out=${2:-out/demo}
speed=${SIXDIAL_DEMO_SPEED:-20}
begun=$SECONDS

say() { printf '\n-- %s  [%d s]\n' "$*" $((SECONDS - begun)); }
die() { printf 'demo: %s\n' "$*" >&2; exit 1; }

rm -rf "$out"
mkdir -p "$out"
out=$(readlink -f "$out")
# A Unix socket's path is short; the output folder's may not be.
run_dir=$(mktemp -d "${TMPDIR:-/tmp}/sixdial-demo.XXXXXX")
socket=$run_dir/sixdiald.sock
mock_pid='' daemon_pid=''
finish() {
  [ -z "$daemon_pid" ] || kill -TERM "$daemon_pid" 2>/dev/null || true
  [ -z "$mock_pid" ] || kill -TERM "$mock_pid" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$run_dir"
}
trap finish EXIT
wait_for() {  # what, command ...: up to a minute
  local what=$1 i
  shift
  for ((i = 0; i < 600; i++)); do
    "$@" && return 0
    sleep 0.1
  done
  die "$what did not come up; see $out/*.log"
}
sixdial() { "$bin/sixdial" --socket "$socket" "$@"; }

start=$(date -u +%Y-%m-%dT%H:%M:%S.000Z)
say "Mock rig as rigs are: dials misplaced (standard deviation 0.03 mm along, 0.1 mm across the axis), each with an error curve; the paper's Table 2"
echo "   robot with small faults, a smooth error of 0.02 mm rms and a hidden backlash; clock x$speed"
"$bin/sixdial-mock-rig" --speed "$speed" --start-time "$start" --robot table2 --seed 2021 \
  --workshop --warp 0.02 --hide joint_backlash:joint2:0.0006 >"$out/mock-rig.json" 2>"$out/mock-rig.log" &
mock_pid=$!
wait_for "the mock rig" grep -q '"ready":true' "$out/mock-rig.json"
port() { sed -n "s/.*\"$1_port\":\([0-9]*\).*/\1/p" "$out/mock-rig.json"; }
sed -e "s/ROBOT_PORT/$(port robot)/" -e "s/DIAL_PORT/$(port dial)/" examples/mock/rig.toml >"$out/rig.toml"
echo "   dials on port $(port dial), robot controller on port $(port robot) (Modbus TCP)"

say "Service on a Unix socket, with its SQLite store"
"$bin/sixdiald" --socket "$socket" --db "$out/sixdial.db" --clock-speed "$speed" \
  --clock-start "$start" 2>"$out/sixdiald.log" &
daemon_pid=$!
wait_for "the service" test -S "$socket"
sixdial hello

say "Plan: 100 points G1 to calibrate, 50 points G2 to validate"
sixdial plan random --rig "$out/rig.toml" --set G1 --count 100 --seed 1 -o "$out/g1.csv"
sixdial plan random --rig "$out/rig.toml" --set G2 --count 50 --seed 2 -o "$out/g2.csv"
{ cat "$out/g1.csv"; tail -n +2 "$out/g2.csv"; } >"$out/plan.csv"

say "Collecting 150 points: move, settle, read six dials, check, store"
sixdial session create demo --rig "$out/rig.toml"
collecting=$SECONDS
sixdial collect "$out/plan.csv" --session demo
printf '   collected in %d s\n' $((SECONDS - collecting))

say "Calibrating: EKF, two quantum-behaved particle swarms, ANFIS"
sixdial calibrate demo --seed 1 -o "$out/result.json"

say "Diagnosis: what the simulation gets wrong, and why"
sixdial --quiet diagnose demo --report "$out/diagnosis.html" -o "$out/diagnosis.json" >"$out/diagnosis.txt" 2>/dev/null
awk 'NF == 0 { exit } { print "   " $0 }' "$out/diagnosis.txt"

say "Which model to command by, and why"
sixdial recommend demo -o "$out/recommendation.json"

say "Compensation, tried: the G2 targets commanded by each model and measured again (Fig. 7)"
sixdial compensate demo --target 28,48
validating=$SECONDS
sixdial validate demo -o "$out/validation.json"
printf '   validated in %d s\n' $((SECONDS - validating))

say "Report, bundle, numbers"
sixdial report demo -o "$out/report"
sixdial session export demo "$out/bundle"

say "Diagnosis: $(head -1 "$out/diagnosis.txt")"
say "Done. Look at:"
find "$out" -type f ! -name '*.log' ! -name 'sixdial.db-*' | sort | sed "s|^$PWD/|   |"
