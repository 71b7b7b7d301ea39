#include "geometry/instruments/contact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace sixdial::geometry {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalfPi = std::numbers::pi / 2;
// An axis within half a degree of a face's plane cannot measure it.
constexpr double kLeastCosine = 0.00873;

Vector2d unit(double angle) { return {std::cos(angle), std::sin(angle)}; }

Vector2d ball_centre(const DialGeometry& dial, double displacement_mm) {
  return dial.position_mm - (dial.tip_radius_mm + displacement_mm) * dial.axis;
}

bool neighbours(int face_a, int face_b) { return (face_a - face_b) % 2 != 0; }

struct Equations {
  Eigen::Matrix<double, Eigen::Dynamic, 3> J;
  Eigen::VectorXd r;  // measured - computed
};

Equations linearise(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings,
    std::span<const int> faces, const CuboidPose& pose, double side_mm) {
  const auto n = static_cast<Eigen::Index>(readings.size());
  Equations result{Eigen::Matrix<double, Eigen::Dynamic, 3>(n, 3), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const DialReading& reading = readings[static_cast<std::size_t>(i)];
    const Contact contact = contact_on_face(
        dials[static_cast<std::size_t>(reading.dial)], pose, side_mm,
        faces[static_cast<std::size_t>(i)]);
    result.J.row(i) = contact.J;
    result.r[i] = reading.displacement_mm - contact.displacement_mm;
  }
  return result;
}

std::vector<int> faces_of(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings,
    double gamma_rad) {
  std::vector<int> faces;
  faces.reserve(readings.size());
  for (const DialReading& reading : readings) {
    faces.push_back(face_towards(dials[static_cast<std::size_t>(reading.dial)], gamma_rad));
  }
  return faces;
}

PoseEstimate estimate_of(
    const CuboidPose& pose, const Matrix3d& covariance, std::span<const DialReading> readings,
    const Eigen::VectorXd& residual) {
  PoseEstimate result{pose, covariance, {}, {}};
  for (std::size_t i = 0; i < readings.size(); ++i) {
    result.dials.push_back(readings[i].dial);
    result.residual_mm.push_back(residual[static_cast<Eigen::Index>(i)]);
  }
  return result;
}

}  // namespace

std::string_view describe(ContactTrouble trouble) {
  switch (trouble) {
    case ContactTrouble::kNoTouch:
      return "the cuboid is out of the plunger's reach";
    case ContactTrouble::kBeyondTravel:
      return "the cuboid is closer than the plunger's travel allows";
    case ContactTrouble::kOffFace:
      return "the tip misses the face";
    case ContactTrouble::kAlongFace:
      return "no face looks at the dial";
  }
  return "unknown contact trouble";
}

std::string_view describe(PoseTrouble trouble) {
  switch (trouble) {
    case PoseTrouble::kTooFewContacts:
      return "fewer than two dials on one face and one on a neighbouring face";
    case PoseTrouble::kCoincidentBalls:
      return "the two dials of one face touch it in the same point";
    case PoseTrouble::kNotConverged:
      return "the readings contradict each other";
  }
  return "unknown pose trouble";
}

Vector2d face_normal(int face, const Vector2d& heading) {
  switch (face & 3) {
    case 0:
      return heading;
    case 1:
      return {-heading.y(), heading.x()};
    case 2:
      return -heading;
    default:
      return {heading.y(), -heading.x()};
  }
}
Vector2d face_normal(int face, double gamma_rad) { return face_normal(face, unit(gamma_rad)); }

int face_towards(const DialGeometry& dial, const Vector2d& heading) {
  const double right = -dial.axis.dot(heading);
  const double top = dial.axis.x() * heading.y() - dial.axis.y() * heading.x();
  if (std::abs(right) >= std::abs(top)) return right >= 0 ? 0 : 2;
  return top > 0 ? 1 : 3;
}
int face_towards(const DialGeometry& dial, double gamma_rad) {
  return face_towards(dial, unit(gamma_rad));
}

double displacement_on_face(
    const DialGeometry& dial, const Vector2d& p_WE, double side_mm, const Vector2d& normal) {
  return (side_mm / 2 + dial.tip_radius_mm - (ball_centre(dial, 0.0) - p_WE).dot(normal)) /
         -dial.axis.dot(normal);
}

Contact contact_on_face(
    const DialGeometry& dial, const CuboidPose& pose, double side_mm, int face) {
  const Vector2d n = face_normal(face, pose.gamma_rad);
  const Vector2d t(-n.y(), n.x());  // dn/dgamma
  const Vector2d p_ET = ball_centre(dial, 0.0) - pose.p_WE;
  const double cosine = -dial.axis.dot(n);
  Contact contact;
  contact.face = face;
  contact.displacement_mm = (side_mm / 2 + dial.tip_radius_mm - p_ET.dot(n)) / cosine;
  contact.along_mm = (p_ET - contact.displacement_mm * dial.axis).dot(t);
  contact.J << n.x() / cosine, n.y() / cosine, -contact.along_mm / cosine;
  return contact;
}

tl::expected<Contact, ContactTrouble> touch(
    const DialGeometry& dial, const CuboidPose& pose, double side_mm) {
  const int face = face_towards(dial, pose.gamma_rad);
  if (-dial.axis.dot(face_normal(face, pose.gamma_rad)) < kLeastCosine) {
    return tl::unexpected(ContactTrouble::kAlongFace);
  }
  const Contact contact = contact_on_face(dial, pose, side_mm, face);
  if (std::abs(contact.along_mm) > side_mm / 2) {
    return tl::unexpected(ContactTrouble::kOffFace);
  }
  if (!(contact.displacement_mm > 0.0)) return tl::unexpected(ContactTrouble::kNoTouch);
  if (contact.displacement_mm >= dial.travel_mm) {
    return tl::unexpected(ContactTrouble::kBeyondTravel);
  }
  return contact;
}

CuboidPose equation_39(
    const Vector2d& position_B_mm, const Vector2d& position_C_mm, const Vector2d& position_D_mm,
    double displacement_B_mm, double displacement_C_mm, double displacement_D_mm,
    double side_mm) {
  const double xB = position_B_mm.x(), yB = position_B_mm.y();
  const double xC = position_C_mm.x(), yC = position_C_mm.y();
  const double xD = position_D_mm.x();
  const double db = displacement_B_mm, dc = displacement_C_mm, dd = displacement_D_mm;
  const double gamma = std::atan2(dc - dd, xD - xC);
  Matrix2d A;
  A << dc - dd, xC - xD, xD - xC, dc - dd;
  const Vector2d right(xC * (yC - dd) - xD * (yC - dc), (xB - db) * (xD - xC) + yB * (dc - dd));
  const Vector2d corner = A.inverse() * right;
  const Vector2d half_diagonal(
      side_mm / 2 * (std::cos(gamma) - std::sin(gamma)),
      side_mm / 2 * (std::cos(gamma) + std::sin(gamma)));
  return {corner + half_diagonal, gamma};
}

tl::expected<PoseEstimate, PoseTrouble> active_three(
    std::span<const DialGeometry> dials, const std::array<DialReading, 3>& pair_then_single,
    double side_mm, double gamma_guess_rad) {
  const auto& [first, second, single] = pair_then_single;
  const DialGeometry& dial_1 = dials[static_cast<std::size_t>(first.dial)];
  const DialGeometry& dial_2 = dials[static_cast<std::size_t>(second.dial)];
  const DialGeometry& dial_3 = dials[static_cast<std::size_t>(single.dial)];
  const int face = face_towards(dial_1, gamma_guess_rad);
  const int other = face_towards(dial_3, gamma_guess_rad);
  if (face != face_towards(dial_2, gamma_guess_rad) || !neighbours(face, other)) {
    return tl::unexpected(PoseTrouble::kTooFewContacts);
  }
  const Vector2d c1 = ball_centre(dial_1, first.displacement_mm);
  const Vector2d c2 = ball_centre(dial_2, second.displacement_mm);
  const Vector2d c3 = ball_centre(dial_3, single.displacement_mm);
  // (c1 - c2) . n = rho1 - rho2 fixes n up to the side, which the guess settles.
  const Vector2d v = c1 - c2;
  const double length = v.norm();
  const double step = dial_1.tip_radius_mm - dial_2.tip_radius_mm;
  if (length <= std::abs(step) || length < 1e-6) {
    return tl::unexpected(PoseTrouble::kCoincidentBalls);
  }
  const double towards_v = std::atan2(v.y(), v.x());
  const double inner = std::acos(step / length);
  double gamma = 0.0;
  double best = 10.0;
  for (const double angle : {towards_v + inner, towards_v - inner}) {
    const double candidate = angle - face * kHalfPi;
    const double away = std::remainder(candidate - gamma_guess_rad, 2 * std::numbers::pi);
    if (std::abs(away) < best) {
      best = std::abs(away);
      gamma = gamma_guess_rad + away;
    }
  }
  const Vector2d n = face_normal(face, gamma);
  const Vector2d m = face_normal(other, gamma);
  Matrix2d A;
  A << n.transpose(), m.transpose();
  const Vector2d right(
      c1.dot(n) - side_mm / 2 - dial_1.tip_radius_mm,
      c3.dot(m) - side_mm / 2 - dial_3.tip_radius_mm);
  const CuboidPose pose{A.inverse() * right, gamma};

  const std::array<int, 3> faces{face, face, other};
  const Equations equations = linearise(dials, pair_then_single, faces, pose, side_mm);
  const Matrix3d inverse = Matrix3d(equations.J).inverse();
  const Vector3d variance(
      first.sigma_mm * first.sigma_mm, second.sigma_mm * second.sigma_mm,
      single.sigma_mm * single.sigma_mm);
  const Matrix3d covariance = inverse * variance.asDiagonal() * inverse.transpose();
  if (!pose.p_WE.allFinite() || !covariance.allFinite()) {
    return tl::unexpected(PoseTrouble::kNotConverged);
  }
  return estimate_of(pose, covariance, pair_then_single, equations.r);
}

tl::expected<PoseEstimate, PoseTrouble> best_active_three(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings, double side_mm,
    double gamma_guess_rad) {
  const std::vector<int> faces = faces_of(dials, readings, gamma_guess_rad);
  tl::expected<PoseEstimate, PoseTrouble> best = tl::unexpected(PoseTrouble::kTooFewContacts);
  double best_trace = 0.0;
  const std::size_t n = readings.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      if (faces[i] != faces[j]) continue;
      for (std::size_t k = 0; k < n; ++k) {
        if (!neighbours(faces[i], faces[k])) continue;
        auto candidate = active_three(
            dials, {readings[i], readings[j], readings[k]}, side_mm, gamma_guess_rad);
        if (!candidate) continue;
        const double trace = candidate->covariance.topLeftCorner<2, 2>().trace();
        if (!best || trace < best_trace) {
          best_trace = trace;
          best = std::move(candidate);
        }
      }
    }
  }
  return best;
}

tl::expected<PoseEstimate, PoseTrouble> least_squares_pose(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings, double side_mm,
    double gamma_guess_rad) {
  const auto start = best_active_three(dials, readings, side_mm, gamma_guess_rad);
  if (!start) return tl::unexpected(start.error());
  const std::vector<int> faces = faces_of(dials, readings, gamma_guess_rad);
  Eigen::VectorXd weight(static_cast<Eigen::Index>(readings.size()));
  for (std::size_t i = 0; i < readings.size(); ++i) {
    weight[static_cast<Eigen::Index>(i)] = 1.0 / (readings[i].sigma_mm * readings[i].sigma_mm);
  }
  CuboidPose pose = start->pose;
  constexpr int kMostSteps = 30;
  for (int step = 0; step < kMostSteps; ++step) {
    const Equations equations = linearise(dials, readings, faces, pose, side_mm);
    const Matrix3d normal = equations.J.transpose() * weight.asDiagonal() * equations.J;
    const Vector3d change =
        normal.ldlt().solve(equations.J.transpose() * weight.asDiagonal() * equations.r);
    if (!change.allFinite()) break;
    pose.p_WE += change.head<2>();
    pose.gamma_rad += change[2];
    if (change.head<2>().norm() < 1e-11 && std::abs(change[2]) < 1e-13) {
      return estimate_of(
          pose, normal.inverse(), readings, linearise(dials, readings, faces, pose, side_mm).r);
    }
  }
  return tl::unexpected(PoseTrouble::kNotConverged);
}

tl::expected<PoseEstimate, PoseTrouble> least_squares_pose_with_gamma(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings, double side_mm,
    double gamma_rad, double gamma_sigma_rad) {
  const std::vector<int> faces = faces_of(dials, readings, gamma_rad);
  const bool two_directions =
      std::any_of(faces.begin(), faces.end(), [&](int f) { return neighbours(f, faces[0]); });
  if (readings.size() < 2 || !two_directions) {
    return tl::unexpected(PoseTrouble::kTooFewContacts);
  }
  // gamma enters as one more observation with its own sigma; displacement is linear in (x, y).
  CuboidPose pose{Vector2d::Zero(), gamma_rad};
  const Equations at_start = linearise(dials, readings, faces, pose, side_mm);
  Eigen::VectorXd weight(static_cast<Eigen::Index>(readings.size()));
  for (std::size_t i = 0; i < readings.size(); ++i) {
    weight[static_cast<Eigen::Index>(i)] = 1.0 / (readings[i].sigma_mm * readings[i].sigma_mm);
  }
  const auto J_xy = at_start.J.leftCols<2>();
  const Matrix2d normal = J_xy.transpose() * weight.asDiagonal() * J_xy;
  pose.p_WE = normal.ldlt().solve(J_xy.transpose() * weight.asDiagonal() * at_start.r);
  const Equations equations = linearise(dials, readings, faces, pose, side_mm);
  const Vector2d by_gamma = -normal.ldlt().solve(
      equations.J.leftCols<2>().transpose() * weight.asDiagonal() * equations.J.col(2));
  Matrix3d covariance = Matrix3d::Zero();
  const double gamma_variance = gamma_sigma_rad * gamma_sigma_rad;
  covariance.topLeftCorner<2, 2>() =
      normal.inverse() + by_gamma * by_gamma.transpose() * gamma_variance;
  covariance.topRightCorner<2, 1>() = by_gamma * gamma_variance;
  covariance.bottomLeftCorner<1, 2>() = by_gamma.transpose() * gamma_variance;
  covariance(2, 2) = gamma_variance;
  return estimate_of(pose, covariance, readings, equations.r);
}

}  // namespace sixdial::geometry
