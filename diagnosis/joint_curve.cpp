#include "diagnosis/joint_curve.h"

#include <algorithm>
#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/own_curve.h"
#include "diagnosis/stages.h"
#include "simulation/smooth_function.h"

namespace sixdial::diagnosis {
namespace {

/// A part of a curve as these readings see it.
Eigen::MatrixXd columns_of(
    const Readings& readings, const Eigen::MatrixXd& stage, const UnknownCandidate& part,
    int joint) {
  Eigen::MatrixXd columns(readings.count(), part.kernel.size.size());
  for (Eigen::Index row = 0; row < columns.rows(); ++row) {
    const auto trial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].trial);
    columns.row(row) =
        stage(row, 0) *
        kernel_values(part.kernel, readings.trials()[trial].q[joint]).transpose();
  }
  return columns;
}

simulation::ActiveEffect effect_of(
    const JointCurve& curve, const Kernel& kernel, const Eigen::VectorXd& u) {
  const int most = *std::ranges::max_element(kernel.functions);
  std::vector<double> x(simulation::kSmoothHead + static_cast<std::size_t>(most) + 1, 0.0);
  x[0] = kernel.low;
  x[1] = kernel.high;
  x[2] = kernel.half_width;
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    const int j = kernel.functions[static_cast<std::size_t>(k)];
    x[simulation::kSmoothHead + static_cast<std::size_t>(j)] = kernel.size[k] * u[k];
  }
  return {simulation::curve_of_joints(), curve.place, std::move(x)};
}

/// The joints' curves of an explanation, one after the other until none shows.
class CurvesFirst {
 public:
  CurvesFirst(const Readings& readings, const NamingSettings& settings)
      : readings_(readings), settings_(settings) {
    found_.fit = fit_baseline(readings);
  }

  /// False where only a few joints err: their names are looked for one by one.
  [[nodiscard]] bool run() {
    constexpr std::size_t kMany = 3;
    while (take_best()) {
    }
    if (found_.unknown.size() < kMany) return false;
    // Each again beside all others: the first were sized when the noise seemed larger.
    for (std::size_t i = 0; i < found_.unknown.size(); ++i) size_again(i);
    return true;
  }

  [[nodiscard]] std::vector<JointCurve> curves() const {
    std::vector<JointCurve> result;
    for (const simulation::Place& place : simulation::at_each_joint(readings_.model().rig())) {
      for (std::size_t i = 0; i < found_.unknown.size(); ++i) {
        if (found_.unknown[i].enters != place.name) continue;
        JointCurve curve = curve_of_joint(readings_, found_, place, {i});
        curve.evidence = found_.unknown[i].evidence;
        curve.own_evidence = curve.evidence;
        curve.settled = found_.fit.converged;
        curve.left_out = found_.fit.left_out();
        hold_against_sham(readings_, without(i), settings_, curve);
        result.push_back(std::move(curve));
      }
    }
    return result;
  }

 private:
  bool take_best() {
    std::vector<UnknownCandidate> all = score_joint_curves(readings_, found_.fit);
    std::erase_if(all, [&](const UnknownCandidate& each) {
      return each.kernel.functions.empty() ||
             std::ranges::any_of(found_.unknown, [&](const UnknownCandidate& known) {
               return known.enters == each.enters;
             });
    });
    const auto best = std::ranges::max_element(all, {}, &UnknownCandidate::evidence);
    if (best == all.end() || best->evidence < settings_.beside_unknown_log_odds) return false;
    found_.unknown.push_back(std::move(*best));
    fit_again();
    return true;
  }

  void fit_again() {
    found_.fit = fit_jointly(
        readings_, found_.fit.model, {}, &found_.fit,
        random_columns(readings_.count(), found_.unknown));
  }

  [[nodiscard]] JointFit without(std::size_t i) const {
    std::vector<UnknownCandidate> others = found_.unknown;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    return fit_jointly(
        readings_, found_.fit.model, {}, &found_.fit,
        random_columns(readings_.count(), others));
  }

  [[nodiscard]] std::size_t joint_of(const UnknownCandidate& curve) const {
    const auto places = simulation::at_each_joint(readings_.model().rig());
    const auto at = std::ranges::find(places, curve.enters, &simulation::Place::name);
    return static_cast<std::size_t>(at - places.begin());
  }

  void size_again(std::size_t i) {
    std::vector<UnknownCandidate> all = score_joint_curves(readings_, without(i));
    found_.unknown[i] = std::move(all[joint_of(found_.unknown[i])]);
    fit_again();
  }

  const Readings& readings_;
  const NamingSettings& settings_;
  Explanation found_;
};

}  // namespace

std::vector<JointCurve> find_joint_curves(
    const Readings& readings, const NamingSettings& settings) {
  if (readings.axes() < 3) return {};
  CurvesFirst search(readings, settings);
  if (!search.run()) return {};
  return search.curves();
}

JointFit with_joint_curves(
    const Readings& readings, const JointFit& from, const std::vector<JointCurve>& curves,
    const Eigen::MatrixXd& random) {
  if (curves.empty()) return from;
  const simulation::ExtendedModel extended(readings.model(), from.effects);
  const Eigen::VectorXd simulated = readings.simulate(from.model, extended);
  Eigen::MatrixXd columns = random;
  columns.conservativeResize(readings.count(), Eigen::NoChange);
  for (const JointCurve& curve : curves) {
    const Eigen::MatrixXd stage = stage_columns(
        readings, from.model, extended, simulated, Stage::kJointAngle, curve.place.joint);
    for (const UnknownCandidate& part : curve.parts) {
      const Eigen::Index before = columns.cols();
      columns.conservativeResize(Eigen::NoChange, before + part.kernel.size.size());
      columns.rightCols(part.kernel.size.size()) =
          columns_of(readings, stage, part, curve.place.joint);
    }
  }
  const JointFit free = fit_jointly(readings, from.model, from.effects, &from, columns);
  std::vector<simulation::ActiveEffect> effects = free.effects;
  Eigen::Index first = free.known + random.cols();
  for (const JointCurve& curve : curves) {
    for (const UnknownCandidate& part : curve.parts) {
      const Eigen::Index own = part.kernel.size.size();
      effects.push_back(effect_of(curve, part.kernel, free.u.segment(first, own)));
      first += own;
    }
  }
  return fit_jointly(readings, free.model, std::move(effects), &free, random);
}

}  // namespace sixdial::diagnosis
