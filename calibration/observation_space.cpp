#include "calibration/observation_space.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "calibration/identifiability.h"
#include "calibration/position_fit.h"

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

}  // namespace

LeastSquaresProblem ObservationSpace::problem(bool weighted) const {
  if (positions && !weighted) return position_problem(*positions);
  LeastSquaresProblem result;
  result.parameters = parameters();
  result.residuals = rows();
  const VectorXd weight =
      weighted ? VectorXd(mean_sigma() * sigma_mm.cwiseInverse()) : VectorXd::Ones(rows());
  result.evaluate = [this, weight](const VectorXd& x, VectorXd& r, MatrixXd* J) {
    MatrixXd block;
    for (int i = 0; i < samples(); ++i) {
      const int first = first_row[static_cast<std::size_t>(i)];
      const int count = rows(i);
      auto part = r.segment(first, count);
      if (J != nullptr) block.resize(count, parameters());
      if (!evaluate(i, x, part, J != nullptr ? &block : nullptr)) return false;
      const auto w = weight.segment(first, count);
      part = -part.cwiseProduct(w).eval();
      if (J != nullptr) J->middleRows(first, count) = w.asDiagonal() * block;
    }
    return true;
  };
  return result;
}

double ObservationSpace::rmse(const VectorXd& x) const {
  double sum = 0.0;
  VectorXd e;
  for (int i = 0; i < samples(); ++i) {
    e.resize(rows(i));
    if (!evaluate(i, x, e, nullptr)) return std::numeric_limits<double>::infinity();
    sum += e.squaredNorm();
  }
  if (!std::isfinite(sum)) return std::numeric_limits<double>::infinity();
  return samples() > 0 ? std::sqrt(sum / samples()) : 0.0;
}

double ObservationSpace::mean_sigma() const {
  return sigma_mm.size() > 0
             ? std::sqrt(sigma_mm.squaredNorm() / static_cast<double>(sigma_mm.size()))
             : 0.0;
}

std::optional<int> ObservationSpace::find(std::string_view parameter) const {
  for (int i = 0; i < parameters(); ++i) {
    if (parameter_names[static_cast<std::size_t>(i)] == parameter) return i;
  }
  return std::nullopt;
}

ObservationSpace position_space(
    PositionObservations observations, const ParameterVector& nominal, double noise_mm) {
  ObservationSpace space;
  space.name = "positions";
  space.parameter_names = parameter_names();
  space.nominal = nominal;
  space.scale = parameter_scale();
  space.first_row.push_back(0);
  space.sigma_mm.resize(2 * observations.size());
  for (int i = 0; i < observations.size(); ++i) {
    const Eigen::Matrix2d& C = observations.covariance_mm2[static_cast<std::size_t>(i)];
    for (int axis = 0; axis < 2; ++axis) {
      space.channel.push_back(axis);
      space.sigma_mm[2 * i + axis] = C(axis, axis) > 0.0 ? std::sqrt(C(axis, axis)) : noise_mm;
    }
    space.first_row.push_back(2 * (i + 1));
  }
  space.sample = observations.sample;
  space.positions = std::make_shared<const PositionObservations>(std::move(observations));
  space.evaluate = [data = space.positions](
                       int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    const auto assembly = data->assembly[static_cast<std::size_t>(i)];
    const Eigen::Vector2d q = data->q_rad.col(i);
    if (J == nullptr) {
      const auto pose = geometry::forward(x, q, assembly);
      if (!pose) return false;
      e = data->p_WE.col(i) - pose->p_WE;
      return true;
    }
    const auto d = geometry::forward_derivative(x, q, assembly);
    if (!d) return false;
    e = data->p_WE.col(i) - d->pose.p_WE;
    *J = d->J_v;
    return true;
  };
  return space;
}

ObservationSpace dial_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig) {
  auto data = std::make_shared<DialData>();
  data->rig = rig;
  data->dials = rig.dial_geometries();
  data->reference_rad = geometry::reference_link_angle(rig).value_or(0.0);
  const bool free = rig.cuboid.mount == geometry::Mount::kFree;

  ObservationSpace space;
  space.name = "dials";
  space.parameter_names = parameter_names();
  const int n = kParameterCount + (free ? 0 : 1);
  space.nominal = VectorXd::Zero(n);
  space.scale = VectorXd::Constant(n, kClampScale_rad);
  space.nominal.head<kParameterCount>() = rig.robot.nominal;
  space.scale.head<kParameterCount>() = parameter_scale();
  if (!free) space.parameter_names.push_back("clamp");
  space.channels = static_cast<int>(rig.dials.size());
  space.first_row.push_back(0);
  std::vector<double> sigma;
  for (const simulation::Trial& trial : trials) {
    DialSample sample{trial.q, trial.assembly, {}, {}, {}, 0.0};
    const auto nominal = geometry::forward(rig.robot.nominal, trial.q, trial.assembly);
    if (free) {
      sample.gamma_guess_rad = trial.gamma_rad.value_or(0.0);
    } else if (nominal) {
      sample.gamma_guess_rad = geometry::cuboid_angle(rig, data->reference_rad, *nominal, 0.0);
    }
    for (std::size_t k = 0; k < trial.reading.size() && k < rig.dials.size(); ++k) {
      if (!trial.reading[k] || !std::isfinite(*trial.reading[k])) continue;
      sample.dials.push_back(static_cast<int>(k));
      sample.faces.push_back(geometry::face_towards(data->dials[k], sample.gamma_guess_rad));
      sample.measured_mm.push_back(*trial.reading[k]);
    }
    if (sample.dials.size() < (free ? 3U : 2U)) continue;
    for (const int dial : sample.dials) {
      space.channel.push_back(dial);
      sigma.push_back(reading_sigma(rig.dials[static_cast<std::size_t>(dial)]));
    }
    space.first_row.push_back(static_cast<int>(sigma.size()));
    space.sample.push_back(trial.sample);
    data->samples.push_back(std::move(sample));
  }
  space.sigma_mm =
      Eigen::Map<const VectorXd>(sigma.data(), static_cast<Eigen::Index>(sigma.size()));
  space.evaluate = [data, free](int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    const DialSample& sample = data->samples[static_cast<std::size_t>(i)];
    return free ? evaluate_free(*data, sample, x, e, J)
                : evaluate_mounted(*data, sample, x, e, J);
  };
  return space;
}

tl::expected<std::vector<char>, std::string> fixed_by_name(
    const ObservationSpace& space, std::span<const std::string> names) {
  std::vector<char> fixed(static_cast<std::size_t>(space.parameters()), 0);
  for (const std::string& name : names) {
    const auto index = space.find(name);
    if (!index) return tl::unexpected(name);
    fixed[static_cast<std::size_t>(*index)] = 1;
  }
  return fixed;
}

}  // namespace sixdial::calibration
