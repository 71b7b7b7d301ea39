// Whether a session has enough poses for so many parameters. Many readings of one pose are one
// pose; then a fit leaves nothing over whatever the robot is like, and nothing can be accused.
#include "studies/plausibility_of_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "calibration/reading_space.h"
#include "geometry/registration.h"
#include "geometry/units.h"

namespace sixdial::studies {
namespace {

/// No controller comes back closer to a pose than this and calls it another.
constexpr double kSamePose = 2e-3;  // rad; of a prismatic joint mm

/// Different poses of some trials, and how many equations they make.
struct DistinctPoses {
  int count = 0;
  int equations = 0;
  int each = 0;  // of a pose that shows all that is fitted
};

DistinctPoses distinct_poses(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig) {
  constexpr int kOfATurn = 3;
  struct SeenPose {
    Eigen::VectorXd q;
    bool turn = false;
  };
  const bool turns = calibration::fits_turns(trials, rig);
  const auto instrument = turns ? geometry::instrument_of(rig) : nullptr;
  std::vector<SeenPose> poses;
  for (const simulation::Trial& trial : trials) {
    auto same = std::ranges::find_if(poses, [&](const SeenPose& each) {
      return (each.q - trial.q).cwiseAbs().maxCoeff() < kSamePose;
    });
    if (same == poses.end()) same = poses.insert(poses.end(), SeenPose{trial.q});
    same->turn = same->turn || (turns && calibration::has_turn(trial, *instrument));
  }
  const auto count = static_cast<int>(poses.size());
  const auto turned = static_cast<int>(std::ranges::count(poses, true, &SeenPose::turn));
  const int axes = rig.instrument.dimensions;
  return {count, axes * count + kOfATurn * turned, axes + (turns ? kOfATurn : 0)};
}

/// Of a parameter in the rig file; rows of an arm have no key of their own.
WarningPlace place_of(const geometry::ParameterInfo& info) {
  return {.file = "rig.toml", .field = info.rig_key.empty() ? "" : "[robot] " + info.rig_key};
}

/// More equations than unknowns, before any noise can be known from them (calibration/noise.h).
constexpr int kToSpare = 5;

}  // namespace

std::optional<Warning> smaller_fit(
    const std::vector<Warning>& warnings, const calibration::ObservationSpace& space,
    const std::vector<char>& fixed) {
  const auto few = std::ranges::find(warnings, kTooFewPoses, &Warning::code);
  if (few == warnings.end() || space.samples() == 0) return std::nullopt;
  const auto poses = static_cast<int>(std::get<double>(few->parts.at("poses")));
  const int equations = poses * space.rows() / space.samples();
  // By how many standard deviations a plausible change of each parameter moves each row.
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(space.rows(), space.parameters());
  for (int i = 0; i < space.samples(); ++i) {
    const int first = space.first_row[static_cast<std::size_t>(i)];
    Eigen::VectorXd e(space.rows(i));
    Eigen::MatrixXd J(space.rows(i), space.parameters());
    if (space.evaluate(i, space.nominal, e, &J)) moves.middleRows(first, space.rows(i)) = J;
  }
  moves =
      (space.sigma_mm.cwiseInverse().asDiagonal() * moves * space.scale().asDiagonal()).eval();
  for (std::size_t k = 0; k < fixed.size(); ++k) {
    if (fixed[k] != 0) moves.col(static_cast<Eigen::Index>(k)).setZero();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(moves);
  int kept = 0;
  while (kept < std::min<int>(equations - kToSpare, space.parameters()) &&
         std::abs(qr.matrixQR()(kept, kept)) > 1.0) {
    ++kept;
  }
  if (kept == 0) return std::nullopt;
  std::vector<std::string> hold;
  for (int k = kept; k < space.parameters(); ++k) {
    const auto parameter = static_cast<std::size_t>(qr.colsPermutation().indices()[k]);
    hold.push_back(space.parameter_info[parameter].name);
  }
  if (hold.empty()) return std::nullopt;
  std::ranges::sort(hold);
  return Warning{
      "smaller_fit",
      Severity::kNote,
      {.file = "session.csv"},
      {{"fitted", static_cast<double>(kept)},
       {"fix", fmt::format("{}", fmt::join(hold, ","))}}};
}

std::optional<Warning> too_few_poses(
    std::span<const simulation::Trial> fitted, const geometry::Rig& rig, int free_parameters) {
  // As many equations as unknowns leave nothing that could contradict; so few more that no
  // noise can be known from them (calibration/noise.h) leave too little.
  const DistinctPoses poses = distinct_poses(fitted, rig);
  const int missing = free_parameters + kToSpare - poses.equations;
  if (missing <= 0) return std::nullopt;
  const int needed = poses.count + (missing + poses.each - 1) / poses.each;
  return Warning{
      std::string(kTooFewPoses),
      Severity::kDoubt,
      {.file = "session.csv"},
      {{"poses", static_cast<double>(poses.count)},
       {"samples", static_cast<double>(fitted.size())},
       {"parameters", static_cast<double>(free_parameters)},
       {"needed", static_cast<double>(needed)}}};
}

void add(std::vector<Warning> more, std::vector<Warning>& warnings) {
  warnings.insert(
      warnings.end(), std::make_move_iterator(more.begin()),
      std::make_move_iterator(more.end()));
}

void add_too_few_poses(
    std::vector<Warning>& warnings, std::span<const simulation::Trial> fitted,
    const geometry::Rig& rig, const std::vector<std::string>& fix,
    const std::vector<std::string>& free) {
  const auto found = too_few_poses(fitted, rig, free_parameters(*rig.robot.model, fix, free));
  if (found) warnings.push_back(*found);
}

int free_parameters(
    const geometry::RobotModel& robot, const std::vector<std::string>& fix,
    const std::vector<std::string>& free) {
  return free.empty() ? robot.parameter_count() - static_cast<int>(fix.size())
                      : static_cast<int>(free.size());
}

std::optional<std::string> why_no_reading_is_judged(const std::vector<Warning>& warnings) {
  if (std::ranges::find(warnings, kTooFewPoses, &Warning::code) != warnings.end()) {
    return "there are too few different poses";
  }
  if (forbids_commands(warnings)) return "the session contradicts itself, see above";
  return std::nullopt;
}

std::optional<std::string> settle_first(
    const session::Session& measured, const session::Session& believed) {
  const auto readings = [](const session::Session& session) {
    std::int64_t count = 0;
    for (const session::Sample& sample : session.samples) {
      if (sample.left_out) continue;
      count += std::ranges::count_if(sample.channels, [](const session::ChannelValue& each) {
        return each.value && each.quality != session::Quality::kBad;
      });
    }
    return count;
  };
  const std::int64_t all = readings(measured);
  const std::int64_t set_aside = all - readings(believed);
  if (2 * set_aside <= all) return std::nullopt;
  return fmt::format(
      "{} of {} readings are not used, as they are not plausible: settle first what the "
      "session's warnings list, more points would not help.",
      set_aside, all);
}

std::vector<Warning> implausible_lengths(
    const std::vector<ParameterRow>& parameters, const geometry::RobotModel& robot) {
  constexpr double kTimesPlausible = 10.0;  // of the change that is plausible for the kind
  constexpr double kShare = 0.15;           // of a link
  std::vector<Warning> found;
  for (const ParameterRow& row : parameters) {
    const auto index = robot.find_parameter(row.name);
    if (!index || row.unit != "mm") continue;
    const geometry::ParameterInfo& info = robot.parameters[static_cast<std::size_t>(*index)];
    if (info.range == geometry::FileRange::kAny) continue;  // no length: where the robot stands
    const double most = std::max(kTimesPlausible * info.change, kShare * std::abs(row.nominal));
    if (std::abs(row.identified - row.nominal) <= most) continue;
    found.push_back(
        {"implausible_length",
         Severity::kWrong,
         place_of(info),
         {{"name", row.name},
          {"meaning", info.meaning},
          {"value", row.identified},
          {"nominal", row.nominal}}});
  }
  return found;
}

std::vector<Warning> far_angles(
    const std::vector<ParameterRow>& parameters, const geometry::RobotModel& robot) {
  constexpr double kFar_deg = 10.0;
  std::vector<Warning> found;
  for (const ParameterRow& row : parameters) {
    const auto index = robot.find_parameter(row.name);
    if (!index || row.unit != "rad") continue;
    const geometry::ParameterInfo& info = robot.parameters[static_cast<std::size_t>(*index)];
    const double value = row.identified * geometry::kDegPerRad;
    const double nominal = row.nominal * geometry::kDegPerRad;
    if (info.stands || std::abs(value - nominal) < kFar_deg) continue;
    found.push_back(
        {"far_angle",
         Severity::kNote,
         place_of(info),
         {{"name", row.name},
          {"meaning", info.meaning},
          {"value", value},
          {"nominal", nominal}}});
  }
  return found;
}

std::optional<Warning> fits_nowhere(
    const calibration::ObservationSpace& space, const Eigen::VectorXd& x) {
  std::vector<double> left, moves;  // by sample, squares in units of sigma
  const Eigen::VectorXd change = space.scale();
  for (int i = 0; i < calibration::measured_samples(space); ++i) {
    const int rows = space.rows(i);
    const auto weight =
        space.sigma_mm.segment(space.first_row[static_cast<std::size_t>(i)], rows)
            .cwiseInverse();
    Eigen::VectorXd e(rows);
    Eigen::MatrixXd J(rows, space.parameters());
    if (space.evaluate(i, space.nominal, e, &J)) {
      moves.push_back((weight.asDiagonal() * J * change.asDiagonal()).squaredNorm());
    }
    if (space.evaluate(i, x, e, nullptr)) left.push_back(e.cwiseProduct(weight).squaredNorm());
  }
  if (left.empty() || moves.empty()) return std::nullopt;
  const double times = std::sqrt(geometry::median_of(left) / geometry::median_of(moves));
  if (!(times > 1.0)) return std::nullopt;
  return Warning{"fits_nowhere", Severity::kWrong, {.file = "session.csv"}, {{"times", times}}};
}

void judge_fitted(
    const std::vector<ParameterRow>& parameters, const geometry::RobotModel& robot,
    const calibration::ObservationSpace& space, const Eigen::VectorXd& best, bool all_free,
    std::vector<Warning>& warnings) {
  if (auto found = all_free ? fits_nowhere(space, best) : std::nullopt) {
    warnings.push_back(std::move(*found));
  }
  add(implausible_lengths(parameters, robot), warnings);
  add(far_angles(parameters, robot), warnings);
}

}  // namespace sixdial::studies
