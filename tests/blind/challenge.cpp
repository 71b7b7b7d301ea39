#include "tests/blind/challenge.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <random>

#include "diagnosis/identify.h"
#include "mock_devices/session_generator.h"
#include "session/trials.h"

namespace sixdial::blind {
namespace {

using mock_devices::HiddenEffect;

/// Where and with what a session is measured.
struct Site {
  geometry::Rig rig = geometry::default_rig();
  Eigen::Vector2d low_mm{16, 30}, high_mm{40, 66};
  double noise_mm = 0.002;
  int points_g1 = 100, points_g2 = 50;
};

/// Another rig: links, base, cuboid, dials, mount, working mode, noise, number of points. A
/// draw that its robot cannot measure is drawn again.
Site drawn_site(std::uint64_t seed) {
  std::mt19937_64 engine(seed * 104729 + 5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const auto below = [&](int n) {
    return std::uniform_int_distribution<int>(0, n - 1)(engine);
  };
  for (int attempt = 0; attempt < 200; ++attempt) {
    Site site;
    geometry::Rig& rig = site.rig;
    const double scale = uniform(0.8, 2.5);
    auto& nominal = rig.robot.nominal;
    for (int i = 0; i < 4; ++i) nominal[i] = std::round(scale * uniform(52, 68));
    nominal[geometry::kD] = below(5) == 0 ? 0.0 : std::round(scale * uniform(50, 110));
    rig.robot.working_mode = geometry::kWorkingModes[static_cast<std::size_t>(below(4))];
    // On one axis, legs that bend to the same side lie on each other.
    const bool coaxial = nominal[geometry::kD] == 0.0;
    if (coaxial && rig.robot.working_mode.leg(0) == rig.robot.working_mode.leg(1)) continue;
    constexpr std::array kMounts{geometry::Mount::kDistal1, geometry::Mount::kDistal2};
    rig.cuboid.mount = kMounts[static_cast<std::size_t>(below(2))];
    rig.cuboid.side_mm = std::round(uniform(50, 100));
    const Eigen::Vector2d centre(scale * uniform(-20, 30), scale * uniform(40, 75));
    const Eigen::Vector2d half(uniform(8, 14), uniform(8, 16));
    rig.cuboid.reference_pose_mm = centre;
    site.low_mm = centre - half;
    site.high_mm = centre + half;
    const double reach = rig.cuboid.side_mm / 2 - 18;  // plungers in by 18 mm at the centre
    const double apart = uniform(0.15, 0.3) * rig.cuboid.side_mm;
    rig.dials.clear();
    const auto add = [&](const char* id, double x, double y, double ax, double ay) {
      geometry::Dial dial;
      dial.id = id;
      dial.geometry.position_mm = centre + Eigen::Vector2d(x, y);
      dial.geometry.axis = {ax, ay};
      dial.repeatability_mm = site.noise_mm;
      rig.dials.push_back(dial);
    };
    site.noise_mm = uniform(0.001, 0.004);
    add("A", reach, 0, -1, 0);
    add("B", -reach, 0, 1, 0);
    add("C", -apart, -reach, 0, 1);
    add("D", apart, -reach, 0, 1);
    if (below(4) != 0) {
      add("E", -apart, reach, 0, -1);
      add("F", apart, reach, 0, -1);
    }
    site.points_g1 = 80 + below(120);
    site.points_g2 = 30 + below(50);
    try {
      const simulation::ForwardModel model(rig);
      mock_devices::World world;
      world.rig = rig;
      world.robot = mock_devices::drawn_robot(rig, seed);
      world.dials = mock_devices::kIdealDials;
      const auto session = mock_devices::generate_session(
          world, mock_devices::random_plan(
                     rig, seed, site.points_g1, site.points_g2, site.low_mm, site.high_mm));
      std::size_t seen = 0;
      for (const auto& row : session.rows) {
        for (const auto& value : row.noise_free_mm) seen += value.has_value() ? 1U : 0U;
      }
      // Nobody measures beside a singularity.
      constexpr double kWorstTransmission = 6.0;
      bool singular = false;
      for (const auto& row : session.rows) {
        const auto pose = geometry::forward_derivative(
            rig.robot.nominal, row.planned.q_rad, row.planned.assembly);
        if (!pose) {
          singular = true;
          break;
        }
        const Eigen::JacobiSVD<Eigen::Matrix2d> svd(pose->J_q);
        singular =
            singular || svd.singularValues()[0] > kWorstTransmission * svd.singularValues()[1];
      }
      if (singular) continue;
      if (seen * 10 >= session.rows.size() * rig.dials.size() * 8) return site;
    } catch (const std::exception&) {
      continue;
    }
  }
  return {};
}

/// What is left of the noise-free readings after refitting robot and clamp, rms over noise.
double visible_ratio(
    const simulation::ForwardModel& model, const mock_devices::GeneratedSession& session,
    bool xy_only, double noise_mm) {
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
  const double noise = xy_only ? readings.rig_noise_mm() : noise_mm;
  return std::sqrt(e.squaredNorm() / static_cast<double>(e.size())) / noise;
}

std::string covariate_of(const HiddenEffect& effect) {
  const auto covariate = mock_devices::cause_row(effect.cause).covariate;
  return covariate ? covariate(effect.where) : "";
}

/// Under the name that a diagnosis gives it: of the effect whose twin it is, if there is one.
std::string name_of(const HiddenEffect& effect) {
  for (const simulation::Effect* each : simulation::all_effects()) {
    if (each->twin == effect.cause) return std::string(each->cause) + "@" + effect.where;
  }
  return effect.cause + "@" + effect.where;
}

}  // namespace

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
    sample.q = row.planned.q_rad;
    sample.target_mm = row.planned.target_mm;
    sample.approach = {row.approach[0], row.approach[1]};
    sample.temperature_c = row.temperature_c;
    sample.time_utc =
        start + std::chrono::milliseconds(static_cast<std::int64_t>(row.planned.time_s * 1000));
    for (const auto& value : noise_free ? row.noise_free_mm : row.dial_mm) {
      session::ChannelValue dial;
      dial.value = value;
      sample.channels.push_back(dial);
    }
    auto trial = session::trial_of(rig, sample, static_cast<int>(i), start);
    if (xy_only) trial.reading.assign(trial.reading.size(), std::nullopt);
    trials.push_back(std::move(trial));
  }
  return trials;
}

std::optional<Outcome> try_blind(const Challenge& options, std::uint64_t seed) {
  std::mt19937_64 engine(seed * 7919 + 17);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  Site site = options.drawn_rig ? drawn_site(seed) : Site{};
  const geometry::Rig& rig = site.rig;
  const simulation::ForwardModel model(rig);
  Outcome outcome;
  outcome.seed = seed;
  const int count = options.kind == "none"    ? 0
                    : options.kind == "two"   ? 2
                    : options.kind == "three" ? 3
                                              : 1;
  const bool outside = options.kind == "outside";
  mock_devices::World world;
  world.rig = rig;
  world.robot = mock_devices::drawn_robot(rig, seed);
  world.seed = seed;
  world.dials = {site.noise_mm, 0.001, 0.0, 0.0};
  if (options.curve) world.dials = mock_devices::DialHabits{.noise_sd_mm = site.noise_mm};
  world.warm_up.tau_s = uniform(600, 3000);
  world.warm_up.rise_c = uniform(2, 6);
  const auto plan = mock_devices::random_plan(
      rig, seed, site.points_g1, site.points_g2, site.low_mm, site.high_mm);
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
            outside ? mock_devices::Pool::kOutside : mock_devices::Pool::kCatalogue;
        effect = options.cause.empty() ? mock_devices::draw_effect(rig, draw, pool)
                                       : mock_devices::draw_effect_of(rig, options.cause, draw);
        const mock_devices::CauseRow& row = mock_devices::cause_row(effect.cause);
        if (row.is_data_fault) continue;
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
              options.xy_only, site.noise_mm);
        };
        if (!row.swaps_cables) {
          // Scale the size to the wanted strength; an effect that would have to be ten times as
          // large as a rig of this kind shows is not drawn.
          ratio = alone(effect);
          if (!(ratio > 1e-3)) continue;
          const double factor = wanted / ratio;
          if (factor > 10) continue;
          effect = mock_devices::enlarged(effect, factor);
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
      outcome.truth.push_back(name_of(effect));
      break;
    }
  }
  if (count == 0) outcome.least = 0;
  if (static_cast<int>(outcome.truth.size()) != count) return std::nullopt;
  if (options.gross > 0) {
    HiddenEffect gross = mock_devices::make_effect(rig, "outliers", "samples", 0.3, seed);
    gross.parameters.at("share") = options.gross;
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
    if (finding.certain()) outcome.named_causes.push_back(finding.hypothesis.name());
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
    if (outside) {
      const std::string right = covariate_of(world.effects.front());
      for (const auto& each : verdict.depends_on()) {
        outcome.unknown = outcome.unknown || each == right;
      }
    }
  }
  return outcome;
}

}  // namespace sixdial::blind
