#!/usr/bin/env bash
# What was reached against what was predicted, on drawn mock rigs: collect, calibrate, diagnose,
# validate, recommend, over real protocol bytes. Usage: scripts/reached.sh BIN_FOLDER [OUT_FOLDER]
# [RIG ...]. Prints the table of doc/diagnosis.md.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
bin=$(readlink -f "$1")
out=${2:-out/reached}
shift; shift || true
speed=${SIXDIAL_REACHED_SPEED:-40}
mkdir -p "$out"
out=$(readlink -f "$out")

# name, what the mock rig hides, its seed, how the plan approaches
rigs=(
  "demo|--robot table2 --warp 0.02 --hide joint_backlash:joint2:0.0006|2021|as-it-comes"
  "backlash|--robot drawn --hide joint_backlash:joint1:0.0008|11|as-it-comes"
  "backlash-both-sides|--robot drawn --warp 0.01 --hide joint_backlash:joint2:0.001|12|both-sides"
  "backlash-two|--robot drawn --hide joint_backlash:joint1:0.0005 --hide joint_eccentricity:joint2:0.006|13|alternate"
  "thermal|--robot drawn --warm-up 6 --hide link_thermal_growth|21|as-it-comes"
  "creep|--robot drawn --hide creep|22|as-it-comes"
  "drift|--robot drawn --hide base_drift|23|as-it-comes"
  "warp|--robot drawn --warp 0.03|31|as-it-comes"
  "warp-long|--robot drawn --warp 0.02 --warp-wavelength 60|32|as-it-comes"
  "compliance|--robot drawn --warp 0.01 --hide joint_compliance|41|as-it-comes"
  "dial|--robot drawn --hide dial_gain:C|42|as-it-comes"
  "warp-31|--robot drawn --warp 0.02|131|as-it-comes"
  "warp-32|--robot drawn --warp 0.02|132|as-it-comes"
  "warp-33|--robot drawn --warp 0.04 --warp-wavelength 50|133|as-it-comes"
  "warp-short|--robot drawn --warp 0.02 --warp-wavelength 25|134|as-it-comes"
  "warp-backlash|--robot drawn --warp 0.03 --hide joint_backlash:joint1:0.0005|135|as-it-comes"
  "warp-eccentric|--robot drawn --warp 0.02 --hide joint_eccentricity:joint2:0.002|136|as-it-comes"
  "outside-1|--robot drawn --hide-pool outside --hide-seed 1|137|as-it-comes"
  "outside-2|--robot drawn --hide-pool outside --hide-seed 2|138|as-it-comes"
  "outside-3|--robot drawn --hide-pool outside --hide-seed 3|139|as-it-comes"
  "outside-4|--robot drawn --hide-pool outside --hide-seed 4|140|as-it-comes"
  "outside-5|--robot drawn --hide-pool outside --hide-seed 5|141|as-it-comes"
  "clean|--robot drawn|51|as-it-comes"
)

wanted() { # name, asked for ...: no names mean all
  local name=$1 each
  shift
  [ $# -gt 0 ] || return 0
  for each in "$@"; do [ "$each" != "$name" ] || return 0; done
  return 1
}

one() { # name, options of the mock rig, seed, approach
  local name=$1 hidden=$2 seed=$3 approach=$4
  local folder=$out/$name run_dir mock_pid daemon_pid start
  rm -rf "$folder"
  mkdir -p "$folder"
  run_dir=$(mktemp -d "${TMPDIR:-/tmp}/sixdial-reached.XXXXXX")
  start=$(date -u +%Y-%m-%dT%H:%M:%S.000Z)
  # shellcheck disable=SC2086  # several options
  "$bin/sixdial-mock-rig" --speed "$speed" --start-time "$start" --seed "$seed" $hidden \
    --reveal "$folder/truth.json" >"$folder/mock.json" 2>"$folder/mock.log" &
  mock_pid=$!
  "$bin/sixdiald" --socket "$run_dir/s" --db "$folder/store.db" --clock-speed "$speed" \
    --clock-start "$start" 2>"$folder/service.log" &
  daemon_pid=$!
  # shellcheck disable=SC2064  # these processes, not later ones
  trap "kill -TERM $mock_pid $daemon_pid 2>/dev/null; wait; rm -rf '$run_dir'" RETURN
  local i
  for ((i = 0; i < 600; i++)); do
    if grep -qs '"ready":true' "$folder/mock.json" && [ -S "$run_dir/s" ]; then break; fi
    sleep 0.1
  done
  port() { sed -n "s/.*\"$1_port\":\([0-9]*\).*/\1/p" "$folder/mock.json"; }
  sed -e "s/ROBOT_PORT/$(port robot)/" -e "s/DIAL_PORT/$(port dial)/" examples/mock/rig.toml \
    >"$folder/rig.toml"
  sixdial() { "$bin/sixdial" --quiet --socket "$run_dir/s" "$@"; }
  {
    sixdial plan random --rig "$folder/rig.toml" --set G1 --count 100 --seed "$seed" \
      --approach "$approach" -o "$folder/g1.csv"
    sixdial plan random --rig "$folder/rig.toml" --set G2 --count 50 --seed $((seed + 1)) \
      --approach "$approach" -o "$folder/g2.csv"
    { cat "$folder/g1.csv"; tail -n +2 "$folder/g2.csv"; } >"$folder/plan.csv"
    sixdial session create run --rig "$folder/rig.toml"
    sixdial collect "$folder/plan.csv" --session run
    sixdial calibrate run --seed 1 -o "$folder/calibration.json"
    sixdial diagnose run --bootstrap 0 -o "$folder/diagnosis.json"
    sixdial recommend run -o "$folder/before_validation.json"
    sixdial validate run -o "$folder/validation.json"
    sixdial recommend run -o "$folder/recommendation.json"
    sixdial report run -o "$folder/report"
  } >"$folder/log.txt" 2>&1 || true
}

for each in "${rigs[@]}"; do
  IFS='|' read -r name hidden seed approach <<<"$each"
  wanted "$name" "$@" || continue
  one "$name" "$hidden" "$seed" "$approach"
done
python3 scripts/reached_table.py "$out"
