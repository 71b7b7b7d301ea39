#!/usr/bin/env bash
# Runs what is tried in the suite at small size (crashes, failing disks, device faults, load, soak,
# fuzzing, package) at the sizes asked for, and writes doc/reliability.md from what came out.
# Usage: scripts/reliability.sh [--only PARTS] [--crashes N] [--power-seeds N] [--sweep-stride N]
#        [--fault-repeats N] [--load-seconds N] [--soak-hours N] [--soak-speed N] [--fuzz-seconds N]
#        [--keep-corpus] [--trial-root DIR] [--page-only] [--out FILE]
# PARTS: store,devices,service,fuzz,package, any of them; all without --only. A part's logs, with the
# command, date and size, replace its former ones in out/reliability/PART once it has passed (else they
# are in out/reliability/PART.failed); the page is made from the newest of each part, and keeps the
# section of a part that has no logs here. --page-only: just that.
# --keep-corpus: inputs that reach new code are merged into tests/fuzz/*_corpus, as few as do; without it
# they wait in out/reliability/corpus. --trial-root: the package is also installed, used and removed in
# that Debian 12 root (scripts/package_trial.sh --help).
# The full run: scripts/reliability.sh --crashes 10000 --power-seeds 50 --fault-repeats 50 --load-seconds 600 --fuzz-seconds 600
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

crashes=1000 power_seeds=5 sweep_stride=1 fault_repeats=20 load_seconds=30 soak_hours=24 soak_speed=1000
fuzz_seconds=20 only=store,devices,service,fuzz,package keep_corpus=0 trial_root="" page=doc/reliability.md
die() { printf 'reliability: %s\n' "$*" >&2; exit 1; }
while [ $# -gt 0 ]; do
  case $1 in
    --keep-corpus) keep_corpus=1; shift; continue ;;
    --page-only) only=""; shift; continue ;;
    --crashes | --power-seeds | --sweep-stride | --fault-repeats | --load-seconds | --soak-hours | --soak-speed | --fuzz-seconds)
      [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || die "$1 needs a number above 0"
      name=${1#--}
      declare "${name//-/_}=$2" ;;
    --only)
      only=${2:?--only needs parts}
      for part in ${only//,/ }; do
        [[ $part =~ ^(store|devices|service|fuzz|package)$ ]] || die "no part '$part'; see --help"
      done ;;
    --trial-root) trial_root=${2:?--trial-root needs a folder} ;;
    --out) page=${2:?--out needs a file} ;;
    -h | --help) sed -n '2,/^set -/{s/^# //p}' "$0"; exit 0 ;;
    *) die "unknown option $1; see --help" ;;
  esac
  shift 2
done

bin=build/release/bin
out=out/reliability
mkdir -p "$out"
begun=$SECONDS
failed_parts=()
say() { printf '\n== %s  [%d s]\n' "$*" $((SECONDS - begun)); }
run() {  # log, what ...: its output goes to the part's log; a failure is remembered and shown
  local log=$logs/$1.log
  shift
  if ! "$@" >"$log" 2>&1; then
    failed=1
    echo "FAILED: $*"
    tail -20 "$log"
  fi
  grep -aE '^(FIGURE|FAULT) ' "$log" || true
}
figure() { echo "FIGURE $2 $3" | tee -a "$logs/$1.log"; }

configured=0
build() {  # targets of build/release
  if [ "$configured" = 0 ]; then
    say "Building"
    mkdir -p build/release
    cmake --preset release -DSIXDIAL_TESTS=ON >"$out/configure.log" 2>&1 ||
      { tail "$out/configure.log"; die "configuring failed"; }
    configured=1
  fi
  cmake --build build/release --target "$@" -j "$(nproc)" >"$out/build.log" 2>&1 ||
    { tail -30 "$out/build.log"; die "building failed"; }
}

# Each part says in `size` what it was run with.
part_store() {
  size="--crashes $crashes --power-seeds $power_seeds --sweep-stride $sweep_stride"
  build test_db
  say "Store: kill -9 at random moments, $crashes times"
  run crashes env SIXDIAL_CRASHES="$crashes" $bin/test_db --gtest_filter='StoreFile.LosesNo*'
  say "Store: every write, sync and truncation of a session fails; power goes at each"
  run store env SIXDIAL_SWEEP_STRIDE="$sweep_stride" SIXDIAL_POWER_SEEDS="$power_seeds" \
    $bin/test_db --gtest_filter='StoreFaults.*:StoreFile.*Schema*:StoreFile.StopsWhen*'
}

part_devices() {
  size="--fault-repeats $fault_repeats"
  build test_acquisition
  say "Devices: each fault, $fault_repeats times, at the rig's own speed"
  run devices env SIXDIAL_FAULT_REPEATS="$fault_repeats" SIXDIAL_FAULT_SPEED=1 \
    $bin/test_acquisition --gtest_filter='DeviceFaults.*:*Late*:*Unplugged*:*Replugged*'
  say "Devices: scans a second"
  run throughput env SIXDIAL_THROUGHPUT_SECONDS=5 $bin/test_acquisition --gtest_filter='*Throughput*'
}

part_service() {
  size="--load-seconds $load_seconds --soak-hours $soak_hours --soak-speed $soak_speed"
  build programs test_service
  say "Service: daemon, handed-over socket, full disk, stepping clock, killed while it collects"
  run daemon $bin/test_service --gtest_filter='Daemon*:SocketActivation.*:Rights.*:PythonClient.*:Methods.EveryExample*:Events.*:DiskTrouble.*:SteppingClock.*'
  say "Service: 64 clients for $load_seconds s while a session is collected"
  run load env SIXDIAL_LOAD_SECONDS="$load_seconds" $bin/test_service --gtest_filter='Load.*'
  say "Service: $soak_hours h of the rig's time, clock x$soak_speed"
  run soak env SIXDIAL_SOAK_MINUTES=$((soak_hours * 60)) SIXDIAL_SOAK_SPEED="$soak_speed" \
    $bin/test_service --gtest_filter='Soak.*'
}

part_fuzz() {
  size="--fuzz-seconds $fuzz_seconds"
  local fuzzer corpus found runs
  command -v clang++ >/dev/null || die "the fuzzers need clang: apt-get install clang libclang-rt-14-dev"
  build test_fuzz
  say "Corpus of the fuzzers"
  run corpus $bin/test_fuzz
  say "Fuzzers, $fuzz_seconds s each"
  if ! { cmake -G Ninja -S . -B build/fuzz -DSIXDIAL_FUZZ=ON -DSIXDIAL_BENCH=OFF -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_C_COMPILER=clang && cmake --build build/fuzz --target fuzzers -j "$(nproc)"; } >"$logs/build.log" 2>&1; then
    tail -20 "$logs/build.log"
    failed=1
    return
  fi
  for fuzzer in $(<tests/fuzz/fuzzers.txt); do
    corpus=tests/fuzz/${fuzzer#fuzz_}_corpus
    corpus=${corpus/_fuzz_corpus/_corpus}
    found=$out/corpus/$fuzzer
    mkdir -p "$found"
    if ! build/fuzz/bin/"$fuzzer" -max_total_time="$fuzz_seconds" -artifact_prefix="$logs/finding-$fuzzer-" \
      -print_final_stats=1 "$found" "$corpus" >"$logs/$fuzzer.log" 2>&1; then
      failed=1
      echo "FAILED: $fuzzer"
      tail -20 "$logs/$fuzzer.log"
    fi
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$logs/$fuzzer.log")
    figure fuzz "fuzz.$fuzzer.executions" "${runs:-0}"
    figure fuzz "fuzz.$fuzzer.findings" "$(find "$logs" -maxdepth 1 -name "finding-$fuzzer-*" | wc -l)"
    [ "$keep_corpus" = 1 ] || continue
    keep "$fuzzer" "$corpus" "$found" || failed=1
  done
}

keep() {  # fuzzer, corpus, found: as few of the found as reach what the corpus does not
  local before file name
  before=$(find "$2" -type f | wc -l)
  build/fuzz/bin/"$1" -merge=1 "$2" "$3" >"$logs/merge-$1.log" 2>&1 || return 1
  for file in "$2"/*; do  # libFuzzer's names are 40 digits long
    name=${file##*/}
    [ ${#name} = 40 ] && mv "$file" "$2/${name:0:12}"
  done
  echo "   $(($(find "$2" -type f | wc -l) - before)) inputs more in $2"
}

part_package() {
  size="--only package${trial_root:+ --trial-root DIR}"
  local deb
  build programs test_service
  say "Package"
  stage=$(mktemp -d)
  trap 'rm -rf "$stage"' EXIT
  DESTDIR=$stage cmake --install build/release --prefix /usr >"$logs/install.log" 2>&1 || failed=1
  figure package package.files "$(find "$stage" -type f | wc -l)"
  rm -f build/release/*.deb
  (cd build/release && cpack -G DEB --config CPackConfig.cmake) >"$logs/cpack.log" 2>&1 || failed=1
  deb=$(find build/release -maxdepth 1 -name '*.deb' | head -1)
  [ -n "$deb" ] || die "no package was made; see $logs/cpack.log"
  figure package package.bytes "$(stat -c %s "$deb")"
  if command -v lintian >/dev/null; then
    lintian "$deb" >"$logs/lintian.log" 2>&1 || true
    cat "$logs/lintian.log"
    figure package package.lintian_errors "$(grep -c '^E:' "$logs/lintian.log" || true)"
    figure package package.lintian_warnings "$(grep -c '^W:' "$logs/lintian.log" || true)"
  fi
  run units $bin/test_service --gtest_filter='Units.*:Manual.*:Completion.*:ExampleRigs.*:SocketActivation.*'
  if [ -n "$trial_root" ]; then
    say "Package: installed, used and removed in a Debian 12 root"
    run trial scripts/package_trial.sh --root "$trial_root" --deb "$deb"
  fi
}

for part in ${only//,/ }; do
  logs=$out/$part.failed
  rm -rf "$logs"
  mkdir -p "$logs"
  failed=0
  size=""
  part_begun=$SECONDS
  "part_$part"
  {
    # A folder of this machine is nothing for the page.
    echo "command=scripts/reliability.sh --only $part ${size#"--only $part"}"
    echo "date=$(date -u +%Y-%m-%d)"
    echo "seconds=$((SECONDS - part_begun))"
    echo "commit=$(git rev-parse --short=10 HEAD 2>/dev/null || echo unknown)"
  } | sed 's/  */ /g; s/ $//' >"$logs/about"
  if [ "$failed" = 1 ]; then
    failed_parts+=("$part")
  else
    rm -rf "${out:?}/$part"
    mv "$logs" "$out/$part"
  fi
done

say "Writing $page"
python3 scripts/reliability_page.py "$out" "$page" >"$out/page.md" || die "$page is left as it was"
cp "$out/page.md" "$page"
[ ${#failed_parts[@]} = 0 ] ||
  die "failed: ${failed_parts[*]}; their sections are left as they were, their logs are in $out/*.failed"
say "Done"
