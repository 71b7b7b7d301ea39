#include "tests/blind/challenge.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <random>

#include "diagnosis/naming.h"
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

/// Whether the site's robot keeps away from singular poses, and most dials touch at most
/// points.
bool is_measurable(const Site& site, std::uint64_t seed) {
  const geometry::Rig& rig = site.rig;
  const simulation::ForwardModel model(rig);  // throws for a rig that cannot be
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
    // Nobody measures beside a singularity.
    constexpr double kWorstTransmission = 6.0;
    const auto pose = geometry::forward_derivative(
        rig.robot.nominal, row.planned.q_rad, row.planned.assembly);
    if (!pose) return false;
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(pose->J_q);
    if (svd.singularValues()[0] > kWorstTransmission * svd.singularValues()[1]) return false;
  }
  return seen * 10 >= session.rows.size() * rig.dials.size() * 8;
}

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
      if (is_measurable(site, seed)) return site;
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

/// What one blind try hides its effects in.
struct Hiding {
  const Challenge& options;
  const Site& site;
  const simulation::ForwardModel& model;
  const mock_devices::World& ideal;  // dials without errors
  const std::vector<mock_devices::PlannedPose>& plan;
  int count = 0;  // effects to hide
};

/// An effect and what it leaves of the readings after a refit, over the noise.
struct DrawnEffect {
  HiddenEffect effect;
  double ratio = 0.0;
};

double ratio_of(const Hiding& hiding, const HiddenEffect& effect) {
  mock_devices::World one = hiding.ideal;
  one.effects = {effect};
  return visible_ratio(
      hiding.model, generate_session(mock_devices::WorldModel(one).world(), hiding.plan),
      hiding.options.xy_only, hiding.site.noise_mm);
}

/// The effect that `draw` gives, as strong as `wanted`. Empty where it cannot be: there
/// already, a fault of the data, or ten times as large as a rig of this kind shows.
std::optional<DrawnEffect> drawn_effect(
    const Hiding& hiding, const std::vector<HiddenEffect>& there, std::uint64_t draw,
    double wanted) {
  const geometry::Rig& rig = hiding.site.rig;
  const auto pool = hiding.options.kind == "outside" ? mock_devices::Pool::kOutside
                                                     : mock_devices::Pool::kCatalogue;
  HiddenEffect effect = hiding.options.cause.empty()
                            ? mock_devices::draw_effect(rig, draw, pool)
                            : mock_devices::draw_effect_of(rig, hiding.options.cause, draw);
  const mock_devices::CauseRow& row = mock_devices::cause_row(effect.cause);
  if (row.is_data_fault) return std::nullopt;
  for (const HiddenEffect& each : there) {
    if (each.cause == effect.cause && each.where == effect.where) return std::nullopt;
  }
  if (row.swaps_cables) {
    if (hiding.count > 1) return std::nullopt;
    // Millimetres: the refit of exchanged readings means nothing.
    return DrawnEffect{effect, 1000.0};
  }
  constexpr double kMostEnlarged = 10;
  double ratio = ratio_of(hiding, effect);
  if (!(ratio > 1e-3)) return std::nullopt;
  const double factor = wanted / ratio;
  if (factor > kMostEnlarged) return std::nullopt;
  effect = mock_devices::enlarged(effect, factor);
  ratio = ratio_of(hiding, effect);
  if (!(ratio > 0.5 * wanted && ratio < 2 * wanted)) return std::nullopt;
  return DrawnEffect{effect, ratio};
}

/// How many of the hidden effects were named, alone or in a tie.
struct Hits {
  std::size_t exact = 0, tied = 0;
};

bool is_tied_with(const diagnosis::Finding& finding, const std::string& name) {
  return std::ranges::any_of(finding.tied_with, [&](const diagnosis::Rival& rival) {
    return rival.hypothesis.name() == name;
  });
}

Hits hits_of(const diagnosis::NamedCauses& verdict, const std::vector<std::string>& hidden) {
  Hits hits;
  for (const std::string& truth : hidden) {
    bool is_exact = false, is_tied = false;
    for (const diagnosis::Finding& finding : verdict.findings) {
      if (finding.hypothesis.name() == truth) (finding.certain() ? is_exact : is_tied) = true;
      if (is_tied_with(finding, truth)) is_tied = true;
    }
    if (verdict.swap && verdict.swap->name() == truth) is_exact = true;
    hits.exact += is_exact ? 1U : 0U;
    hits.tied += is_exact || is_tied ? 1U : 0U;
  }
  return hits;
}

/// "joint_backlash@joint1|joint_second_harmonic@joint1(1.2)(35.1 0.9) ": sizes in plausible
/// ones.
std::string said_of(const diagnosis::Finding& finding) {
  std::string said = finding.hypothesis.name();
  for (const diagnosis::Rival& rival : finding.tied_with) {
    said += "|" + rival.hypothesis.name() + fmt::format("({:.1f})", rival.log_odds);
  }
  said += fmt::format("({:.1f}", finding.evidence);
  for (std::size_t k = 0; k < finding.fitted.x.size(); ++k) {
    said += fmt::format(
        " {:.2g}", finding.fitted.x[k] / finding.fitted.effect->parameters[k].sigma);
  }
  return said + ") ";
}

void judge_unknown(
    const diagnosis::NamedCauses& verdict, const std::optional<std::string>& right,
    Outcome& outcome) {
  for (const diagnosis::DialCurve& curve : verdict.dial_curves) {
    const std::string& own = curve.smooth.covariates.front();
    outcome.said +=
        fmt::format("CURVE({}, {:.1f}, {:.4f} mm) ", own, curve.evidence, curve.half_span);
    outcome.unknown = outcome.unknown || own == right;
    outcome.wrong = outcome.wrong || (curve.certain() && own != right);
  }
  for (const diagnosis::JointCurve& curve : verdict.joint_curves) {
    const std::string& own = curve.smooth.covariates.front();
    outcome.said += fmt::format("CURVE({}, {:.1f}) ", own, curve.evidence);
    outcome.unknown = outcome.unknown || own == right;
    outcome.wrong = outcome.wrong || (curve.certain() && own != right);
  }
  if (verdict.unknown.empty()) return;
  outcome.said += fmt::format(
      "UNKNOWN({:.1f}, {}:", verdict.unknown.front().evidence, verdict.unknown.front().enters);
  for (const auto& each : verdict.depends_on()) outcome.said += " " + each;
  outcome.said += ")";
  for (const auto& each : verdict.depends_on()) {
    outcome.unknown = outcome.unknown || each == right;
  }
}

/// "dial_mount@C": the rig is not as its file says.
bool is_of_rig(const std::string& name) {
  const simulation::Effect* effect = simulation::find_effect(name.substr(0, name.find('@')));
  return effect != nullptr && effect->of_rig_geometry;
}

/// `right`: the covariate of an effect outside of the catalogue.
void judge(
    const diagnosis::NamedCauses& verdict, const std::optional<std::string>& right,
    Outcome& outcome) {
  const Hits hits = hits_of(verdict, outcome.truth);
  for (const diagnosis::Finding& finding : verdict.findings) {
    outcome.said += said_of(finding);
    if (!finding.certain()) continue;
    outcome.named_causes.push_back(finding.hypothesis.name());
    const bool touches = std::ranges::any_of(outcome.truth, [&](const std::string& truth) {
      return finding.hypothesis.name() == truth || is_tied_with(finding, truth);
    });
    outcome.wrong = outcome.wrong || !touches;
  }
  if (verdict.swap) outcome.said += verdict.swap->name() + " ";
  if (verdict.rig_geometry) {
    outcome.said += "rig_geometry ";
    outcome.wrong = outcome.wrong || !std::ranges::any_of(outcome.truth, is_of_rig);
  }
  outcome.detected = !verdict.findings.empty() || !verdict.unknown.empty() ||
                     !verdict.dial_curves.empty() || !verdict.joint_curves.empty() ||
                     verdict.swap.has_value() || verdict.rig_geometry.has_value();
  const bool only =
      verdict.findings.size() + (verdict.swap ? 1U : 0U) == outcome.truth.size() &&
      !verdict.rig_geometry;
  outcome.named = hits.exact == outcome.truth.size() && only && !outcome.truth.empty();
  outcome.in_tie = hits.tied == outcome.truth.size() && !outcome.truth.empty();
  judge_unknown(verdict, right, outcome);
}

/// Dials that stand elsewhere than the rig file says.
void hide_shifts(
    const Challenge& options, std::uint64_t seed, mock_devices::World& world,
    Outcome& outcome) {
  if (options.shifted == 0) return;
  std::mt19937_64 engine(seed * 6271 + 3);
  std::vector<std::string> ids;
  for (const geometry::Dial& dial : world.rig.dials) ids.push_back(dial.id);
  std::shuffle(ids.begin(), ids.end(), engine);
  for (int k = 0; k < std::min(options.shifted, static_cast<int>(ids.size())); ++k) {
    const double share = std::uniform_real_distribution<double>(0, 1)(engine);
    const double size =
        options.shift_low_mm * std::pow(options.shift_high_mm / options.shift_low_mm, share);
    const double sign = std::uniform_int_distribution<int>(0, 1)(engine) == 0 ? -1.0 : 1.0;
    world.effects.push_back(mock_devices::make_effect(
        world.rig, "dial_mount", ids[static_cast<std::size_t>(k)], sign * size, seed));
    outcome.truth.push_back(name_of(world.effects.back()));
  }
}

int count_of(const std::string& kind) {
  return kind == "none" ? 0 : kind == "two" ? 2 : kind == "three" ? 3 : 1;
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
    if (row.planned.target_mm) sample.target_mm = *row.planned.target_mm;
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
  const Site site = options.drawn_rig ? drawn_site(seed) : Site{};
  const geometry::Rig& rig = site.rig;
  const simulation::ForwardModel model(rig);
  Outcome outcome;
  outcome.seed = seed;
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
  const Hiding hiding{options, site, model, ideal, plan, count_of(options.kind)};
  outcome.least = hiding.count == 0 ? 0.0 : 1e9;
  for (int k = 0; k < hiding.count; ++k) {
    for (int attempt = 0; attempt < 60; ++attempt) {
      const std::uint64_t draw = engine();
      const double wanted = options.low * std::pow(options.high / options.low, uniform(0, 1));
      std::optional<DrawnEffect> drawn;
      try {
        drawn = drawn_effect(hiding, world.effects, draw, wanted);
      } catch (const std::exception&) {
        continue;
      }
      if (!drawn) continue;
      world.effects.push_back(drawn->effect);
      outcome.least = std::min(outcome.least, drawn->ratio);
      outcome.truth.push_back(name_of(drawn->effect));
      break;
    }
  }
  if (static_cast<int>(outcome.truth.size()) != hiding.count) return std::nullopt;
  world.scatter = options.scatter;
  hide_shifts(options, seed, world, outcome);
  if (options.gross > 0) {
    HiddenEffect gross = mock_devices::make_effect(rig, "outliers", "samples", 0.3, seed);
    gross.parameters.at("share") = options.gross;
    world.effects.push_back(gross);
  }
  const auto session = generate_session(world, plan);
  const auto trials = trials_of(rig, session, false, options.xy_only);
  const auto start = std::chrono::steady_clock::now();
  diagnosis::Readings readings(model, trials);
  const auto verdict = diagnosis::name_causes(readings);
  outcome.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.scatter =
      diagnosis::scatter_of(readings, verdict.extended, noise_of(readings, verdict.extended))
          .found;
  outcome.gross_share =
      static_cast<double>(verdict.gross.size()) / static_cast<double>(readings.count());
  judge(
      verdict,
      options.kind == "outside" ? std::optional(covariate_of(world.effects.front()))
                                : std::nullopt,
      outcome);
  return outcome;
}

}  // namespace sixdial::blind
