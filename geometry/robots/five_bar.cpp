#include "geometry/robots/five_bar.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/units.h"

namespace sixdial::geometry {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAngle_rad = 1.0 / 60.0;  // moves the end of a 60 mm link by one millimetre

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }
Vector2d turned_left(const Vector2d& a) { return {-a.y(), a.x()}; }

bool usable(const ParameterVector& v) { return v.allFinite() && v.head<4>().minCoeff() > 0.0; }

struct Closure {  // all in frame B
  Vector2d p_O3, p_O4, p_E;
};

tl::expected<Closure, KinematicTrouble> close_loop(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  if (!usable(v) || !q.allFinite()) return tl::unexpected(KinematicTrouble::kBadParameters);
  const double a1 = q[0] + v[kOffset1];
  const double a2 = q[1] + v[kOffset2];
  const Vector2d p_O3(v[kL11] * std::cos(a1) - v[kD] / 2, v[kL11] * std::sin(a1));  // (4)
  const Vector2d p_O4(v[kL21] * std::cos(a2) + v[kD] / 2, v[kL21] * std::sin(a2));  // (5)
  const Vector2d w = p_O4 - p_O3;
  const double D2 = w.squaredNorm();
  const double la = v[kL12];
  const double lb = v[kL22];
  const double D = std::sqrt(D2);  // (6)
  if (D <= 1e-12 * (la + lb)) return tl::unexpected(KinematicTrouble::kCoincidentElbows);
  // 16 sigma^2 factored so that no digits are lost near stretched and folded (7).
  const double sixteen_sigma2 = (D + la + lb) * (D + la - lb) * (D - la + lb) * (la + lb - D);
  if (sixteen_sigma2 < 0.0) return tl::unexpected(KinematicTrouble::kOutOfReach);
  const double sigma = std::sqrt(sixteen_sigma2) / 4;
  if (2 * sigma < kSingularSine * la * lb) {
    return tl::unexpected(
        D > std::max(la, lb) ? KinematicTrouble::kStretched : KinematicTrouble::kFolded);
  }
  const double beta = static_cast<double>(assembly);
  const Vector2d p_E = (p_O3 + p_O4) / 2 + (la - lb) * (la + lb) / (2 * D2) * w +
                       beta * 2 * sigma / D2 * turned_left(w);  // (3)
  return Closure{p_O3, p_O4, p_E};
}

Matrix2d rotation(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return (Matrix2d() << c, -s, s, c).finished();
}

ForwardPose in_world(const ParameterVector& v, const Closure& closure) {
  const Matrix2d R_WB = rotation(v[kAlpha]);
  const Vector2d p_WB(v[kX0], v[kY0]);
  return {
      p_WB + R_WB * closure.p_E, p_WB + R_WB * closure.p_O3,
      p_WB + R_WB * closure.p_O4};  // (1)
}

}  // namespace

namespace {

constexpr double kMade_mm = 1.0;      // what a workshop keeps
constexpr double kPut_mm = 2.0;       // how well a robot is put onto its table
constexpr double kTurned_rad = 0.03;  // and turned, and its encoders zeroed

ParameterInfo with_words(
    ParameterInfo info, double known_to, const char* meaning, const char* plainly) {
  info.known_to = known_to;
  info.meaning = meaning;
  info.plainly = plainly;
  return info;
}

ParameterInfo link(
    const char* name, const char* rig_key, const char* meaning, const char* plainly) {
  ParameterInfo info = with_words(
      {name, rig_key, "mm", 1.0, "mm", 1.0, FileRange::kPositive}, kMade_mm, meaning, plainly);
  info.grows = true;
  return info;
}
ParameterInfo stand(
    const char* name, const char* rig_key, const char* meaning, const char* plainly) {
  return with_words({name, rig_key, "mm", 1.0, "mm", 1.0}, kPut_mm, meaning, plainly);
}
ParameterInfo turn(
    const char* name, const char* rig_key, const char* meaning, const char* plainly) {
  return with_words(
      {name, rig_key, "deg", kDegPerRad, "rad", kAngle_rad}, kTurned_rad, meaning, plainly);
}

std::array<ParameterInfo, kParameterCount> parameters() {
  return {
      link("l11", "l11_mm", "proximal link of leg 1", "motor link, leg 1"),
      link("l12", "l12_mm", "distal link of leg 1", "far link, leg 1"),
      link("l21", "l21_mm", "proximal link of leg 2", "motor link, leg 2"),
      link("l22", "l22_mm", "distal link of leg 2", "far link, leg 2"),
      with_words(
          {"d", "d_mm", "mm", 1.0, "mm", 1.0, FileRange::kNotNegative}, kMade_mm,
          "distance of the motor axes", "between the motors"),
      stand("x0", "x0_mm", "base, along x", "robot stands at x"),
      stand("y0", "y0_mm", "base, along y", "robot stands at y"),
      turn("alpha", "alpha_deg", "base, rotation", "robot turned by"),
      turn("dtheta1", "theta1_offset_deg", "encoder offset of joint 1", "zero of encoder 1"),
      turn("dtheta2", "theta2_offset_deg", "encoder offset of joint 2", "zero of encoder 2")};
}

}  // namespace

const std::array<ParameterInfo, kParameterCount> kParameters = parameters();

std::string to_string(WorkingMode mode) {
  return {mode.leg(0) > 0 ? '+' : '-', mode.leg(1) > 0 ? '+' : '-'};
}

std::optional<WorkingMode> working_mode_from(std::string_view text) {
  for (const WorkingMode mode : kWorkingModes) {
    if (to_string(mode) == text) return mode;
  }
  return std::nullopt;
}

double ForwardPose::distal_angle(int leg) const {
  const Vector2d u = p_WE - (leg == 0 ? p_WO3 : p_WO4);
  return std::atan2(u.y(), u.x());
}

tl::expected<ForwardPose, KinematicTrouble> forward(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  return close_loop(v, q, assembly).map([&](const Closure& c) { return in_world(v, c); });
}

tl::expected<ForwardDerivative, KinematicTrouble> forward_derivative(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  const auto closure = close_loop(v, q, assembly);
  if (!closure) return tl::unexpected(closure.error());
  const auto& [p_O3, p_O4, p_E] = *closure;
  const Vector2d u1 = p_E - p_O3;
  const Vector2d u2 = p_E - p_O4;
  const Vector2d unit1 = turned_left(p_O3 + Vector2d(v[kD] / 2, 0.0));  // dO3/dtheta1
  const Vector2d unit2 = turned_left(p_O4 - Vector2d(v[kD] / 2, 0.0));  // dO4/dtheta2

  // Differentiating (2): u1'(dE - dO3) = l12 dl12, u2'(dE - dO4) = l22 dl22.
  const double det = cross(u1, u2);
  Matrix2d A_inverse;
  A_inverse << u2.y(), -u1.y(), -u2.x(), u1.x();
  A_inverse /= det;

  Eigen::Matrix<double, 2, kParameterCount> dO3 = decltype(dO3)::Zero();
  Eigen::Matrix<double, 2, kParameterCount> dO4 = decltype(dO4)::Zero();
  dO3.col(kL11) = (p_O3 + Vector2d(v[kD] / 2, 0.0)) / v[kL11];
  dO3.col(kD) = Vector2d(-0.5, 0.0);
  dO3.col(kOffset1) = unit1;
  dO4.col(kL21) = (p_O4 - Vector2d(v[kD] / 2, 0.0)) / v[kL21];
  dO4.col(kD) = Vector2d(0.5, 0.0);
  dO4.col(kOffset2) = unit2;
  Eigen::Matrix<double, 2, kParameterCount> right;
  right.row(0) = u1.transpose() * dO3;
  right.row(1) = u2.transpose() * dO4;
  right(0, kL12) += v[kL12];
  right(1, kL22) += v[kL22];
  const ParameterJacobian dE = A_inverse * right;

  ForwardDerivative result;
  result.pose = in_world(v, *closure);
  const Matrix2d R_WB = rotation(v[kAlpha]);
  result.J_v = R_WB * dE;
  result.J_v(0, kX0) = 1.0;
  result.J_v(1, kY0) = 1.0;
  result.J_v.col(kAlpha) = turned_left(R_WB * p_E);
  result.J_q << result.J_v.col(kOffset1), result.J_v.col(kOffset2);

  // Angle of u: d(atan2) = cross(u, du) / |u|^2; alpha turns both.
  result.distal_J_v.row(0) =
      (u1.x() * (dE - dO3).row(1) - u1.y() * (dE - dO3).row(0)) / u1.squaredNorm();
  result.distal_J_v.row(1) =
      (u2.x() * (dE - dO4).row(1) - u2.y() * (dE - dO4).row(0)) / u2.squaredNorm();
  result.distal_J_v.col(kAlpha).setOnes();
  result.distal_J_q << result.distal_J_v.col(kOffset1), result.distal_J_v.col(kOffset2);
  return result;
}

tl::expected<Vector2d, KinematicTrouble> inverse(
    const ParameterVector& v, const Vector2d& p_WE, WorkingMode mode,
    std::optional<Vector2d> near) {
  if (!usable(v) || !p_WE.allFinite()) return tl::unexpected(KinematicTrouble::kBadParameters);
  const Vector2d p_BE = rotation(-v[kAlpha]) * (p_WE - Vector2d(v[kX0], v[kY0]));
  Vector2d q;
  for (int leg = 0; leg < 2; ++leg) {
    const double la = leg == 0 ? v[kL11] : v[kL21];
    const double lb = leg == 0 ? v[kL12] : v[kL22];
    const double base_x = (leg == 0 ? -0.5 : 0.5) * v[kD];
    const Vector2d to_E = p_BE - Vector2d(base_x, 0.0);
    const double r = to_E.norm();
    const double sixteen_sigma2 = (r + la + lb) * (r + la - lb) * (r - la + lb) * (la + lb - r);
    if (sixteen_sigma2 < 0.0) return tl::unexpected(KinematicTrouble::kOutOfReach);
    const double twice_sigma = std::sqrt(sixteen_sigma2) / 2;
    if (twice_sigma < kSingularSine * la * lb) {
      return tl::unexpected(
          r > std::max(la, lb) ? KinematicTrouble::kStretched : KinematicTrouble::kFolded);
    }
    // acos((la^2 + r^2 - lb^2)/(2 la r)) as an atan2, which keeps its digits near 0 and pi.
    const double inner = std::atan2(twice_sigma, (la * la + r * r - lb * lb) / 2);
    const double side = mode.leg(leg);
    double angle = std::atan2(to_E.y(), to_E.x()) + side * inner;
    angle = std::remainder(angle, 2 * std::numbers::pi) - v[kOffset1 + leg];
    if (near) {
      angle +=
          2 * std::numbers::pi * std::round(((*near)[leg] - angle) / (2 * std::numbers::pi));
    }
    q[leg] = angle;
  }
  return q;
}

tl::expected<Assembly, KinematicTrouble> assembly_at(
    const ParameterVector& v, const Vector2d& q, const Vector2d& p_WE) {
  const auto left = forward(v, q, Assembly::kLeft);
  if (!left) return tl::unexpected(left.error());
  const auto right = forward(v, q, Assembly::kRight);
  if (!right) return tl::unexpected(right.error());
  return (left->p_WE - p_WE).squaredNorm() <= (right->p_WE - p_WE).squaredNorm()
             ? Assembly::kLeft
             : Assembly::kRight;
}

tl::expected<WorkingMode, KinematicTrouble> working_mode_of(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  const auto closure = close_loop(v, q, assembly);
  if (!closure) return tl::unexpected(closure.error());
  const Vector2d half_base(v[kD] / 2, 0.0);
  const double side1 = cross(closure->p_E + half_base, closure->p_O3 + half_base);
  const double side2 = cross(closure->p_E - half_base, closure->p_O4 - half_base);
  return WorkingMode{side1 >= 0 ? +1 : -1, side2 >= 0 ? +1 : -1};
}

namespace {

enum Frame : std::size_t { kTool, kDistal1, kDistal2, kFrames };

ParameterVector vector_of(std::span<const double> v) {
  return Eigen::Map<const ParameterVector>(v.data());
}

/// d(p_WO3)/dv or d(p_WO4)/dv, 2x10, from equations (4), (5) and (1).
ParameterJacobian elbow_derivative(
    const ParameterVector& v, const ForwardPose& pose, const Vector2d& q, int leg) {
  const int link = leg == 0 ? kL11 : kL21;
  const double angle = v[kAlpha] + q[leg] + v[kOffset1 + leg];
  const Vector2d along(std::cos(angle), std::sin(angle));
  ParameterJacobian J = ParameterJacobian::Zero();
  J.col(link) = along;
  J.col(kD) = (leg == 0 ? -0.5 : 0.5) * Vector2d(std::cos(v[kAlpha]), std::sin(v[kAlpha]));
  J(0, kX0) = 1.0;
  J(1, kY0) = 1.0;
  J.col(kAlpha) = turned_left((leg == 0 ? pose.p_WO3 : pose.p_WO4) - Vector2d(v[kX0], v[kY0]));
  J.col(kOffset1 + leg) = v[link] * turned_left(along);
  return J;
}

Eigen::Matrix3d about_z(double cosine, double sine) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() << cosine, -sine, sine, cosine;
  return R;
}

/// The tool is a pin: it turns with no link, so its frame is turned as B. A distal frame sits
/// at its elbow, x towards E.
void write_frames(
    const ParameterVector& v, const ForwardPose& pose, std::span<Pose<double>> X) {
  X[kTool].p << pose.p_WE, 0.0;
  X[kTool].R = about_z(std::cos(v[kAlpha]), std::sin(v[kAlpha]));
  const auto distal = [&](Frame frame, const Vector2d& p_WO) {
    const Vector2d along = (pose.p_WE - p_WO).normalized();
    X[frame].p << p_WO, 0.0;
    X[frame].R = about_z(along.x(), along.y());
  };
  distal(kDistal1, pose.p_WO3);
  distal(kDistal2, pose.p_WO4);
}

Reached frames_of(
    const RobotModel& /*robot*/, std::span<const double> v, std::span<const double> q,
    Assembly assembly, std::span<Pose<double>> X) {
  const ParameterVector at = vector_of(v);
  const auto pose = forward(at, {q[0], q[1]}, assembly);
  if (!pose) return tl::unexpected(pose.error());
  write_frames(at, *pose, X);
  return {};
}

Reached frame_derivatives(
    const RobotModel& /*robot*/, std::span<const double> v, std::span<const double> q,
    Assembly assembly, Frames& at) {
  const ParameterVector values = vector_of(v);
  const auto d = forward_derivative(values, {q[0], q[1]}, assembly);
  if (!d) return tl::unexpected(d.error());
  write_frames(values, d->pose, at.X);
  // What is not written here is zero from the start and never written: z, turns out of the
  // plane.
  at.by_v[kTool].topRows<2>() = d->J_v;
  at.by_q[kTool].topRows<2>() = d->J_q;
  at.by_v[kTool](5, kAlpha) = 1.0;
  for (const int leg : {0, 1}) {
    const std::size_t frame = leg == 0 ? kDistal1 : kDistal2;
    at.by_v[frame].topRows<2>() = elbow_derivative(values, d->pose, {q[0], q[1]}, leg);
    at.by_v[frame].row(5) = d->distal_J_v.row(leg);
    at.by_q[frame].col(leg) = at.by_v[frame].col(kOffset1 + leg);
    at.by_q[frame].row(5) = d->distal_J_q.row(leg);
  }
  return {};
}

tl::expected<Eigen::VectorXd, KinematicTrouble> joints_at(
    const RobotModel& /*robot*/, std::span<const double> v, const Pose<double>& X_WE,
    WorkingMode mode, std::span<const double> near) {
  std::optional<Vector2d> turns;
  if (!near.empty()) turns = Vector2d(near[0], near[1]);
  const auto q = inverse(vector_of(v), X_WE.p.head<2>(), mode, turns);
  if (!q) return tl::unexpected(q.error());
  return Eigen::VectorXd(*q);
}

tl::expected<WorkingMode, KinematicTrouble> mode_at(
    const RobotModel& /*robot*/, std::span<const double> v, std::span<const double> q,
    Assembly assembly) {
  return working_mode_of(vector_of(v), {q[0], q[1]}, assembly);
}

tl::expected<PlanarPose, KinematicTrouble> pose_in_plane(
    const RobotModel& /*robot*/, std::span<const double> v, std::span<const double> q,
    Assembly assembly, std::optional<int> link, Eigen::Matrix2Xd* J_q) {
  const ParameterVector values = vector_of(v);
  const Vector2d angles(q[0], q[1]);
  const auto seen = [&](const ForwardPose& pose) {
    return PlanarPose{
        pose.p_WE, link ? pose.distal_angle(*link == static_cast<int>(kDistal1) ? 0 : 1) : 0.0};
  };
  if (J_q == nullptr) return forward(values, angles, assembly).map(seen);
  const auto d = forward_derivative(values, angles, assembly);
  if (!d) return tl::unexpected(d.error());
  *J_q = d->J_q;
  return seen(d->pose);
}

/// Motors, elbows and tool with the tool at p_WE.
Sketch drawn(
    const RobotModel& /*robot*/, std::span<const double> values, const Vector2d& p_WE,
    WorkingMode mode) {
  const ParameterVector v = vector_of(values);
  Sketch sketch;
  sketch.base = {v[kX0], v[kY0]};
  sketch.base_rad = v[kAlpha];
  const auto pose = inverse(v, p_WE, mode).and_then([&](const Vector2d& q) {
    return assembly_at(v, q, p_WE).and_then([&](Assembly assembly) {
      return forward(v, q, assembly);
    });
  });
  if (!pose) {
    sketch.trouble = pose.error();
    return sketch;
  }
  const Vector2d along(std::cos(v[kAlpha]), std::sin(v[kAlpha]));
  const Vector2d O1 = sketch.base + (-v[kD] / 2) * along;
  const Vector2d O2 = sketch.base + (v[kD] / 2) * along;
  using Part = Sketch::Part;
  sketch.lines = {
      {O1, O2, Part::kBase},
      {O1, pose->p_WO3, Part::kProximal},
      {O2, pose->p_WO4, Part::kProximal},
      {pose->p_WO3, pose->p_WE, Part::kDistal},
      {pose->p_WO4, pose->p_WE, Part::kDistal}};
  sketch.dots = {
      {O1, Part::kMotor, "O1, motor 1", {-7, -3}, "end"},
      {O2, Part::kMotor, "O2, motor 2", {7, -3}, "start"},
      {pose->p_WO3, Part::kJoint, "O3", {0, 5}, "middle"},
      {pose->p_WO4, Part::kJoint, "O4", {0, 5}, "middle"},
      {pose->p_WE, Part::kTool, "E tool", {5, 3}, "start"}};
  return sketch;
}

std::shared_ptr<const RobotModel> make_model() {
  RobotModel robot;
  robot.kind = &five_bar;
  robot.joints = {
      {"theta1", JointKind::kRevolute, 0.5, 2.6}, {"theta2", JointKind::kRevolute, 0.5, 2.6}};
  const auto all = parameters();
  robot.parameters.assign(all.begin(), all.end());
  robot.nominal = Eigen::VectorXd::Zero(kParameterCount);
  robot.nominal.head<5>() << 60, 60, 60, 60, 90;
  robot.frames = {"E", "distal1", "distal2"};
  robot.assemblies = {{+1, "left"}, {-1, "right"}};
  for (const WorkingMode mode : kWorkingModes) {
    robot.modes.push_back({mode.number, to_string(mode)});
  }
  robot.mode_in_words = "the elbow side of leg 1 and leg 2";
  // Coaxial motors: the whole robot turned in its frame is the frame turned.
  robot.named_directions = {
      {{{"alpha", 1.0}, {"dtheta1", -1.0}, {"dtheta2", -1.0}},
       "the frame's rotation against a common shift of both motors, exact where d = 0"}};
  return std::make_shared<const RobotModel>(std::move(robot));
}

}  // namespace

const std::shared_ptr<const RobotModel>& five_bar_model() {
  static const std::shared_ptr<const RobotModel> model = make_model();
  return model;
}

extern constinit const RobotKind five_bar{
    .name = "five_bar",
    .in_words = "planar five-bar",
    .has_passive_joints = true,
    .example = [] { return five_bar_model(); },
    .forward = frames_of,
    .forward_derivative = frame_derivatives,
    .inverse = joints_at,
    .mode_of = mode_at,
    .in_plane = pose_in_plane,
    .sketch = drawn,
};

}  // namespace sixdial::geometry
