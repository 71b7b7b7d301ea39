#include "calibration/rig_spaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "calibration/five_bar/spaces.h"
#include "calibration/rig_errors.h"
#include "geometry/tool.h"
#include "simulation/forward_model.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using simulation::Trial;
using Trials = std::span<const Trial>;

constexpr int kGammaIterations = 20;
constexpr double kGammaSettled_rad = 1e-13;

/// Kinds of robot with spaces of their own, which say the same in less time.
struct OwnSpaces {
  const geometry::RobotKind* kind;
  int axes;  // of the positions
  ObservationSpace (*positions)(Trials trials, const geometry::Rig& rig, double noise_mm);
  ObservationSpace (*dials)(Trials trials, const geometry::Rig& rig);
};
constexpr std::array kOwnSpaces{
    OwnSpaces{&geometry::five_bar, 2, five_bar_position_space, five_bar_dial_space}};

const OwnSpaces* own_spaces(const geometry::Rig& rig) {
  const auto* const found =
      std::ranges::find(kOwnSpaces, rig.robot.model->kind, &OwnSpaces::kind);
  return found == kOwnSpaces.end() ? nullptr : found;
}

MatrixXd matrix_of(const std::vector<VectorXd>& columns, Eigen::Index rows) {
  MatrixXd result(rows, std::ssize(columns));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    result.col(static_cast<Eigen::Index>(i)) = columns[i];
  }
  return result;
}

VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const VectorXd>(values.data(), std::ssize(values));
}

/// Names of parameters, joints and what the robot's kind has words for; no samples yet.
ObservationSpace without_samples(const geometry::Rig& rig) {
  const geometry::RobotModel& robot = *rig.robot.model;
  ObservationSpace space;
  space.parameter_info = robot.parameters;
  space.nominal = rig.robot.nominal;
  space.named_directions = robot.named_directions;
  for (const geometry::JointInfo& joint : robot.joints) {
    space.joint_info.push_back({joint.name, std::string(joint.unit())});
  }
  return space;
}

void add_sample(const Trial& trial, int rows, ObservationSpace& space) {
  space.first_row.push_back(space.first_row.back() + rows);
  space.sample.push_back(trial.sample);
  space.point.push_back(trial.point);
  space.repeat.push_back(trial.repeat);
}

bool usable_position(const Trial& trial, const geometry::Tool& tool) {
  return trial.position_mm && trial.position_mm->size() == tool.axes() &&
         trial.q.size() == tool.robot().joint_count() && trial.position_mm->allFinite() &&
         trial.q.allFinite();
}

/// Of any robot: one call of its kind for each sample.
ObservationSpace any_position_space(Trials trials, const geometry::Rig& rig, double noise_mm) {
  const geometry::Tool tool(rig);
  const Eigen::Index axes = tool.axes();
  ObservationSpace space = without_samples(rig);
  space.name = "positions";
  for (const char* const axis : {"x", "y", "z"}) {
    if (std::ssize(space.channel_info) < axes) space.channel_info.push_back({axis, "mm"});
  }
  struct Sample {
    VectorXd q;
    geometry::Assembly assembly;
    VectorXd p_WE;
  };
  std::vector<Sample> samples;
  std::vector<VectorXd> joints;
  std::vector<VectorXd> off_target;
  std::vector<double> sigma;
  std::vector<double> measured;
  for (const Trial& trial : trials) {
    if (!usable_position(trial, tool)) continue;
    const MatrixXd C = trial.covariance_or_zero();
    for (Eigen::Index axis = 0; axis < axes; ++axis) {
      space.channel.push_back(static_cast<int>(axis));
      sigma.push_back(C(axis, axis) > 0.0 ? std::sqrt(C(axis, axis)) : noise_mm);
      measured.push_back((*trial.position_mm)[axis]);
    }
    space.covariance_mm2.push_back(C.diagonal().minCoeff() > 0.0 ? C : MatrixXd());
    if (!(C.diagonal().minCoeff() > 0.0)) space.sigma_is_assumed = true;
    add_sample(trial, static_cast<int>(axes), space);
    joints.push_back(trial.q);
    const bool aimed = trial.target_mm && trial.target_mm->size() == axes;
    off_target.push_back(
        aimed ? VectorXd(*trial.position_mm - *trial.target_mm)
              : VectorXd::Constant(axes, std::numeric_limits<double>::quiet_NaN()));
    samples.push_back({trial.q, trial.assembly, *trial.position_mm});
  }
  space.joints = matrix_of(joints, tool.robot().joint_count());
  space.sigma_mm = vector_of(sigma);
  space.measured_mm = vector_of(measured);
  space.position_axes = tool.axes();
  space.off_target_mm = matrix_of(off_target, axes);
  space.rows_belong_together = true;
  space.random_stream = 1;
  space.evaluate = [tool,
                    all = std::make_shared<const std::vector<Sample>>(std::move(samples))](
                       int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    const Sample& sample = (*all)[static_cast<std::size_t>(i)];
    if (J == nullptr) {
      const auto at = tool.position(x, sample.q, sample.assembly);
      if (at) e = sample.p_WE - *at;
      return at.has_value();
    }
    const auto at = tool.derivative(x, sample.q, sample.assembly);
    if (!at) return false;
    e = sample.p_WE - at->p_WE;
    *J = at->J_v;
    return true;
  };
  space.position_error = [evaluate = space.evaluate](
                             int i, const VectorXd& x, Eigen::Ref<VectorXd> e) {
    return evaluate(i, x, e, nullptr);
  };
  return space;
}

/// Readings of one sample against the forward model.
struct ReadSample {
  VectorXd q;
  geometry::Assembly assembly;
  std::vector<Eigen::Index> dials;
  VectorXd measured_mm;
  double gamma_guess_rad = 0.0;
};

ReadSample readings_of(const Trial& trial, std::size_t dials) {
  ReadSample sample{trial.q, trial.assembly, {}, {}, trial.gamma_rad.value_or(0.0)};
  std::vector<double> measured;
  for (std::size_t k = 0; k < trial.reading.size() && k < dials; ++k) {
    if (!trial.reading[k] || !std::isfinite(*trial.reading[k])) continue;
    sample.dials.push_back(static_cast<Eigen::Index>(k));
    measured.push_back(*trial.reading[k]);
  }
  sample.measured_mm = vector_of(measured);
  return sample;
}

bool evaluate_readings(
    const simulation::ForwardModel& model, const ReadSample& sample, const VectorXd& x,
    Eigen::Ref<VectorXd> e, MatrixXd* J) {
  const auto seen = model.predict(x, sample.q, sample.assembly, std::nullopt, false);
  if (!seen) return false;
  e = sample.measured_mm - seen->reading(sample.dials);
  if (J != nullptr) *J = seen->reading_J(sample.dials, Eigen::all);
  return true;
}

/// The rotation is this sample's own unknown: best gamma, then its direction taken out of e and
/// J. x: the robot's parameters.
bool evaluate_turned(
    const simulation::ForwardModel& model, const ReadSample& sample, const VectorXd& x,
    Eigen::Ref<VectorXd> e, MatrixXd* J) {
  simulation::ModelVector at = model.nominal();
  at.head(x.size()) = x;
  double gamma_rad = sample.gamma_guess_rad;
  VectorXd g;
  MatrixXd by_x;
  const auto look = [&] {
    const auto seen = model.predict(at, sample.q, sample.assembly, gamma_rad, false);
    if (!seen) return false;
    e = sample.measured_mm - seen->reading(sample.dials);
    g = seen->reading_J_gamma(sample.dials);
    by_x = seen->reading_J(sample.dials, Eigen::all).leftCols(x.size());
    return true;
  };
  for (int k = 0; k < kGammaIterations; ++k) {
    if (!look()) return false;
    const double step = g.dot(e) / g.squaredNorm();
    if (!std::isfinite(step)) return false;
    gamma_rad += step;
    if (std::abs(step) < kGammaSettled_rad) break;
  }
  if (!look()) return false;
  g.normalize();
  e -= (g * g.dot(e)).eval();
  if (J != nullptr) *J = by_x - g * (g.transpose() * by_x);
  return true;
}

/// By the tool's coordinates in the plane that the dials measure in; what a free cuboid's own
/// rotation takes over is left out.
MatrixXd readings_by_tool(
    const simulation::ForwardModel& model, const ReadSample& sample, const VectorXd& x,
    bool free) {
  simulation::ModelVector at = model.nominal();
  at.head(x.size()) = x;
  const auto seen = model.predict(
      at, sample.q, sample.assembly,
      free ? std::optional(sample.gamma_guess_rad) : std::nullopt, false);
  constexpr Eigen::Index kAxes = 2;
  if (!seen) return MatrixXd::Zero(std::ssize(sample.dials), kAxes);
  MatrixXd by_tool = seen->observation.by_frames(sample.dials, Eigen::seqN(0, kAxes));
  if (free) {
    const VectorXd g = seen->reading_J_gamma(sample.dials).normalized();
    by_tool -= (g * (g.transpose() * by_tool)).eval();
  }
  return by_tool;
}

ObservationSpace any_dial_space(Trials trials, const geometry::Rig& rig) {
  geometry::Rig with_dials = rig;
  with_dials.instrument.kind = "dials_on_cuboid";
  const auto model = std::make_shared<const simulation::ForwardModel>(std::move(with_dials));
  const geometry::InstrumentModel& dials = model->instrument();
  const bool free = !dials.unknowns.empty();
  ObservationSpace space = without_samples(rig);
  space.name = "dials";
  if (!free) {
    space.parameter_info = model->parameters();
    space.nominal = model->nominal();
  }
  for (const auto& dial : dials.channels) space.channel_info.push_back({dial.name, dial.unit});
  space.unknowns_per_sample = free ? 1 : 0;
  std::vector<double> sigma;
  std::vector<double> measured;
  std::vector<VectorXd> joints;
  std::vector<ReadSample> samples;
  for (const Trial& trial : trials) {
    ReadSample sample = readings_of(trial, rig.dials.size());
    if (sample.dials.size() < (free ? 3U : 2U)) continue;
    for (const Eigen::Index dial : sample.dials) {
      space.channel.push_back(static_cast<int>(dial));
      sigma.push_back(dials.channels[static_cast<std::size_t>(dial)].sd);
    }
    measured.insert(measured.end(), sample.measured_mm.begin(), sample.measured_mm.end());
    add_sample(trial, static_cast<int>(sample.dials.size()), space);
    joints.push_back(trial.q);
    samples.push_back(std::move(sample));
  }
  space.joints = matrix_of(joints, model->robot().joint_count());
  space.sigma_mm = vector_of(sigma);
  space.measured_mm = vector_of(measured);
  const auto all = std::make_shared<const std::vector<ReadSample>>(std::move(samples));
  space.evaluate = [model, free, all](
                       int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    const ReadSample& sample = (*all)[static_cast<std::size_t>(i)];
    return free ? evaluate_turned(*model, sample, x, e, J)
                : evaluate_readings(*model, sample, x, e, J);
  };
  space.by_tool = [model, free, all](int i, const VectorXd& x) {
    return readings_by_tool(*model, (*all)[static_cast<std::size_t>(i)], x, free);
  };
  return space;
}

}  // namespace

ObservationSpace position_space(Trials trials, const geometry::Rig& rig, double noise_mm) {
  const OwnSpaces* own = own_spaces(rig);
  ObservationSpace space = own != nullptr && own->axes == rig.instrument.dimensions
                               ? own->positions(trials, rig, noise_mm)
                               : any_position_space(trials, rig, noise_mm);
  space.rig_mm = rig_errors(space, trials, rig);
  return space;
}

ObservationSpace dial_space(Trials trials, const geometry::Rig& rig) {
  if (rig.dials.empty()) {
    ObservationSpace none = without_samples(rig);
    none.name = "dials";
    return none;
  }
  const OwnSpaces* own = own_spaces(rig);
  ObservationSpace space =
      own != nullptr ? own->dials(trials, rig) : any_dial_space(trials, rig);
  space.rig_mm = rig_errors(space, trials, rig);
  return space;
}

}  // namespace sixdial::calibration
