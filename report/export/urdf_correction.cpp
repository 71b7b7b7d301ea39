#include "report/export/urdf_correction.h"

#include <fmt/format.h>
#include <tinyxml.h>

#include <Eigen/Geometry>
#include <map>
#include <sstream>

#include "geometry/rotation.h"
#include "report/export/holding.h"

namespace sixdial::report {
namespace {

using Eigen::Vector3d;
using geometry::Pose;

constexpr double kMmPerM = 1000.0;
constexpr double kSamePlace_mm = 1e-4;  // of files that round to a micrometre, and not further
constexpr double kSameTurn = 1e-6;

[[noreturn]] void refuse(const std::string& why) {
  throw studies::StudyError(
      studies::StudyErrorCode::kInvalidParams, "the URDF cannot be corrected: " + why,
      {{"param", "urdf"}},
      "Give the URDF that rig.toml was made from (a xacro file has to be expanded first), or "
      "none: then a new one is written.");
}

std::string text_of(const char* text) { return text == nullptr ? "" : text; }

Vector3d triple_of(const TiXmlElement* element, const char* name) {
  Vector3d value = Vector3d::Zero();
  if (element == nullptr || element->Attribute(name) == nullptr) return value;
  std::istringstream words(element->Attribute(name));
  words.imbue(std::locale::classic());
  for (double& each : value) words >> each;
  if (!words) refuse(fmt::format("'{}' is no three numbers", element->Attribute(name)));
  return value;
}

/// A joint of the file.
struct FileJoint {
  TiXmlElement* element = nullptr;
  std::string parent{};
  bool fixed = false;
  Pose<double> origin{};  // [mm]
};

FileJoint joint_of(TiXmlElement& element) {
  FileJoint joint{.element = &element};
  if (const TiXmlElement* parent = element.FirstChildElement("parent")) {
    joint.parent = text_of(parent->Attribute("link"));
  }
  joint.fixed = text_of(element.Attribute("type")) == "fixed";
  const TiXmlElement* origin = element.FirstChildElement("origin");
  const Vector3d rpy = triple_of(origin, "rpy");
  joint.origin.p = kMmPerM * triple_of(origin, "xyz");
  for (const int axis : {2, 1, 0}) {
    geometry::turn_about<double>(joint.origin.R, axis, rpy[axis]);
  }
  return joint;
}

struct FileJoints {
  std::map<std::string, FileJoint> by_name{}, by_child{};
};

FileJoints joints_of(TiXmlElement& robot) {
  FileJoints joints;
  for (TiXmlElement* each = robot.FirstChildElement("joint"); each != nullptr;
       each = each->NextSiblingElement("joint")) {
    const TiXmlElement* child = each->FirstChildElement("child");
    const FileJoint joint = joint_of(*each);
    joints.by_name[text_of(each->Attribute("name"))] = joint;
    if (child != nullptr) joints.by_child[text_of(child->Attribute("link"))] = joint;
  }
  return joints;
}

bool same(const Pose<double>& a, const Pose<double>& b) {
  return (a.p - b.p).norm() < kSamePlace_mm && (a.R - b.R).norm() < kSameTurn;
}

/// What fixed joints do between the arm's joint before and this one: the rig file's nominal arm
/// has them in its origin.
Pose<double> fixed_before(
    const FileJoints& joints, const FileJoint& joint, const ChainJoint& nominal) {
  Pose<double> fixed;
  std::string link = joint.parent;
  for (std::size_t steps = 0; steps <= joints.by_child.size(); ++steps) {
    if (same(behind(fixed, joint.origin), nominal.origin)) return fixed;
    const auto before = joints.by_child.find(link);
    if (before == joints.by_child.end() || !before->second.fixed) break;
    fixed = behind(before->second.origin, fixed);
    link = before->second.parent;
  }
  refuse(fmt::format(
      "its joint {} stands elsewhere than that of the rig file's nominal arm", nominal.name));
}

void set_origin(TiXmlElement& joint, const Pose<double>& pose) {
  TiXmlElement* origin = joint.FirstChildElement("origin");
  if (origin == nullptr) {
    origin = joint.LinkEndChild(new TiXmlElement("origin"))->ToElement();  // it owns it
  }
  const Vector3d at_m = pose.p / kMmPerM;
  origin->SetAttribute("xyz", exactly(at_m, " ").c_str());
  origin->SetAttribute("rpy", exactly(roll_pitch_yaw(pose.R), " ").c_str());
}

}  // namespace

std::string corrected_urdf(
    const std::string& text, const JointChain& nominal, const JointChain& calibrated,
    const std::string& comment) {
  TiXmlDocument document;
  document.Parse(text.c_str(), nullptr, TIXML_ENCODING_UTF8);
  TiXmlElement* robot = document.FirstChildElement("robot");
  if (document.Error() || robot == nullptr) {
    refuse(document.Error() ? document.ErrorDesc() : "it has no <robot>");
  }
  const FileJoints joints = joints_of(*robot);
  for (std::size_t i = 0; i < nominal.joints.size(); ++i) {
    const auto found = joints.by_name.find(nominal.joints[i].name);
    if (found == joints.by_name.end()) {
      refuse(fmt::format("it has no joint {}", nominal.joints[i].name));
    }
    const Pose<double> fixed = fixed_before(joints, found->second, nominal.joints[i]);
    set_origin(*found->second.element, behind(inverse(fixed), calibrated.joints[i].origin));
  }
  document.InsertBeforeChild(robot, TiXmlComment(comment.c_str()));
  TiXmlPrinter printer;
  printer.SetIndent("  ");
  document.Accept(&printer);
  return printer.CStr();
}

}  // namespace sixdial::report
