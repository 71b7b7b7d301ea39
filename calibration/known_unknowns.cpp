#include "calibration/known_unknowns.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What the enlarged space evaluates.
struct Enlarged {
  decltype(ObservationSpace::evaluate) evaluate;
  std::vector<int> first_row;
  Index parameters = 0;
  MatrixXd columns;  // for one unit of the parameter
  VectorXd known;    // as parameters
};

bool evaluate_enlarged(
    const Enlarged& of, int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
  const Index quantities = of.columns.cols();
  const int samples = static_cast<int>(of.first_row.size()) - 1;
  if (i >= samples) {
    const Index k = i - samples;
    e[0] = of.known[k] - x[of.parameters + k];
    if (J != nullptr) {
      J->setZero();
      (*J)(0, of.parameters + k) = 1.0;
    }
    return true;
  }
  MatrixXd own;
  if (J != nullptr) own.resize(e.size(), of.parameters);
  if (!of.evaluate(i, x.head(of.parameters), e, J != nullptr ? &own : nullptr)) return false;
  const auto rows = of.columns.middleRows(of.first_row[static_cast<std::size_t>(i)], e.size());
  e -= rows * x.tail(quantities);
  if (J != nullptr) *J << own, rows;
  return true;
}

}  // namespace

double known_unit_mm(const ObservationSpace& space) { return space.mean_sigma(); }

ObservationSpace with_known(
    ObservationSpace space, const MatrixXd& columns, const VectorXd& known) {
  const Index quantities = columns.cols();
  if (quantities == 0) return space;
  const double unit_mm = known_unit_mm(space);
  const Index rows = space.rows(), samples = space.samples();
  auto enlarged = std::make_shared<Enlarged>();
  enlarged->evaluate = std::move(space.evaluate);
  enlarged->first_row = space.first_row;
  enlarged->parameters = space.parameters();
  enlarged->columns = columns / unit_mm;
  enlarged->known =
      known.size() == quantities ? VectorXd(unit_mm * known) : VectorXd::Zero(quantities);
  space.nominal.conservativeResize(enlarged->parameters + quantities);
  space.nominal.tail(quantities) = enlarged->known;
  space.joints.conservativeResize(Eigen::NoChange, samples + quantities);
  space.joints.rightCols(quantities).setZero();
  space.measured_mm.conservativeResize(rows + quantities);
  space.measured_mm.tail(quantities) = enlarged->known;
  space.sigma_mm.conservativeResize(rows + quantities);
  space.sigma_mm.tail(quantities).setConstant(unit_mm);
  if (!space.covariance_mm2.empty()) {
    space.covariance_mm2.resize(static_cast<std::size_t>(samples + quantities));
  }
  for (int k = 0; k < quantities; ++k) {
    ParameterInfo info;
    info.name = fmt::format("known{}", k);
    info.unit = "mm";
    info.change = 1.0;
    space.parameter_info.push_back(std::move(info));
    space.sample.push_back(-1);
    space.point.push_back(-1 - k);
    space.repeat.push_back(0);
    space.first_row.push_back(space.first_row.back() + 1);
    space.channel.push_back(0);
  }
  space.evaluate = [of = std::shared_ptr<const Enlarged>(std::move(enlarged))](
                       int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    return evaluate_enlarged(*of, i, x, e, J);
  };
  space.rig_mm.resize(0, 0);
  space.by_tool = nullptr;
  space.position_error = nullptr;
  space.position_axes = 0;
  space.rows_belong_together = false;
  space.kernels = nullptr;
  return space;
}

}  // namespace sixdial::calibration
