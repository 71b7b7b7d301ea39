#!/usr/bin/env bash
# The main job on the mock rig: collect G1 and G2 over real protocol bytes, calibrate through the
# service's socket, report. Usage: scripts/demo.sh BIN_FOLDER [--robot five_bar|serial] [OUT_FOLDER]
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
bin=$(readlink -f "$1")
shift
robot=five_bar
if [ "${1:-}" = --robot ]; then
  robot=${2:-}
  shift $(($# < 2 ? $# : 2))
fi
case $robot in
  five_bar | serial) ;;
  *) printf "demo: no robot '%s'; known are five_bar and serial\n" "$robot" >&2; exit 2 ;;
esac
out=${1:-out/demo}
[ "$robot" = five_bar ] || out=${1:-out/demo_$robot}
# shellcheck source=scripts/demo_steps.sh
source scripts/demo_steps.sh

five_bar() {
  say "Mock rig as rigs are: dials misplaced (standard deviation 0.03 mm along, 0.1 mm across the axis), each with an error curve; the paper's Table 2"
  echo "   robot with small faults, a smooth error of 0.02 mm rms and a hidden backlash; clock x$speed"
  start_mock --robot table2 --seed 2021 --workshop --warp 0.02 --hide joint_backlash:joint2:0.0006
  sed -e "s/ROBOT_PORT/$(port robot)/" -e "s/DIAL_PORT/$(port dial)/" examples/mock/rig.toml >"$out/rig.toml"
  echo "   dials on port $(port dial), robot controller on port $(port robot) (Modbus TCP)"
  start_service
  plan_points 100 50
  collect_plan "six dials"

  say "Calibrating: EKF, two quantum-behaved particle swarms, ANFIS"
  sixdial calibrate demo --seed 1 -o "$out/result.json"
  name_causes

  say "Which model to command by, and why"
  sixdial recommend demo -o "$out/recommendation.json"

  say "Compensation, tried: the G2 targets commanded by each model and measured again (Fig. 7)"
  sixdial compensate demo --target 28,48
  local validating=$SECONDS
  sixdial validate demo -o "$out/validation.json"
  printf '   validated in %d s\n' $((SECONDS - validating))
}

serial() {
  say "Mock arm: six joints in series with lengths of their own, a hidden backlash, six draw wires from its tool to anchors; clock x$speed"
  start_mock --robot serial --joints 6 --seed 2021 --hide joint_backlash:joint2:0.0006 \
    --write-rig "$out/rig.toml"
  echo "   wires on port $(port dial), robot controller on port $(port robot) (Modbus TCP)"
  start_service
  plan_points 120 50
  collect_plan "six wires"

  say "Calibrating the arm (Levenberg-Marquardt; the paper's two swarms take a minute longer with thirty parameters)"
  sixdial calibrate demo --method lm -o "$out/result.json"
  name_causes
}

"$robot"
say "Report, bundle, numbers"
sixdial report demo -o "$out/report"
sixdial session export demo "$out/bundle"
list_results
