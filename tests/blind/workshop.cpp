#include "tests/blind/workshop.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>
#include <set>

#include "diagnosis/command_fit.h"
#include "diagnosis/naming.h"
#include "mock_devices/hidden/cause.h"
#include "studies/extended_command.h"
#include "tests/blind/challenge.h"

namespace sixdial::blind {

void state_deviations(geometry::Rig& file, const mock_devices::Misplaced& by) {
  for (geometry::Dial& dial : file.dials) {
    dial.deviations = {
        Eigen::Vector2d(by.along_mm, by.across_mm), by.axis_rad, by.tip_radius_mm};
  }
  file.cuboid.deviations = {by.side_mm, by.squareness_rad, by.offset_mm};
}

namespace {

using mock_devices::Workshop;

constexpr int kTargets = 40;
constexpr double kLow_x_mm = 16, kHigh_x_mm = 40, kLow_y_mm = 30, kHigh_y_mm = 66;
constexpr double kNormal_95 = 1.959963984540054;

/// Of this thread: other work on the machine does not count.
double core_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What the generator gives any size at all, under the names that a diagnosis uses.
std::set<std::string> names_of(const Workshop& workshop, const WorkshopCase& of) {
  std::set<std::string> result;
  const auto add = [&](const mock_devices::HiddenEffect& effect) {
    for (const simulation::Effect* each : simulation::all_effects()) {
      if (each->twin == effect.cause) {
        result.insert(fmt::format("{}@{}", each->cause, effect.where));
      }
    }
  };
  for (const auto& effect : workshop.world.effects) add(effect);
  for (const geometry::Dial& dial : workshop.file.dials) {
    add({"dial_hysteresis", dial.id, {}});
    if (!of.misplaced) continue;
    add({"dial_mount", dial.id, {}});
    add({"dial_lean", dial.id, {}});
  }
  return result;
}

std::string name_of(const mock_devices::HiddenEffect& effect) {
  for (const simulation::Effect* each : simulation::all_effects()) {
    if (each->twin == effect.cause) return fmt::format("{}@{}", each->cause, effect.where);
  }
  return fmt::format("{}@{}", effect.cause, effect.where);
}

/// RMS of what a cause alone leaves of noise-free readings once all the rest is fitted, in the
/// noise: the robot, and the rig's geometry as well as a workshop knows it (a cuboid 0.01 mm
/// larger than stated, where that is what the file says of it, is no cause at all).
double ratio_of(
    const Workshop& workshop, const mock_devices::Misplaced& by,
    const mock_devices::HiddenEffect& effect,
    const std::vector<mock_devices::PlannedPose>& plan) {
  mock_devices::World alone = workshop.world;
  alone.rig = workshop.file;
  alone.dials = mock_devices::kIdealDials;
  alone.effects = {effect};
  geometry::Rig stated = workshop.file;
  state_deviations(stated, by);
  const simulation::ForwardModel model(stated);
  const auto trials = trials_of(stated, generate_session(alone, plan), true);
  diagnosis::Readings readings(model, trials);
  readings.place_tool(model.nominal());
  const simulation::ExtendedModel plain(model, {});
  const double noise_mm = workshop.world.dials.noise_sd_mm;
  // For one standard deviation of each quantity.
  const Eigen::MatrixXd rig = readings.rig_noise_mm() / noise_mm * readings.nuisance();
  simulation::ModelVector at = model.nominal();
  const Eigen::Index n = readings.count(), k = at.size();
  Eigen::VectorXd e(n + rig.cols()), of_rig = Eigen::VectorXd::Zero(rig.cols());
  const auto leave = [&] {
    e << (readings.measured_mm() - readings.simulate(at, plain)) / noise_mm - rig * of_rig,
        -of_rig;
    return e.allFinite();
  };
  for (int step = 0; step < 12; ++step) {
    if (!leave()) return std::nan("");
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(e.size(), k + rig.cols());
    columns.topLeftCorner(n, k) = readings.jacobian(at) / noise_mm;
    columns.topRightCorner(n, rig.cols()) = rig;
    columns.bottomRightCorner(rig.cols(), rig.cols()).setIdentity();
    const Eigen::VectorXd x = columns.completeOrthogonalDecomposition().solve(e);
    at += x.head(k);
    of_rig += x.tail(rig.cols());
  }
  if (!leave()) return std::nan("");
  return std::sqrt(e.head(n).squaredNorm() / static_cast<double>(n));
}

/// A cause of the catalogue, not of the cables, as strong as wanted.
std::optional<mock_devices::HiddenEffect> strong_cause(
    const Workshop& workshop, const mock_devices::Misplaced& by,
    const std::vector<mock_devices::PlannedPose>& plan, double wanted,
    std::mt19937_64& engine) {
  for (int attempt = 0; attempt < 40; ++attempt) {
    mock_devices::HiddenEffect effect = mock_devices::draw_effect(workshop.file, engine());
    const mock_devices::CauseRow& row = mock_devices::cause_row(effect.cause);
    if (row.swaps_cables || row.is_data_fault) continue;
    try {
      const double factor = wanted / ratio_of(workshop, by, effect, plan);
      if (!(factor > 0 && factor < 10)) continue;
      effect = mock_devices::enlarged(effect, factor);
      const double ratio = ratio_of(workshop, by, effect, plan);
      if (ratio > 0.5 * wanted && ratio < 2 * wanted) return effect;
    } catch (const std::exception&) {
      continue;
    }
  }
  return std::nullopt;
}

/// Mean distance of where the tool comes from where it was sent, after the best rigid
/// alignment of the whole set.
double aligned_mean_mm(
    const std::vector<Eigen::Vector2d>& sent, const std::vector<Eigen::Vector2d>& came) {
  const auto count = static_cast<double>(sent.size());
  Eigen::Vector2d centre_sent = Eigen::Vector2d::Zero(), centre_came = centre_sent;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    centre_sent += sent[i] / count;
    centre_came += came[i] / count;
  }
  double cosine = 0.0, sine = 0.0;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const Eigen::Vector2d a = came[i] - centre_came, b = sent[i] - centre_sent;
    cosine += a.dot(b);
    sine += a.x() * b.y() - a.y() * b.x();
  }
  const Eigen::Rotation2Dd turn(std::atan2(sine, cosine));
  double sum = 0.0;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    sum += (turn * (came[i] - centre_came) - (sent[i] - centre_sent)).norm();
  }
  return sum / count;
}

/// Commands new targets from one side, at the session's last temperature and time.
double commanded_mm(
    const Workshop& workshop, const studies::ExtendedFit& fit,
    const mock_devices::MeasuredRow& last) {
  const mock_devices::WorldModel truth(workshop.world);
  const studies::ExtendedCommand command(fit, workshop.file);
  std::mt19937_64 engine(workshop.world.seed * 13 + 3);
  std::uniform_real_distribution<double> x(kLow_x_mm, kHigh_x_mm), y(kLow_y_mm, kHigh_y_mm);
  const Eigen::Vector2d travel = Eigen::Vector2d(1, 1).normalized();
  studies::CommandMoment moment;
  moment.approach = {1, 1};
  moment.travel << travel, 0.0;
  moment.temperature_c = last.temperature_c;
  std::vector<Eigen::Vector2d> sent, came;
  for (int i = 0; i < kTargets; ++i) {
    const Eigen::Vector2d target(x(engine), y(engine));
    const auto q =
        command.solve(target, workshop.file.robot.working_mode, moment, last.planned.q_rad);
    if (!q) continue;
    mock_devices::Moment there;
    there.time_s = last.planned.time_s;
    there.temperature_c = last.temperature_c;
    there.sample = 150;
    there.q_rad = q->q;
    there.approach = {1, 1};
    there.travel = travel;
    there.assembly = last.planned.assembly;
    const auto pose = truth.pose(there);
    if (!pose) continue;
    sent.push_back(target);
    came.push_back(pose->p_WE);
  }
  return sent.size() < 3 ? std::nan("") : aligned_mean_mm(sent, came);
}

void judge(
    const diagnosis::NamedCauses& verdict, const std::set<std::string>& there, bool misplaced,
    WorkshopOutcome& outcome) {
  for (const diagnosis::Finding& finding : verdict.findings) {
    const std::string name = finding.hypothesis.name();
    outcome.said +=
        fmt::format("{}={:.3g}({:.1f}", name, finding.fitted.x.front(), finding.evidence);
    bool in_set = name == outcome.strong;
    for (const diagnosis::Rival& rival : finding.tied_with) {
      outcome.said += fmt::format("|{}", rival.hypothesis.name());
      in_set = in_set || rival.hypothesis.name() == outcome.strong;
    }
    outcome.said += finding.certain() ? ") " : ")? ";
    outcome.found = outcome.found || in_set;
    if (finding.certain() && !there.contains(name)) outcome.wrong = true;
  }
  if (verdict.swap) outcome.wrong = true;
  if (!verdict.gross.empty()) {
    outcome.said += fmt::format("{} gross readings ", verdict.gross.size());
  }
  for (const diagnosis::DialCurve& each : verdict.dial_curves) {
    // All curves of a workshop are within the makers' limits.
    outcome.said += fmt::format("curve of dial {} ", each.dial);
    outcome.wrong = outcome.wrong || each.certain();
  }
  outcome.rig_geometry = verdict.rig_geometry.has_value();
  if (verdict.rig_geometry) {
    outcome.said += fmt::format("rig_geometry({:.1f}) ", *verdict.rig_geometry);
    outcome.wrong = outcome.wrong || !misplaced;
  }
  for (const auto* list : {&verdict.unknown, &verdict.background}) {
    for (const diagnosis::UnknownCandidate& each : *list) {
      outcome.said += fmt::format(
          "[{} {}: {:.1f}, {:.4f} mm] ", each.enters, fmt::join(each.covariates, " "),
          each.evidence, each.rms_mm);
    }
  }
}

}  // namespace

std::optional<WorkshopOutcome> try_workshop(const WorkshopCase& of, std::uint64_t seed) {
  std::mt19937_64 engine(seed * 6007 + 11);
  const mock_devices::Misplaced by =
      of.misplaced ? mock_devices::Misplaced{} : mock_devices::kPlacedExactly;
  Workshop workshop = mock_devices::drawn_workshop(geometry::default_rig(), seed, by);
  if (of.deviations) state_deviations(workshop.file, by);
  const auto plan = mock_devices::random_plan(
      workshop.file, seed, 100, 50, {kLow_x_mm, kLow_y_mm}, {kHigh_x_mm, kHigh_y_mm});
  WorkshopOutcome outcome;
  outcome.seed = seed;
  if (of.strong) {
    const double wanted =
        of.low * std::pow(of.high / of.low, std::uniform_real_distribution<double>()(engine));
    const auto cause = strong_cause(workshop, by, plan, wanted, engine);
    if (!cause) return std::nullopt;
    std::erase_if(workshop.world.effects, [&](const auto& each) {
      return each.cause == cause->cause && each.where == cause->where;
    });
    workshop.world.effects.push_back(*cause);
    outcome.strong = name_of(*cause);
  }
  const auto session = generate_session(workshop.world, plan);
  const simulation::ForwardModel model(workshop.file);
  diagnosis::Readings readings(model, trials_of(workshop.file, session));
  const double start_s = core_seconds();
  const diagnosis::NamedCauses verdict = diagnosis::name_causes(readings);
  outcome.seconds = core_seconds() - start_s;
  judge(verdict, names_of(workshop, of), of.misplaced, outcome);
  if (of.strong) {
    for (const auto& [name, value] : workshop.world.effects.back().parameters) {
      outcome.said += fmt::format("hidden {}={:.3g} ", name, value);
    }
  }
  for (std::size_t d = 0; d < readings.noise_of_dial().size(); ++d) {
    if (readings.noise_of_dial()[d] == readings.rig_noise_of(d)) continue;
    outcome.said += fmt::format(
        "noise of {} {:.4f} ", workshop.file.dials[d].id, readings.noise_of_dial()[d]);
  }
  diagnosis::JointFit kinematics = verdict.baseline;
  kinematics.effects.clear();
  outcome.kinematics_mm =
      commanded_mm(workshop, studies::commands_of(readings, kinematics), session.rows.back());
  const diagnosis::JointFit commanding = diagnosis::command_fit(readings, verdict);
  outcome.extended_mm =
      commanded_mm(workshop, studies::commands_of(readings, commanding), session.rows.back());
  for (int k = 0; k < geometry::kParameterCount; ++k) {
    const double sd = std::sqrt(commanding.covariance(k, k));
    if (!(sd > 0)) continue;
    outcome.parameters.count(
        std::abs(commanding.model[k] - workshop.world.robot.parameters[k]) <= kNormal_95 * sd);
  }
  return outcome;
}

}  // namespace sixdial::blind
