#include "calibration/comparison.h"

#include <algorithm>
#include <chrono>

namespace sixdial::calibration {
namespace {

using geometry::ParameterVector;

constexpr int kLeastToLearn = 5;  // samples a residual model needs

double seconds_since(std::chrono::steady_clock::time_point began) {
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began;
  return passed.count();
}

Eigen::Matrix2Xd corrected(
    const PositionObservations& set, const ParameterVector& v,
    const TrainedResidual& residual) {
  Eigen::Matrix2Xd errors = position_residuals(set, v);
  if (!residual.correction) return errors;
  for (int i = 0; i < set.size(); ++i) errors.col(i) -= residual.correction(set.q_rad.col(i));
  return errors;
}

Trouble cancelled() { return {Trouble::Kind::kCancelled, "the comparison was cancelled"}; }

/// Learns from the samples that the parameters can reach.
tl::expected<TrainedResidual, Trouble> learn(
    const MethodChoice& choice, const PositionObservations& g1, const ParameterVector& v,
    const ResidualSettings& settings, const std::stop_token& stop) {
  const Eigen::Matrix2Xd left = position_residuals(g1, v);
  std::vector<Eigen::Index> reached;
  for (Eigen::Index i = 0; i < left.cols(); ++i) {
    if (left.col(i).allFinite()) reached.push_back(i);
  }
  if (std::ssize(reached) < kLeastToLearn) {
    return tl::unexpected(Trouble{
        Trouble::Kind::kTooFewSamples,
        choice.id + ": " + std::to_string(reached.size()) +
            " samples of G1 are too few to learn from; at least " +
            std::to_string(kLeastToLearn) +
            " are needed (measure more, or leave the method out)"});
  }
  return train_residual(
      *choice.residual, g1.q_rad(Eigen::all, reached).transpose(),
      left(Eigen::all, reached).transpose(), settings, stop);
}

}  // namespace

tl::expected<MethodChoice, UnknownMethod> method_choice(std::string_view id) {
  MethodChoice choice{std::string(id), nullptr, nullptr};
  if (id == "before") return choice;
  const std::size_t plus = id.find('+');
  const std::string_view first = id.substr(0, plus);
  choice.identifier = find_identifier(first);
  if (choice.identifier == nullptr) {
    UnknownMethod unknown{std::string(first), {"before"}};
    for (const Identifier* each : all_identifiers()) unknown.known.push_back(each->name);
    return tl::unexpected(std::move(unknown));
  }
  if (plus == std::string_view::npos) return choice;
  const std::string_view second = id.substr(plus + 1);
  choice.residual = find_residual_model(second);
  if (choice.residual == nullptr) {
    UnknownMethod unknown{std::string(second), {}};
    for (const ResidualModel* each : all_residual_models()) unknown.known.push_back(each->name);
    return tl::unexpected(std::move(unknown));
  }
  return choice;
}

tl::expected<Comparison, Trouble> compare_methods(
    const ObservationSpace& space, const PositionObservations& g1,
    const PositionObservations& g2, const ParameterVector& nominal,
    const std::vector<MethodChoice>& methods, const ComparisonSettings& settings,
    const std::function<void(const ComparisonProgress&)>& progress,
    const std::stop_token& stop) {
  if (auto trouble = trouble_with(g1, nominal)) return tl::unexpected(*std::move(trouble));
  const auto began = std::chrono::steady_clock::now();
  Comparison result;
  result.before_uses_targets = all_have_targets(g1) && all_have_targets(g2);
  double done = 0.0;  // methods
  const auto tell = [&](const std::string& stage, const QpsoProgress& search) {
    if (!progress) return;
    // A search is most of its method's time; its restart for QPSO-2 only looks like a step
    // back.
    const double part =
        search.iterations > 0 ? 0.9 * search.iteration / search.iterations : 0.0;
    progress(
        {stage, (done + part) / static_cast<double>(methods.size()), search.iteration,
         search.iterations, search.best});
  };
  const auto robot_of = [&](const Identifier& identifier) -> std::size_t {
    const auto known =
        std::ranges::find(result.robots, &identifier, &IdentifiedRobot::identifier);
    if (known != result.robots.end()) {
      return static_cast<std::size_t>(known - result.robots.begin());
    }
    const auto start = std::chrono::steady_clock::now();
    Identified found = identify(
        identifier, space, settings.identify,
        [&](const QpsoProgress& search) { tell(std::string(identifier.name), search); }, stop);
    result.robots.push_back({&identifier, std::move(found), seconds_since(start)});
    return result.robots.size() - 1;
  };
  for (const MethodChoice& choice : methods) {
    if (stop.stop_requested()) return tl::unexpected(cancelled());
    tell(choice.id, {});
    ComparedMethod method;
    method.choice = choice;
    if (choice.identifier == nullptr) {
      method.errors = method_errors(
          choice.id, errors_before(g1, nominal, result.before_uses_targets),
          errors_before(g2, nominal, result.before_uses_targets));
    } else {
      method.robot = robot_of(*choice.identifier);
      if (stop.stop_requested()) return tl::unexpected(cancelled());
      const IdentifiedRobot& robot = result.robots[*method.robot];
      const ParameterVector v = robot.found.x.head<geometry::kParameterCount>();
      method.identify_seconds = robot.seconds;
      if (choice.residual != nullptr) {
        tell(choice.id, {});
        const auto start = std::chrono::steady_clock::now();
        auto learned = learn(choice, g1, v, settings.residual, stop);
        if (stop.stop_requested()) return tl::unexpected(cancelled());
        if (!learned) return tl::unexpected(learned.error());
        method.residual = *std::move(learned);
        method.residual_seconds = seconds_since(start);
      }
      method.errors = method_errors(
          choice.id, corrected(g1, v, method.residual), corrected(g2, v, method.residual));
    }
    result.methods.push_back(std::move(method));
    ++done;
  }
  if (progress) progress({"report", 1.0, 0, 0, 0.0});
  result.seconds = seconds_since(began);
  return result;
}

}  // namespace sixdial::calibration
