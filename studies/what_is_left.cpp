// What a diagnosis leaves over, along each quantity and at each place.
#include <cmath>

#include "diagnosis/gain.h"
#include "studies/diagnosis_curves.h"
#include "studies/left_along.h"

namespace sixdial::studies {

std::vector<LeftAlong> DiagnosisCurves::left_along() const {
  const diagnosis::Readings& readings = data_.readings;
  LeftSorter sorter(data_);
  const auto joints = static_cast<int>(readings.trials().front().q.size());
  for (int joint = 0; joint < joints; ++joint) {
    const CurveAxis axis = slides(joint) ? CurveAxis::kJointSlide : CurveAxis::kJointAngle;
    sorter.by_number({axis, joint}, by_row(joint_values(joint)));
  }
  for (const CurveAxis axis :
       {CurveAxis::kToolX, CurveAxis::kToolY, CurveAxis::kToolZ, CurveAxis::kTime,
        CurveAxis::kTemperature}) {
    sorter.by_number({.axis = axis}, by_row(on_axis({.axis = axis})));
  }
  if (readings.has_dials())
    sorter.by_number({.axis = CurveAxis::kAnyReading}, readings.measured_mm());
  constexpr int kFewJoints = 3;  // of more there are too many combinations
  if (joints <= kFewJoints) sorter.by_arrival();
  if (readings.has_dials()) {
    sorter.by_plunger_travel();
    sorter.by_dial();
  }
  return sorter.take();
}

ToolShifts DiagnosisCurves::tool_shifts() const {
  // One model for both: the difference is in the residuals.
  const Eigen::MatrixXd before = diagnosis::tool_shift(
      data_.readings, data_.after, data_.before.residual_mm, data_.before.weight);
  const Eigen::MatrixXd after =
      diagnosis::tool_shift(data_.readings, data_.after, data_.left_mm, data_.after.weight);
  ToolShifts shifts;
  if (before.rows() == 3) shifts.z_mm.emplace();
  for (Eigen::Index t = 0; t < before.cols(); ++t) {
    if (!std::isfinite(known_.x_mm[t]) || !before.col(t).allFinite() ||
        !after.col(t).allFinite()) {
      continue;
    }
    shifts.sample.push_back(data_.readings.trials()[static_cast<std::size_t>(t)].sample);
    shifts.x_mm.push_back(known_.x_mm[t]);
    shifts.y_mm.push_back(known_.y_mm[t]);
    if (shifts.z_mm) shifts.z_mm->push_back(known_.z_mm[t]);
    shifts.before_mm.emplace_back(before.col(t));
    shifts.after_mm.emplace_back(after.col(t));
  }
  return shifts;
}

}  // namespace sixdial::studies
