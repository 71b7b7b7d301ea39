#!/usr/bin/env bash
# Format and static checks over the tracked sources. Configures build/check for its
# compile_commands.json (without precompiled headers, which clang-tidy cannot read from GCC) and makes
# the generated sources that it names.
#   scripts/check.sh           clang-tidy reads the folders that everything stands on
#   scripts/check.sh quick     everything but clang-tidy
#   scripts/check.sh changed   the files of the last commits, newest first, for four minutes at most
#   scripts/check.sh all       every folder, tests and benchmarks too
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
what=${1:-base}
tidy_seconds=${SIXDIAL_TIDY_SECONDS:-240}

mapfile -t sources < <(git ls-files '*.cpp' '*.h')
echo "== clang-format: ${#sources[@]} files"
clang-format --dry-run --Werror "${sources[@]}"

echo "== words that say unfinished"
if git grep -nIwE 'TODO|FIXME|XXX|HACK' -- ':!scripts/check.sh' ':!CONTRIBUTING.md'; then
  echo "check: finish these or say in doc/ what is left" >&2
  exit 1
fi

echo "== generated sources"
mkdir -p build/check
{ cmake --preset check && cmake --build build/check --target generated_sources; } \
  >build/check/check.log 2>&1 || { tail -30 build/check/check.log; exit 1; }
echo "== cppcheck"
cppcheck --project=build/check/compile_commands.json --quiet --enable=warning,portability \
  --inline-suppr --suppressions-list=.cppcheck-suppressions -j "$(nproc)" --error-exitcode=1

if [ "$what" = quick ]; then
  echo "checks passed"
  exit 0
fi

base_folders=(geometry simulation session)
all_folders=("${base_folders[@]}" calibration acquisition mock_devices diagnosis studies db report service
  cli apps tests bench)
limit=()
case $what in
  base) mapfile -t files < <(git ls-files "${base_folders[@]/%//*.cpp}") ;;
  all) mapfile -t files < <(git ls-files "${all_folders[@]/%//*.cpp}" ':!tests/howto') ;;
  changed)
    # Newest change first. Headers are read through the sources beside them.
    mapfile -t files < <(git log -n 40 --name-only --diff-filter=d --format= -- "${all_folders[@]/%//*.cpp}" \
      ':!tests/howto' | awk '!seen[$0]++' | while read -r file; do [ ! -f "$file" ] || echo "$file"; done)
    limit=(--seconds "$tidy_seconds")
    ;;
  *) echo "check: '$what' is none of base, quick, changed, all" >&2; exit 2 ;;
esac
echo "== clang-tidy: $what, ${#files[@]} files"
scripts/tidy.py "${limit[@]}" "${files[@]}" || { echo "check: clang-tidy has something to say" >&2; exit 1; }
echo "checks passed"
