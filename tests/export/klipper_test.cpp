// Klipper's block, read back and recomputed as klippy/kinematics/delta.py describes a delta:
// three spheres about the carriages, whose heights follow from the end stops.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <sstream>

#include "geometry/units.h"
#include "report/export/export_format.h"
#include "tests/export/made_models.h"

namespace sixdial::report {
namespace {

using Eigen::Vector3d;
using studies::ExportedModel;
using ::testing::HasSubstr;

constexpr double kSame_mm = 1e-9;
constexpr std::array<double, 3> kEndstops_mm{333.0, 333.4, 332.7};  // as printer.cfg has them

/// "section.key" -> text. Comments are left out.
std::map<std::string, std::string> read_config(const std::string& text) {
  std::map<std::string, std::string> read;
  std::istringstream lines(text);
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (line.front() == '[') {
      section = line.substr(1, line.size() - 2);
      continue;
    }
    const std::size_t colon = line.find(": ");
    read[section + "." + line.substr(0, colon)] = line.substr(colon + 2);
  }
  return read;
}

/// The lower of the two points at these distances from three others, by linear equations and a
/// root, in another way than ours.
Vector3d below(const std::array<Vector3d, 3>& centre, const std::array<double, 3>& radius) {
  Eigen::Matrix<double, 2, 3> A;
  Eigen::Vector2d b;
  for (int i = 0; i < 2; ++i) {
    const auto k = static_cast<std::size_t>(i + 1);
    A.row(i) = 2.0 * (centre[k] - centre[0]).transpose();
    b[i] = radius[0] * radius[0] - radius[k] * radius[k] + centre[k].squaredNorm() -
           centre[0].squaredNorm();
  }
  const Vector3d along = Vector3d(A.row(0)).cross(Vector3d(A.row(1))).normalized();
  const Vector3d at = A.transpose() * (A * A.transpose()).ldlt().solve(b);
  const Vector3d from = at - centre[0];
  const double half = from.dot(along);
  const double root = std::sqrt(half * half - from.squaredNorm() + radius[0] * radius[0]);
  const Vector3d one = at + (-half + root) * along;
  const Vector3d other = at + (-half - root) * along;
  return one.z() < other.z() ? one : other;
}

/// A printer with this configuration; the carriages are so far below their end stops.
Vector3d klipper_nozzle(
    const std::map<std::string, std::string>& config, const Vector3d& below_endstop_mm) {
  const double radius = std::stod(config.at("printer.delta_radius"));
  std::array<Vector3d, 3> carriage;
  std::array<double, 3> arm{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string section = std::string("stepper_") + "abc"[i];
    const double angle = std::stod(config.at(section + ".angle")) * geometry::kRadPerDeg;
    arm[i] = std::stod(config.at(section + ".arm_length"));
    const double endstop = std::stod(config.at(section + ".position_endstop")) +
                           std::sqrt(arm[i] * arm[i] - radius * radius);
    carriage[i] = {
        radius * std::cos(angle), radius * std::sin(angle),
        endstop - below_endstop_mm[static_cast<Eigen::Index>(i)]};
  }
  return below(carriage, arm);
}

/// How far each carriage is below its end stop where the encoders read q: the nominal robot is
/// what printer.cfg has, with its end stops.
Vector3d below_endstops(const ExportedModel& model, const Eigen::VectorXd& q) {
  const auto nominal = [&](const std::string& name) {
    return model.nominal[model.robot().find_parameter(name).value()];
  };
  Vector3d result;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string tower(1, "abc"[i]);
    const double arm = nominal("rod_" + tower);
    const double radius = nominal("radius");
    const double endstop = kEndstops_mm[i] + std::sqrt(arm * arm - radius * radius);
    const auto at = static_cast<Eigen::Index>(i);
    result[at] = endstop - (q[at] + nominal("stop_" + tower));
  }
  return result;
}

const ExportOptions kWithEndstops{.endstops_mm = {kEndstops_mm.begin(), kEndstops_mm.end()}};

/// A delta whose base has only what Klipper holds: a height and a turn about the bed's normal.
ExportedModel level_delta() {
  ExportedModel model = studies::made_model(studies::example_of("linear_delta"));
  for (const char* const name : {"base_x", "base_y", "base_rx", "base_ry"}) {
    model.model[model.robot().find_parameter(name).value()] = 0.0;
  }
  return model;
}

TEST(Klipper, ReadsTheSameDelta) {
  const ExportedModel model = level_delta();
  const Exported exported = export_model(model, "klipper", kWithEndstops);
  EXPECT_TRUE(exported.left_out.empty());
  const auto config = read_config(exported.text);
  EXPECT_EQ(config.at("printer.kinematics"), "delta");
  for (const studies::ModelPose& pose : model.poses) {
    const auto ours = studies::tool_pose(model, pose);
    ASSERT_TRUE(ours);
    const Vector3d theirs = klipper_nozzle(config, below_endstops(model, pose.q));
    ASSERT_LT((theirs - ours->p).norm(), kSame_mm);
  }
}

TEST(Klipper, WithoutChangesKeepsTheConfiguration) {
  ExportedModel model = level_delta();
  model.model.head(model.nominal.size()) = model.nominal;
  const auto config = read_config(export_model(model, "klipper", kWithEndstops).text);
  EXPECT_NEAR(std::stod(config.at("printer.delta_radius")), 172.0, 1e-12);
  EXPECT_NEAR(std::stod(config.at("stepper_b.angle")), 210.0, 1e-12);
  EXPECT_NEAR(std::stod(config.at("stepper_c.arm_length")), 340.0, 1e-12);
  EXPECT_NEAR(std::stod(config.at("stepper_b.position_endstop")), kEndstops_mm[1], 1e-12);
}

TEST(Klipper, TellsWhatATiltMakesThatItDoesNotHold) {
  ExportedModel model = level_delta();
  constexpr double kTilt_rad = 2e-3;
  model.model[model.robot().find_parameter("base_rx").value()] = kTilt_rad;
  const Exported exported = export_model(model, "klipper", kWithEndstops);
  ASSERT_EQ(exported.left_out.size(), 1U);
  const LeftOut& left = exported.left_out.front();
  double most_mm = 0.0;
  const auto config = read_config(exported.text);
  for (const studies::ModelPose& pose : model.poses) {
    const auto ours = studies::tool_pose(model, pose);
    const Vector3d theirs = klipper_nozzle(config, below_endstops(model, pose.q));
    most_mm = std::max(most_mm, (theirs - ours->p).norm());
  }
  EXPECT_GT(most_mm, 0.1);
  EXPECT_NEAR(left.miss.max_mm, most_mm, 1e-8);
  EXPECT_NEAR(exported.miss.max_mm, most_mm, 1e-8);
  EXPECT_THAT(exported.text, HasSubstr("shift and tilt of the towers"));
}

TEST(Klipper, WithoutEndstopsSaysWhatToAddToThem) {
  const ExportedModel model = level_delta();
  const std::string text = export_model(model, "klipper").text;
  const auto with = read_config(export_model(model, "klipper", kWithEndstops).text);
  const auto without = read_config(text);
  EXPECT_FALSE(without.contains("stepper_a.position_endstop"));
  const std::string front = "# position_endstop: yours plus ";
  const std::size_t at = text.find(front);
  ASSERT_NE(at, std::string::npos);
  EXPECT_NEAR(
      kEndstops_mm[0] + std::stod(text.substr(at + front.size())),
      std::stod(with.at("stepper_a.position_endstop")), 1e-12);
}

TEST(Klipper, RefusesWhatItCannotUse) {
  const ExportedModel model = level_delta();
  EXPECT_THROW(
      static_cast<void>(export_model(model, "klipper", {.endstops_mm = {1.0}})),
      studies::StudyError);
  EXPECT_THROW(
      static_cast<void>(export_model(model, "python", kWithEndstops)), studies::StudyError);
}

}  // namespace
}  // namespace sixdial::report
