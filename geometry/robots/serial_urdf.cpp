// A URDF's joints from one link to another as rows of an arm (liburdfdom reads the file).
#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <mutex>
#include <string>
#include <vector>

#include "geometry/robots/serial_chain.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

using serial_chain::can_name_a_joint;
using serial_chain::is_range;
using serial_chain::unit_axis;

constexpr double kMmPerM = 1000.0;

/// Takes what liburdfdom would print, as long as it lives. One at a time: its log is global.
class QuietLog : public console_bridge::OutputHandler {
 public:
  QuietLog() : lock_(mutex()) { console_bridge::useOutputHandler(this); }
  ~QuietLog() override { console_bridge::restorePreviousOutputHandler(); }
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;
  void log(
      const std::string& text, console_bridge::LogLevel level, const char* /*filename*/,
      int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_error_.empty()) {
      first_error_ = text;
    }
  }
  [[nodiscard]] const std::string& first_error() const { return first_error_; }

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  std::lock_guard<std::mutex> lock_;
  std::string first_error_;
};

Pose<double> pose_of(const urdf::Pose& pose) {
  const auto& q = pose.rotation;
  Pose<double> X;
  X.p = kMmPerM * Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  X.R = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  return X;
}

Pose<double> product(const Pose<double>& a, const Pose<double>& b) {
  return {a.p + a.R * b.p, a.R * b.R};
}

/// The last link where only one can be meant.
tl::expected<std::string, std::string> one_leaf(const urdf::ModelInterface& model) {
  std::string leaf;
  std::string all;
  int count = 0;
  for (const auto& [name, link] : model.links_) {
    if (!link->child_joints.empty()) continue;
    leaf = name;
    all += (all.empty() ? "" : ", ") + name;
    ++count;
  }
  if (count == 1) return leaf;
  return tl::unexpected("`tip` must say which link is the last: " + all);
}

std::string known_links(const urdf::ModelInterface& model) {
  std::string all;
  for (const auto& [name, link] : model.links_) all += (all.empty() ? "" : ", ") + name;
  return all;
}

/// Joints from base to tip, in that order.
tl::expected<std::vector<urdf::JointSharedPtr>, std::string> path(
    const urdf::ModelInterface& model, const std::string& base, const std::string& tip) {
  for (const std::string& name : {base, tip}) {
    if (!model.getLink(name)) {
      return tl::unexpected("there is no link '" + name + "'; there are " + known_links(model));
    }
  }
  std::vector<urdf::JointSharedPtr> joints;
  urdf::LinkConstSharedPtr link = model.getLink(tip);
  while (link->name != base) {
    // Links that hang on each other in a circle end nowhere.
    if (!link->parent_joint || joints.size() > model.links_.size()) {
      return tl::unexpected("link '" + tip + "' does not hang on link '" + base + "'");
    }
    joints.push_back(link->parent_joint);
    link = model.getLink(link->parent_joint->parent_link_name);
  }
  std::ranges::reverse(joints);
  return joints;
}

/// Links own their children: those that hang on each other in a circle would stay for ever.
class Untied {
 public:
  explicit Untied(urdf::ModelInterface& model) : model_(model) {}
  ~Untied() {
    for (auto& [name, link] : model_.links_) {
      link->child_links.clear();
      link->child_joints.clear();
    }
  }
  Untied(const Untied&) = delete;
  Untied& operator=(const Untied&) = delete;

 private:
  urdf::ModelInterface& model_;
};

constexpr const char* kNoNumber = "' has a number that is not finite or beyond 1e9 mm";
bool is_sensible(const auto& numbers) {
  constexpr double kMost = 1e9;
  return numbers.allFinite() && numbers.cwiseAbs().maxCoeff() <= kMost;
}

bool slides(const urdf::Joint& joint) { return joint.type == urdf::Joint::PRISMATIC; }

/// `before`: fixed joints between the last moving one and this.
tl::expected<SerialRow, std::string> row_of(
    const urdf::ModelInterface& model, const urdf::Joint& joint, const Pose<double>& before) {
  for (const std::string& name :
       {joint.name, joint.mimic ? joint.mimic->joint_name : joint.name}) {
    if (!can_name_a_joint(name)) {
      return tl::unexpected(
          "has a joint '" + name + "', which cannot name a column: use letters, digits and _");
    }
  }
  SerialRow row;
  row.name = joint.name;
  row.form = RowForm::kOrigin;
  row.kind = slides(joint) ? JointKind::kPrismatic : JointKind::kRevolute;
  const Pose<double> X = product(before, pose_of(joint.parent_to_joint_origin_transform));
  row.origin_mm = X.p;
  row.turn_rad = rotation_vector(X.R);
  const auto axis = unit_axis({joint.axis.x, joint.axis.y, joint.axis.z});
  if (!axis) return tl::unexpected("joint '" + joint.name + "' has an axis without direction");
  row.axis = *axis;
  const double unit = slides(joint) ? kMmPerM : 1.0;
  if (joint.limits && is_range(unit * joint.limits->lower, unit * joint.limits->upper)) {
    row.low = unit * joint.limits->lower;
    row.high = unit * joint.limits->upper;
  }
  const Eigen::Vector2d range(row.low.value_or(0.0), row.high.value_or(0.0));
  if (!is_sensible(row.origin_mm) || !is_sensible(row.turn_rad) || !is_sensible(range)) {
    return tl::unexpected("joint '" + joint.name + kNoNumber);
  }
  if (!joint.mimic) return row;
  const auto leader = model.getJoint(joint.mimic->joint_name);
  if (!leader) {
    return tl::unexpected(
        "joint '" + joint.name + "' mimics '" + joint.mimic->joint_name +
        "', which is not there");
  }
  if (leader->mimic) {
    return tl::unexpected("joint '" + joint.name + "' mimics a joint that mimics another one");
  }
  row.follows = leader->name;
  row.ratio = joint.mimic->multiplier * unit / (slides(*leader) ? kMmPerM : 1.0);
  row.offset = unit * joint.mimic->offset;
  if (!is_sensible(Eigen::Vector2d(row.ratio, row.offset))) {
    return tl::unexpected("joint '" + joint.name + kNoNumber);
  }
  return row;
}

}  // namespace

tl::expected<SerialRobot, std::string> read_urdf(
    std::string_view text, const std::string& base, const std::string& tip) {
  urdf::ModelInterfaceSharedPtr model;
  std::string error;
  {
    QuietLog quiet;
    try {
      model = urdf::parseURDF(std::string(text));
    } catch (const std::exception& thrown) {
      error = thrown.what();
    }
    if (error.empty()) error = quiet.first_error();
  }
  if (!model) {
    return tl::unexpected(std::string("is no URDF").append(error.empty() ? "" : ": ") + error);
  }
  const Untied at_the_end(*model);
  const auto last = tip.empty() ? one_leaf(*model) : tip;
  if (!last) return tl::unexpected(last.error());
  const auto joints = path(*model, base.empty() ? model->getRoot()->name : base, *last);
  if (!joints) return tl::unexpected(joints.error());
  SerialRobot arm;
  Pose<double> fixed;  // since the last moving joint
  for (const auto& joint : *joints) {
    switch (joint->type) {
      case urdf::Joint::FIXED:
        fixed = product(fixed, pose_of(joint->parent_to_joint_origin_transform));
        break;
      case urdf::Joint::REVOLUTE:
      case urdf::Joint::CONTINUOUS:
      case urdf::Joint::PRISMATIC: {
        auto row = row_of(*model, *joint, fixed);
        if (!row) return tl::unexpected(row.error());
        arm.rows.push_back(*std::move(row));
        fixed = {};
        break;
      }
      default:
        return tl::unexpected(
            "joint '" + joint->name + "' neither turns nor slides along one axis");
    }
  }
  if (arm.rows.empty())
    return tl::unexpected(std::string("no joint moves between its base and its tip"));
  arm.tool_mm = fixed.p;
  arm.tool_turn_rad = rotation_vector(fixed.R);
  if (!is_sensible(arm.tool_mm) || !is_sensible(arm.tool_turn_rad)) {
    return tl::unexpected("the way to link '" + *last + kNoNumber);
  }
  return arm;
}

}  // namespace sixdial::geometry
