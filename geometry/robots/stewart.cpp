#include "geometry/robots/stewart.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "geometry/dual.h"
#include "geometry/robots/parameter_row.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr std::size_t kLegs = 6;
constexpr std::size_t kPlatform = 18;  // first of the platform's joints
constexpr std::size_t kLeg = 36;       // first of the legs' zeros
constexpr std::size_t kCount = 42;
constexpr int kSteps = 60;
constexpr double kClosed_mm = 1e-11;  // of legs of some 500 mm: a few roundings
constexpr double kAccepted_mm = 1e-10;
constexpr double kSingular = 1e-7;  // |determinant| of the legs' lines, turns per half a metre
constexpr double kLever_mm = 200.0;
constexpr double kLongestTurn_rad = 0.3;

struct Home {
  Pose<double> X;
};

/// What leg i lacks: its length at X, moved by a small shift and turn, less what it is told.
template <typename T>
T lacking(
    const Eigen::Matrix<T, 3, 1>& b, const Eigen::Matrix<T, 3, 1>& p, const T& leg,
    const Pose<T>& X) {
  using std::sqrt;
  const Eigen::Matrix<T, 3, 1> along = X.p + X.R * p - b;
  return sqrt(along.dot(along)) - leg;
}

template <typename T>
Eigen::Matrix<T, 3, 1> triple(std::span<const double> v, std::size_t first) {
  return {T(v[first]), T(v[first + 1]), T(v[first + 2])};
}

/// Closure of all legs at X, and its derivative by a shift and a turn of the platform in W.
void closure(
    std::span<const double> v, std::span<const double> q, const Pose<double>& X, Vector6& g,
    Matrix6& by_X) {
  using D = Dual<6>;
  const Eigen::Matrix<D, 3, 1> shift(D(0.0, 0), D(0.0, 1), D(0.0, 2));
  const Eigen::Matrix<D, 3, 1> turn(D(0.0, 3), D(0.0, 4), D(0.0, 5));
  Pose<D> moved;
  moved.p = X.p.cast<D>() + shift;
  moved.R = turned_by<D>(turn) * X.R.cast<D>();
  for (std::size_t i = 0; i < kLegs; ++i) {
    const D lacks = lacking<D>(
        triple<D>(v, 3 * i), triple<D>(v, kPlatform + 3 * i), D(q[i] + v[kLeg + i]), moved);
    const auto row = static_cast<Eigen::Index>(i);
    g[row] = lacks.value;
    for (int k = 0; k < 6; ++k) by_X(row, k) = lacks.d[k];
  }
}

/// Newton's steps from the middle pose, halved where they would not close the legs further.
Reached close_legs(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Pose<double>& X, Matrix6& by_X) {
  for (const double each : v) {
    if (!std::isfinite(each)) return tl::unexpected(KinematicTrouble::kBadParameters);
  }
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!(q[i] + v[kLeg + i] > 0.0)) return tl::unexpected(KinematicTrouble::kBadParameters);
  }
  X = static_cast<const Home*>(robot.details.get())->X;
  Vector6 g;
  closure(v, q, X, g, by_X);
  for (int step = 0; step < kSteps && g.cwiseAbs().maxCoeff() > kClosed_mm; ++step) {
    const Vector6 move = by_X.partialPivLu().solve(-g);
    const double turn = move.tail<3>().norm();
    double part = turn > kLongestTurn_rad ? kLongestTurn_rad / turn : 1.0;
    const double before = g.norm();
    Pose<double> next;
    do {
      next.p = X.p + part * move.head<3>();
      next.R = turned_by<double>(Eigen::Vector3d(part * move.tail<3>())) * X.R;
      closure(v, q, next, g, by_X);
      part /= 2.0;
    } while (!(g.norm() < before) && part > 1e-4);
    if (!(g.norm() < before)) {
      closure(v, q, X, g, by_X);
      break;
    }
    X = next;
  }
  if (!(g.cwiseAbs().maxCoeff() < kAccepted_mm)) {
    return tl::unexpected(KinematicTrouble::kOutOfReach);
  }
  // Rounding of many small turns.
  Eigen::Matrix3d& R = X.R;
  R = (1.5 * R - 0.5 * R * R.transpose() * R).eval();
  Matrix6 lines = by_X;
  lines.rightCols<3>() /= kLever_mm;
  if (!(std::abs(lines.determinant()) > kSingular)) {
    return tl::unexpected(KinematicTrouble::kStretched);
  }
  return {};
}

Reached frames_of(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Assembly /*assembly*/, std::span<Pose<double>> X) {
  Matrix6 by_X;
  const auto closed = close_legs(robot, v, q, X[0], by_X);
  if (!closed) return closed;
  X[1] = {Eigen::Vector3d(v[0], v[1], v[2]), Eigen::Matrix3d::Identity()};
  return {};
}

/// The implicit function theorem: the legs stay closed, g(X, v, q) = 0, so dX = -g_X^-1 g_v dv.
Reached frame_derivatives(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Assembly assembly, Frames& at) {
  if (const auto closed = frames_of(robot, v, q, assembly, at.X); !closed) return closed;
  Vector6 g;
  Matrix6 by_X;
  closure(v, q, at.X[0], g, by_X);
  const Matrix6 back = by_X.inverse();
  using D = Dual<7>;
  const Pose<D> X{at.X[0].p.cast<D>(), at.X[0].R.cast<D>()};
  for (std::size_t i = 0; i < kLegs; ++i) {
    Eigen::Matrix<D, 3, 1> b;
    Eigen::Matrix<D, 3, 1> p;
    for (int k = 0; k < 3; ++k) {
      const auto at_k = static_cast<std::size_t>(k);
      b[k] = D(v[3 * i + at_k], k);
      p[k] = D(v[kPlatform + 3 * i + at_k], 3 + k);
    }
    const D lacks = lacking<D>(b, p, D(q[i] + v[kLeg + i], 6), X);
    const Vector6 by_leg = -back.col(static_cast<Eigen::Index>(i));
    for (int k = 0; k < 3; ++k) {
      const auto first = static_cast<Eigen::Index>(3 * i) + k;
      at.by_v[0].col(first) = lacks.d[k] * by_leg;
      at.by_v[0].col(static_cast<Eigen::Index>(kPlatform) + first) = lacks.d[3 + k] * by_leg;
    }
    at.by_v[0].col(static_cast<Eigen::Index>(kLeg + i)) = lacks.d[6] * by_leg;
    at.by_q[0].col(static_cast<Eigen::Index>(i)) = lacks.d[6] * by_leg;
  }
  at.by_v[1].topLeftCorner<3, 3>().setIdentity();
  return {};
}

tl::expected<Eigen::VectorXd, KinematicTrouble> joints_at(
    const RobotModel& robot, std::span<const double> v, const Pose<double>& X_WE,
    WorkingMode /*mode*/, std::span<const double> /*near*/) {
  Pose<double> X = X_WE;
  if (!X.R.allFinite()) X.R = static_cast<const Home*>(robot.details.get())->X.R;
  Eigen::VectorXd q(kLegs);
  for (std::size_t i = 0; i < kLegs; ++i) {
    q[static_cast<Eigen::Index>(i)] = lacking<double>(
        triple<double>(v, 3 * i), triple<double>(v, kPlatform + 3 * i), v[kLeg + i], X);
  }
  return q;
}

std::shared_ptr<const RobotModel> with_home(const Home& home) {
  RobotModel robot;
  robot.kind = &stewart;
  robot.axes = 3;
  robot.frames = {"E", "base1"};
  robot.nominal = Eigen::VectorXd::Zero(kCount);
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  const auto points = [&](const std::string& of, const std::string& meaning) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      const std::string number = std::to_string(i + 1);
      for (const char* const axis : kAxes) {
        robot.parameters.push_back(
            length_row(of + number + '_' + axis, meaning + number + ", along " + axis));
        robot.parameters.back().grows = true;
      }
    }
  };
  points("base", "base joint of leg ");
  points("platform", "platform joint of leg ");
  for (std::size_t i = 0; i < kLegs; ++i) {
    const std::string number = std::to_string(i + 1);
    robot.parameters.push_back(length_row("leg" + number, "zero of leg " + number));
    // Pairs of joints on the base, between them pairs on the platform.
    constexpr double kPair_rad = 0.2;
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const std::size_t base_pair = (i + 1) / 2;
    const std::size_t platform_pair = i / 2;
    const double on_base =
        static_cast<double>(base_pair) * 2 * std::numbers::pi / 3 + side * kPair_rad;
    const double on_platform = static_cast<double>(platform_pair) * 2 * std::numbers::pi / 3 +
                               std::numbers::pi / 3 - side * kPair_rad;
    const auto k = static_cast<Eigen::Index>(3 * i);
    robot.nominal.segment<3>(k) << 250 * std::cos(on_base), 250 * std::sin(on_base), 0;
    robot.nominal.segment<3>(static_cast<Eigen::Index>(kPlatform) + k)
        << 150 * std::cos(on_platform),
        150 * std::sin(on_platform), 0;
    robot.joints.push_back({"q" + number, JointKind::kPrismatic, 390.0, 460.0});
  }
  robot.assemblies = {{+1, "from the middle pose"}};
  robot.modes = {{0, "the one"}};
  robot.details = std::make_shared<const Home>(home);
  return std::make_shared<const RobotModel>(std::move(robot));
}

std::shared_ptr<const RobotModel> example() {
  static const auto model =
      with_home({{Eigen::Vector3d(0, 0, 380), Eigen::Matrix3d::Identity()}});
  return model;
}

constexpr std::array<std::string_view, 2> kFileKeys{"home_mm", "home_turn_deg"};

tl::expected<std::shared_ptr<const RobotModel>, RobotFileFault> from_file(
    const RobotFile& file) {
  Home home{{Eigen::Vector3d(0, 0, 380), Eigen::Matrix3d::Identity()}};
  for (const std::string_view key : kFileKeys) {
    const auto at = file.robot.find(key);
    if (at == file.robot.end()) continue;
    const auto* list = std::get_if<std::vector<FileValue>>(&at->second.value);
    Eigen::Vector3d value;
    bool good = list != nullptr && list->size() == 3;
    for (std::size_t i = 0; good && i < 3; ++i) {
      const double* number = std::get_if<double>(&(*list)[i].value);
      good = number != nullptr && std::isfinite(*number);
      if (good) value[static_cast<Eigen::Index>(i)] = *number;
    }
    if (!good) {
      return tl::unexpected(RobotFileFault{
          std::string(key), "is not a list of three numbers", "write [x, y, z]"});
    }
    if (key == kFileKeys[0]) {
      home.X.p = value;
    } else {
      home.X.R = turned_by<double>(Eigen::Vector3d(value * kRadPerDeg));
    }
  }
  return with_home(home);
}

RobotFileText to_file(const RobotModel& robot, const Eigen::VectorXd& /*nominal*/) {
  const auto& X = static_cast<const Home*>(robot.details.get())->X;
  const Eigen::Vector3d turn = rotation_vector(X.R);
  const auto list = [](const Eigen::Vector3d& value) {
    return FileValue{std::vector<FileValue>{{value[0]}, {value[1]}, {value[2]}}};
  };
  RobotFileText out;
  out.robot["home_mm"] = list(X.p);
  out.robot["home_turn_deg"] = list(turn);
  return out;
}

}  // namespace

extern constinit const RobotKind stewart{
    .name = "stewart",
    .in_words = "platform on six legs",
    .has_passive_joints = true,
    .example = example,
    .from_file = from_file,
    .file_keys = kFileKeys,
    .to_file = to_file,
    .forward = frames_of,
    .forward_derivative = frame_derivatives,
    .inverse = joints_at,
};

}  // namespace sixdial::geometry
