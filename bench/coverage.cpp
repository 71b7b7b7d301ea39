// How often 95 % intervals hold the truth, how often a diagnosis says what is not there, and
// how often it finds what its limits say it would: the table of doc/accuracy.md. Each finished
// session is a line of a file, so that a stopped run goes on where it was.
#include "tests/blind/coverage.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bench/workshop_table.h"
#include "tests/blind/limit_power.h"
#include "tests/blind/workshop.h"

namespace {

using namespace sixdial::blind;

struct Options {
  int sessions = 300;
  std::uint64_t seed = 1;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  std::string path, only, cause;
};

// ---- Cases

void add_repeats_and_points(bool dials, bool diagnosis, std::vector<CoverageCase>& all) {
  for (const int points : {9, 15, 30, 100}) {
    for (const double noise : {1.0, 3.0}) {
      all.push_back(
          {.dials = dials, .points = points, .noise_times = noise, .diagnosis = diagnosis});
    }
  }
  for (const Repeats repeats : {Repeats::kAtRest, Repeats::kInterleaved}) {
    all.push_back({.dials = dials, .points = 33, .repeats = repeats, .diagnosis = diagnosis});
  }
}

std::vector<CoverageCase> calibration_cases() {
  std::vector<CoverageCase> all;
  for (const bool dials : {false, true}) {
    add_repeats_and_points(dials, false, all);
    for (const int points : {30, 100}) {
      all.push_back({.dials = dials, .points = points, .warp_mm = 0.01});
    }
  }
  return all;
}

std::vector<CoverageCase> diagnosis_cases(const std::string& cause) {
  std::vector<CoverageCase> all;
  for (const bool dials : {false, true}) add_repeats_and_points(dials, true, all);
  const std::string hidden = cause.empty() ? std::string(kAnyCause) : cause;
  for (const bool dials : {false, true}) {
    for (const double noise : {1.0, 3.0}) {
      all.push_back(
          {.dials = dials,
           .points = 100,
           .noise_times = noise,
           .diagnosis = true,
           .cause = hidden});
    }
  }
  return all;
}

// ---- The file: "case <tab> seed <tab> numbers"

/// What an earlier run has finished, by case and seed. A last line that was cut off has no end
/// and is left out.
using Done = std::map<std::string, std::map<std::uint64_t, std::string>>;

Done read(const std::string& path) {
  Done done;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find('\t');
    const auto second = line.find('\t', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    if (!line.ends_with('.')) continue;
    done[line.substr(0, first)][std::stoull(line.substr(first + 1))] = line.substr(second + 1);
  }
  return done;
}

/// Finishes the sessions of a case that the file does not have.
class Sessions {
 public:
  explicit Sessions(const Options& options)
      : options_(options), done_(options.path.empty() ? Done{} : read(options.path)) {
    if (!options.path.empty()) out_.open(options.path, std::ios::app);
  }

  /// `tried`: numbers of one session; empty where its draw makes none.
  const std::map<std::uint64_t, std::string>& of(
      const std::string& name, const std::function<std::string(std::uint64_t)>& tried) {
    auto& finished = done_[name];
    std::atomic<int> next = 0;
    const auto work = [&] {
      for (int i = next++; i < options_.sessions; i = next++) {
        const std::uint64_t seed = options_.seed * 1'000'000 + static_cast<std::uint64_t>(i);
        {
          const std::lock_guard lock(mutex_);
          if (finished.contains(seed)) continue;
        }
        const std::string numbers = tried(seed);
        if (numbers.empty()) continue;
        const std::lock_guard lock(mutex_);
        finished[seed] = numbers;
        if (out_.is_open())
          out_ << name << '\t' << seed << '\t' << numbers << " .\n" << std::flush;
      }
    };
    std::vector<std::jthread> workers;
    for (unsigned k = 0; k < options_.threads; ++k) workers.emplace_back(work);
    workers.clear();
    return finished;
  }

 private:
  const Options& options_;
  Done done_;
  std::ofstream out_;
  std::mutex mutex_;
};

// ---- Coverage and false alarms

constexpr std::array kShares{
    &Covered::parameters, &Covered::positions, &Covered::amplitudes, &Covered::gain};

std::string numbers_of(const Covered& covered) {
  std::string text;
  for (const auto share : kShares) {
    text += fmt::format("{} {} ", (covered.*share).inside, (covered.*share).of);
  }
  return text +
         fmt::format(
             "{:.17g} {:d} {:d}", covered.width_mm, covered.false_cause, covered.false_alarm);
}

Covered covered_from(const std::string& numbers) {
  Covered covered;
  std::istringstream in(numbers);
  for (const auto share : kShares) in >> (covered.*share).inside >> (covered.*share).of;
  in >> covered.width_mm >> covered.false_cause >> covered.false_alarm;
  return covered;
}

std::string percent(int part, int of) {
  return of == 0 ? "-" : fmt::format("{:.1f}", 100.0 * part / of);
}

void print(const CoverageCase& of, const std::map<std::uint64_t, std::string>& sessions) {
  Covered sum;
  int false_causes = 0, false_alarms = 0;
  std::vector<double> widths;
  for (const auto& [seed, numbers] : sessions) {
    const Covered each = covered_from(numbers);
    for (const auto share : kShares) {
      (sum.*share).inside += (each.*share).inside;
      (sum.*share).of += (each.*share).of;
    }
    false_causes += each.false_cause ? 1 : 0;
    false_alarms += each.false_alarm ? 1 : 0;
    if (each.width_mm > 0.0) widths.push_back(each.width_mm);
  }
  std::ranges::sort(widths);
  const auto count = static_cast<int>(sessions.size());
  std::string line = fmt::format("| {} | {}", of.name(), count);
  if (of.diagnosis) {
    line += fmt::format(
        " | {} | {} | {} | {}", percent(sum.amplitudes.inside, sum.amplitudes.of),
        percent(sum.gain.inside, sum.gain.of), percent(false_causes, count),
        of.cause.empty() ? percent(false_alarms, count) : "-");
  } else {
    line += fmt::format(
        " | {} | {} | {}", percent(sum.parameters.inside, sum.parameters.of),
        percent(sum.positions.inside, sum.positions.of),
        widths.empty() ? "-" : fmt::format("{:.1f}", 1e3 * widths[widths.size() / 2]));
  }
  fmt::print("{} |\n", line);
  std::fflush(stdout);
}

void print_coverage(
    std::string_view head, const std::vector<CoverageCase>& cases, const Options& options,
    Sessions& sessions) {
  bool first = true;
  for (const CoverageCase& each : cases) {
    const std::string name = each.name();
    if (name.find(options.only) == std::string::npos) continue;
    if (first) fmt::print("\n{}\n", head);
    first = false;
    print(each, sessions.of(name, [&](std::uint64_t seed) {
      const auto covered = try_coverage(each, seed);
      return covered ? numbers_of(*covered) : std::string();
    }));
  }
}

// ---- Rigs as they are

std::string numbers_of(const WorkshopOutcome& each) {
  return fmt::format(
      "{} {} {:d} {:d} {:d} {:.17g} {:.17g} {:.4g}", each.parameters.inside, each.parameters.of,
      each.wrong, !each.strong.empty(), each.found, each.kinematics_mm, each.extended_mm,
      each.seconds);
}

WorkshopOutcome workshop_from(const std::string& numbers) {
  WorkshopOutcome each;
  bool strong = false;
  std::istringstream(numbers) >> each.parameters.inside >> each.parameters.of >> each.wrong >>
      strong >> each.found >> each.kinematics_mm >> each.extended_mm >> each.seconds;
  if (strong) each.strong = "one";
  return each;
}

void print_workshops(const Options& options, Sessions& sessions) {
  const std::pair<const char*, WorkshopCase> cases[] = {
      {"workshop, deviations in the file", {}},
      {"workshop, silent file", {.deviations = false}},
      {"workshop, exact geometry", {.misplaced = false}}};
  bool first = true;
  for (const auto& [name, of] : cases) {
    if (std::string_view(name).find(options.only) == std::string_view::npos) continue;
    if (first)
      fmt::print(
          "\n| rigs as they are | sessions | parameters % | wrong certain names % | strong "
          "cause "
          "% | kinematics um | extended um | worse | s | longest |\n"
          "|---|---|---|---|---|---|---|---|---|---|\n");
    first = false;
    const auto& finished = sessions.of(name, [&of](std::uint64_t seed) {
      const auto outcome = try_workshop(of, seed);
      return outcome ? numbers_of(*outcome) : std::string();
    });
    std::vector<WorkshopOutcome> outcomes;
    for (const auto& [seed, numbers] : finished) outcomes.push_back(workshop_from(numbers));
    const WorkshopSum sum = sum_of(outcomes);
    fmt::print(
        "| {} | {} | {} | {} | {} | {:.1f} | {:.2f} | {} | {:.1f} | {:.1f} |\n", name, sum.n,
        percent(sum.parameters.inside, sum.parameters.of), percent(sum.wrong, sum.n),
        percent(sum.found, sum.strong), 1e3 * sum.kinematics_mm, 1e3 * sum.extended_mm,
        sum.worse, sum.seconds, sum.longest_s);
    std::fflush(stdout);
  }
}

// ---- Power at the stated limits

struct Power {
  int tried = 0, found = 0;
};

void print_power(std::string name, RigFile file, const Options& options, Sessions& sessions) {
  if (!options.cause.empty()) name += ", " + options.cause;
  if (name.find(options.only) == std::string::npos) return;
  const auto& finished = sessions.of(name, [&](std::uint64_t seed) {
    std::string text;
    for (const AtLimit& each : try_limits(seed, file, options.cause)) {
      text += fmt::format(
          "{} {:d} {:d} ", each.cause, each.of_name, each.of_name ? each.named : each.detected);
    }
    return text;
  });
  std::map<std::string, std::array<Power, 2>> table;  // by cause: detection, naming
  for (const auto& [seed, text] : finished) {
    std::istringstream in(text);
    std::string cause;
    bool of_name = false, found = false;
    while (in >> cause >> of_name >> found) {
      for (const std::string& line : {cause, std::string("all")}) {
        Power& power = table[line][of_name ? 1 : 0];
        ++power.tried;
        power.found += found ? 1 : 0;
      }
    }
  }
  fmt::print(
      "\n| effect of a limit's size ({}) | sessions | found at the limit of detection % | "
      "named "
      "at that of naming % |\n|---|---|---|---|\n",
      name);
  for (const auto& [cause, power] : table) {
    fmt::print(
        "| {} | {} | {} | {} |\n", cause, power[0].tried,
        percent(power[0].found, power[0].tried), percent(power[1].found, power[1].tried));
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Coverage of 95 % intervals, false alarms and power, over drawn sessions"};
  app.add_option("--sessions", options.sessions, "of each case")->capture_default_str();
  app.add_option("--seed", options.seed, "session i has the seed 1,000,000 x this + i")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "the figures do not depend on it");
  app.add_option("--file", options.path, "finished sessions; a second run goes on from there");
  app.add_option("--only", options.only, "cases whose name has this text");
  app.add_option("--cause", options.cause, "hides this cause only");
  CLI11_PARSE(app, argc, argv);
  Sessions sessions(options);
  fmt::print("seed {}\n", options.seed);
  print_coverage(
      "| calibration of | sessions | parameters % | positions % | half width um |\n"
      "|---|---|---|---|---|",
      calibration_cases(), options, sessions);
  print_coverage(
      "| diagnosis of | sessions | sizes % | gain % | false names % | anything % |\n"
      "|---|---|---|---|---|---|",
      diagnosis_cases(options.cause), options, sessions);
  print_power("power", RigFile::kExact, options, sessions);
  print_power("limits, deviations in the file", RigFile::kDeviations, options, sessions);
  print_workshops(options, sessions);
}
