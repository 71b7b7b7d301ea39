#include "tests/blind/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <string_view>

#include "diagnosis/diagnosis.h"
#include "mock_devices/session_generator.h"
#include "session/bundle.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "tests/blind/gain_truth.h"

namespace sixdial::blind {
namespace {

constexpr double kFileNoise_mm = 0.002;
constexpr double kSecondsApart = 8.0;
constexpr int kRounds = 3;
constexpr double kNormal_95 = 1.959963984540054;

/// The plan's poses measured three times.
std::vector<mock_devices::PlannedPose> repeated(
    const std::vector<mock_devices::PlannedPose>& once, Repeats repeats) {
  if (repeats == Repeats::kNone) return once;
  std::vector<mock_devices::PlannedPose> plan;
  const auto add = [&](mock_devices::PlannedPose pose, int repeat) {
    pose.repeat = repeat;
    plan.push_back(pose);
  };
  if (repeats == Repeats::kAtRest) {
    for (const auto& pose : once) {
      for (int repeat = 0; repeat < kRounds; ++repeat) add(pose, repeat);
    }
  } else {
    for (int repeat = 0; repeat < kRounds; ++repeat) {
      for (const auto& pose : once) add(pose, repeat);
    }
  }
  for (std::size_t i = 0; i < plan.size(); ++i) {
    plan[i].time_s = kSecondsApart * static_cast<double>(i + 1);
  }
  return plan;
}

mock_devices::Moment moment_of(const mock_devices::MeasuredRow& row, std::int64_t sample) {
  mock_devices::Moment moment;
  moment.time_s = row.planned.time_s;
  moment.temperature_c = row.temperature_c;
  moment.sample = sample;
  moment.q_rad = row.planned.q_rad;
  moment.approach = row.approach;
  moment.assembly = row.planned.assembly;
  return moment;
}

/// As a user has it: from the files. Positions: each with noise of its own, no dial readings.
session::Session session_of(
    const mock_devices::World& world, const mock_devices::GeneratedSession& generated,
    bool dials) {
  session::Session session = session::parse_session(
      mock_devices::session_csv(generated, world.rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(world.rig), "rig.toml");
  session.name = "coverage";
  if (dials) return session;
  const mock_devices::WorldModel model(world);
  std::mt19937_64 engine(world.seed * 31 + 7);
  std::normal_distribution<double> noise(0.0, world.dials.noise_sd_mm);
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    session::Sample& sample = session.samples[i];
    for (session::ChannelValue& channel : sample.channels) channel = {};
    const auto pose = model.pose(moment_of(generated.rows[i], static_cast<std::int64_t>(i)));
    if (!pose) continue;
    const Eigen::Vector2d shift(noise(engine), noise(engine));
    session::set_position(
        sample, session.rig.dials.size(), geometry::Position(pose->p_WE + shift));
  }
  return session;
}

void count_parameters(
    const std::vector<studies::ParameterRow>& rows, const Eigen::VectorXd& truth,
    Covered& covered) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (!std::isfinite(rows[k].sd) || rows[k].fixed || rows[k].partly_held) continue;
    const double value = truth[static_cast<Eigen::Index>(k)];
    covered.parameters.count(rows[k].low_95 <= value && value <= rows[k].high_95);
  }
}

/// Where the true tool is when the fitted robot is commanded to each place of the map.
void count_positions(
    const studies::Assessment& assessment, const mock_devices::WorldModel& model,
    Covered& covered) {
  if (!assessment.position_uncertainty || !assessment.noise.known) return;
  const studies::PositionMap& map = *assessment.position_uncertainty;
  const double quantile = calibration::quantile_95(assessment.noise);
  geometry::ParameterVector v;
  for (int k = 0; k < geometry::kParameterCount; ++k) {
    v[k] = assessment.parameters.at(static_cast<std::size_t>(k)).identified;
  }
  std::vector<double> widths;
  const geometry::WorkingMode mode = model.world().rig.robot.working_mode;
  for (std::size_t row = 0; row < map.y_mm.size(); ++row) {
    for (std::size_t column = 0; column < map.x_mm.size(); ++column) {
      const std::size_t at = row * map.x_mm.size() + column;
      if (!std::isfinite(map.sd_x_mm[at])) continue;
      const Eigen::Vector2d p(map.x_mm[column], map.y_mm[row]);
      const auto q = geometry::inverse(v, p, mode);
      if (!q) continue;
      const auto assembly = geometry::assembly_at(v, *q, p);
      if (!assembly) continue;
      mock_devices::Moment moment;
      moment.q_rad = *q;
      moment.assembly = *assembly;
      const auto truth = model.tool(moment);
      if (!truth) continue;
      const Eigen::Vector2d off = (*truth - p).cwiseAbs();
      covered.positions.count(off.x() <= quantile * map.sd_x_mm[at]);
      covered.positions.count(off.y() <= quantile * map.sd_y_mm[at]);
      widths.push_back(quantile * map.sd_x_mm[at]);
      widths.push_back(quantile * map.sd_y_mm[at]);
    }
  }
  if (widths.empty()) return;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::ranges::nth_element(widths, middle);
  covered.width_mm = *middle;
}

void judge_calibration(
    const CoverageCase& of, const session::Session& session,
    const mock_devices::WorldModel& model, Covered& covered) {
  Eigen::VectorXd truth(geometry::kParameterCount + 1);
  truth << model.world().robot.parameters, model.world().robot.clamp_rad;
  studies::CompareRequest request;
  request.space = of.dials ? "dials" : "positions";
  request.methods = {"lm"};
  request.threads = 1;
  const studies::ComparisonResult result = studies::compare(session, request);
  count_parameters(result.assessment.parameters, truth, covered);
  count_positions(result.assessment, model, covered);
}

/// What is to be diagnosed, and the same with other held-out poses.
struct Drawn {
  const CoverageCase& of;
  const mock_devices::World& world;
  std::vector<mock_devices::PlannedPose> plan;
};

session::Session session_of(
    const Drawn& drawn, const mock_devices::World& world,
    const std::vector<mock_devices::PlannedPose>& plan) {
  return session_of(world, mock_devices::generate_session(world, plan), drawn.of.dials);
}

std::vector<bool> held_out_of(const session::Session& session) {
  std::vector<bool> held_out;
  for (const session::Sample& sample : session.samples) {
    held_out.push_back(sample.set == "G2");
  }
  return held_out;
}

/// The poses of G2 drawn anew, at the same times.
std::vector<mock_devices::PlannedPose> with_other_g2(const Drawn& drawn, std::uint64_t seed) {
  const auto others =
      mock_devices::random_plan(drawn.world.rig, seed, drawn.of.points, drawn.of.points / 2);
  std::vector<mock_devices::PlannedPose> plan = drawn.plan;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    if (plan[i].set != "G2") continue;
    const double time_s = plan[i].time_s;
    plan[i] = others[i];
    plan[i].time_s = time_s;
  }
  return plan;
}

/// The stated gain against that of many other held-out poses.
void count_gain(
    const Drawn& drawn, const diagnosis::Diagnosis& found, const std::vector<bool>& held_out,
    Covered& covered) {
  if (drawn.of.repeats != Repeats::kNone) return;  // samples of G2 are not poses then
  const auto stated = stated_gain(found, held_out);
  if (!stated) return;
  std::vector<double> differences;
  for (std::uint64_t k = 1; k <= kOtherSessions; ++k) {
    mock_devices::World world = drawn.world;
    world.seed = drawn.world.seed + k * 1'000'003;
    try {
      const session::Session other = session_of(drawn, world, with_other_g2(drawn, world.seed));
      const auto here = differences_on(
          *stated, session::trials_of(other, ""), held_out_of(other), found.readings->model());
      differences.insert(differences.end(), here.begin(), here.end());
    } catch (const std::invalid_argument&) {
      continue;  // a pose that this robot cannot take
    }
  }
  if (differences.empty()) return;
  double mean = 0.0;
  for (const double each : differences) mean += each / static_cast<double>(differences.size());
  covered.gain.count(stated->low_mm <= mean && mean <= stated->high_mm);
}

/// The number of the mock rig's effect that one of a diagnosis' stands for, in its unit. The
/// generator's numbers have names of its own, with units in them ("b_rad", "change_mm").
std::optional<double> true_size(
    const mock_devices::HiddenEffect& hidden, const diagnosis::Estimate& estimate) {
  const auto& cause = hidden.cause;
  const auto& number = hidden.parameters;
  const auto or_none = [&](const char* name) {
    const auto found = number.find(name);
    return found == number.end() ? 0.0 : found->second;
  };
  if (cause == "joint_compliance") {
    return 1 / number.at(estimate.name == "1/K1" ? "k1_nmm_per_rad" : "k2_nmm_per_rad");
  }
  if (cause == "dial_cyclic") {
    if (estimate.name == "period") return number.at("period_mm");
    const double phase_rad = or_none("phase_rad");
    return number.at("amplitude_mm") *
           (estimate.name == "a" ? std::cos(phase_rad) : std::sin(phase_rad));
  }
  if (cause == "step") {
    if (estimate.name == "sample") return std::nullopt;  // a whole number
    const bool turns = number.contains("amount_rad");
    const double amount = number.at(turns ? "amount_rad" : "amount_mm");
    if (hidden.where != "base") return amount;
    const double direction_rad = or_none("direction_rad");
    return amount *
           (estimate.name == "shift" ? std::cos(direction_rad) : std::sin(direction_rad));
  }
  static const std::map<std::string_view, std::string> kNames{
      {"joint_eccentricity a", "a_rad"},
      {"joint_eccentricity b", "b_rad"},
      {"joint_second_harmonic a", "a_rad"},
      {"joint_second_harmonic b", "b_rad"},
      {"joint_gain g", "gain"},
      {"joint_backlash b", "b_rad"},
      {"link_thermal_growth a", "per_k"},
      {"passive_clearance c", "c_mm"},
      {"base_drift vx", "x_mm_per_h"},
      {"base_drift vy", "y_mm_per_h"},
      {"frame_skew s", "angle_rad"},
      {"cuboid_size l", "change_mm"},
      {"cuboid_squareness s", "angle_rad"},
      {"cuboid_offset u", "x_mm"},
      {"cuboid_offset v", "y_mm"},
      {"tip_radius rho", "change_mm"},
      {"dial_gain g", "gain"},
      {"dial_lean angle", "angle_rad"},
      {"dial_mount shift", "change_mm"},
      {"dial_hysteresis h", "width_mm"}};
  return number.at(kNames.at(cause + " " + estimate.name));
}

void count_amplitudes(
    const diagnosis::Cause& cause, const mock_devices::HiddenEffect& hidden, Covered& covered) {
  for (const diagnosis::Estimate& estimate : cause.estimate) {
    const auto truth = true_size(hidden, estimate);
    if (!truth || !std::isfinite(estimate.sd)) continue;
    const bool inside = std::abs(estimate.value - *truth) <= kNormal_95 * estimate.sd;
    covered.amplitudes.count(inside);
  }
}

void judge_diagnosis(const Drawn& drawn, Covered& covered) {
  const session::Session session = session_of(drawn, drawn.world, drawn.plan);
  const simulation::ForwardModel model(session.rig);
  const std::vector<bool> held_out = held_out_of(session);
  diagnosis::DiagnosisSettings settings;
  settings.with_gain = settings.with_limits = false;
  settings.null_draws = 1;
  settings.seed = drawn.world.seed;
  const diagnosis::Diagnosis found =
      diagnosis::diagnose(model, session::trials_of(session, ""), held_out, settings);
  const auto& effects = drawn.world.effects;
  for (const diagnosis::Cause& cause : found.causes) {
    const diagnosis::Hypothesis& named = cause.finding.hypothesis;
    const auto hidden = std::ranges::find_if(effects, [&](const auto& each) {
      return each.cause == named.effect->twin && each.where == named.place.name;
    });
    if (hidden == effects.end()) {
      covered.false_cause = covered.false_cause || cause.finding.certain();
    } else {
      count_amplitudes(cause, *hidden, covered);
    }
  }
  covered.false_alarm =
      effects.empty() && (!found.causes.empty() || !found.named.unknown.empty() ||
                          !found.named.dial_curves.empty());
  if (!effects.empty()) count_gain(drawn, found, held_out, covered);
}

/// All causes in turn that have a size.
std::string cause_of(const CoverageCase& of, std::uint64_t seed) {
  if (of.cause != kAnyCause) return of.cause;
  std::vector<std::string_view> all;
  for (const mock_devices::CauseRow* row : mock_devices::causes()) {
    const bool has_size = !row->is_data_fault && !row->swaps_cables;
    if (has_size && row->in_catalogue) all.push_back(row->id);
  }
  return std::string(all[seed % all.size()]);
}

}  // namespace

std::string_view to_string(Repeats repeats) {
  switch (repeats) {
    case Repeats::kNone:
      return "no repeats";
    case Repeats::kAtRest:
      return "3 at rest";
    case Repeats::kInterleaved:
      return "3 rounds";
  }
  return "";
}

std::string CoverageCase::name() const {
  std::string text = fmt::format(
      "{}, {}, {} points, {}, noise x{:g}", diagnosis ? "diagnosis" : "calibration",
      dials ? "dials" : "positions", points, to_string(repeats), noise_times);
  if (warp_mm > 0.0) text += fmt::format(", warp {:g} mm", warp_mm);
  if (!cause.empty()) text += ", " + cause;
  return text;
}

std::optional<Covered> try_coverage(const CoverageCase& of, std::uint64_t seed) {
  mock_devices::World world;
  for (geometry::Dial& dial : world.rig.dials) dial.repeatability_mm = kFileNoise_mm;
  world.robot = mock_devices::drawn_robot(world.rig, seed);
  world.seed = seed;
  world.dials = {of.noise_times * kFileNoise_mm, 0.0, 0.0, 0.0};
  world.warp.amplitude_mm = of.warp_mm;
  try {
    if (!of.cause.empty()) {
      const int samples = of.points + of.points / 2;
      world.effects = {
          mock_devices::draw_effect_of(world.rig, cause_of(of, seed), seed, samples)};
    }
    const auto once = mock_devices::random_plan(world.rig, seed, of.points, of.points / 2);
    const Drawn drawn{of, world, repeated(once, of.repeats)};
    Covered covered;
    covered.seed = seed;
    if (of.diagnosis) {
      judge_diagnosis(drawn, covered);
    } else {
      const mock_devices::WorldModel model(world);
      judge_calibration(of, session_of(drawn, world, drawn.plan), model, covered);
    }
    return covered;
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // this robot cannot take the plan
  }
}

}  // namespace sixdial::blind
