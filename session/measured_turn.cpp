#include "session/measured_turn.h"

#include "geometry/rotation.h"

namespace sixdial::session {

std::optional<std::size_t> first_turn(const SampleLayout& layout) {
  for (std::size_t i = 0; i + 2 < layout.others.size(); ++i) {
    if (layout.others[i].name == "rx") return i;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> turn_of(const Sample& sample, const SampleLayout& layout) {
  const auto first = first_turn(layout);
  if (!first || sample.others.size() < *first + 3) return std::nullopt;
  Eigen::Vector3d turn_rad;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<double>& each = sample.others[*first + k];
    if (!each) return std::nullopt;
    turn_rad[static_cast<Eigen::Index>(k)] = *each;
  }
  return turn_rad;
}

void set_turn(
    Sample& sample, const SampleLayout& layout,
    const std::optional<Eigen::Vector3d>& turn_rad) {
  const auto first = first_turn(layout);
  if (!first || sample.others.size() < *first + 3) return;
  for (std::size_t k = 0; k < 3; ++k) {
    std::optional<double>& each = sample.others[*first + k];
    each.reset();
    if (turn_rad) each = (*turn_rad)[static_cast<Eigen::Index>(k)];
  }
}

Eigen::Matrix3d frame_of_angles(
    std::string_view convention, const Eigen::Vector3d& angles_rad) {
  return geometry::turned_by<double>(
      turn_of_angles(convention, angles_rad).value_or(angles_rad));
}

}  // namespace sixdial::session
