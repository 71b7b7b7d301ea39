#include "diagnosis/joint_curve.h"

#include <algorithm>
#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/own_curve.h"

namespace sixdial::diagnosis {
namespace {

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
  std::vector<JointCurve> curves = search.curves();
  // What may as well be nothing stays a smooth function without a name.
  std::erase_if(curves, [](const JointCurve& each) { return !is_for_sure(each); });
  return curves;
}

}  // namespace sixdial::diagnosis
