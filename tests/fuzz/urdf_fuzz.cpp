// Any bytes as a URDF: an error with words, or an arm that has a pose with its joints in the
// middle of their ranges and is written as joint rows that make an arm again.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "geometry/robot_kind.h"

namespace {

using namespace sixdial::geometry;

void expect(bool law) {
  if (!law) std::abort();
}

Eigen::Vector3d tool_of(const RobotModel& robot) {
  Eigen::VectorXd q(robot.joint_count());
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const JointInfo& joint = robot.joints[static_cast<std::size_t>(k)];
    q[k] = joint.low / 2 + joint.high / 2;
  }
  std::vector<Pose<double>> X(robot.frames.size());
  expect(robot.forward(robot.nominal, q, static_cast<Assembly>(robot.assemblies[0].number), X)
             .has_value());
  return X[0].p;
}

}  // namespace

// liburdfdom's links own their children: of a file whose links hang on each other in a circle
// and that has no root it throws the model away itself, and these links stay.
// NOLINTNEXTLINE(readability-identifier-naming): the sanitizer's own name
extern "C" const char* __lsan_default_suppressions() { return "leak:urdf::parseURDF\n"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const RobotKind& serial = *find_robot_kind("serial");
  RobotFile file;
  file.robot["urdf"] = {std::string("arm.urdf")};
  file.text_beside = [&](const std::string&) { return text; };
  const auto made = serial.from_file(file);
  if (!made) {
    expect(!made.error().what.empty() && !made.error().hint.empty());
    return 0;
  }
  const RobotModel& robot = **made;
  expect(tool_of(robot).allFinite());
  const RobotFileText written = serial.to_file(robot, robot.nominal);
  RobotFile again;
  again.robot = written.robot;
  again.joints = written.joints;
  const auto back = serial.from_file(again);
  expect(back.has_value());
  expect((*back)->joint_count() == robot.joint_count());
  return 0;
}
