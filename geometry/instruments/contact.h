// A ball-tipped dial indicator on a face of the cuboid, and the tool's pose from several of
// them.
//
//   face k: 0 right, 1 top, 2 left, 3 bottom; outward normal n_k = (cos, sin)(gamma + k pi/2)
//
//   centre of the ball at zero displacement:  p_WT = position - rho axis
//
//   it touches where  (p_WT - delta axis - p_WE) . n = h + rho,  with h = side / 2  (spec 1)
//
//   so  delta = (h + rho - (p_WT - p_WE) . n) / (-axis . n)
//
// Lengths mm, angles rad, frame W. Degenerate: an axis along the face, a tip beyond the face's
// edge, two dials of a face whose balls coincide, an active three without a neighbouring face.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace sixdial::geometry {

/// One dial as it stands on the table.
struct DialGeometry {
  Eigen::Vector2d position_mm{0, 0};  // front of the tip at zero displacement, in W
  Eigen::Vector2d axis{1, 0};         // unit vector from the dial towards the cuboid
  double travel_mm = 50.8;
  double tip_radius_mm = 1.5;  // 0 is a sharp tip
};

/// Position of the cuboid's centre (the tool) and its rotation in W.
struct CuboidPose {
  Eigen::Vector2d p_WE{0, 0};
  double gamma_rad = 0.0;
};

enum class ContactTrouble {
  kNoTouch,       // the face is further away than the free tip: displacement <= 0
  kBeyondTravel,  // the plunger would have to go in further than its travel
  kOffFace,       // the touching point lies beyond the face's edge
  kAlongFace,     // no face looks at the dial
};
[[nodiscard]] std::string_view describe(ContactTrouble trouble);

struct Contact {
  int face = 0;
  double displacement_mm = 0.0;
  double along_mm = 0.0;  // touching point along the face from its middle
  Eigen::RowVector3d J;   // d(displacement)/d(x, y, gamma)
};

/// The face (0..3) that looks at the dial: the one whose normal is nearest to -axis.
[[nodiscard]] int face_towards(const DialGeometry& dial, double gamma_rad);
/// The same by the normal of face 0, (cos gamma, sin gamma): no trigonometry.
[[nodiscard]] int face_towards(const DialGeometry& dial, const Eigen::Vector2d& heading);
/// n_k, 2x1.
[[nodiscard]] Eigen::Vector2d face_normal(int face, double gamma_rad);
[[nodiscard]] Eigen::Vector2d face_normal(int face, const Eigen::Vector2d& heading);

/// Displacement [mm] on a given face, whether or not the dial can reach it.
[[nodiscard]] Contact contact_on_face(
    const DialGeometry& dial, const CuboidPose& pose, double side_mm, int face);
/// The displacement alone, by the face's normal.
[[nodiscard]] double displacement_on_face(
    const DialGeometry& dial, const Eigen::Vector2d& p_WE, double side_mm,
    const Eigen::Vector2d& normal);
/// The contact that a real dial would show; says why there is none.
[[nodiscard]] tl::expected<Contact, ContactTrouble> touch(
    const DialGeometry& dial, const CuboidPose& pose, double side_mm);

/// Equation (39) as published: dial B on the left face, C and D on the lower one, sharp tips,
/// y_C = y_D, axes along W. Returns p_WE [mm] and gamma. Here as the special case to compare
/// with; use `active_three` for measurements.
[[nodiscard]] CuboidPose equation_39(
    const Eigen::Vector2d& position_B_mm, const Eigen::Vector2d& position_C_mm,
    const Eigen::Vector2d& position_D_mm, double displacement_B_mm, double displacement_C_mm,
    double displacement_D_mm, double side_mm);

/// A reading to solve with. `sigma_mm` is its standard deviation.
struct DialReading {
  int dial = 0;  // index into the span of dials
  double displacement_mm = 0.0;
  double sigma_mm = 0.002;
};

enum class PoseTrouble {
  kTooFewContacts,  // fewer than two dials on one face and one on a neighbouring face
  kCoincidentBalls,
  kNotConverged,  // least squares: readings contradict each other
};
[[nodiscard]] std::string_view describe(PoseTrouble trouble);

struct PoseEstimate {
  CuboidPose pose;
  Eigen::Matrix3d
      covariance;          // of (x, y, gamma) [mm^2, mm rad, rad^2], from the readings' sigma
  std::vector<int> dials;  // indices used; the active three: pair first, then the single dial
  std::vector<double> residual_mm;  // measured - computed displacement, as `dials`
};

/// Closed form for two dials of one face and one of a neighbouring face. `gamma_guess_rad` says
/// which way the cuboid is held, to better than 45 degrees.
[[nodiscard]] tl::expected<PoseEstimate, PoseTrouble> active_three(
    std::span<const DialGeometry> dials, const std::array<DialReading, 3>& pair_then_single,
    double side_mm, double gamma_guess_rad = 0.0);

/// The best conditioned active three among the readings: least trace of the position
/// covariance.
[[nodiscard]] tl::expected<PoseEstimate, PoseTrouble> best_active_three(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings, double side_mm,
    double gamma_guess_rad = 0.0);

/// Weighted least squares over all readings, gamma free. Surplus readings show as residuals.
[[nodiscard]] tl::expected<PoseEstimate, PoseTrouble> least_squares_pose(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings, double side_mm,
    double gamma_guess_rad = 0.0);

/// The same with gamma known to `gamma_sigma_rad` (a clamp on a distal link): two dials on
/// neighbouring faces are enough.
[[nodiscard]] tl::expected<PoseEstimate, PoseTrouble> least_squares_pose_with_gamma(
    std::span<const DialGeometry> dials, std::span<const DialReading> readings, double side_mm,
    double gamma_rad, double gamma_sigma_rad);

}  // namespace sixdial::geometry
