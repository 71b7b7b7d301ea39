// How often the swarm solves the standard functions: 50 seeds of each, 10, 20 and 30
// dimensions. Prints the table of doc/accuracy.md.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/support/standard_functions.h"

namespace {

constexpr int kParticles = 80;
constexpr int kSeeds = 50;
struct Size {
  int dimensions, iterations;
};
constexpr Size kSizes[] = {{10, 1000}, {20, 1500}, {30, 2000}};

}  // namespace

int main() {
  std::printf(
      "| function | dimensions | iterations | start within | goal | reached, of %d seeds "
      "| closer goal | reached | median value | worst |\n",
      kSeeds);
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& problem : sixdial::testing::kStandardProblems) {
    for (const Size& size : kSizes) {
      std::vector<double> values;
      for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        values.push_back(sixdial::testing::minimise(
                             problem, size.dimensions, kParticles, size.iterations, seed, 2)
                             .value);
      }
      std::ranges::sort(values);
      const auto within = [&](double goal) {
        return std::ranges::count_if(values, [&](double each) { return each <= goal; });
      };
      std::printf(
          "| %s | %d | %d | +-%g | %g | %td | %g | %td | %.3g | %.3g |\n", problem.name,
          size.dimensions, size.iterations, problem.half, problem.solved,
          within(problem.solved), problem.solved_well, within(problem.solved_well),
          values[values.size() / 2], values.back());
    }
  }
  return EXIT_SUCCESS;
}
