#include "calibration/comparison.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "calibration/reading_space.h"

namespace sixdial::calibration {
namespace {

constexpr int kLeastToLearn = 5;  // samples a residual model needs

double seconds_since(std::chrono::steady_clock::time_point began) {
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began;
  return passed.count();
}

Eigen::MatrixXd corrected(
    const ObservationSpace& set, const Eigen::VectorXd& v, const TrainedResidual& residual) {
  Eigen::MatrixXd errors = position_errors(set, v);
  if (!residual.correction) return errors;
  for (Eigen::Index i = 0; i < errors.cols(); ++i) {
    errors.col(i) -= residual.correction(set.joints.col(i));
  }
  return errors;
}

Trouble cancelled() { return {Trouble::Kind::kCancelled, "the comparison was cancelled"}; }

/// Learns from the samples that the parameters can reach.
tl::expected<TrainedResidual, Trouble> learn(
    const MethodChoice& choice, const ObservationSpace& g1, const Eigen::VectorXd& v,
    ResidualSettings settings, const std::stop_token& stop) {
  const Eigen::MatrixXd left = position_errors(g1, v);
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
  if (settings.output_names.empty() && shows_position(g1)) {
    for (int axis = 0; axis < g1.position_axes; ++axis) {
      settings.output_names.push_back(g1.channel_info[static_cast<std::size_t>(axis)].name);
    }
  }
  try {
    return train_residual(
        *choice.residual, g1.joints(Eigen::all, reached).transpose(),
        left(Eigen::all, reached).transpose(), settings, stop);
  } catch (const std::invalid_argument& error) {
    return tl::unexpected(
        Trouble{Trouble::Kind::kNotPossible, choice.id + ": " + error.what()});
  }
}

/// A comparison in progress: each identifier's robot is found once and used by every method
/// that begins with it.
class Run {
 public:
  Run(const ObservationSpace& space, const ObservationSpace& g1, const ObservationSpace& g2,
      std::size_t methods, const ComparisonSettings& settings,
      const std::function<void(const ComparisonProgress&)>& progress,
      const std::stop_token& stop)
      : space_(space),
        g1_(g1),
        g2_(g2),
        total_(static_cast<double>(methods)),
        settings_(settings),
        progress_(progress),
        stop_(stop) {
    result_.before_uses_targets = all_have_targets(g1) && all_have_targets(g2);
  }

  /// Why it could not be done, or nothing.
  std::optional<Trouble> add(const MethodChoice& choice);
  [[nodiscard]] Comparison take() {
    if (progress_) progress_({"report", 1.0, 0, 0, 0.0});
    result_.seconds = seconds_since(began_);
    return std::move(result_);
  }

 private:
  void tell(const std::string& stage, const QpsoProgress& search) const;
  /// Index into result_.robots.
  [[nodiscard]] std::size_t robot_of(const Identifier& identifier);
  std::optional<Trouble> identify_and_learn(const MethodChoice& choice, ComparedMethod& method);

  const ObservationSpace& space_;
  const ObservationSpace& g1_;
  const ObservationSpace& g2_;
  double total_;
  const ComparisonSettings& settings_;
  const std::function<void(const ComparisonProgress&)>& progress_;
  const std::stop_token& stop_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  Comparison result_;
};

void Run::tell(const std::string& stage, const QpsoProgress& search) const {
  if (!progress_) return;
  // A search is most of its method's time; its restart for QPSO-2 only looks like a step back.
  const double part = search.iterations > 0 ? 0.9 * search.iteration / search.iterations : 0.0;
  const auto done = static_cast<double>(result_.methods.size());
  progress_({stage, (done + part) / total_, search.iteration, search.iterations, search.best});
}

std::size_t Run::robot_of(const Identifier& identifier) {
  const auto known =
      std::ranges::find(result_.robots, &identifier, &IdentifiedRobot::identifier);
  if (known != result_.robots.end()) {
    return static_cast<std::size_t>(known - result_.robots.begin());
  }
  const auto start = std::chrono::steady_clock::now();
  Identified found = identify(
      identifier, space_, settings_.identify,
      [&](const QpsoProgress& search) { tell(std::string(identifier.name), search); }, stop_);
  result_.robots.push_back({&identifier, std::move(found), seconds_since(start)});
  return result_.robots.size() - 1;
}

std::optional<Trouble> Run::identify_and_learn(
    const MethodChoice& choice, ComparedMethod& method) {
  method.robot = robot_of(*choice.identifier);
  if (stop_.stop_requested()) return cancelled();
  const IdentifiedRobot& robot = result_.robots[*method.robot];
  const Eigen::VectorXd v = parameters_in(g1_, space_, robot.found.x);
  method.identify_seconds = robot.seconds;
  if (choice.residual != nullptr) {
    tell(choice.id, {});
    const auto start = std::chrono::steady_clock::now();
    auto learned = learn(choice, g1_, v, settings_.residual, stop_);
    if (stop_.stop_requested()) return cancelled();
    if (!learned) return learned.error();
    method.residual = *std::move(learned);
    method.residual_seconds = seconds_since(start);
  }
  method.errors = method_errors(
      choice.id, corrected(g1_, v, method.residual), corrected(g2_, v, method.residual));
  return std::nullopt;
}

std::optional<Trouble> Run::add(const MethodChoice& choice) {
  if (stop_.stop_requested()) return cancelled();
  tell(choice.id, {});
  ComparedMethod method;
  method.choice = choice;
  if (choice.identifier == nullptr) {
    method.errors = method_errors(
        choice.id, errors_before(g1_, result_.before_uses_targets),
        errors_before(g2_, result_.before_uses_targets));
  } else if (auto trouble = identify_and_learn(choice, method)) {
    return trouble;
  }
  result_.methods.push_back(std::move(method));
  return std::nullopt;
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

Eigen::VectorXd parameters_in(
    const ObservationSpace& wanted, const ObservationSpace& space, const Eigen::VectorXd& x) {
  Eigen::VectorXd result(wanted.parameters());
  for (int i = 0; i < wanted.parameters(); ++i) {
    const std::string& name = wanted.parameter_info[static_cast<std::size_t>(i)].name;
    const auto index = space.find(name);
    if (!index) throw std::invalid_argument("the space has no parameter '" + name + "'");
    result[i] = x[*index];
  }
  return result;
}

tl::expected<Comparison, Trouble> compare_methods(
    const ObservationSpace& space, const ObservationSpace& g1, const ObservationSpace& g2,
    const std::vector<MethodChoice>& methods, const ComparisonSettings& settings,
    const std::function<void(const ComparisonProgress&)>& progress,
    const std::stop_token& stop) {
  // Raw readings can be fitted where they allow no position; then none is judged.
  const bool judged = g1.samples() > 0 || space.samples() == 0 || space.name == g1.name;
  if (judged) {
    if (auto trouble = trouble_with(g1)) return tl::unexpected(*std::move(trouble));
  }
  Run run(space, g1, g2, methods.size(), settings, progress, stop);
  for (const MethodChoice& choice : methods) {
    if (auto trouble = run.add(choice)) return tl::unexpected(*std::move(trouble));
  }
  return run.take();
}

}  // namespace sixdial::calibration
