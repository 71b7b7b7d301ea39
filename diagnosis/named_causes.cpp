// What a verdict says of itself.
#include <algorithm>

#include "diagnosis/naming.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

bool Finding::of_a_part() const { return left_out > kMostLeftOut; }
bool OwnCurve::of_a_part() const { return left_out > kMostLeftOut; }

std::vector<OwnCurve> NamedCauses::curves() const {
  std::vector<OwnCurve> result(dial_curves.begin(), dial_curves.end());
  result.insert(result.end(), joint_curves.begin(), joint_curves.end());
  return result;
}

Eigen::MatrixXd NamedCauses::dial_columns(Eigen::Index readings) const {
  std::vector<UnknownCandidate> of_dials = background;
  for (const DialCurve& each : dial_curves) of_dials.push_back(each.smooth);
  return random_columns(readings, of_dials);
}

Eigen::MatrixXd NamedCauses::own_columns(Eigen::Index readings) const {
  Eigen::MatrixXd result = dial_columns(readings);
  if (joints_set_right) return result;
  for (const JointCurve& each : joint_curves) {
    const Eigen::Index before = result.cols();
    result.conservativeResize(Eigen::NoChange, before + each.smooth.columns.cols());
    result.rightCols(each.smooth.columns.cols()) = each.smooth.columns;
  }
  return result;
}

std::vector<std::string> NamedCauses::depends_on() const {
  std::vector<std::string> result;
  for (const auto* list : {&unknown, &unknown_rivals}) {
    for (const UnknownCandidate& each : *list) {
      for (const std::string& covariate : each.covariates) {
        if (std::find(result.begin(), result.end(), covariate) == result.end()) {
          result.push_back(covariate);
        }
      }
    }
  }
  return result;
}

}  // namespace sixdial::diagnosis
