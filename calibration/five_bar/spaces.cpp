#include "calibration/five_bar/spaces.h"

#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "calibration/five_bar/position_kernel.h"
#include "calibration/five_bar/swarm_kernels.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::kParameterCount;
using geometry::ParameterVector;

constexpr double kClampScale_rad = 1.0 / 60.0;
constexpr int kGammaIterations = 20;
constexpr double kGammaSettled_rad = 1e-13;

/// One sample's readings, ready to be predicted.
struct DialSample {
  Eigen::Vector2d q_rad;
  geometry::Assembly assembly;
  std::vector<int> dials;
  std::vector<int> faces;
  std::vector<double> measured_mm;
  double gamma_guess_rad = 0.0;
};

struct DialData {
  geometry::Rig rig;
  std::vector<geometry::DialGeometry> dials;
  double reference_rad = 0.0;
  std::vector<DialSample> samples;
};

/// e and the derivatives of the predicted displacements by (x, y, gamma): rows x 3.
MatrixXd contact_errors(
    const DialData& data, const DialSample& sample, const geometry::CuboidPose& pose,
    Eigen::Ref<VectorXd> e) {
  MatrixXd by_pose(e.size(), 3);
  for (Eigen::Index row = 0; row < e.size(); ++row) {
    const auto k = static_cast<std::size_t>(row);
    const geometry::Contact contact = geometry::contact_on_face(
        data.dials[static_cast<std::size_t>(sample.dials[k])], pose, data.rig.cuboid.side_mm,
        sample.faces[k]);
    e[row] = sample.measured_mm[k] - contact.displacement_mm;
    by_pose.row(row) = contact.J;
  }
  return by_pose;
}

/// Derivatives of the predicted displacements by (x, y) of the tool; what a free cuboid's own
/// rotation takes over is left out.
MatrixXd dials_by_tool(const DialData& data, const DialSample& sample, const VectorXd& x) {
  const bool free = data.rig.cuboid.mount == geometry::Mount::kFree;
  const auto rows = std::ssize(sample.dials);
  const auto pose = geometry::forward(x.head<kParameterCount>(), sample.q_rad, sample.assembly);
  if (!pose) return MatrixXd::Zero(rows, 2);
  const double gamma =
      free ? sample.gamma_guess_rad
           : geometry::cuboid_angle(data.rig, data.reference_rad, *pose, x[kParameterCount]);
  VectorXd e(rows);
  const MatrixXd by_pose = contact_errors(data, sample, {pose->p_WE, gamma}, e);
  MatrixXd by_tool = by_pose.leftCols<2>();
  if (free) {
    const VectorXd g = by_pose.col(2).normalized();
    by_tool -= (g * (g.transpose() * by_tool)).eval();
  }
  return by_tool;
}

bool evaluate_mounted(
    const DialData& data, const DialSample& sample, const VectorXd& x, Eigen::Ref<VectorXd> e,
    MatrixXd* J) {
  const ParameterVector v = x.head<kParameterCount>();
  const int leg = data.rig.cuboid.mount == geometry::Mount::kDistal1 ? 0 : 1;
  const auto d = geometry::forward_derivative(v, sample.q_rad, sample.assembly);
  if (!d) return false;
  const double gamma =
      geometry::cuboid_angle(data.rig, data.reference_rad, d->pose, x[kParameterCount]);
  const MatrixXd by_pose = contact_errors(data, sample, {d->pose.p_WE, gamma}, e);
  if (J != nullptr) {
    J->leftCols<kParameterCount>() =
        by_pose.leftCols<2>() * d->J_v + by_pose.col(2) * d->distal_J_v.row(leg);
    J->col(kParameterCount) = by_pose.col(2);
  }
  return true;
}

/// The rotation is this sample's own unknown: best gamma, then its direction taken out of e and
/// J.
bool evaluate_free(
    const DialData& data, const DialSample& sample, const VectorXd& x, Eigen::Ref<VectorXd> e,
    MatrixXd* J) {
  const ParameterVector v = x;
  const auto d = geometry::forward_derivative(v, sample.q_rad, sample.assembly);
  if (!d) return false;
  geometry::CuboidPose pose{d->pose.p_WE, sample.gamma_guess_rad};
  MatrixXd by_pose;
  for (int k = 0; k < kGammaIterations; ++k) {
    by_pose = contact_errors(data, sample, pose, e);
    const double step = by_pose.col(2).dot(e) / by_pose.col(2).squaredNorm();
    pose.gamma_rad += step;
    if (!std::isfinite(step)) return false;
    if (std::abs(step) < kGammaSettled_rad) break;
  }
  by_pose = contact_errors(data, sample, pose, e);
  const VectorXd g = by_pose.col(2).normalized();
  e -= (g * g.dot(e)).eval();
  if (J != nullptr) {
    *J = by_pose.leftCols<2>() * d->J_v;
    *J -= (g * (g.transpose() * *J)).eval();
  }
  return true;
}

double reading_sigma(const geometry::Dial& dial) {
  const double rounding = dial.resolution_mm / std::sqrt(12.0);
  return std::hypot(dial.repeatability_mm, rounding);
}

/// The dials in contact at one trial, each with the face that it touches.
DialSample readings_of(const simulation::Trial& trial, const DialData& data) {
  const geometry::Rig& rig = data.rig;
  DialSample sample{trial.q, trial.assembly, {}, {}, {}, 0.0};
  const auto nominal = geometry::forward(rig.robot.nominal, trial.q, trial.assembly);
  if (rig.cuboid.mount == geometry::Mount::kFree) {
    sample.gamma_guess_rad = trial.gamma_rad.value_or(0.0);
  } else if (nominal) {
    sample.gamma_guess_rad = geometry::cuboid_angle(rig, data.reference_rad, *nominal, 0.0);
  }
  for (std::size_t k = 0; k < trial.reading.size() && k < rig.dials.size(); ++k) {
    if (!trial.reading[k] || !std::isfinite(*trial.reading[k])) continue;
    sample.dials.push_back(static_cast<int>(k));
    sample.faces.push_back(geometry::face_towards(data.dials[k], sample.gamma_guess_rad));
    sample.measured_mm.push_back(*trial.reading[k]);
  }
  return sample;
}

/// The ten parameters as every space lists them.
std::vector<ParameterInfo> parameter_infos() {
  return {geometry::kParameters.begin(), geometry::kParameters.end()};
}

std::vector<SpaceJoint> joint_infos() { return {{"theta1", "rad"}, {"theta2", "rad"}}; }

/// The eleventh parameter of a cuboid that is clamped to a link.
void add_clamp(ObservationSpace& space) {
  ParameterInfo clamp = geometry::kParameters[geometry::kAlpha];  // an angle like any other
  clamp.name = "clamp";
  clamp.rig_key.clear();
  clamp.meaning = "clamp angle of the cuboid";
  clamp.plainly.clear();
  clamp.change = kClampScale_rad;
  space.parameter_info.push_back(clamp);
  space.nominal.conservativeResize(kParameterCount + 1);
  space.nominal[kParameterCount] = 0.0;
}

MatrixXd matrix_of(const std::vector<Eigen::Vector2d>& columns) {
  MatrixXd result(2, std::ssize(columns));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    result.col(static_cast<Eigen::Index>(i)) = columns[i];
  }
  return result;
}

/// Measured positions with what the kernels make of them, made when first asked for.
class PositionData {
 public:
  PositionData(PositionObservations set, const ParameterVector& at)
      : observations(std::move(set)), nominal(at) {}

  [[nodiscard]] const SwarmTable& table() const {
    std::call_once(table_made_, [this] { table_.emplace(observations, nominal); });
    return *table_;
  }
  [[nodiscard]] const std::vector<PositionBlock>& blocks() const {
    std::call_once(blocks_made_, [this] { blocks_ = position_blocks(observations); });
    return blocks_;
  }

  const PositionObservations observations;
  const ParameterVector nominal;

 private:
  mutable std::once_flag table_made_, blocks_made_;
  mutable std::optional<SwarmTable> table_;
  mutable std::vector<PositionBlock> blocks_;
};
using SharedPositions = std::shared_ptr<const PositionData>;

/// e = measured - f(x) and J of one position.
bool evaluate_position(
    const PositionObservations& set, int i, const VectorXd& x, Eigen::Ref<VectorXd> e,
    MatrixXd* J) {
  const auto assembly = set.assembly[static_cast<std::size_t>(i)];
  const Eigen::Vector2d q = set.q_rad.col(i);
  if (J == nullptr) {
    const auto pose = geometry::forward(x, q, assembly);
    if (!pose) return false;
    e = set.p_WE.col(i) - pose->p_WE;
    return true;
  }
  const auto d = geometry::forward_derivative(x, q, assembly);
  if (!d) return false;
  e = set.p_WE.col(i) - d->pose.p_WE;
  *J = d->J_v;
  return true;
}

/// Residuals f(x) - measured of all positions, x before y, and their Jacobian.
bool evaluate_positions(
    const PositionObservations& set, const VectorXd& x, VectorXd& r, MatrixXd* J) {
  const ParameterVector v = x;
  for (int i = 0; i < set.size(); ++i) {
    const Eigen::Vector2d q = set.q_rad.col(i);
    const auto assembly = set.assembly[static_cast<std::size_t>(i)];
    if (J == nullptr) {
      const auto pose = geometry::forward(v, q, assembly);
      if (!pose) return false;
      r.segment<2>(2 * i) = pose->p_WE - set.p_WE.col(i);
    } else {
      const auto d = geometry::forward_derivative(v, q, assembly);
      if (!d) return false;
      r.segment<2>(2 * i) = d->pose.p_WE - set.p_WE.col(i);
      J->middleRows<2>(2 * i) = d->J_v;
    }
  }
  return true;
}

LeastSquaresProblem unweighted_problem(const SharedPositions& data) {
  LeastSquaresProblem problem;
  problem.parameters = kParameterCount;
  problem.residuals = 2 * data->observations.size();
  problem.evaluate = [data](const VectorXd& x, VectorXd& r, MatrixXd* J) {
    return evaluate_positions(data->observations, x, r, J);
  };
  problem.normal = [data](const VectorXd& x, MatrixXd& JtJ, VectorXd& Jtr, double& rss) {
    return position_normal(data->blocks(), x, JtJ, Jtr, rss);
  };
  return problem;
}

/// Calls work(first column, lanes used, lanes) for every kLanes columns; idle lanes repeat the
/// last column.
template <int Rows, class Work>
void by_lanes(const MatrixXd& columns, const Work& work) {
  Lanes<Rows> lanes;
  for (Eigen::Index first = 0; first < columns.cols(); first += kLanes) {
    const Eigen::Index used = std::min<Eigen::Index>(kLanes, columns.cols() - first);
    for (Eigen::Index lane = 0; lane < kLanes; ++lane) {
      lanes.col(lane) = columns.col(first + std::min(lane, used - 1));
    }
    work(first, used, lanes);
  }
}

void batch_rmse(
    const SwarmTable& table, const MatrixXd& x, Eigen::Ref<Eigen::ArrayXd> rmse_mm) {
  by_lanes<kParameterCount>(
      x, [&](Eigen::Index first, Eigen::Index used, const ParameterLanes& v) {
        Lanes<1> values;
        swarm_rmse(table, v, values);
        rmse_mm.segment(first, used) = values.head(used).transpose().array();
      });
}

void batch_filter(
    const SwarmTable& table, Linearisation linearisation, const VectorXd& p0,
    const MatrixXd& noise, MatrixXd& errors) {
  errors.resize(kParameterCount, noise.cols());
  by_lanes<kParameterCount + 2>(
      noise, [&](Eigen::Index first, Eigen::Index used, const NoiseLanes& of) {
        ParameterLanes state;
        if (linearisation == Linearisation::kNominal) {
          swarm_filter_nominal(table, p0, of, state);
        } else {
          swarm_filter_estimate(table, p0, of, state);
        }
        errors.middleCols(first, used) = state.leftCols(used);
      });
}

std::shared_ptr<const BatchKernels> kernels_of(const SharedPositions& data) {
  BatchKernels kernels;
  kernels.problem = unweighted_problem(data);
  kernels.rmse = [data](const MatrixXd& x, Eigen::Ref<Eigen::ArrayXd> rmse_mm) {
    batch_rmse(data->table(), x, rmse_mm);
  };
  kernels.filter = [data](
                       Linearisation linearisation, const VectorXd& p0, const MatrixXd& noise,
                       MatrixXd& errors) {
    batch_filter(data->table(), linearisation, p0, noise, errors);
  };
  return std::make_shared<const BatchKernels>(std::move(kernels));
}

/// The rows of a position space, two a sample.
void add_rows(const PositionObservations& set, double noise_mm, ObservationSpace& space) {
  space.sigma_mm.resize(2 * set.size());
  space.measured_mm = set.p_WE.reshaped();
  for (int i = 0; i < set.size(); ++i) {
    const Eigen::Matrix2d& C = set.covariance_mm2[static_cast<std::size_t>(i)];
    for (int axis = 0; axis < 2; ++axis) {
      space.channel.push_back(axis);
      space.sigma_mm[2 * i + axis] = C(axis, axis) > 0.0 ? std::sqrt(C(axis, axis)) : noise_mm;
    }
    space.covariance_mm2.emplace_back(C.diagonal().minCoeff() > 0.0 ? MatrixXd(C) : MatrixXd());
    space.first_row.push_back(2 * (i + 1));
    if (!(C.diagonal().minCoeff() > 0.0)) space.sigma_is_assumed = true;
  }
}

MatrixXd off_target(const PositionObservations& set) {
  MatrixXd result(2, set.size());
  for (int i = 0; i < set.size(); ++i) {
    const auto& target = set.target_mm[static_cast<std::size_t>(i)];
    if (target) {
      result.col(i) = set.p_WE.col(i) - *target;
    } else {
      result.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return result;
}

}  // namespace

std::vector<std::string_view> parameter_names() {
  std::vector<std::string_view> names;
  for (const geometry::ParameterInfo& each : geometry::kParameters)
    names.emplace_back(each.name);
  return names;
}

ParameterVector parameter_scale() {
  ParameterVector scale;
  for (int i = 0; i < kParameterCount; ++i) {
    scale[i] = geometry::kParameters[static_cast<std::size_t>(i)].change;
  }
  return scale;
}

ObservationSpace position_space(
    PositionObservations observations, const ParameterVector& nominal, double noise_mm) {
  ObservationSpace space;
  space.name = "positions";
  space.parameter_info = parameter_infos();
  space.named_directions = geometry::five_bar_model()->named_directions;
  space.nominal = nominal;
  space.joint_info = joint_infos();
  space.channel_info = {{"x", "mm"}, {"y", "mm"}};
  add_rows(observations, noise_mm, space);
  space.joints = observations.q_rad;
  space.sample = observations.sample;
  space.point = observations.point;
  space.repeat = observations.repeat;
  space.position_axes = 2;
  space.off_target_mm = off_target(observations);
  space.rows_belong_together = true;
  space.random_stream = 1;
  const auto data = std::make_shared<const PositionData>(std::move(observations), nominal);
  space.evaluate = [data](int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    return evaluate_position(data->observations, i, x, e, J);
  };
  space.position_error = [data](int i, const VectorXd& x, Eigen::Ref<VectorXd> e) {
    return evaluate_position(data->observations, i, x, e, nullptr);
  };
  space.kernels = kernels_of(data);
  return space;
}

ObservationSpace five_bar_dial_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig) {
  auto data = std::make_shared<DialData>();
  data->rig = rig;
  data->dials = rig.dial_geometries();
  data->reference_rad = geometry::reference_link_angle(rig).value_or(0.0);
  const bool free = rig.cuboid.mount == geometry::Mount::kFree;

  ObservationSpace space;
  space.name = "dials";
  space.parameter_info = parameter_infos();
  space.named_directions = geometry::five_bar_model()->named_directions;
  space.nominal = rig.robot.nominal;
  if (!free) add_clamp(space);
  space.joint_info = joint_infos();
  for (const geometry::Dial& dial : rig.dials) space.channel_info.push_back({dial.id, "mm"});
  space.unknowns_per_sample = free ? 1 : 0;
  std::vector<double> sigma;
  std::vector<double> measured;
  std::vector<Eigen::Vector2d> joints;
  for (const simulation::Trial& trial : trials) {
    DialSample sample = readings_of(trial, *data);
    if (sample.dials.size() < (free ? 3U : 2U)) continue;
    for (const int dial : sample.dials) {
      space.channel.push_back(dial);
      sigma.push_back(reading_sigma(rig.dials[static_cast<std::size_t>(dial)]));
    }
    measured.insert(measured.end(), sample.measured_mm.begin(), sample.measured_mm.end());
    space.first_row.push_back(static_cast<int>(sigma.size()));
    space.sample.push_back(trial.sample);
    space.point.push_back(trial.point);
    space.repeat.push_back(trial.repeat);
    joints.push_back(trial.q);
    data->samples.push_back(std::move(sample));
  }
  space.joints = matrix_of(joints);
  space.sigma_mm = Eigen::Map<const VectorXd>(sigma.data(), std::ssize(sigma));
  space.measured_mm = Eigen::Map<const VectorXd>(measured.data(), std::ssize(measured));
  space.evaluate = [data, free](int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    const DialSample& sample = data->samples[static_cast<std::size_t>(i)];
    return free ? evaluate_free(*data, sample, x, e, J)
                : evaluate_mounted(*data, sample, x, e, J);
  };
  space.by_tool = [data](int i, const VectorXd& x) {
    return dials_by_tool(*data, data->samples[static_cast<std::size_t>(i)], x);
  };
  return space;
}

ObservationSpace five_bar_position_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig, double noise_mm) {
  return position_space(position_observations(trials), rig.robot.nominal, noise_mm);
}

}  // namespace sixdial::calibration
