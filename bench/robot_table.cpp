#include "bench/robot_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/in_parallel.h"

namespace sixdial::blind {
namespace {

double percent(int k, int n) { return 100.0 * k / std::max(1, n); }

struct Tally {
  int n = 0, detected = 0, named = 0, in_set = 0, wrong = 0;
  void count(const RobotOutcome& each) {
    ++n;
    detected += each.detected;
    named += each.named;
    in_set += each.named || each.in_tie;
    wrong += each.wrong;
  }
};

void print_row(const std::string& what, const Tally& t) {
  fmt::print(
      "  {:<44}{:>6}{:>11.1f}{:>9.1f}{:>9.1f}{:>9.1f}\n", what, t.n, percent(t.detected, t.n),
      percent(t.named, t.n), percent(t.in_set, t.n), percent(t.wrong, t.n));
}

}  // namespace

int print_robots(
    const char* title, Challenged challenged, int sessions, std::uint64_t first_seed,
    int threads, bool verbose) {
  struct Line {
    const char* what;
    RobotChallenge of;
    double named_at_least, wrong_at_most;  // per cent; of no cause: detected at most
  };
  // As asked of the five-bar.
  const std::vector<Line> lines{
      {"no effect", {.causes = 0}, 0, 2},
      {"one, 0.15 <= R < 0.25", {.causes = 1, .low = 0.15, .high = 0.25}, 0, 1},
      {"one, R >= 0.25", {.causes = 1, .low = 0.25, .high = 5}, 95, 1},
      {"two, each R >= 0.5", {.causes = 2, .low = 0.5, .high = 5}, 90, 1}};
  int missed = 0;
  fmt::print(
      "  {:<44}{:>6}{:>11}{:>9}{:>9}{:>9}\n", title, "n", "detected%", "named%", "in set%",
      "wrong%");
  for (const Line& line : lines) {
    const auto outcomes = tried_in_parallel<RobotOutcome>(sessions, threads, [&](int i) {
      return std::optional(challenged(line.of, first_seed + static_cast<std::uint64_t>(i)));
    });
    Tally all;
    std::map<std::string, Tally> by_cause;
    std::vector<double> seconds;
    for (const RobotOutcome& each : outcomes) {
      all.count(each);
      seconds.push_back(each.seconds);
      if (each.truth.size() == 1) {
        by_cause[each.truth[0].substr(0, each.truth[0].find('@'))].count(each);
      }
    }
    print_row(line.what, all);
    if (by_cause.size() > 1) {
      for (const auto& [cause, tally] : by_cause) print_row("    " + cause, tally);
    }
    std::ranges::sort(seconds);
    fmt::print(
        "    seconds: median {:.1f}, longest {:.1f}\n", seconds[seconds.size() / 2],
        seconds.back());
    const bool none = line.of.causes == 0;
    missed += percent(none ? all.detected : all.wrong, all.n) > line.wrong_at_most;
    missed += percent(all.named, all.n) < line.named_at_least;
    for (std::size_t i = 0; verbose && i < outcomes.size(); ++i) {
      const RobotOutcome& each = outcomes[i];
      if (each.named || (none && !each.detected)) continue;
      std::string truth;
      for (const std::string& name : each.truth) truth += name + " ";
      fmt::print(
          "      seed {} {} R {:.2f} truth {}said {}\n", first_seed + i, each.robot,
          each.strength, truth, each.said.empty() ? "nothing" : each.said);
    }
  }
  return missed;
}

}  // namespace sixdial::blind
