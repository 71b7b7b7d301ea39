#include "geometry/inverse_by_steps.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kSteps = 60;
constexpr int kStarts = 40;
constexpr double kArrived = 1e-13;   // of the robot's size
constexpr double kAccepted = 1e-12;  // where rounding lets no step improve any more
constexpr double kFirstDamping = 1e-6;
constexpr double kMostDamping = 1e6;
constexpr double kLongestStep_rad = 0.7;

class Search {
 public:
  Search(const RobotModel& robot, std::span<const double> v, const Pose<double>& X_WE)
      : robot_(robot),
        v_(Eigen::Map<const VectorXd>(v.data(), static_cast<Index>(v.size()))),
        X_WE_(X_WE),
        at_(robot),
        assembly_(static_cast<Assembly>(robot.assemblies.front().number)),
        rows_(robot.joint_count() >= 6 && X_WE.R.allFinite() ? 6 : 3) {}

  std::optional<VectorXd> from(VectorXd q) {
    if (!look(q)) return std::nullopt;
    size_mm_ = size_of_robot();
    VectorXd e = miss();
    double damping = kFirstDamping;
    for (int step = 0; step < kSteps; ++step) {
      const double now = e.norm();
      if (now <= kArrived * size_mm_) return q;
      MatrixXd J = at_.by_q[0].topRows(rows_);
      if (rows_ == 6) J.bottomRows<3>() *= size_mm_;
      const VectorXd scale = scales();
      J = J * scale.asDiagonal();
      bool better = false;
      while (damping < kMostDamping && !better) {
        const double lambda = damping * J.squaredNorm();
        MatrixXd JJt = J * J.transpose();
        JJt.diagonal().array() += lambda;
        VectorXd move = J.transpose() * JJt.ldlt().solve(e);
        const double longest = move.cwiseAbs().maxCoeff();
        if (longest > kLongestStep_rad) move *= kLongestStep_rad / longest;
        const VectorXd next = q + scale.cwiseProduct(move);
        if (next.allFinite() && look(next) && miss().norm() < now) {
          q = next;
          e = miss();
          better = true;
          damping = std::max(damping * 0.1, 1e-15);
        } else {
          damping = std::max(damping * 10.0, 1e-12);
        }
      }
      if (!better) {
        if (!look(q)) return std::nullopt;
        break;
      }
    }
    if (e.norm() <= kAccepted * size_mm_) return q;
    return std::nullopt;
  }

 private:
  bool look(const VectorXd& q) {
    return robot_.forward_derivative(v_, q, assembly_, at_).has_value();
  }

  /// What is missing: place [mm], and turn times the robot's size.
  [[nodiscard]] VectorXd miss() const {
    VectorXd e(rows_);
    e.head<3>() = X_WE_.p - at_.X[0].p;
    if (rows_ == 6) {
      const Eigen::Matrix3d turn = X_WE_.R * at_.X[0].R.transpose();
      e.tail<3>() = size_mm_ * rotation_vector(turn);
    }
    return e;
  }

  /// How far a turn of its joints carries the tool.
  [[nodiscard]] double size_of_robot() const {
    double size = 1.0;
    for (Index k = 0; k < robot_.joint_count(); ++k) {
      if (robot_.joints[static_cast<std::size_t>(k)].kind == JointKind::kRevolute) {
        size = std::max(size, at_.by_q[0].col(k).head<3>().norm());
      }
    }
    for (const Pose<double>& X : at_.X) size = std::max(size, (X.p - at_.X[0].p).norm());
    return size;
  }

  /// A prismatic joint's unit is a millimetre, that of a turn one radian.
  [[nodiscard]] VectorXd scales() const {
    VectorXd scale = VectorXd::Ones(robot_.joint_count());
    for (Index k = 0; k < scale.size(); ++k) {
      if (robot_.joints[static_cast<std::size_t>(k)].kind == JointKind::kPrismatic) {
        scale[k] = size_mm_;
      }
    }
    return scale;
  }

  const RobotModel& robot_;
  VectorXd v_;
  Pose<double> X_WE_;
  Frames at_;
  Assembly assembly_;
  Index rows_;
  double size_mm_ = 1.0;
};

/// Whole turns that leave the pose as it is, towards `near`.
void come_near(const RobotModel& robot, std::span<const double> near, VectorXd& q) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (std::size_t k = 0; k < near.size(); ++k) {
    const bool whole = robot.joints[k].kind == JointKind::kRevolute && !robot.joints[k].geared;
    double& each = q[static_cast<Index>(k)];
    if (whole) each += kTurn * std::round((near[k] - each) / kTurn);
  }
}

}  // namespace

tl::expected<VectorXd, KinematicTrouble> inverse_by_steps(
    const RobotModel& robot, std::span<const double> v, const Pose<double>& X_WE,
    std::span<const double> near) {
  if (!X_WE.p.allFinite()) return tl::unexpected(KinematicTrouble::kBadParameters);
  Search search(robot, v, X_WE);
  std::uint64_t state = 7;
  for (int start = near.empty() ? 1 : 0; start < kStarts; ++start) {
    VectorXd q(robot.joint_count());
    for (Index k = 0; k < q.size(); ++k) {
      const JointInfo& joint = robot.joints[static_cast<std::size_t>(k)];
      state = state * 6364136223846793005U + 1442695040888963407U;  // Knuth's generator
      const double drawn = start < 2 ? 0.5 : static_cast<double>(state >> 11U) * 0x1p-53;
      q[k] = start == 0 ? near[static_cast<std::size_t>(k)]
                        : joint.low + drawn * (joint.high - joint.low);
    }
    if (auto found = search.from(std::move(q))) {
      come_near(robot, near, *found);
      return *std::move(found);
    }
  }
  return tl::unexpected(KinematicTrouble::kOutOfReach);
}

}  // namespace sixdial::geometry
