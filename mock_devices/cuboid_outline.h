// The cuboid as a polygon and a ball that a plunger pushes against it: contact by distance, not
// by choosing a face, so that corners, sheared cuboids and dials at any angle need no special
// case.
//
//   the plunger slides along -axis as it is pushed in; the ball rests where the distance of its
//   centre to the outline equals its radius; of two such places the one on the dial's side.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace sixdial::mock_devices {

/// Four sides, each with outward unit normal n_k and distance h_k from the reference point
/// p_WE.
class CuboidOutline {
 public:
  /// `centre_W` of the cuboid [mm]; sides 1 and 3 are turned by `shear_rad` against square.
  CuboidOutline(
      const Eigen::Vector2d& centre_W, double gamma_rad, double side_mm, double shear_rad);

  struct Distance {
    double mm;                 // negative inside
    Eigen::Vector2d gradient;  // unit vector away from the outline
    bool on_corner;
  };
  [[nodiscard]] Distance distance(const Eigen::Vector2d& p_W) const;

 private:
  std::array<Eigen::Vector2d, 4> corner_;  // corner k joins side k and side k + 1
  std::array<Eigen::Vector2d, 4> normal_;
  std::array<Eigen::Vector2d, 4> along_;  // unit vector from corner k - 1 to corner k
  std::array<double, 4> length_;
};

/// A dial as it truly stands.
struct Plunger {
  Eigen::Vector2d tip_front_mm;  // at zero displacement, in W
  Eigen::Vector2d axis;          // unit vector towards the cuboid
  double tip_radius_mm;
};

struct Push {
  double displacement_mm;
  bool on_corner;
  /// d(displacement)/d(position of the cuboid), 2x1.
  Eigen::Vector2d by_position;
};

/// How far the cuboid pushes the plunger in; it can exceed the travel. Empty if it is out of
/// the free tip's reach.
[[nodiscard]] std::optional<Push> push_of(
    const CuboidOutline& outline, const Plunger& plunger, double travel_mm);

}  // namespace sixdial::mock_devices
