#include "bench/workshop_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bench/in_parallel.h"

namespace sixdial::blind {
namespace {

double percent(int k, int n) { return 100.0 * k / std::max(1, n); }

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

WorkshopSum sum_of(const std::vector<WorkshopOutcome>& outcomes) {
  WorkshopSum sum;
  std::vector<double> kinematics, extended, seconds;
  for (const WorkshopOutcome& each : outcomes) {
    ++sum.n;
    sum.wrong += each.wrong ? 1 : 0;
    sum.strong += each.strong.empty() ? 0 : 1;
    sum.found += each.found ? 1 : 0;
    sum.worse += each.extended_mm > each.kinematics_mm * (1 + 1e-9) ? 1 : 0;
    sum.parameters.inside += each.parameters.inside;
    sum.parameters.of += each.parameters.of;
    kinematics.push_back(each.kinematics_mm);
    extended.push_back(each.extended_mm);
    seconds.push_back(each.seconds);
    sum.longest_s = std::max(sum.longest_s, each.seconds);
  }
  sum.kinematics_mm = median(std::move(kinematics));
  sum.extended_mm = median(std::move(extended));
  sum.seconds = median(std::move(seconds));
  return sum;
}

void print_workshop(
    int sessions, std::uint64_t first_seed, int threads, const WorkshopCase& of, bool verbose) {
  const std::vector<WorkshopOutcome> outcomes = tried_in_parallel<WorkshopOutcome>(
      sessions, threads,
      [&](int i) { return try_workshop(of, first_seed + static_cast<std::uint64_t>(i)); });
  for (const WorkshopOutcome& each : outcomes) {
    if (!verbose) break;
    fmt::print(
        "  seed {} {}{}strong {}, um {:.1f} -> {:.1f}, {:.1f} s: {}\n", each.seed,
        each.wrong ? "WRONG " : "", each.strong.empty() || each.found ? "" : "MISSED ",
        each.strong.empty() ? "none" : each.strong, 1e3 * each.kinematics_mm,
        1e3 * each.extended_mm, each.seconds, each.said);
  }
  const WorkshopSum sum = sum_of(outcomes);
  const auto line = [](const char* what, double value, const char* asked) {
    fmt::print("{:<58}{:>8.2f}  {}\n", what, value, asked);
  };
  line("sessions", sum.n, "");
  line("with a certain name that is not there, %", percent(sum.wrong, sum.n), "at most 5");
  if (sum.strong > 0) {
    line(
        "the strong cause named, or in its set, %", percent(sum.found, sum.strong),
        "at least 90");
  }
  line("commanded by kinematics, median, um", 1e3 * sum.kinematics_mm, "");
  line(
      "commanded by the extended model, median, um", 1e3 * sum.extended_mm,
      of.misplaced ? "at most 5" : "at most 1");
  line("in so many sessions worse than kinematics", sum.worse, "0");
  line(
      "95 % intervals of parameters that hold the truth, %",
      percent(sum.parameters.inside, sum.parameters.of), "92 to 98");
  line("seconds of a diagnosis, median", sum.seconds, "at most 2");
  line("longest", sum.longest_s, "at most 10");
}

}  // namespace sixdial::blind
