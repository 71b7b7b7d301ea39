#include "sample_session.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/rig.h"

namespace sixdial::report {
namespace {

using geometry::ParameterMatrix;
using geometry::ParameterVector;

constexpr std::uint64_t kSeed = 20260302;
constexpr double kNoise_mm = 0.003;
constexpr double kSmooth_mm = 0.03;
constexpr double kFilterNoise = 1e-4;  // R of the paper's filter [mm^2]

struct Measured {
  std::string set;
  int point = 0;
  Eigen::Vector2d target, q, p;
};

Eigen::Vector2d smooth_error(const Eigen::Vector2d& q) {
  return kSmooth_mm * Eigen::Vector2d{std::sin(7.0 * q[0] + 0.4), std::cos(6.0 * q[1] - 0.7)};
}

class Bench {
 public:
  explicit Bench(const SampleOptions& options) : rig_(geometry::default_rig()) {
    for (const auto& [set, count] :
         {std::pair{std::string{"G1"}, options.g1_points}, {"G2", options.g2_points}}) {
      for (int i = 0; i < count; ++i) {
        const Eigen::Vector2d target{
            16.0 + 24.0 * uniform_(random_), 30.0 + 36.0 * uniform_(random_)};
        const Eigen::Vector2d q =
            geometry::inverse(
                rig_.robot.nominal, target, rig_.robot.working_mode, Eigen::Vector2d{1.2, 2.9})
                .value();
        Eigen::Vector2d p =
            geometry::forward(geometry::table_2_robot(), q, rig_.robot.assembly).value().p_WE;
        if (options.smooth_error) p += smooth_error(q);
        for (double& v : p) v += kNoise_mm * normal_(random_);
        points_.push_back({set, i, target, q, p});
      }
    }
  }

  [[nodiscard]] Eigen::Vector2d residual(const ParameterVector& v, const Measured& m) const {
    return m.p - geometry::forward(v, m.q, rig_.robot.assembly).value().p_WE;
  }

  /// Gauss-Newton on G1 from nominal; also gives the covariance.
  std::pair<ParameterVector, ParameterMatrix> fitted() const {
    ParameterVector v = rig_.robot.nominal;
    ParameterMatrix information = ParameterMatrix::Zero();
    for (int round = 0; round < 12; ++round) {
      information.setZero();
      ParameterVector gradient = ParameterVector::Zero();
      for (const Measured& m : points_) {
        if (m.set != "G1") continue;
        const auto d = geometry::forward_derivative(v, m.q, rig_.robot.assembly).value();
        information += d.J_v.transpose() * d.J_v;
        gradient += d.J_v.transpose() * (m.p - d.pose.p_WE);
      }
      v += information.ldlt().solve(gradient);
    }
    const double s = rmse(v);
    return {v, s * s * 0.5 * information.inverse()};
  }

  [[nodiscard]] double rmse(const ParameterVector& v) const {
    double sum = 0.0;
    int n = 0;
    for (const Measured& m : points_) {
      if (m.set != "G1") continue;
      sum += residual(v, m).squaredNorm();
      ++n;
    }
    return std::sqrt(sum / n);
  }

  /// The filter's estimate after each point of G1.
  [[nodiscard]] std::vector<ParameterVector> filtered() const {
    ParameterVector v = rig_.robot.nominal;
    ParameterMatrix P = ParameterMatrix::Identity();
    std::vector<ParameterVector> out{ParameterVector::Zero()};
    for (const Measured& m : points_) {
      if (m.set != "G1") continue;
      const auto d = geometry::forward_derivative(v, m.q, rig_.robot.assembly).value();
      const Eigen::Matrix2d S =
          d.J_v * P * d.J_v.transpose() + kFilterNoise * Eigen::Matrix2d::Identity();
      const Eigen::Matrix<double, 10, 2> K = P * d.J_v.transpose() * S.inverse();
      v += K * (m.p - d.pose.p_WE);
      const ParameterMatrix A = ParameterMatrix::Identity() - K * d.J_v;
      P = A * P * A.transpose() + kFilterNoise * K * K.transpose();
      out.emplace_back(v - rig_.robot.nominal);
    }
    return out;
  }

  /// What a residual model leaves: a cubic in both angles, fitted to G1's residuals.
  [[nodiscard]] std::vector<Eigen::Vector2d> after_residual_model(
      const ParameterVector& v) const {
    const auto terms = [](const Eigen::Vector2d& q) {
      std::vector<double> out;
      for (int i = 0; i < 5; ++i) {
        for (int j = 0; i + j < 5; ++j) {
          out.push_back(std::pow(q[0] - 1.2, i) * std::pow(q[1] - 2.8, j));
        }
      }
      return Eigen::VectorXd{
          Eigen::Map<const Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()))};
    };
    Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(15, 15) * 1e-6;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(15, 2);
    for (const Measured& m : points_) {
      if (m.set != "G1") continue;
      const Eigen::VectorXd t = terms(m.q);
      normal += t * t.transpose();
      right += t * residual(v, m).transpose();
    }
    const Eigen::MatrixXd weights = normal.ldlt().solve(right);
    std::vector<Eigen::Vector2d> out;
    for (const Measured& m : points_) {
      out.emplace_back(residual(v, m) - weights.transpose() * terms(m.q));
    }
    return out;
  }

  [[nodiscard]] const std::vector<Measured>& points() const { return points_; }
  [[nodiscard]] const geometry::Rig& rig() const { return rig_; }
  double normal() { return normal_(random_); }

 private:
  geometry::Rig rig_;
  std::mt19937_64 random_{kSeed};
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  std::normal_distribution<double> normal_{0.0, 1.0};
  std::vector<Measured> points_;
};

/// Best cost of a swarm: improves now and then, less and less.
std::vector<double> swarm(Bench& bench, double start, double end, int iterations, double fall) {
  std::vector<double> out{start};
  for (int i = 1; i <= iterations; ++i) {
    const double goal = end + (start - end) * std::exp(-i / fall);
    const double trial = goal + 0.05 * (start - end) * std::exp(-i / fall) * bench.normal();
    out.push_back(std::max(end, std::min(out.back(), trial)));
  }
  out.back() = end;
  return out;
}

Head head_of(const SampleOptions& options, const geometry::Rig& rig) {
  Head h;
  h.session_name = options.session_name;
  h.rig_name = rig.name;
  h.robot = "planar five-bar, working mode ++, coplanar arms 60 mm";
  h.operator_name = "M. Okafor";
  h.measured_from = "2026-03-02T08:30:06.976Z";
  h.measured_to = "2026-03-02T08:52:41.120Z";
  h.reported = "2026-03-02T09:04:00.000Z";
  h.temperature_min_c = 20.03;
  h.temperature_max_c = 21.47;
  h.software_version = SIXDIAL_VERSION;
  h.data_hash = "sha256:5f1e0c3b6b7a4c0d9a1f2e8877b0c1d2e3f405162738495a6b7c8d9eafb0c1d2";
  h.rig_hash = "sha256:09ab34cd56ef7890123456789abcdef0fedcba9876543210aabbccddeeff0011";
  h.seed = kSeed;
  h.profile = "default";
  h.settings = {
      {"QPSO-1", "50 particles, 100 iterations, 12 dimensions"},
      {"QPSO-2", "50 particles, 400 iterations, whitened by the filter's covariance"},
      {"ANFIS", "3 Gaussian functions per input, ridge 0.001, by cross-validation"}};
  for (const geometry::Dial& d : rig.dials) {
    h.instruments.push_back(
        {.id = d.id,
         .description = "digital dial indicator",
         .serial = fmt::format("ID-{}4417", d.id),
         .connection = "modbus-tcp://127.0.0.1:1502/1",
         .resolution_mm = d.resolution_mm,
         .accuracy_mm = d.accuracy_mm,
         .repeatability_mm = d.repeatability_mm,
         .travel_mm = d.geometry.travel_mm,
         .tip_radius_mm = d.geometry.tip_radius_mm});
  }
  return h;
}

}  // namespace

ReportData sample_session(const SampleOptions& options) {
  Bench bench{options};
  ReportData out;
  out.head = head_of(options, bench.rig());
  const ParameterVector nominal = bench.rig().robot.nominal;
  const auto [identified, covariance] = bench.fitted();
  out.parameters = parameter_rows(*geometry::five_bar_model(), nominal, identified, covariance);
  out.condition_number = 166.4;
  out.joints = {{"theta1", "rad"}, {"theta2", "rad"}};
  out.correlations = {{"l11", "dtheta1", -0.952}, {"alpha", "dtheta2", 0.934}};
  for (const double s : {31.2, 22.9, 14.1, 9.6, 5.2, 3.3, 1.9, 0.84, 0.41, 0.1875}) {
    out.singular_values.push_back(s);
  }
  out.methods = {
      {.id = "before", .name = "Before calibration"},
      {.id = "ekf_dqpso", .name = "EKF-DQPSO", .seconds = 0.412},
      {.id = "ekf_dqpso+anfis",
       .name = "EKF-DQPSO & ANFIS",
       .seconds = 0.655,
       .has_residual_model = true}};
  const std::vector<Eigen::Vector2d> rest = bench.after_residual_model(identified);
  for (std::size_t i = 0; i < bench.points().size(); ++i) {
    const Measured& m = bench.points()[i];
    PointRow row{
        .set = m.set,
        .point = m.point,
        .q = m.q,
        .target_mm = m.target,
        .measured_mm = m.p,
        .dials = i % 3 == 0   ? "CDB"
                 : i % 3 == 1 ? "EFA"
                              : "CDA",
        .temperature_c = 20.03 + 1.44 * static_cast<double>(i) / 149.0};
    row.residual_mm = {bench.residual(nominal, m), bench.residual(identified, m), rest[i]};
    if (m.set == "G1" && m.point == 41) {  // contacts allowed no position here
      row.measured_mm.reset();
      row.dials.clear();
      row.residual_mm.assign(3, std::nullopt);
    }
    out.points.push_back(std::move(row));
  }
  for (std::size_t m = 0; m < out.methods.size(); ++m) {
    out.methods[m].g1 = error_statistics(out, "G1", m);
    out.methods[m].g2 = error_statistics(out, "G2", m);
  }
  out.position_noise_mm = 0.0031;
  out.least_squares_rmse_mm = bench.rmse(identified);
  out.rmse_mm = *out.least_squares_rmse_mm + 2.1e-9;
  const std::vector<ParameterVector> filter = bench.filtered();
  const double after_filter = bench.rmse(nominal + filter.back());
  out.convergence = {
      {.name = "QPSO-1",
       .best_mm = swarm(bench, after_filter * 1.3, *out.rmse_mm * 1.03, 100, 12.0)},
      {.name = "QPSO-2",
       .best_mm = swarm(bench, *out.rmse_mm * 1.03, *out.rmse_mm, 400, 38.0)}};
  out.traces = {
      {.name = "EKF", .step = "point", .error = {filter.begin(), filter.end()}},
      {.name = "QPSO-2", .step = "iteration"}};
  for (int i = 0; i <= 400; ++i) {
    const double left = std::exp(-i / 38.0);
    out.traces[1].error.emplace_back(
        left * filter.back() + (1.0 - left) * (identified - nominal));
  }
  out.samples = static_cast<int>(out.points.size());
  out.rejected = {
      {.line = 88, .text = "", .reason = "column dial_C_mm: \"12,55\" is not a number"}};
  out.bad_readings = {
      {.set = "G1", .point = 41, .dial = "C", .reason = "timeout"},
      {.set = "G1", .point = 41, .dial = "E", .reason = "no contact"},
      {.set = "G2", .point = 7, .dial = "F", .reason = "unsettled", .value_mm = 26.044}};
  return out;
}

}  // namespace sixdial::report
