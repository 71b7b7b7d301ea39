// How two lists of the same points lie to each other: which turn and shift (and, where allowed,
// which unit and which handedness) carries one list to the other. Closed form (Kabsch; with a
// scale Umeyama), so there is no start and no search; points that stand out do not count.
//
//   to = scale * R * from + t
//
// In the plane or in space. Degenerate: all points at one place, or on a line in space, say
// nothing of the turn; points on a line say nothing of the handedness.
//
// Example:
//   Eigen::MatrixXd nominal_mm(2, 3);  // axes x points
//   nominal_mm << 0, 60, 0, 0, 0, 40;
//   const Eigen::MatrixXd measured_mm = -nominal_mm;  // half a turn
//   const auto found = register_points(nominal_mm, measured_mm);
//   if (found) show(found->X.turn_rad(), found->X.t, found->rms);
//   found->X.mirrored();  // -> false
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace sixdial::geometry {

struct Similarity {
  Eigen::MatrixXd R;  // orthogonal; its determinant is -1 where the frame is mirrored
  Eigen::VectorXd t;
  double scale = 1.0;

  [[nodiscard]] static Similarity identity(Eigen::Index axes);
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& p) const {
    return scale * (R * p) + t;
  }
  [[nodiscard]] Similarity inverse() const;
  [[nodiscard]] bool mirrored() const;
  /// In the plane with its sign, in space the size of the turn. Of a mirrored frame: what is
  /// left when its last axis is turned round.
  [[nodiscard]] double turn_rad() const;
};

struct RegistrationChoice {
  bool may_scale = false;
  bool may_mirror = false;
};

struct Registration {
  Similarity X;
  std::vector<bool> fits;     // by point; false: it stands out
  double rms = 0.0;           // distance of those that fit
  double median = 0.0;        // distance of all
  bool mirror_known = false;  // the points could tell a mirrored frame from a turned one
};

/// Both axes x points, finite. Empty where the points do not tell a turn.
[[nodiscard]] std::optional<Registration> register_points(
    const Eigen::MatrixXd& from, const Eigen::MatrixXd& to,
    const RegistrationChoice& choice = {});

/// Distance of each point of `to` from X(from).
[[nodiscard]] Eigen::VectorXd distances(
    const Similarity& X, const Eigen::MatrixXd& from, const Eigen::MatrixXd& to);

/// Middle value; 0 of none.
[[nodiscard]] double median_of(std::vector<double> values);

}  // namespace sixdial::geometry
