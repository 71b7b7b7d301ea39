// How often 95 % intervals hold the truth, and how often a diagnosis names what is not there:
// the table of doc/accuracy.md. Each finished session is a line of a file, so that a stopped
// run goes on where it was.
#include "tests/blind/coverage.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "mock_devices/hidden_effect.h"

namespace {

using namespace sixdial::blind;
namespace mock_devices = sixdial::mock_devices;

std::vector<CoverageCase> cases() {
  std::vector<CoverageCase> all;
  for (const bool diagnosis : {false, true}) {
    for (const bool dials : {false, true}) {
      for (const int points : {9, 15, 30, 100}) {
        for (const double noise : {1.0, 3.0}) {
          all.push_back(
              {.dials = dials, .points = points, .noise_times = noise, .diagnosis = diagnosis});
        }
      }
      for (const Repeats repeats : {Repeats::kAtRest, Repeats::kInterleaved}) {
        all.push_back(
            {.dials = dials, .points = 33, .repeats = repeats, .diagnosis = diagnosis});
      }
      if (diagnosis) continue;
      for (const int points : {30, 100}) {
        all.push_back({.dials = dials, .points = points, .warp_mm = 0.01});
      }
    }
  }
  for (const mock_devices::CauseRow* cause : mock_devices::causes()) {
    if (cause->is_data_fault || cause->swaps_cables) continue;
    all.push_back(
        {.dials = true, .points = 100, .diagnosis = true, .cause = std::string(cause->id)});
  }
  return all;
}

struct Line {
  Covered covered;
  [[nodiscard]] std::string text(const std::string& name) const {
    return fmt::format(
        "{}\t{}\t{} {} {} {} {} {} {:.17g} {:d}\n", name, covered.seed,
        covered.parameters.inside, covered.parameters.of, covered.positions.inside,
        covered.positions.of, covered.amplitudes.inside, covered.amplitudes.of,
        covered.width_mm, covered.false_cause);
  }
};

using Done = std::map<std::string, std::map<std::uint64_t, Covered>>;

/// What an earlier run has finished; a last line that was cut off is left out.
Done read(const std::string& path) {
  Done done;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find('\t');
    const auto second = line.find('\t', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    Covered covered;
    std::istringstream numbers(line.substr(first + 1));
    int false_cause = 0;
    if (!(numbers >> covered.seed >> covered.parameters.inside >> covered.parameters.of >>
          covered.positions.inside >> covered.positions.of >> covered.amplitudes.inside >>
          covered.amplitudes.of >> covered.width_mm >> false_cause)) {
      continue;
    }
    covered.false_cause = false_cause != 0;
    done[line.substr(0, first)][covered.seed] = covered;
  }
  return done;
}

std::string percent(int part, int of) {
  return of == 0 ? "-" : fmt::format("{:.1f}", 100.0 * part / of);
}

void print(const CoverageCase& of, const std::map<std::uint64_t, Covered>& sessions) {
  Share parameters, positions, amplitudes;
  int false_causes = 0;
  std::vector<double> widths;
  for (const auto& [seed, each] : sessions) {
    for (const auto& [sum, part] :
         {std::pair{&parameters, &each.parameters}, std::pair{&positions, &each.positions},
          std::pair{&amplitudes, &each.amplitudes}}) {
      sum->inside += part->inside;
      sum->of += part->of;
    }
    false_causes += each.false_cause ? 1 : 0;
    if (each.width_mm > 0.0) widths.push_back(each.width_mm);
  }
  std::ranges::sort(widths);
  fmt::print(
      "| {} | {} | {} | {} | {} | {} | {} |\n", of.name(), sessions.size(),
      percent(parameters.inside, parameters.of), percent(positions.inside, positions.of),
      widths.empty() ? "-" : fmt::format("{:.1f}", 1e3 * widths[widths.size() / 2]),
      percent(amplitudes.inside, amplitudes.of),
      of.diagnosis ? percent(false_causes, static_cast<int>(sessions.size())) : "-");
}

}  // namespace

int main(int argc, char** argv) {
  int sessions = 300;
  std::uint64_t seed = 1;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  std::string path, only;
  CLI::App app{"Coverage of 95 % intervals and false alarms, over drawn sessions"};
  app.add_option("--sessions", sessions, "of each case")->capture_default_str();
  app.add_option("--seed", seed, "session i has the seed 1,000,000 x this + i")
      ->capture_default_str();
  app.add_option("--threads", threads, "the figures do not depend on it");
  app.add_option("--file", path, "finished sessions; a second run goes on from there");
  app.add_option("--only", only, "cases whose name has this text");
  CLI11_PARSE(app, argc, argv);
  Done done = path.empty() ? Done{} : read(path);
  std::ofstream out;
  if (!path.empty()) out.open(path, std::ios::app);
  fmt::print(
      "seed {}\n\n| case | sessions | parameters % | positions % | half width um | amplitudes "
      "% | false causes % |\n|---|---|---|---|---|---|---|\n",
      seed);
  std::mutex mutex;
  for (const CoverageCase& each : cases()) {
    const std::string name = each.name();
    if (name.find(only) == std::string::npos) continue;
    auto& finished = done[name];
    std::atomic<int> next = 0;
    const auto work = [&] {
      for (int i = next++; i < sessions; i = next++) {
        const std::uint64_t at = seed * 1'000'000 + static_cast<std::uint64_t>(i);
        {
          const std::lock_guard lock(mutex);
          if (finished.contains(at)) continue;
        }
        const auto covered = try_coverage(each, at);
        if (!covered) continue;
        const std::lock_guard lock(mutex);
        finished[at] = *covered;
        if (out.is_open()) out << Line{*covered}.text(name) << std::flush;
      }
    };
    std::vector<std::jthread> workers;
    for (unsigned k = 0; k < threads; ++k) workers.emplace_back(work);
    workers.clear();
    print(each, finished);
    std::fflush(stdout);
  }
}
