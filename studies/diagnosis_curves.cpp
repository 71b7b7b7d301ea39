#include "studies/diagnosis_curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "diagnosis/gain.h"
#include "diagnosis/thresholds.h"
#include "geometry/units.h"

namespace sixdial::studies {
namespace {

using diagnosis::Readings;
using simulation::ActiveEffect;
using simulation::ExtendedModel;
using simulation::Scene;

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

/// d(readings)/d(angle of a joint) [mm/rad].
Eigen::VectorXd angle_column(const DiagnosedReadings& data, int joint) {
  constexpr double kStep_rad = 1e-5;
  const Readings& readings = data.readings;
  const ExtendedModel model(readings.model(), data.after.effects);
  Eigen::VectorXd plus = Eigen::VectorXd::Zero(readings.count());
  Eigen::VectorXd minus = plus;
  Scene scene;
  for (std::size_t t = 0; t < readings.trials().size(); ++t) {
    for (const double sign : {1.0, -1.0}) {
      simulation::Trial trial = readings.trials()[t];
      trial.q[joint] += sign * kStep_rad;
      if (model.run(data.after.model, trial, readings.circumstances()[t], scene)) {
        readings.pick(scene, t, sign > 0 ? plus : minus);
      }
    }
  }
  return (plus - minus) / (2 * kStep_rad);
}

/// Least-squares coefficient of a column by trial; NaN where the sample says nothing of it.
Eigen::VectorXd by_trial(
    const Readings& readings, const Eigen::VectorXd& column, const Eigen::VectorXd& weight,
    const Eigen::VectorXd& value) {
  const auto n = static_cast<Eigen::Index>(readings.trials().size());
  Eigen::VectorXd result = Eigen::VectorXd::Constant(n, kNoValue);
  const double typical =
      column.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, column.size()));
  for (Eigen::Index t = 0; t < n; ++t) {
    const Eigen::Index first = readings.first_row(static_cast<std::size_t>(t));
    const Eigen::Index rows = readings.first_row(static_cast<std::size_t>(t) + 1) - first;
    const auto a = column.segment(first, rows);
    const auto w = weight.segment(first, rows);
    const double normal = w.cwiseProduct(a).dot(a);
    constexpr double kLeast = 1e-2;  // of a typical reading's
    if (!(normal > kLeast * typical)) continue;
    result[t] = w.cwiseProduct(a).dot(value.segment(first, rows)) / normal;
  }
  return result;
}

using Takes = std::function<bool(Eigen::Index)>;

/// Those that `takes` takes (all without it) and that are known, in rising order of x.
CurveGroup group_of(
    CurveGroupOf of, const Eigen::VectorXd& x, const Eigen::VectorXd& measured,
    const Eigen::VectorXd& model, const Takes& takes = {}) {
  std::vector<Eigen::Index> order;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const bool known =
        std::isfinite(x[k]) && std::isfinite(measured[k]) && std::isfinite(model[k]);
    if (known && (!takes || takes(k))) order.push_back(k);
  }
  std::ranges::stable_sort(order, [&](Eigen::Index a, Eigen::Index b) { return x[a] < x[b]; });
  CurveGroup group{.of = of};
  for (const Eigen::Index k : order) {
    group.x.push_back(x[k]);
    group.measured.push_back(measured[k]);
    group.model.push_back(model[k]);
  }
  return group;
}

void add(std::vector<CurveGroup>& groups, CurveGroup group) {
  if (!group.x.empty()) groups.push_back(std::move(group));
}

std::optional<SignatureCurve> unless_empty(SignatureCurve curve) {
  const bool empty = std::ranges::all_of(
      curve.panels, [](const CurvePanel& panel) { return panel.groups.empty(); });
  return empty ? std::nullopt : std::optional(std::move(curve));
}

/// The joint whose value is drawn along an axis; -1: none is.
int joint_of(const simulation::Place& place, CurveAxis axis) {
  if (axis == CurveAxis::kOtherJoint) return place.other_joint;
  return axis == CurveAxis::kJointAngle ? place.joint : -1;
}

/// The axis that a row's picture is drawn against.
CurveAxis axis_of(simulation::Against against) {
  switch (against) {
    case simulation::Against::kJointAngle:
      return CurveAxis::kJointAngle;
    case simulation::Against::kOtherJoint:
      return CurveAxis::kOtherJoint;
    case simulation::Against::kTime:
      return CurveAxis::kTime;
    case simulation::Against::kTemperature:
      return CurveAxis::kTemperature;
    case simulation::Against::kTravel:
      return CurveAxis::kTravel;
    case simulation::Against::kForce:
      return CurveAxis::kForce;
    case simulation::Against::kOtherCoordinate:
      return CurveAxis::kOtherCoordinate;
    case simulation::Against::kRotation:
      return CurveAxis::kFaceRotation;
    case simulation::Against::kReadingTimesRotation:
      return CurveAxis::kReadingTimesFace;
    case simulation::Against::kReading:
      return CurveAxis::kReading;
    case simulation::Against::kSimulatedReading:
      return CurveAxis::kSimulatedReading;
  }
  return CurveAxis::kSample;
}

}  // namespace

/// The row's picture of an effect, with the axis that this session has for it.
struct DiagnosisCurves::Shape {
  using Shows = simulation::Shows;
  using Groups = simulation::Groups;
  Shows shows;
  CurveAxis against;
  Groups groups;
  bool is_function;
};

DiagnosisCurves::Shape DiagnosisCurves::shape_of(const ActiveEffect& active) {
  const simulation::SignaturePlot plot = simulation::plot_at(*active.effect, active.place);
  return {plot.shows, axis_of(plot.against), plot.groups, plot.is_function};
}

DiagnosisCurves::DiagnosisCurves(const DiagnosedReadings& data) : data_(data) {
  const Readings& readings = data.readings;
  const auto n = static_cast<Eigen::Index>(readings.trials().size());
  for (Eigen::VectorXd* each :
       {&known_.time_min, &known_.temperature_degC, &known_.x_mm, &known_.y_mm, &known_.z_mm,
        &known_.face_deg, &known_.travel_deg}) {
    each->setConstant(n, kNoValue);
  }
  const ExtendedModel model(readings.model(), data.after.effects);
  Scene scene;
  for (Eigen::Index t = 0; t < n; ++t) {
    const auto& trial = readings.trials()[static_cast<std::size_t>(t)];
    const auto& sample = readings.circumstances()[static_cast<std::size_t>(t)];
    if (trial.time_s) known_.time_min[t] = sample.time_h * 60.0;
    if (trial.temperature_c) known_.temperature_degC[t] = *trial.temperature_c;
    if (sample.travel.norm() > 0.0) {
      known_.travel_deg[t] =
          std::atan2(sample.travel.y(), sample.travel.x()) * geometry::kDegPerRad;
    }
    if (!model.run(data.after.model, trial, sample, scene)) continue;
    known_.x_mm[t] = scene.p_WE.x();
    known_.y_mm[t] = scene.p_WE.y();
    if (readings.axes() == 3) known_.z_mm[t] = scene.p_WE.z();
    if (!readings.model().rig().on_cuboid()) continue;
    constexpr double kQuarter_deg = 90.0;
    const double turn = scene.gamma_rad * geometry::kDegPerRad;
    known_.face_deg[t] = turn - kQuarter_deg * std::round(turn / kQuarter_deg);
  }
}

Eigen::Index DiagnosisCurves::trial_of(Eigen::Index row) const {
  return static_cast<Eigen::Index>(data_.readings.rows()[static_cast<std::size_t>(row)].trial);
}

Eigen::VectorXd DiagnosisCurves::by_row(const Eigen::VectorXd& by_trial) const {
  Eigen::VectorXd result(data_.readings.count());
  for (Eigen::Index row = 0; row < result.size(); ++row) result[row] = by_trial[trial_of(row)];
  return result;
}

bool DiagnosisCurves::slides(int joint) const {
  const auto& joints = data_.readings.model().rig().robot.model->joints;
  return joints[static_cast<std::size_t>(joint)].kind == geometry::JointKind::kPrismatic;
}

Eigen::VectorXd DiagnosisCurves::joint_values(int joint) const {
  const auto& trials = data_.readings.trials();
  const double in_shown = slides(joint) ? 1.0 : geometry::kDegPerRad;
  Eigen::VectorXd result(std::ssize(trials));
  for (Eigen::Index t = 0; t < result.size(); ++t) {
    result[t] = trials[static_cast<std::size_t>(t)].q[joint] * in_shown;
  }
  return result;
}

Eigen::VectorXd DiagnosisCurves::force_n(int axis) const {
  const auto& samples = data_.readings.circumstances();
  Eigen::VectorXd result(std::ssize(samples));
  for (Eigen::Index t = 0; t < result.size(); ++t) {
    result[t] = samples[static_cast<std::size_t>(t)].force_n[axis];
  }
  return result;
}

Eigen::VectorXd DiagnosisCurves::on_axis(const Along& along) const {
  const auto n = std::ssize(data_.readings.trials());
  switch (along.axis) {
    case CurveAxis::kJointAngle:
    case CurveAxis::kJointSlide:
    case CurveAxis::kOtherJoint:
      return joint_values(along.joint);
    case CurveAxis::kToolX:
      return known_.x_mm;
    case CurveAxis::kToolY:
      return known_.y_mm;
    case CurveAxis::kToolZ:
      return known_.z_mm;
    case CurveAxis::kTime:
      return known_.time_min;
    case CurveAxis::kSample:
      return Eigen::VectorXd::LinSpaced(n, 0.0, static_cast<double>(n) - 1.0);
    case CurveAxis::kTemperature:
      return known_.temperature_degC;
    case CurveAxis::kTravel:
      return known_.travel_deg;
    case CurveAxis::kFaceRotation:
      return known_.face_deg;
    default:
      return Eigen::VectorXd::Constant(n, kNoValue);  // not a number of a sample
  }
}

DiagnosisCurves::Part DiagnosisCurves::part_of(std::size_t i) const {
  const Readings& readings = data_.readings;
  std::vector<ActiveEffect> others = data_.after.effects;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
  const ExtendedModel all(readings.model(), data_.after.effects);
  const ExtendedModel less(readings.model(), others);
  Part part;
  part.model =
      readings.simulate(data_.after.model, all) - readings.simulate(data_.after.model, less);
  part.measured = data_.after.residual_mm + part.model;
  return part;
}

SignatureCurve DiagnosisCurves::joint_curve(
    const ActiveEffect& effect, const Shape& shape, const Part& part) const {
  const int joint = effect.place.joint;
  const Eigen::VectorXd column = angle_column(data_, joint);
  const bool sliding = slides(joint);
  const double in_shown = sliding ? 1.0 : geometry::kDegPerRad;
  const Eigen::VectorXd& weight = data_.after.weight;
  const Eigen::VectorXd measured =
      by_trial(data_.readings, column, weight, part.measured) * in_shown;
  const Eigen::VectorXd model = by_trial(data_.readings, column, weight, part.model) * in_shown;
  SignatureCurve curve{
      .quantity = sliding ? Quantity::kJointSlideError : Quantity::kJointAngleError,
      .joint = joint,
      .along = {shape.against, joint_of(effect.place, shape.against)},
      .is_function = shape.is_function,
      .panels = {{}}};
  if (sliding && curve.along.axis == CurveAxis::kJointAngle) {
    curve.along.axis = CurveAxis::kJointSlide;
  }
  const Eigen::VectorXd x = on_axis(curve.along);
  std::vector<CurveGroup>& groups = curve.panels[0].groups;
  if (shape.groups != Shape::Groups::kJointApproach) {
    add(groups, group_of(CurveGroupOf::kSamples, x, measured, model));
    return curve;
  }
  const auto arrives = [&](int sign) {
    return [this, joint, sign](Eigen::Index t) {
      // By the column, or by the order of rows where there is none.
      const auto& came = data_.readings.circumstances()[static_cast<std::size_t>(t)].approach;
      return joint < came.size() && came[joint] * sign > 0;
    };
  };
  add(groups, group_of(CurveGroupOf::kTurningUp, x, measured, model, arrives(1)));
  add(groups, group_of(CurveGroupOf::kTurningDown, x, measured, model, arrives(-1)));
  return curve;
}

SignatureCurve DiagnosisCurves::tool_curve(const Shape& shape, const Part& part) const {
  const Eigen::MatrixXd measured =
      diagnosis::tool_shift(data_.readings, data_.after, part.measured, data_.after.weight);
  const Eigen::MatrixXd model =
      diagnosis::tool_shift(data_.readings, data_.after, part.model, data_.after.weight);
  SignatureCurve curve{
      .quantity = Quantity::kToolShift,
      .along = {.axis = shape.against},
      .is_function = shape.is_function};
  static constexpr std::array kPanels{
      CurvePanelOf::kToolX, CurvePanelOf::kToolY, CurvePanelOf::kToolZ};
  // Of x against y, of y against x, of z against x.
  static constexpr std::array kOthers{CurveAxis::kToolY, CurveAxis::kToolX, CurveAxis::kToolX};
  for (Eigen::Index axis = 0; axis < measured.rows(); ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const Eigen::VectorXd x =
        shape.against == CurveAxis::kForce             ? force_n(static_cast<int>(axis))
        : shape.against == CurveAxis::kOtherCoordinate ? on_axis({.axis = kOthers.at(k)})
                                                       : on_axis(curve.along);
    CurvePanel panel{.of = kPanels.at(k)};
    add(panel.groups, group_of(CurveGroupOf::kSamples, x, measured.row(axis), model.row(axis)));
    curve.panels.push_back(std::move(panel));
  }
  return curve;
}

std::vector<CurveGroup> DiagnosisCurves::dial_groups(
    int dial, const Shape& shape, const Eigen::VectorXd& x, const Part& part) const {
  const Readings& readings = data_.readings;
  const auto good = [this, &readings, dial](Eigen::Index row) {
    return readings.rows()[static_cast<std::size_t>(row)].dial == dial &&
           data_.after.weight[row] > diagnosis::kGoodWeight;
  };
  std::vector<CurveGroup> groups;
  if (shape.groups != Shape::Groups::kPlungerDirection) {
    add(groups, group_of(CurveGroupOf::kReadings, x, part.measured, part.model, good));
    return groups;
  }
  const auto goes = [&](double sign) {
    return [this, &readings, good, dial, sign](Eigen::Index row) {
      const auto& sample = readings.circumstances()[static_cast<std::size_t>(trial_of(row))];
      return good(row) && sample.plunger_direction[static_cast<std::size_t>(dial)] * sign > 0;
    };
  };
  add(groups, group_of(CurveGroupOf::kPlungerIn, x, part.measured, part.model, goes(1.0)));
  add(groups, group_of(CurveGroupOf::kPlungerOut, x, part.measured, part.model, goes(-1.0)));
  return groups;
}

SignatureCurve DiagnosisCurves::dial_curve(
    const ActiveEffect& effect, const Shape& shape, const Part& part) const {
  const Readings& readings = data_.readings;
  const Eigen::VectorXd x =
      shape.against == CurveAxis::kReading ? readings.measured_mm()
      : shape.against == CurveAxis::kReadingTimesFace
          ? Eigen::VectorXd(
                by_row(known_.face_deg).cwiseProduct(readings.measured_mm()) /
                geometry::kDegPerRad)
          : by_row(on_axis({.axis = shape.against}));
  SignatureCurve curve{
      .quantity = Quantity::kResidual,
      .along = {.axis = shape.against},
      .is_function = shape.is_function};
  const auto& dials = readings.model().rig().dials;
  for (int d = 0; d < static_cast<int>(dials.size()); ++d) {
    if (effect.place.dial >= 0 && d != effect.place.dial) continue;
    curve.panels.push_back(
        {.of = CurvePanelOf::kDial,
         .dial = dials[static_cast<std::size_t>(d)].id,
         .groups = dial_groups(d, shape, x, part)});
  }
  return curve;
}

std::optional<SignatureCurve> DiagnosisCurves::signature_of(std::size_t i) const {
  const ActiveEffect& effect = data_.after.effects.at(i);
  Shape shape = shape_of(effect);
  if (shape.shows == Shape::Shows::kReading && !data_.readings.has_dials()) return std::nullopt;
  // The number of a sample stands for its time where that is not known.
  if (shape.against == CurveAxis::kTime && !known_.time_min.allFinite()) {
    shape.against = CurveAxis::kSample;
  }
  const Part part = part_of(i);
  switch (shape.shows) {
    case Shape::Shows::kJointAngle:
      return unless_empty(joint_curve(effect, shape, part));
    case Shape::Shows::kToolShift:
      return unless_empty(tool_curve(shape, part));
    case Shape::Shows::kReading:
      return unless_empty(dial_curve(effect, shape, part));
  }
  return std::nullopt;
}

std::optional<SignatureCurve> DiagnosisCurves::signature_of_swap(
    const diagnosis::Hypothesis& swap) const {
  const Readings& readings = data_.readings;
  const std::array pair{swap.place.dial, swap.place.other_dial};
  SignatureCurve curve{
      .quantity = Quantity::kReading, .along = {.axis = CurveAxis::kSimulatedReading}};
  for (std::size_t k = 0; k < pair.size(); ++k) {
    const int own = pair[k];
    const auto other = static_cast<std::size_t>(pair[1 - k]);
    Eigen::VectorXd simulated = Eigen::VectorXd::Constant(readings.count(), kNoValue);
    Eigen::VectorXd as_it_came = simulated;
    for (Eigen::Index row = 0; row < readings.count(); ++row) {
      if (readings.rows()[static_cast<std::size_t>(row)].dial != own) continue;
      // The readings are set right already: what came under this name is under the other.
      const auto& trial = readings.trials()[static_cast<std::size_t>(trial_of(row))];
      simulated[row] = readings.measured_mm()[row] - data_.after.residual_mm[row];
      as_it_came[row] = trial.reading[other].value_or(kNoValue);
    }
    CurvePanel panel{
        .of = CurvePanelOf::kDial,
        .dial = readings.model().rig().dials[static_cast<std::size_t>(own)].id};
    add(panel.groups,
        group_of(CurveGroupOf::kReadings, simulated, as_it_came, readings.measured_mm()));
    curve.panels.push_back(std::move(panel));
  }
  return unless_empty(std::move(curve));
}

std::optional<SignatureCurve> DiagnosisCurves::signature_of_curve(
    const diagnosis::DialCurve& curve) const {
  const Shape shape{Shape::Shows::kReading, CurveAxis::kReading, Shape::Groups::kNone, true};
  const Part part{curve.in_readings_mm, data_.after.residual_mm + curve.in_readings_mm};
  SignatureCurve drawn{
      .quantity = Quantity::kResidual,
      .along = {.axis = CurveAxis::kReading},
      .is_function = true,
      .panels = {
          {.of = CurvePanelOf::kDial,
           .dial = data_.readings.model().rig().dials[curve.dial].id,
           .groups = dial_groups(
               static_cast<int>(curve.dial), shape, data_.readings.measured_mm(), part)}}};
  return unless_empty(std::move(drawn));
}

std::optional<SignatureCurve> DiagnosisCurves::signature_of_curve(
    const diagnosis::JointCurve& curve) const {
  const ActiveEffect there{curve.effect, curve.place, {}};
  const Part part{curve.in_readings_mm, data_.after.residual_mm + curve.in_readings_mm};
  return unless_empty(joint_curve(there, shape_of(there), part));
}

}  // namespace sixdial::studies
