#include "session/sample_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/instrument_kind.h"
#include "geometry/rotation.h"

namespace sixdial::session {

SampleLayout make_layout(
    std::vector<Joint> joints, const std::vector<geometry::Dial>& dials,
    std::vector<std::string> axes) {
  SampleLayout layout;
  layout.joints = std::move(joints);
  layout.dials = dials.size();
  for (const geometry::Dial& dial : dials) {
    layout.channels.push_back({"dial_" + dial.id, "mm", dial.resolution_mm});
  }
  layout.axes = std::move(axes);
  for (const std::string& axis : layout.axes) layout.channels.push_back({axis, "mm"});
  return layout;
}

SampleLayout layout_of(const geometry::Rig& rig) {
  std::vector<Joint> joints;
  for (const geometry::JointInfo& joint : rig.robot.model->joints) {
    // Of the five-bar the files have always been in radians.
    const bool five_bar = rig.robot.model->kind == &geometry::five_bar;
    joints.push_back(
        {joint.name, std::string(joint.unit()), joint.unit() == "rad" && !five_bar, five_bar});
  }
  std::vector<std::string> axes{"x", "y"};
  if (rig.instrument.dimensions == 3) axes.emplace_back("z");
  SampleLayout layout = make_layout(std::move(joints), rig.dials, std::move(axes));
  if (rig.instrument.kind == geometry::Instrument{}.kind) return layout;
  const auto instrument = geometry::instrument_of(rig);
  layout.gives_position = false;
  for (const geometry::ChannelInfo& channel : instrument->channels) {
    if (std::ranges::find(layout.axes, channel.name) != layout.axes.end()) {
      layout.gives_position = true;
    } else {
      layout.others.push_back({channel.name, channel.unit});
    }
  }
  for (const geometry::ReferencePoint& socket : rig.instrument.sockets) {
    layout.sockets.push_back(socket.name);
  }
  layout.orientation = rig.instrument.orientation;
  return layout;
}

std::optional<Eigen::Vector3d> turn_of_angles(
    std::string_view convention, const Eigen::Vector3d& angles_rad) {
  if (convention == kRotationVector) return angles_rad;
  const std::size_t blank = convention.find(' ');
  if (blank == std::string_view::npos) return std::nullopt;
  const std::string_view frame = convention.substr(0, blank);
  const std::string_view order = convention.substr(blank + 1);
  if ((frame != "intrinsic" && frame != "extrinsic") || order.size() != 3 ||
      order.find_first_not_of("xyz") != std::string_view::npos || order[0] == order[1] ||
      order[1] == order[2]) {
    return std::nullopt;
  }
  // Turns about fixed axes are those about moving axes in the reverse order.
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t k = frame == "intrinsic" ? i : 2 - i;
    geometry::turn_about<double>(R, order[k] - 'x', angles_rad[static_cast<Eigen::Index>(k)]);
  }
  return geometry::rotation_vector(R);
}

std::string joints_in_words(const SampleLayout& layout, const Eigen::VectorXd& q) {
  const bool angles = std::ranges::all_of(
      layout.joints, [](const Joint& joint) { return joint.unit == "rad"; });
  std::string values;
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    if (!values.empty()) values += ", ";
    values += fmt::format("{}", q[static_cast<Eigen::Index>(i)]);
    if (!angles) values += ' ' + layout.joints[i].unit;
  }
  return angles ? fmt::format("joint angles ({}) rad", values)
                : fmt::format("joints ({})", values);
}

std::optional<Position> position_of(const Sample& sample, std::size_t dials) {
  if (sample.channels.size() <= dials) return std::nullopt;
  Position position(static_cast<Eigen::Index>(sample.channels.size() - dials));
  for (std::size_t i = dials; i < sample.channels.size(); ++i) {
    const ChannelValue& coordinate = sample.channels[i];
    if (!coordinate.value || coordinate.quality == Quality::kBad) return std::nullopt;
    position[static_cast<Eigen::Index>(i - dials)] = *coordinate.value;
  }
  return position;
}

void set_position(
    Sample& sample, std::size_t dials, const std::optional<Position>& position_mm) {
  sample.channels.resize(dials);
  if (!position_mm) return;
  for (const double coordinate_mm : *position_mm) {
    sample.channels.push_back({.value = coordinate_mm});
  }
}

}  // namespace sixdial::session
