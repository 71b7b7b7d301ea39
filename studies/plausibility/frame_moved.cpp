// An instrument, its target or the robot's base that was moved while positions were measured:
// from one row on all of them are shifted. Held against a linear fit of all the robot's
// parameters, where they fit best, so that links which are a millimetre off are no shift.
#include <fmt/format.h>

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <optional>

#include "geometry/tool.h"
#include "studies/plausibility/check.h"
#include "studies/plausibility/tool_seen.h"

namespace sixdial::studies::plausibility {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kFewestRows = 8;  // on either side
constexpr double kClearly = 4.0;  // so many times less is left by two frames than by one
constexpr double kLeast_mm = 0.05;
constexpr int kSteps = 3;  // from nominal to where the robot fits

/// Rows of a linear fit from parameters v: axes x samples equations.
struct LinearPositions {
  std::vector<std::size_t> row;  // of the session
  MatrixXd A;                    // equations x parameters
  Eigen::VectorXd b;             // measured less computed
  Index axes = 0;
};

std::optional<LinearPositions> linear_of(
    const session::Session& session, const MeasuredTool& measured, const Eigen::VectorXd& v) {
  const geometry::Rig& rig = session.rig;
  const geometry::Tool tool(rig);
  LinearPositions all;
  all.axes = tool.axes();
  const auto most = static_cast<Index>(measured.row.size()) * tool.axes();
  all.A.resize(most, rig.robot.nominal.size());
  all.b.resize(most);
  Index equation = 0;
  for (std::size_t i = 0; i < measured.row.size(); ++i) {
    const session::Sample& sample = session.samples[measured.row[i]];
    const auto assembly = assembly_by_target(rig, sample).value_or(rig.robot.assembly);
    const auto at = tool.derivative(v, sample.q, assembly);
    if (!at) continue;
    all.A.middleRows(equation, tool.axes()) = at->J_v;
    all.b.segment(equation, tool.axes()) = measured.p_mm.col(static_cast<Index>(i)) - at->p_WE;
    all.row.push_back(measured.row[i]);
    equation += tool.axes();
  }
  all.A.conservativeResize(equation, Eigen::NoChange);
  all.b.conservativeResize(equation);
  if (equation < 2 * kFewestRows * all.axes + all.A.cols()) return std::nullopt;
  return all;
}

}  // namespace

void look_for_moved_frame(Look& look) {
  if (!is_clean(look.found)) return;  // told already why positions do not fit
  const MeasuredTool measured = measured_tool(look.used);
  if (measured.by_dials) return;
  Eigen::VectorXd v = look.used.rig.robot.nominal;
  auto all = linear_of(look.used, measured, v);
  for (int step = 0; step < kSteps && all; ++step) {
    v += Eigen::CompleteOrthogonalDecomposition<MatrixXd>(all->A).solve(all->b);
    all = linear_of(look.used, measured, v);
  }
  if (!all) return;
  const Index n = std::ssize(all->row);
  // What no parameter explains: of what was measured, and of a shift from some row on.
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(all->A);
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(all->A.rows(), qr.rank());
  const Eigen::VectorXd left = all->b - Q * (Q.transpose() * all->b);
  const double before = left.squaredNorm();
  double least = before;
  Index begin = 0;
  Eigen::VectorXd shift;
  MatrixXd step = MatrixXd::Zero(all->b.size(), all->axes);
  for (Index i = n - 1; i >= kFewestRows; --i) {
    step.middleRows(i * all->axes, all->axes).setIdentity();
    if (n - i < kFewestRows) continue;
    const MatrixXd own = step - Q * (Q.transpose() * step);
    const Eigen::VectorXd by = own.colPivHouseholderQr().solve(left);
    const double after = (left - own * by).squaredNorm();
    if (after >= least) continue;
    least = after;
    begin = i;
    shift = by;
  }
  if (begin == 0 || shift.norm() < kLeast_mm || kClearly * kClearly * least > before) return;
  const std::size_t row = all->row[static_cast<std::size_t>(begin)];
  std::string by;
  for (Index axis = 0; axis < shift.size(); ++axis) {
    by += fmt::format("{}{:.2f}", axis == 0 ? "(" : ", ", shift[axis]);
  }
  look.tell(
      "frame_moved", Severity::kDoubt, look.rows(std::array{row}),
      {{"shift", by + ") mm"}, {"samples", static_cast<double>(n)}});
}

}  // namespace sixdial::studies::plausibility
