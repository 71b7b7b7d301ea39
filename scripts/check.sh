#!/usr/bin/env bash
# Format and static checks over the tracked sources. Configures build/release for its
# compile_commands.json and makes the generated sources that it names.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

mapfile -t sources < <(git ls-files '*.cpp' '*.h')
echo "== clang-format: ${#sources[@]} files"
clang-format --dry-run --Werror "${sources[@]}"

echo "== words that say unfinished"
if git grep -nIwE 'TODO|FIXME|XXX|HACK' -- ':!scripts/check.sh' ':!CONTRIBUTING.md'; then
  echo "check: finish these or say in doc/ what is left" >&2
  exit 1
fi

echo "== generated sources"
mkdir -p build/release
{ cmake --preset release -DSIXDIAL_TESTS=ON -DSIXDIAL_BENCH=ON && cmake --build build/release --target generated_sources; } \
  >build/release/check.log 2>&1 || { tail -30 build/release/check.log; exit 1; }
echo "== cppcheck"
cppcheck --project=build/release/compile_commands.json --quiet --enable=warning,portability \
  --inline-suppr --suppressions-list=.cppcheck-suppressions -j "$(nproc)" --error-exitcode=1

# clang-tidy takes ten seconds a file with Eigen in it: by default the folders that everything
# stands on; `scripts/check.sh all` reads every folder.
folders=(geometry simulation session)
[ "${1:-}" = all ] && folders+=(calibration acquisition mock_devices diagnosis db report service apps)
echo "== clang-tidy: ${folders[*]}"
git ls-files "${folders[@]/%//*.cpp}" | xargs -P "$(nproc)" -n 4 clang-tidy -p build/release --quiet 2>/dev/null
echo "checks passed"
