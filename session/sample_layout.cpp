#include "session/sample_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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
  return make_layout(std::move(joints), rig.dials, std::move(axes));
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
