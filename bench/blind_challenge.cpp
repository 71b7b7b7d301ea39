// Hides effects in generated sessions, diagnoses them without a hint and prints how often the
// verdict was right, by strength R = rms of what an effect leaves in the noise-free readings
// after refitting the robot, over the noise. Generator: mock_devices; it shares geometry only.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <mutex>
#include <numeric>
#include <random>
#include <thread>

#include "diagnosis/identify.h"
#include "mock_devices/session_generator.h"
#include "session/trials.h"

namespace {

using namespace sixdial;
using mock_devices::HiddenEffect;

constexpr double kNoise_mm = 0.002;

std::vector<simulation::Trial> trials_of(
    const geometry::Rig& rig, const mock_devices::GeneratedSession& session, bool noise_free,
    bool xy_only) {
  std::vector<simulation::Trial> trials;
  const session::TimePoint start{};
  for (std::size_t i = 0; i < session.rows.size(); ++i) {
    const auto& row = session.rows[i];
    session::Sample sample;
    sample.set = row.planned.set;
    sample.point = row.planned.point;
    sample.q_rad = row.planned.q_rad;
    sample.target_mm = row.planned.target_mm;
    sample.approach = {row.approach[0], row.approach[1]};
    sample.temperature_c = row.temperature_c;
    sample.time_utc =
        start + std::chrono::milliseconds(static_cast<std::int64_t>(row.planned.time_s * 1000));
    for (const auto& value : noise_free ? row.noise_free_mm : row.dial_mm) {
      session::DialValue dial;
      dial.value_mm = value;
      sample.dials.push_back(dial);
    }
    auto trial = session::trial_of(rig, sample, static_cast<int>(i), start);
    if (xy_only) trial.dial_mm.assign(trial.dial_mm.size(), std::nullopt);
    trials.push_back(std::move(trial));
  }
  return trials;
}

/// What is left of the noise-free readings after refitting robot and clamp, rms over noise.
double visible_ratio(
    const simulation::ForwardModel& model, const mock_devices::GeneratedSession& session,
    bool xy_only) {
  const auto trials = trials_of(model.rig(), session, true, xy_only);
  const diagnosis::Readings readings(model, trials);
  simulation::ModelVector at = model.nominal();
  const simulation::ExtendedModel plain(model, {});
  Eigen::VectorXd e;
  for (int step = 0; step < 12; ++step) {
    e = readings.measured_mm() - readings.simulate(at, plain);
    if (!e.allFinite()) return std::nan("");
    const Eigen::MatrixXd J = readings.jacobian(at);
    at += J.completeOrthogonalDecomposition().solve(e);
  }
  e = readings.measured_mm() - readings.simulate(at, plain);
  double noise = kNoise_mm;
  if (xy_only) noise = readings.rig_noise_mm();
  return std::sqrt(e.squaredNorm() / static_cast<double>(e.size())) / noise;
}

struct Outcome {
  std::vector<std::string> truth;
  bool outside = false;
  double ratio = 0.0;   // of all together
  double least = 0.0;   // of the weakest alone
  bool named = false;   // all truths named, nothing else
  bool in_tie = false;  // all truths named or in a tied set
  bool detected = false;
  bool wrong = false;    // something named with certainty that is not there
  bool unknown = false;  // verdict unknown with the right covariate
  bool g2_at_floor = true;
  double seconds = 0.0;
  std::string said;
  std::uint64_t seed = 0;
};

std::string covariate_of(const HiddenEffect& effect) {
  if (effect.cause == "xy_field") return "x";
  if (effect.cause == "random_walk" || effect.cause == "time_sinusoid") return "time";
  return effect.where == "joint1" ? "theta1" : "theta2";
}

struct Options {
  int sessions = 200;
  std::uint64_t seed = 1;
  int first = 0;
  std::string kind = "one";  // none, one, two, three, outside
  double low = 0.15, high = 5.0;
  double gross = 0.0;
  bool xy_only = false;
  bool curve = false;
  std::string cause;
  int threads = 2;
  bool verbose = false;
};

Outcome trial_of(const Options& options, std::uint64_t seed) {
  std::mt19937_64 engine(seed * 7919 + 17);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const geometry::Rig rig = geometry::default_rig();
  const simulation::ForwardModel model(rig);
  Outcome outcome;
  outcome.seed = seed;
  const int count = options.kind == "none"    ? 0
                    : options.kind == "two"   ? 2
                    : options.kind == "three" ? 3
                                              : 1;
  outcome.outside = options.kind == "outside";
  mock_devices::World world;
  world.rig = rig;
  world.robot = mock_devices::drawn_robot(rig, seed);
  world.seed = seed;
  world.dials = {kNoise_mm, 0.001, 0.0, 0.0};
  if (options.curve) world.dials = mock_devices::DialHabits{};
  world.warm_up.tau_s = uniform(600, 3000);
  world.warm_up.rise_c = uniform(2, 6);
  const auto plan = mock_devices::random_plan(rig, seed);
  mock_devices::World ideal = world;
  ideal.dials = mock_devices::kIdealDials;
  outcome.least = 1e9;
  for (int k = 0; k < count; ++k) {
    for (int attempt = 0; attempt < 60; ++attempt) {
      const std::uint64_t draw = engine();
      HiddenEffect effect;
      double ratio = 0.0;
      const double wanted = options.low * std::pow(options.high / options.low, uniform(0, 1));
      try {
        const auto pool =
            outcome.outside ? mock_devices::Pool::kOutside : mock_devices::Pool::kCatalogue;
        effect = options.cause.empty() ? mock_devices::draw_effect(rig, draw, pool)
                                       : mock_devices::draw_effect_of(rig, options.cause, draw);
        if (effect.cause == "outliers" || effect.cause == "stale_reading") continue;
        bool taken = false;
        for (const auto& each : world.effects) {
          taken = taken || (each.cause == effect.cause && each.where == effect.where);
        }
        if (taken) continue;
        const auto alone = [&](const HiddenEffect& it) {
          mock_devices::World one = ideal;
          one.effects = {it};
          return visible_ratio(
              model, generate_session(mock_devices::WorldModel(one).world(), plan),
              options.xy_only);
        };
        if (effect.cause != "dial_swap") {
          // Scale the size to the wanted strength; an effect that would have to be ten times as
          // large as a rig of this kind shows is not drawn.
          ratio = alone(effect);
          if (!(ratio > 1e-3)) continue;
          const double factor = wanted / ratio;
          if (factor > 10) continue;
          static const std::vector<std::string> kSizes{"_rad",   "_mm", "_mm_per_h",
                                                       "_per_k", "_1",  "_rad_per_nmm"};
          for (auto& [name, value] : effect.parameters) {
            if (name.find("phase") == std::string::npos &&
                name.find("direction") == std::string::npos &&
                name.find("period") == std::string::npos &&
                name.find("length") == std::string::npos &&
                name.find("sample") == std::string::npos &&
                name.find("ref") == std::string::npos &&
                name.find("mid") == std::string::npos &&
                name.find("seed") == std::string::npos) {
              value *= name.starts_with("k1_") || name.starts_with("k2_") ? 1 / factor : factor;
            }
          }
          ratio = alone(effect);
          if (!(ratio > 0.5 * wanted && ratio < 2 * wanted)) continue;
        } else {
          ratio = 1000.0;  // millimetres: the refit of exchanged readings means nothing
          if (count > 1) continue;
        }
      } catch (const std::exception&) {
        continue;
      }
      world.effects.push_back(effect);
      outcome.least = std::min(outcome.least, ratio);
      outcome.truth.push_back(effect.cause + "@" + effect.where);
      break;
    }
  }
  if (count == 0) outcome.least = 0;
  if (options.gross > 0) {
    HiddenEffect gross = mock_devices::make_effect(rig, "outliers", "samples", 0.3, seed);
    for (auto& [name, value] : gross.parameters) {
      if (name.find("share") != std::string::npos ||
          name.find("fraction") != std::string::npos) {
        value = options.gross;
      }
    }
    world.effects.push_back(gross);
  }
  const auto session = generate_session(world, plan);
  const auto trials = trials_of(rig, session, false, options.xy_only);
  const auto start = std::chrono::steady_clock::now();
  diagnosis::Readings readings(model, trials);
  const auto verdict = diagnosis::identify(readings);
  outcome.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::size_t exact = 0, tied = 0;
  for (const std::string& truth : outcome.truth) {
    bool is_exact = false, is_tied = false;
    for (const auto& finding : verdict.findings) {
      const bool certain = finding.certain();
      if (finding.hypothesis.name() == truth) (certain ? is_exact : is_tied) = true;
      for (const auto& rival : finding.tied_with) {
        if (rival.hypothesis.name() == truth) is_tied = true;
      }
    }
    if (verdict.swap && verdict.swap->name() == truth) is_exact = true;
    exact += is_exact;
    tied += is_exact || is_tied;
  }
  for (const auto& finding : verdict.findings) {
    outcome.said += finding.hypothesis.name();
    bool touches = false;
    for (const std::string& truth : outcome.truth) {
      touches = touches || finding.hypothesis.name() == truth;
      for (const auto& rival : finding.tied_with) {
        touches = touches || rival.hypothesis.name() == truth;
      }
    }
    for (const auto& rival : finding.tied_with) {
      outcome.said += "|" + rival.hypothesis.name() + fmt::format("({:.1f})", rival.log_odds);
    }
    outcome.said += fmt::format("({:.1f}", finding.evidence);
    for (std::size_t k = 0; k < finding.fitted.x.size(); ++k) {
      outcome.said += fmt::format(
          " {:.2g}", finding.fitted.x[k] / finding.fitted.effect->parameters[k].sigma);
    }
    outcome.said += ") ";
    outcome.wrong = outcome.wrong || (!touches && finding.certain());
  }
  if (verdict.swap) outcome.said += verdict.swap->name() + " ";
  const bool nothing = verdict.findings.empty() && verdict.unknown.empty() && !verdict.swap;
  outcome.detected = !nothing;
  const bool only = verdict.findings.size() + (verdict.swap ? 1U : 0U) == outcome.truth.size();
  outcome.named = exact == outcome.truth.size() && only && !outcome.truth.empty();
  outcome.in_tie = tied == outcome.truth.size() && !outcome.truth.empty();
  if (!verdict.unknown.empty()) {
    outcome.said += fmt::format(
        "UNKNOWN({:.1f}, {}:", verdict.unknown.front().evidence,
        verdict.unknown.front().enters);
    for (const auto& each : verdict.depends_on()) outcome.said += " " + each;
    outcome.said += ")";
    if (outcome.outside) {
      const std::string right = covariate_of(world.effects.front());
      for (const auto& each : verdict.depends_on()) {
        outcome.unknown = outcome.unknown || each == right;
      }
    }
  }
  return outcome;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Blind challenge: hidden effects, diagnosed without a hint"};
  app.add_option("--sessions", options.sessions);
  app.add_option("--seed", options.seed);
  app.add_option("--first", options.first, "number of the first session of this seed");
  app.add_option("--kind", options.kind, "none, one, two, three, outside");
  app.add_option("--low", options.low);
  app.add_option("--high", options.high);
  app.add_option("--gross", options.gross, "share of gross errors");
  app.add_option("--cause", options.cause);
  app.add_option("--threads", options.threads);
  app.add_flag("--xy", options.xy_only);
  app.add_flag("--curve", options.curve);
  app.add_flag("--verbose", options.verbose);
  CLI11_PARSE(app, argc, argv);

  std::vector<Outcome> outcomes(static_cast<std::size_t>(options.sessions));
  std::atomic<int> next{0};
  std::vector<std::jthread> workers;
  for (int w = 0; w < options.threads; ++w) {
    workers.emplace_back([&] {
      for (int i = next++; i < options.sessions; i = next++) {
        outcomes[static_cast<std::size_t>(i)] = trial_of(
            options, options.seed * 1'000'000 + static_cast<std::uint64_t>(options.first + i));
      }
    });
  }
  workers.clear();

  struct Tally {
    int n = 0, named = 0, tie = 0, detected = 0, wrong = 0, unknown = 0;
  };
  std::map<std::string, Tally> by_cause, by_strength;
  double seconds = 0;
  for (const Outcome& each : outcomes) {
    if (each.truth.empty() && options.kind != "none") continue;
    const char* strength = each.least < 0.15   ? "R < 0.15"
                           : each.least < 0.25 ? "0.15-0.25"
                           : each.least < 0.5  ? "0.25-0.5"
                           : each.least < 1.0  ? "0.5-1"
                           : each.least < 2.0  ? "1-2"
                                               : "2 and up";
    std::string cause;
    for (const auto& truth : each.truth) {
      if (!cause.empty()) cause += "+";
      cause += truth.substr(0, truth.find('@'));
    }
    if (each.truth.size() > 1) cause = "several";
    for (Tally* tally : {&by_strength[strength], &by_cause[cause], &by_strength["all"]}) {
      ++tally->n;
      tally->named += each.named;
      tally->tie += each.in_tie;
      tally->detected += each.detected;
      tally->wrong += each.wrong;
      tally->unknown += each.unknown;
    }
    seconds += each.seconds;
    const bool good = options.kind == "none" ? !each.detected
                      : each.outside         ? each.unknown && !each.wrong
                                             : each.named;
    if (options.verbose && !good) {
      fmt::print("  seed {} R {:.2f} truth", each.seed, each.least);
      for (const auto& truth : each.truth) fmt::print(" {}", truth);
      fmt::print("  said {}\n", each.said.empty() ? "nothing" : each.said);
    }
  }
  fmt::print(
      "{:<28}{:>6}{:>9}{:>9}{:>10}{:>8}{:>9}\n", "", "n", "exact%", "in tie%", "detected%",
      "wrong%", "unknown%");
  for (const auto* table : {&by_strength, &by_cause}) {
    for (const auto& [name, t] : *table) {
      const auto share = [&](int k) { return 100.0 * k / std::max(1, t.n); };
      fmt::print(
          "{:<28}{:>6}{:>9.1f}{:>9.1f}{:>10.1f}{:>8.1f}{:>9.1f}\n", name, t.n, share(t.named),
          share(t.tie), share(t.detected), share(t.wrong), share(t.unknown));
    }
  }
  fmt::print("mean time of a diagnosis {:.0f} ms\n", 1e3 * seconds / options.sessions);
}
