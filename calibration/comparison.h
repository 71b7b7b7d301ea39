// Every method of the paper and its rivals on one session: an identifier finds the parameters
// in either space, a residual model learns from the angles what they leave over, and both are
// judged by positions on G1 and on G2, which nobody fitted: Table 6.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "calibration/identifier.h"
#include "calibration/pipeline.h"
#include "calibration/residual_model.h"

namespace sixdial::calibration {

/// "ekf_dqpso+anfis". Both null: "before", the robot as it is commanded.
struct MethodChoice {
  std::string id;
  const Identifier* identifier = nullptr;
  const ResidualModel* residual = nullptr;  // null: none
};

/// The part of a method's id that is neither an identifier nor a residual model, and the names
/// that could stand there.
struct UnknownMethod {
  std::string word;
  std::vector<std::string_view> known;
};
/// Any identifier, alone or with any residual model after a '+'; or "before".
[[nodiscard]] tl::expected<MethodChoice, UnknownMethod> method_choice(std::string_view id);

/// What a comparison holds unless it is told otherwise.
inline constexpr std::array<std::string_view, 12> kComparedMethods{
    "before",    "lse",      "lm",       "tikhonov", "ekf",    "ekf_qpso1",
    "ekf_dqpso", "lse+bpnn", "ekf+bpnn", "lm+gp",    "lm+rbf", "ekf_dqpso+anfis"};

struct ComparisonSettings {
  IdentifySettings identify;
  ResidualSettings residual;
};

struct ComparisonProgress {
  std::string stage;      // "ekf_dqpso", "lse+bpnn"
  double fraction = 0.0;  // of the whole comparison
  int iteration = 0;      // of a search; 0 of 0: not a search
  int iterations = 0;
  double best_mm = 0.0;  // 0: none yet
};

/// One identifier's answer, used by every method that begins with it.
struct IdentifiedRobot {
  const Identifier* identifier = nullptr;
  Identified found;
  double seconds = 0.0;
};

struct ComparedMethod {
  MethodChoice choice;
  MethodErrors errors;
  std::optional<std::size_t> robot;  // index into Comparison::robots; none: before
  double identify_seconds = 0.0;
  double residual_seconds = 0.0;
  TrainedResidual residual;  // empty functions without a residual model
};

struct Comparison {
  std::vector<IdentifiedRobot> robots;
  std::vector<ComparedMethod> methods;  // in the order asked for
  bool before_uses_targets = false;
  double seconds = 0.0;
};

/// `space`: of G1, what identifiers fit. `g1` and `g2`: position spaces, where errors are
/// judged and residual models learn (g1 only); their parameters are those of `space`, or some
/// of them, by name. Cancelled: Trouble::kCancelled.
[[nodiscard]] tl::expected<Comparison, Trouble> compare_methods(
    const ObservationSpace& space, const ObservationSpace& g1, const ObservationSpace& g2,
    const std::vector<MethodChoice>& methods, const ComparisonSettings& settings = {},
    const std::function<void(const ComparisonProgress&)>& progress = {},
    const std::stop_token& stop = {});

/// Picks from x, a parameter vector of `space`, the parameters that `wanted` has, by name.
/// Throws std::invalid_argument for a name that `space` does not have.
[[nodiscard]] Eigen::VectorXd parameters_in(
    const ObservationSpace& wanted, const ObservationSpace& space, const Eigen::VectorXd& x);

}  // namespace sixdial::calibration
