#!/usr/bin/env bash
# Measures every figure of doc/accuracy.md and writes the page.
#   scripts/accuracy.sh [--bin FOLDER] [--runs 9] [--peers FOLDER | --no-peers] [--only-peers]
# --peers: programs that do the same calibration in Octave, NumPy/SciPy and Ceres, run side by side
# with ours on the same data; default ../shared/peers/calibration if it is there. Without them
# that table stays as of its last run; --only-peers makes that table alone.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
bin=build/release/bin runs=9 peers='' only_peers=''
[ -d ../shared/peers/calibration ] && peers=../shared/peers/calibration
while [ $# -gt 0 ]; do
  case $1 in
    --bin) bin=$2; shift 2 ;;
    --runs) runs=$2; shift 2 ;;
    --peers) peers=$2; shift 2 ;;
    --no-peers) peers=''; shift ;;
    --only-peers) only_peers=1; shift ;;
    *) sed -n '2,7s/^# //p' "$0"; exit 2 ;;
  esac
done
die() { printf 'accuracy: %s\n' "$*" >&2; exit 1; }
say() { printf -- '-- %s  [%d s]\n' "$*" $SECONDS; }
for program in stage_run qpso_study test_calibration sixdial; do
  [ -x "$bin/$program" ] || die "$bin/$program is missing: cmake --build build/release"
done
out=$(mktemp -d "${TMPDIR:-/tmp}/sixdial-accuracy.XXXXXX")
trap 'rm -rf "$out"' EXIT
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1

# Timings go before whatever else the machine does, where that is allowed.
first=()
chrt -f 20 true 2>/dev/null && first=(chrt -f 20)
# One thread against two, between the other steps: a machine that others use has its quiet moments.
round=0
two_threads() {
  local threads
  round=$((round + 1))
  for threads in 1 2; do
    "${first[@]}" "$bin/stage_run" --runs $((2 * runs)) --threads $threads \
      --stages qpso1_at_nominal,qpso1_at_estimate,qpso2_raw,qpso2_whitened,whole_paper,whole_default \
      >"$out/threads_${threads}_$round.json"
  done
}

measure_ours() {
  say 'Times of the stages, one and two threads'
  "${first[@]}" "$bin/stage_run" --runs "$runs" >"$out/stages.json"
  two_threads

  say 'Memory, and cost from 100 to 100 000 points'
  "$bin/stage_run" --runs 1 --stages whole_default >"$out/memory.json"
  for points in 100 1000 10000 100000; do
    "${first[@]}" "$bin/stage_run" --runs 1 --points $points --epochs 5 \
      --stages ekf_once,lm,qpso1_at_nominal,qpso2_raw,anfis_paper >"$out/points_$points.json"
  done

  if command -v valgrind >/dev/null; then
    say 'Instructions, by callgrind'
    for stage in ekf_once lm qpso1_at_nominal qpso1_at_estimate qpso2_raw qpso2_whitened anfis_paper \
      anfis_chosen; do
      two_threads
      for n in 1 2; do
        valgrind --tool=callgrind --callgrind-out-file="$out/callgrind.$stage.$n" \
          "$bin/stage_run" --runs $n --stages $stage >/dev/null 2>&1 || die "callgrind failed on $stage"
      done
    done
  fi

  say 'Table 6, and how near the swarm comes to the least-squares minimum'
  "$bin/stage_run" --table6 >"$out/table6.json"
  "$bin/sixdial" compare tests/data/sessions/00 --json >"$out/session_00.json"

  say 'NIST, Mackey-Glass, dial readings against positions'
  "$bin/test_calibration" --gtest_filter='*Nist*:*Mackey*:Precision*:Network.*:Pipeline.EndsAt*' >"$out/tests.txt" ||
    { grep -A8 Failure "$out/tests.txt" >&2; die 'a test failed: nothing was written'; }

  say 'The swarm on the standard functions'
  "$bin/qpso_study" >"$out/qpso.txt"
}
[ -n "$only_peers" ] || measure_ours

if [ -n "$peers" ]; then
  [ -f "$peers/make_data.py" ] || die "no make_data.py in $peers"
  needed=(octave python3-numpy python3-scipy python3-sklearn libceres-dev libpagmo-dev libopenblas0-pthread)
  missing=()
  for package in "${needed[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  if [ ${#missing[@]} -gt 0 ]; then
    [ "$(id -u)" = 0 ] || die "the peers need: apt-get install ${missing[*]}"
    say "Installing ${missing[*]}"
    DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" \
      >"$out/apt.log" 2>&1 || { tail -5 "$out/apt.log" >&2; die 'apt-get failed'; }
  fi
  say 'The peers, side by side with ours on the same points'
  /usr/bin/python3 "$peers/make_data.py" -o "$out/data.csv" >/dev/null
  { cmake -S "$peers/ceres" -B "$out/peers" && cmake --build "$out/peers" --target fit_ceres; } \
    >"$out/peers.log" 2>&1 || { tail -5 "$out/peers.log" >&2; die 'the Ceres peer does not build'; }
  for k in 1 2 3; do
    [ -n "$only_peers" ] || two_threads
    "${first[@]}" "$bin/stage_run" --data "$out/data.csv" --runs "$runs" >"$out/peer_ours_$k.json"
    "${first[@]}" "$out/peers/fit_ceres" "$out/data.csv" >"$out/peer_ceres_$k.json"
    for mode in vectorised relin loop; do
      "${first[@]}" /usr/bin/python3 "$peers/python/calibrate.py" "$out/data.csv" "$out/peer_numpy-${mode}_$k.json" $mode
      "${first[@]}" octave-cli --norc --no-history "$peers/octave/calibrate.m" "$out/data.csv" \
        "$out/peer_octave-${mode}_$k.json" $mode >/dev/null 2>&1
    done
  done
fi

/usr/bin/python3 scripts/accuracy_page.py "$out" doc/accuracy.md
say 'doc/accuracy.md is written'
