// Hides effects in generated sessions, diagnoses them without a hint and prints how often the
// verdict was right: the table of what is to be reached, by strength and by cause, and what was
// taken for what. Generator: mock_devices; it shares geometry only.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bench/in_parallel.h"
#include "bench/robot_table.h"
#include "bench/workshop_table.h"
#include "tests/blind/arm_challenge.h"
#include "tests/blind/challenge.h"
#include "tests/blind/delta_challenge.h"
#include "tests/blind/limit_power.h"

namespace {

using sixdial::blind::AtLimit;
using sixdial::blind::Challenge;
using sixdial::blind::Outcome;

struct Tally {
  int n = 0, named = 0, in_tie = 0, detected = 0, wrong = 0, unknown = 0;
  void count(const Outcome& each) {
    ++n;
    named += each.named;
    in_tie += each.in_tie;
    detected += each.detected;
    wrong += each.wrong;
    unknown += each.unknown;
  }
};
double percent(int k, int n) { return 100.0 * k / std::max(1, n); }

std::string cause_of(const std::string& name) { return name.substr(0, name.find('@')); }

/// Which sessions these are: those of a file with the same are not made again.
std::string key_of(const Challenge& of) {
  return fmt::format(
      "{} {:g} {:g} gross {:g}{}{}{} {}", of.kind, of.low, of.high, of.gross,
      of.xy_only ? " xy" : "", of.curve ? " curve" : "", of.drawn_rig ? " rigs" : "", of.cause);
}

/// Finished sessions as lines "key <tab> seed <tab> numbers <tab> truth <tab> named .", so that
/// a run that was stopped goes on. A draw that made no session has no numbers.
class Finished {
 public:
  void open(const std::string& path) {
    std::ifstream in(path);
    for (std::string line; std::getline(in, line);) {
      const auto seed = line.find('\t');
      if (seed == std::string::npos || !line.ends_with('.')) continue;
      const auto rest = line.find('\t', seed + 1);
      if (rest == std::string::npos) continue;
      lines_[line.substr(0, rest)] = line.substr(rest + 1);
    }
    out_.open(path, std::ios::app);
  }

  std::optional<Outcome> get(const Challenge& challenge, std::uint64_t seed) {
    const std::string key = fmt::format("{}\t{}", key_of(challenge), seed);
    {
      const std::lock_guard lock(mutex_);
      const auto known = lines_.find(key);
      if (known != lines_.end()) return outcome_from(known->second, seed);
    }
    auto outcome = sixdial::blind::try_blind(challenge, seed);
    const std::lock_guard lock(mutex_);
    if (out_.is_open()) out_ << key << '\t' << text_of(outcome) << ".\n" << std::flush;
    return outcome;
  }

 private:
  static std::string text_of(const std::optional<Outcome>& outcome) {
    if (!outcome) return "";
    return fmt::format(
        "{:.6g} {:d} {:d} {:d} {:d} {:d} {:.3g}\t{}\t{}\t", outcome->least, outcome->named,
        outcome->in_tie, outcome->detected, outcome->wrong, outcome->unknown, outcome->seconds,
        fmt::join(outcome->truth, " "), fmt::join(outcome->named_causes, " "));
  }
  static std::optional<Outcome> outcome_from(const std::string& text, std::uint64_t seed) {
    std::istringstream fields(text);
    std::string numbers, truth, named;
    std::getline(fields, numbers, '\t');
    Outcome outcome;
    std::istringstream in(numbers);
    if (!(in >> outcome.least >> outcome.named >> outcome.in_tie >> outcome.detected >>
          outcome.wrong >> outcome.unknown >> outcome.seconds)) {
      return std::nullopt;
    }
    outcome.seed = seed;
    std::getline(fields, truth, '\t');
    std::getline(fields, named, '\t');
    for (const auto& [list, words] :
         {std::pair{&outcome.truth, &truth}, std::pair{&outcome.named_causes, &named}}) {
      std::istringstream each(*words);
      for (std::string word; each >> word;) list->push_back(word);
    }
    return outcome;
  }

  std::map<std::string, std::string> lines_;
  std::ofstream out_;
  std::mutex mutex_;
};

Finished& finished() {
  static Finished all;
  return all;
}

/// In the order of the seeds, whatever the number of threads.
std::vector<Outcome> run(
    const Challenge& challenge, int sessions, std::uint64_t first_seed, int threads) {
  return sixdial::blind::tried_in_parallel<Outcome>(sessions, threads, [&](int i) {
    return finished().get(challenge, first_seed + static_cast<std::uint64_t>(i));
  });
}

void print_tables(const std::string& kind, const std::vector<Outcome>& outcomes) {
  std::map<std::string, Tally> by_cause, by_strength;
  double seconds = 0.0, longest = 0.0;
  for (const Outcome& each : outcomes) {
    const char* strength = each.truth.empty()  ? "no effect"
                           : each.least < 0.15 ? "R < 0.15"
                           : each.least < 0.25 ? "R 0.15-0.25"
                           : each.least < 0.5  ? "R 0.25-0.5"
                           : each.least < 1.0  ? "R 0.5-1"
                           : each.least < 2.0  ? "R 1-2"
                                               : "R 2 and up";
    by_strength[strength].count(each);
    by_strength["all"].count(each);
    if (each.truth.size() == 1) by_cause[cause_of(each.truth[0])].count(each);
    seconds += each.seconds;
    longest = std::max(longest, each.seconds);
  }
  fmt::print(
      "{:<26}{:>6}{:>9}{:>9}{:>10}{:>8}{:>9}\n", kind, "n", "exact%", "in tie%", "detected%",
      "wrong%", "unknown%");
  for (const auto* table : {&by_strength, &by_cause}) {
    for (const auto& [name, t] : *table) {
      fmt::print(
          "  {:<24}{:>6}{:>9.1f}{:>9.1f}{:>10.1f}{:>8.1f}{:>9.1f}\n", name, t.n,
          percent(t.named, t.n), percent(t.in_tie, t.n), percent(t.detected, t.n),
          percent(t.wrong, t.n), percent(t.unknown, t.n));
    }
  }
  fmt::print(
      "  time of a diagnosis: mean {:.0f} ms, longest {:.0f} ms\n\n",
      1e3 * seconds / std::max<double>(1, static_cast<double>(outcomes.size())), 1e3 * longest);
}

void print_confusions(const std::vector<Outcome>& outcomes) {
  std::map<std::pair<std::string, std::string>, int> taken;
  for (const Outcome& each : outcomes) {
    if (each.truth.size() != 1) continue;
    for (const std::string& named : each.named_causes) {
      if (named != each.truth[0]) ++taken[{each.truth[0], named}];
    }
  }
  if (taken.empty()) return;
  fmt::print("  taken for another, with certainty:\n");
  for (const auto& [pair, n] : taken) {
    fmt::print("    {:>3}  {} -> {}\n", n, pair.first, pair.second);
  }
  fmt::print("\n");
}

bool good(const std::string& kind, const Outcome& each) {
  if (kind == "none") return !each.detected;
  if (kind == "outside") return each.unknown && !each.wrong;
  return each.named;
}

/// The figures that issue and specification ask for, over `sessions` of each kind.
int whole_table(int sessions, std::uint64_t seed, int threads, Challenge base) {
  struct Line {
    const char* what;
    const char* kind;
    double low, high;
    double gross;
    double (*figure)(const Tally&);
    bool at_most;
    double limit;
  };
  const auto exact = [](const Tally& t) { return percent(t.named, t.n); };
  const auto tie = [](const Tally& t) { return percent(t.in_tie, t.n); };
  const auto seen = [](const Tally& t) { return percent(t.detected, t.n); };
  const auto wrong = [](const Tally& t) { return percent(t.wrong, t.n); };
  const auto unknown = [](const Tally& t) { return percent(t.unknown, t.n); };
  const std::vector<Line> lines{
      {"no effect: false alarms", "none", 0, 0, 0, seen, true, 2},
      {"one, R >= 0.25: named exactly", "one", 0.25, 5, 0, exact, false, 95},
      {"one, R >= 0.25: exactly or in the tied set", "one", 0.25, 5, 0, tie, false, 98},
      {"one, 0.15 <= R < 0.25: detected", "one", 0.15, 0.25, 0, seen, false, 80},
      {"one, any strength: named wrongly with certainty", "one", 0.05, 5, 0, wrong, true, 1},
      {"two, each R >= 0.5: both", "two", 0.5, 5, 0, exact, false, 90},
      {"three, each R >= 1: all", "three", 1, 5, 0, exact, false, 80},
      {"outside the catalogue, R >= 1: unknown, covariate right", "outside", 1, 5, 0, unknown,
       false, 90},
      {"outside the catalogue, R >= 1: named wrongly", "outside", 1, 5, 0, wrong, true, 3},
      {"4 % gross errors, no effect: false alarms", "none", 0, 0, 0.04, seen, true, 5},
      {"4 % gross errors, one, R >= 0.25: named exactly", "one", 0.25, 5, 0.04, exact, false,
       92},
      {"4 % gross errors, one: exactly or in the tied set", "one", 0.25, 5, 0.04, tie, false,
       95},
      {"4 % gross errors, two: both", "two", 0.5, 5, 0.04, exact, false, 87}};
  std::map<std::string, std::vector<Outcome>> done;
  int missed = 0;
  fmt::print("{:<58}{:>8}{:>8}{:>8}\n", "", "n", "here", "asked");
  for (const Line& line : lines) {
    const std::string key =
        fmt::format("{} {} {} {}", line.kind, line.low, line.high, line.gross);
    if (!done.contains(key)) {
      Challenge challenge = base;
      challenge.kind = line.kind;
      challenge.low = std::max(0.05, line.low);
      challenge.high = line.high;
      challenge.gross = line.gross;
      done[key] = run(challenge, sessions, seed, threads);
    }
    Tally tally;
    for (const Outcome& each : done[key]) {
      if (each.truth.empty() || each.least >= line.low) tally.count(each);
    }
    const double value = line.figure(tally);
    const bool reached = line.at_most ? value <= line.limit : value >= line.limit;
    missed += reached ? 0 : 1;
    fmt::print(
        "{:<58}{:>8}{:>7.1f}%{:>2}{:>5.0f}%{}\n", line.what, tally.n, value,
        line.at_most ? "<=" : ">=", line.limit, reached ? "" : "  not reached");
  }
  fmt::print("\n");
  for (const auto& [key, outcomes] : done) {
    print_tables(key, outcomes);
    print_confusions(outcomes);
  }
  return missed;
}

/// How often an effect of a stated limit's size is found and named, by cause.
void print_power(int sessions, std::uint64_t first_seed, int threads) {
  std::vector<std::vector<AtLimit>> drawn(static_cast<std::size_t>(sessions));
  std::atomic<int> next{0};
  std::vector<std::jthread> workers;
  for (int w = 0; w < threads; ++w) {
    workers.emplace_back([&] {
      for (int i = next++; i < sessions; i = next++) {
        drawn[static_cast<std::size_t>(i)] =
            sixdial::blind::try_limits(first_seed + static_cast<std::uint64_t>(i));
      }
    });
  }
  workers.clear();
  struct Power {
    int n = 0, detected = 0, named = 0, tied = 0, wrong = 0;
  };
  for (const bool of_name : {false, true}) {
    std::map<std::string, Power> table;
    for (const auto& session : drawn) {
      for (const AtLimit& each : session) {
        if (each.of_name != of_name) continue;
        for (const std::string& line : {each.cause, std::string("all")}) {
          Power& power = table[line];
          ++power.n;
          power.detected += each.detected;
          power.named += each.named;
          power.tied += each.tied && !each.named;
          power.wrong += each.wrong;
        }
      }
    }
    fmt::print(
        "{:<26}{:>6}{:>11}{:>9}{:>9}{:>9}\n",
        of_name ? "at the limit of naming" : "at that of detection", "n", "detected%", "named%",
        "in tie%", "wrong%");
    for (const auto& [cause, power] : table) {
      fmt::print(
          "  {:<24}{:>6}{:>11.1f}{:>9.1f}{:>9.1f}{:>9.1f}\n", cause, power.n,
          percent(power.detected, power.n), percent(power.named, power.n),
          percent(power.tied, power.n), percent(power.wrong, power.n));
    }
    fmt::print("\n");
  }
}

void add_robot(CLI::App& app, std::string& robot) {
  app.add_option(
         "--robot", robot,
         "five_bar; serial: drawn arms under a tracker; delta: drawn deltas on towers or with "
         "arms, "
         "under a tracker or wires")
      ->check(CLI::IsMember({"five_bar", "serial", "delta"}))
      ->capture_default_str();
}

/// The exit code.
int robots(
    const std::string& robot, int sessions, std::uint64_t first_seed, int threads,
    bool verbose) {
  using namespace sixdial::blind;
  const bool arms = robot == "serial";
  const int missed = print_robots(
      arms ? "arms of 4 to 7 joints" : "deltas, linear and rotary",
      arms ? challenge_arm : challenge_delta, sessions, first_seed, threads, verbose);
  return missed > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  Challenge challenge;
  challenge.kind = "all";
  int sessions = 100;
  std::uint64_t seed = 1;
  int first = 0;
  int threads = 2;
  bool verbose = false, workshop = false;
  sixdial::blind::WorkshopCase rigs;
  bool exact = false, silent = false;
  std::string file, robot = "five_bar";
  CLI::App app{"Blind challenge: hidden effects, diagnosed without a hint"};
  app.add_option("--sessions", sessions, "drawn sessions of each kind")->capture_default_str();
  app.add_option("--seed", seed, "session i has the seed 1,000,000 x this + i")
      ->capture_default_str();
  app.add_option("--first", first, "number of the first session");
  app.add_option(
         "--kind", challenge.kind,
         "all, none, one, two, three, outside; limits: power at the stated limits")
      ->capture_default_str();
  app.add_option("--low", challenge.low, "least strength R of each effect");
  app.add_option("--high", challenge.high, "greatest");
  app.add_option("--gross", challenge.gross, "share of readings with gross errors");
  app.add_option("--cause", challenge.cause, "only this cause");
  app.add_option("--threads", threads, "the figures do not depend on it");
  app.add_option("--file", file, "finished sessions; a second run goes on from there");
  add_robot(app, robot);
  app.add_flag("--xy", challenge.xy_only, "positions instead of dial readings");
  app.add_flag("--curve", challenge.curve, "dials with error curves and hysteresis");
  app.add_flag("--rigs", challenge.drawn_rig, "another rig in each session");
  CLI::Option* as_they_are = app.add_flag(
      "--workshop", workshop, "rigs as they are: everything a little off, one strong cause");
  app.add_flag("--exact", exact, "with the dials where the rig file says")->needs(as_they_are);
  app.add_flag("--silent", silent, "with a rig file that claims exactness")->needs(as_they_are);
  app.add_option(
      "--scatter-mm", challenge.scatter.tool_mm,
      "standard deviation of each arrival in x and y");
  app.add_option(
      "--joints-rad", challenge.scatter.joints_rad,
      "standard deviation of the joints against their encoders");
  app.add_option("--shifted", challenge.shifted, "so many dials stand elsewhere");
  app.add_option("--shift-low", challenge.shift_low_mm, "by at least this [mm]");
  app.add_option("--shift-high", challenge.shift_high_mm, "by at most this [mm]");
  app.add_flag("--verbose", verbose, "print each session that was not right");
  CLI11_PARSE(app, argc, argv);
  if (!file.empty()) finished().open(file);
  const std::uint64_t first_seed = seed * 1'000'000 + static_cast<std::uint64_t>(first);
  fmt::print("seed {}, {} sessions of a kind\n\n", seed, sessions);
  if (robot != "five_bar") return robots(robot, sessions, first_seed, threads, verbose);
  if (workshop) {
    rigs.misplaced = !exact;
    rigs.deviations = !silent;
    rigs.strong = challenge.kind != "none";
    sixdial::blind::print_workshop(sessions, first_seed, threads, rigs, verbose);
    return 0;
  }
  if (challenge.kind == "all") return whole_table(sessions, first_seed, threads, challenge);
  if (challenge.kind == "limits") {
    print_power(sessions, first_seed, threads);
    return 0;
  }
  const auto outcomes = run(challenge, sessions, first_seed, threads);
  for (const Outcome& each : outcomes) {
    if (!verbose || (good(challenge.kind, each) && !each.scatter)) continue;
    fmt::print("  seed {} R {:.2f} truth", each.seed, each.least);
    for (const auto& truth : each.truth) fmt::print(" {}", truth);
    fmt::print("  said {}", each.said.empty() ? "nothing" : each.said);
    if (each.scatter) {
      fmt::print(
          " scatter {:.2f} ({:.2f} to {:.2f}) um in {}", 1e3 * each.scatter->sd_mm,
          1e3 * each.scatter->low_mm, 1e3 * each.scatter->high_mm,
          static_cast<int>(each.scatter->in));
    }
    if (each.gross_share > 0) fmt::print(" gross {:.1f} %", 100 * each.gross_share);
    fmt::print("\n");
  }
  print_tables(challenge.kind, outcomes);
  print_confusions(outcomes);
}
