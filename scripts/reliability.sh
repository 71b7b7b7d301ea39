#!/usr/bin/env bash
# Runs what is tried in the suite at small size (crashes, failing disks, device faults, load, soak,
# fuzzing, package) at the sizes asked for, and writes doc/reliability.md from what came out.
# Usage: scripts/reliability.sh [--crashes N] [--power-seeds N] [--sweep-stride N] [--fault-repeats N]
#        [--load-seconds N] [--soak-hours N] [--soak-speed N] [--fuzz-seconds N] [--no-package] [--out FILE]
# The full run: scripts/reliability.sh --crashes 10000 --power-seeds 50 --fault-repeats 200 --load-seconds 600 --fuzz-seconds 600
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

crashes=1000 power_seeds=5 sweep_stride=1 fault_repeats=20 load_seconds=30 soak_hours=24 soak_speed=1000
fuzz_seconds=20 package=1 page=doc/reliability.md
command="scripts/reliability.sh $*"
die() { printf 'reliability: %s\n' "$*" >&2; exit 1; }
while [ $# -gt 0 ]; do
  case $1 in
    --no-package) package=0; shift; continue ;;
    --crashes | --power-seeds | --sweep-stride | --fault-repeats | --load-seconds | --soak-hours | --soak-speed | --fuzz-seconds)
      [[ ${2:-} =~ ^[0-9]+$ ]] || die "$1 needs a number"
      name=${1#--}
      declare "${name//-/_}=$2" ;;
    --out) page=${2:?--out needs a file} ;;
    -h | --help) sed -n '2,7s/^# //p' "$0"; exit 0 ;;
    *) die "unknown option $1; see --help" ;;
  esac
  shift 2
done

bin=build/release/bin
logs=out/reliability
rm -rf "$logs"
mkdir -p "$logs"
begun=$SECONDS
failed=0
say() { printf '\n== %s  [%d s]\n' "$*" $((SECONDS - begun)); }
run() {  # log, what ...: its output goes to the log; a failure is remembered and shown
  local log=$logs/$1.log
  shift
  if ! "$@" >"$log" 2>&1; then
    failed=1
    echo "FAILED: $*"
    tail -20 "$log"
  fi
  grep -aE '^(FIGURE|FAULT) ' "$log" || true
}

say "Building"
mkdir -p build/release
cmake --preset release -DSIXDIAL_TESTS=ON >"$logs/configure.log" 2>&1 || { tail "$logs/configure.log"; die "configuring failed"; }
cmake --build build/release --target programs test_db test_acquisition test_service test_fuzz -j "$(nproc)" \
  >"$logs/build.log" 2>&1 || { tail -30 "$logs/build.log"; die "building failed"; }

say "Store: kill -9 at random moments, $crashes times"
run crashes env SIXDIAL_CRASHES="$crashes" $bin/test_db --gtest_filter='StoreFile.LosesNo*'
say "Store: every write, sync and truncation of a session fails; power goes at each"
run store env SIXDIAL_SWEEP_STRIDE="$sweep_stride" SIXDIAL_POWER_SEEDS="$power_seeds" \
  $bin/test_db --gtest_filter='StoreFaults.*:StoreFile.*Schema*:StoreFile.StopsWhen*'
say "Devices: each fault, $fault_repeats times, at the rig's own speed"
run devices env SIXDIAL_FAULT_REPEATS="$fault_repeats" SIXDIAL_FAULT_SPEED=1 \
  $bin/test_acquisition --gtest_filter='DeviceFaults.*:*Late*:*Unplugged*:*Replugged*'
say "Devices: scans a second"
run throughput env SIXDIAL_THROUGHPUT_SECONDS=5 $bin/test_acquisition --gtest_filter='*Throughput*'
say "Service: daemon, handed-over socket, killed while it collects"
run daemon $bin/test_service --gtest_filter='Daemon.*:SocketActivation.*:Rights.*:PythonClient.*:Methods.EveryExample*:Events.*'
say "Service: 64 clients for $load_seconds s while a session is collected"
run load env SIXDIAL_LOAD_SECONDS="$load_seconds" $bin/test_service --gtest_filter='Load.*'
say "Service: $soak_hours h of the rig's time, clock x$soak_speed"
run soak env SIXDIAL_SOAK_MINUTES=$((soak_hours * 60)) SIXDIAL_SOAK_SPEED="$soak_speed" \
  $bin/test_service --gtest_filter='Soak.*'
say "Corpus of the fuzzers"
run corpus $bin/test_fuzz

fuzzed="not run (no clang)"
if [ "$fuzz_seconds" -gt 0 ] && command -v clang++ >/dev/null; then
  say "Fuzzers, $fuzz_seconds s each"
  if cmake -G Ninja -S . -B build/fuzz -DSIXDIAL_FUZZ=ON -DSIXDIAL_BENCH=OFF -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_C_COMPILER=clang >"$logs/fuzz-configure.log" 2>&1 &&
    cmake --build build/fuzz --target fuzzers -j "$(nproc)" >"$logs/fuzz-build.log" 2>&1; then
    fuzzed=yes
    for fuzzer in fuzz_dials fuzz_modbus_reply fuzz_connection fuzz_request session_csv_fuzz session_rig_fuzz; do
      corpus=tests/fuzz/${fuzzer#fuzz_}_corpus
      corpus=${corpus/_fuzz_corpus/_corpus}
      mkdir -p "$logs/found_$fuzzer"
      if ! build/fuzz/bin/"$fuzzer" -max_total_time="$fuzz_seconds" -artifact_prefix="$logs/$fuzzer-" \
        -print_final_stats=1 "$logs/found_$fuzzer" "$corpus" >"$logs/$fuzzer.log" 2>&1; then
        failed=1
        echo "FAILED: $fuzzer"
        tail -20 "$logs/$fuzzer.log"
      fi
      runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$logs/$fuzzer.log")
      findings=$(find "$logs" -maxdepth 1 -name "$fuzzer-*" | wc -l)
      echo "FIGURE fuzz.$fuzzer.executions ${runs:-0}" | tee -a "$logs/fuzz.log"
      echo "FIGURE fuzz.$fuzzer.findings $findings" | tee -a "$logs/fuzz.log"
    done
  else
    tail -20 "$logs/fuzz-build.log" || true
    failed=1
  fi
fi

if [ "$package" = 1 ]; then
  say "Package"
  stage=$(mktemp -d)
  trap 'rm -rf "$stage"' EXIT
  DESTDIR=$stage cmake --install build/release --prefix /usr >"$logs/install.log" 2>&1 || failed=1
  echo "FIGURE package.files $(find "$stage" -type f | wc -l)" | tee "$logs/package.log"
  (cd build/release && cpack -G DEB --config CPackConfig.cmake) >"$logs/cpack.log" 2>&1 || failed=1
  deb=$(find build/release -maxdepth 1 -name '*.deb' | head -1)
  [ -n "$deb" ] || die "no package was made; see $logs/cpack.log"
  echo "FIGURE package.bytes $(stat -c %s "$deb")" | tee -a "$logs/package.log"
  if command -v lintian >/dev/null; then
    lintian "$deb" >"$logs/lintian.log" 2>&1 || true
    echo "FIGURE package.lintian_errors $(grep -c '^E:' "$logs/lintian.log" || true)" | tee -a "$logs/package.log"
    echo "FIGURE package.lintian_warnings $(grep -c '^W:' "$logs/lintian.log" || true)" | tee -a "$logs/package.log"
  fi
fi

say "Writing $page"
[ "$failed" = 0 ] || die "something failed; $page is left as it was, the logs are in $logs"
python3 scripts/reliability_page.py "$logs" "$command" "$((SECONDS - begun))" "$fuzzed" >"$logs/page.md"
cp "$logs/page.md" "$page"
say "Done"
