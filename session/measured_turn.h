// How the tool is turned, as an instrument measured it and as a target asks for it. Inside a
// turn is a rotation vector [rad] in W; in files and commands it is three angles, which mean
// what rig.toml says (`orientation`).
//
//   const auto turn = turn_of(session.samples[0], layout_of(session.rig));
//   if (turn) show(geometry::turned_by<double>(*turn));  // R_WE
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "session/sample_layout.h"

namespace sixdial::session {

/// Which of SampleLayout::others is rx; ry and rz follow. Empty: the instrument measures no
/// turns.
[[nodiscard]] std::optional<std::size_t> first_turn(const SampleLayout& layout);

/// Rotation vector of the tool's frame [rad], as it was measured. Empty: this sample has none.
[[nodiscard]] std::optional<Eigen::Vector3d> turn_of(
    const Sample& sample, const SampleLayout& layout);
/// Sets it where the layout has turns; empty: takes it away.
void set_turn(
    Sample& sample, const SampleLayout& layout, const std::optional<Eigen::Vector3d>& turn_rad);

/// R_WE of three angles [rad] by a convention that turn_of_angles knows.
[[nodiscard]] Eigen::Matrix3d frame_of_angles(
    std::string_view convention, const Eigen::Vector3d& angles_rad);

}  // namespace sixdial::session
