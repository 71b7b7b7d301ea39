// The curves behind a diagnosis, ready to be drawn long after: what each sample says of a cause
// if the model leaves it out, beside the fitted cause; and what is left by covariate, before
// and after.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "diagnosis/naming.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

/// The fits of a verdict on the readings as they were explained.
struct DiagnosedReadings {
  const diagnosis::Readings& readings;  // exchanged dials set right
  const diagnosis::JointFit& before;    // robot alone
  const diagnosis::JointFit& after;     // with the causes
  Eigen::VectorXd left_mm;              // robot and named causes alone
  bool has_unknown = false;             // after.residual_mm is less something smooth
};

/// Computes once what all curves need. `data` must outlive this object.
class DiagnosisCurves {
 public:
  explicit DiagnosisCurves(const DiagnosedReadings& data);

  /// Of after.effects[i]: a joint's effect as an error of its angle, the robot's as a shift of
  /// the tool, a dial's as its residual. Empty where nothing can be drawn.
  [[nodiscard]] std::optional<SignatureCurve> signature_of(std::size_t i) const;
  /// Of exchanged dials: readings as they came against what the simulation says.
  [[nodiscard]] std::optional<SignatureCurve> signature_of_swap(
      const diagnosis::Hypothesis& swap) const;
  /// Of a dial's own curve over its reading.
  [[nodiscard]] std::optional<SignatureCurve> signature_of_curve(
      const diagnosis::DialCurve& curve) const;
  /// Of a joint's own curve over its value.
  [[nodiscard]] std::optional<SignatureCurve> signature_of_curve(
      const diagnosis::JointCurve& curve) const;
  /// Along each number in ten classes of equally many readings, and by kind of arrival, travel
  /// and dial; those only that vary.
  [[nodiscard]] std::vector<LeftAlong> left_along() const;
  [[nodiscard]] ToolShifts tool_shifts() const;

 private:
  /// What each sample knows, by trial; NaN where it does not.
  struct Known {
    Eigen::VectorXd time_min, temperature_degC;
    Eigen::VectorXd x_mm, y_mm, z_mm, face_deg, travel_deg;
  };
  /// What the fitted cause does to each reading, and what the readings say of it.
  struct Part {
    Eigen::VectorXd model, measured;
  };
  struct Shape;

  [[nodiscard]] static Shape shape_of(const simulation::ActiveEffect& effect);
  [[nodiscard]] Part part_of(std::size_t i) const;
  [[nodiscard]] Eigen::Index trial_of(Eigen::Index row) const;
  [[nodiscard]] Eigen::VectorXd by_row(const Eigen::VectorXd& by_trial) const;
  [[nodiscard]] bool slides(int joint) const;
  /// Its value by trial [deg]; of a sliding joint [mm].
  [[nodiscard]] Eigen::VectorXd joint_values(int joint) const;
  [[nodiscard]] Eigen::VectorXd force_n(int axis) const;
  /// The number of each sample on an axis.
  [[nodiscard]] Eigen::VectorXd on_axis(const Along& along) const;
  [[nodiscard]] SignatureCurve joint_curve(
      const simulation::ActiveEffect& effect, const Shape& shape, const Part& part) const;
  [[nodiscard]] SignatureCurve tool_curve(const Shape& shape, const Part& part) const;
  [[nodiscard]] SignatureCurve dial_curve(
      const simulation::ActiveEffect& effect, const Shape& shape, const Part& part) const;
  [[nodiscard]] std::vector<CurveGroup> dial_groups(
      int dial, const Shape& shape, const Eigen::VectorXd& x, const Part& part) const;

  const DiagnosedReadings& data_;
  Known known_;
};

}  // namespace sixdial::studies
