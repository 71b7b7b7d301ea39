// Arms as URDF, default_kinematics.yaml and genserkins, read back by what is not ours:
// liburdfdom, yaml-cpp, and orocos-kdl for the poses.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>
#include <yaml-cpp/yaml.h>

#include <kdl/frames.hpp>
#include <map>
#include <numbers>
#include <regex>

#include "geometry/units.h"
#include "report/export/export_format.h"
#include "tests/export/made_models.h"

namespace sixdial::report {
namespace {

using studies::ExportedModel;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kSame_mm = 1e-9;
constexpr double kSameTurn = 1e-12;
constexpr double kMmPerM = 1000.0;

void expect_at(
    const ExportedModel& model, const Eigen::VectorXd& q, const KDL::Frame& theirs,
    double same_mm = kSame_mm) {
  const auto ours =
      studies::tool_pose(model, studies::commanded_pose(model, q, geometry::Assembly::kLeft));
  ASSERT_TRUE(ours);
  for (int i = 0; i < 3; ++i) {
    ASSERT_LT(std::abs(theirs.p(i) - ours->p[i]), same_mm);
    for (int j = 0; j < 3; ++j) {
      ASSERT_LT(std::abs(theirs.M(i, j) - ours->R(i, j)), same_mm / kSame_mm * kSameTurn);
    }
  }
}

KDL::Frame frame_of(const urdf::Pose& pose) {
  const auto& r = pose.rotation;
  return {
      KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w),
      KDL::Vector(pose.position.x, pose.position.y, pose.position.z) * kMmPerM};
}

/// From `world` to `tool` by what liburdfdom read; joints by name.
KDL::Frame urdf_pose(
    const urdf::ModelInterface& read, const std::map<std::string, double>& values) {
  KDL::Frame at;
  for (auto link = read.getLink("tool"); link->parent_joint;
       link = read.getLink(link->parent_joint->parent_link_name)) {
    const urdf::Joint& joint = *link->parent_joint;
    KDL::Frame move;
    if (joint.type != urdf::Joint::FIXED) {
      const double value = joint.mimic
                               ? joint.mimic->multiplier * values.at(joint.mimic->joint_name) +
                                     joint.mimic->offset
                               : values.at(joint.name);
      const KDL::Vector axis(joint.axis.x, joint.axis.y, joint.axis.z);
      // A slide's value is in metres.
      move = joint.type == urdf::Joint::PRISMATIC
                 ? KDL::Frame(axis * value * kMmPerM)
                 : KDL::Frame(KDL::Rotation::Rot2(axis, value));
    }
    at = frame_of(joint.parent_to_joint_origin_transform) * move * at;
  }
  return at;
}

void expect_same_urdf(const ExportedModel& model, const std::string& text) {
  const auto read = urdf::parseURDF(text);
  ASSERT_NE(read, nullptr) << text;
  for (const studies::ModelPose& pose : model.poses) {
    std::map<std::string, double> values;
    for (std::size_t j = 0; j < model.robot().joints.size(); ++j) {
      const auto& joint = model.robot().joints[j];
      const double unit = joint.kind == geometry::JointKind::kRevolute ? 1.0 : kMmPerM;
      values[joint.name] = pose.q[static_cast<Eigen::Index>(j)] / unit;
    }
    expect_at(model, pose.q, urdf_pose(*read, values));
  }
}

using MakesArm = std::shared_ptr<const geometry::RobotModel> (*)();

TEST(Urdf, HoldsTheGeometryOfAnyArm) {
  for (const MakesArm arm :
       {MakesArm([] { return studies::ur10(); }), MakesArm([] { return studies::ur10(true); }),
        MakesArm(studies::panda), MakesArm(studies::slanted_arm)}) {
    const ExportedModel model = studies::made_model(arm());
    const Exported exported = export_model(model, "urdf");
    EXPECT_TRUE(exported.left_out.empty());
    expect_same_urdf(model, exported.text);
  }
}

TEST(Urdf, OfAJointThatFollowsOneWithoutALink) {
  geometry::SerialRobot arm;
  geometry::SerialRow row{.name = "q1"};
  row.a_mm = 200.0;
  arm.rows.push_back(row);
  row.name = "coupled";
  row.follows = "motor";
  row.ratio = 0.25;
  row.offset = -0.1;
  arm.rows.push_back(row);
  const ExportedModel model = studies::made_model(geometry::serial_model(arm));
  ASSERT_EQ(model.robot().joint_count(), 2);
  expect_same_urdf(model, export_model(model, "urdf").text);
}

simulation::ActiveEffect effect_at(
    const ExportedModel& model, const char* cause, const std::string& where,
    std::vector<double> x) {
  const simulation::Effect* effect = simulation::find_effect(cause);
  for (const simulation::Place& place : effect->places(model.base->rig())) {
    if (place.name == where) return {effect, place, std::move(x)};
  }
  throw std::invalid_argument(where);
}

TEST(Urdf, TellsWhatItLeavesOutAndHowMuchThatMakes) {
  const ExportedModel plain = studies::made_model(studies::ur10());
  constexpr double kBacklash_rad = 8e-4;
  const ExportedModel bent = studies::with_effects(
      plain, {effect_at(plain, "joint_backlash", "joint2", {kBacklash_rad}),
              effect_at(plain, "joint_gain", "joint1", {1e-3})});
  const Exported exported = export_model(bent, "urdf");
  ASSERT_EQ(exported.left_out.size(), 2U);
  const LeftOut& backlash = exported.left_out[0];
  EXPECT_EQ(backlash.what, "backlash of joint 2");
  EXPECT_EQ(backlash.values, std::vector<std::string>{"b = 0.0008 rad"});
  // By hand: half of it turns everything behind the second axis.
  double most_mm = 0.0;
  for (const studies::ModelPose& pose : bent.poses) {
    Eigen::VectorXd q = pose.q;
    q[0] += 1e-3 * q[0];
    Eigen::VectorXd bent_q = q;
    bent_q[1] -= 0.5 * kBacklash_rad * pose.sample.approach[1];
    const auto one =
        studies::tool_pose(plain, studies::commanded_pose(plain, q, pose.assembly));
    const auto other =
        studies::tool_pose(plain, studies::commanded_pose(plain, bent_q, pose.assembly));
    most_mm = std::max(most_mm, (one->p - other->p).norm());
  }
  EXPECT_GT(most_mm, 0.1);
  EXPECT_NEAR(backlash.miss.max_mm, most_mm, 1e-9);
  EXPECT_EQ(backlash.miss.poses, 120);
  EXPECT_GE(exported.miss.max_mm, exported.left_out[1].miss.max_mm);
  EXPECT_THAT(exported.text, HasSubstr("Left out: backlash of joint 2 (b = 0.0008 rad)"));
  EXPECT_THAT(exported.text, HasSubstr(fmt::format("{:.4f} mm at most", most_mm)));
  expect_same_urdf(plain, exported.text);
}

TEST(Urdf, AStepThatHasComeIsInTheJointsZero) {
  for (const MakesArm arm :
       {MakesArm([] { return studies::ur10(); }), MakesArm(studies::slanted_arm)}) {
    const ExportedModel plain = studies::made_model(arm());
    const ExportedModel knocked =
        studies::with_effects(plain, {effect_at(plain, "step", "joint4", {2e-3, 0.0, 60.0})});
    const Exported exported = export_model(knocked, "urdf");
    EXPECT_TRUE(exported.left_out.empty());
    expect_same_urdf(knocked, exported.text);
    EXPECT_GT(
        (studies::tool_pose(knocked, studies::moments_of(knocked)[3])->p -
         studies::tool_pose(plain, studies::moments_of(plain)[3])->p)
            .norm(),
        1e-2);
  }
}

// Fixed joints before and between those of the arm, a shape, a mass, a joint beside the arm.
constexpr const char* kMakersUrdf = R"xml(<?xml version="1.0"?>
<robot name="two axes"><!-- of its maker -->
  <link name="floor"/>
  <joint name="bolt" type="fixed"><parent link="floor"/><child link="plinth"/>
    <origin xyz="0.1 0.2 0.3" rpy="0 0 0.5"/></joint>
  <link name="plinth"/>
  <joint name="pan" type="revolute"><parent link="plinth"/><child link="column"/>
    <origin xyz="0 0 0.15" rpy="0 0.1 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="30" velocity="1.5"/></joint>
  <link name="column"><inertial><mass value="3.5"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="bracket" type="fixed"><parent link="column"/><child link="flange"/>
    <origin xyz="0.05 0 0.1" rpy="1.5707963267948966 0 0"/></joint>
  <link name="flange"/>
  <joint name="tilt" type="continuous"><parent link="flange"/><child link="table"/>
    <axis xyz="0 1 0"/></joint>
  <link name="table"><visual><geometry><box size="0.2 0.2 0.01"/></geometry></visual></link>
  <joint name="to_tool" type="fixed"><parent link="table"/><child link="tool"/>
    <origin xyz="0.1 0 0.2" rpy="0 0 0"/></joint>
  <link name="tool"/>
  <joint name="lid" type="revolute"><parent link="column"/><child link="cover"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
  <link name="cover"/>
</robot>
)xml";

/// That arm, from its plinth.
ExportedModel makers_arm() {
  auto read = geometry::read_urdf(kMakersUrdf, "plinth", "tool");
  if (!read) throw std::invalid_argument(read.error());
  return studies::made_model(geometry::serial_model(*read));
}

TEST(Urdf, OfTheMakerIsSetRightAndKeepsTheRest) {
  ExportedModel model = makers_arm();
  const auto& parameters = model.robot().parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    // What such a file does not get.
    const auto at = static_cast<Eigen::Index>(k);
    const bool outside = parameters[k].stands || parameters[k].rig_key.starts_with("tool_");
    if (outside) model.model[at] = model.nominal[at];
  }
  const Exported exported = export_model(model, "urdf", {.urdf_text = kMakersUrdf});
  EXPECT_TRUE(exported.left_out.empty());
  for (const char* const kept :
       {"<mass value=\"3.5\"", "<box size=\"0.2 0.2 0.01\"", "of its maker", "velocity=\"1.5\"",
        "<origin xyz=\"0.1 0.2 0.3\" rpy=\"0 0 0.5\"", "Nothing of the model is left out"}) {
    EXPECT_THAT(exported.text, HasSubstr(kept));
  }
  const auto read = urdf::parseURDF(exported.text);
  ASSERT_NE(read, nullptr);
  const KDL::Frame plinth = frame_of(read->getJoint("bolt")->parent_to_joint_origin_transform);
  for (const studies::ModelPose& pose : model.poses) {
    const KDL::Frame whole =
        urdf_pose(*read, {{"pan", pose.q[0]}, {"tilt", pose.q[1]}, {"lid", 0.0}});
    expect_at(model, pose.q, plinth.Inverse() * whole);
  }
}

TEST(Urdf, OfTheMakerTellsBaseAndToolAndRefusesAnotherArms) {
  const ExportedModel model = makers_arm();
  const Exported exported = export_model(model, "urdf", {.urdf_text = kMakersUrdf});
  ASSERT_EQ(exported.left_out.size(), 2U);
  EXPECT_GT(exported.left_out[0].miss.max_mm, 0.1);
  const auto why = [&](const std::string& text) {
    try {
      static_cast<void>(export_model(model, "urdf", {.urdf_text = text}));
    } catch (const studies::StudyError& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  std::string moved = kMakersUrdf;
  moved.replace(moved.find("0 0 0.15"), 8, "0 0 0.16");
  EXPECT_THAT(why(moved), HasSubstr("its joint pan stands elsewhere"));
  std::string renamed = kMakersUrdf;
  renamed.replace(renamed.find("\"tilt\""), 6, "\"roll\"");
  EXPECT_THAT(why(renamed), HasSubstr("it has no joint tilt"));
  EXPECT_THAT(why("<robot"), HasSubstr("the URDF cannot be corrected"));
  EXPECT_THAT(why("<html/>"), HasSubstr("it has no <robot>"));
}

/// "... x y z = 1 2 3 mm, roll pitch yaw = 4 5 6 deg", the n-th of a text.
KDL::Frame frame_in(const std::string& text, std::size_t n) {
  static const std::regex pose(
      R"(x y z = (\S+) (\S+) (\S+) mm, roll pitch yaw = (\S+) (\S+) (\S+) deg)");
  auto found = std::sregex_iterator(text.begin(), text.end(), pose);
  std::advance(found, static_cast<std::ptrdiff_t>(n));
  const auto number = [&](std::size_t k) { return std::stod((*found)[k]); };
  const double rad = std::numbers::pi / 180;
  return {
      KDL::Rotation::RPY(number(4) * rad, number(5) * rad, number(6) * rad),
      KDL::Vector(number(1), number(2), number(3))};
}

constexpr std::array<const char*, 6> kUrNames{"shoulder", "upper_arm", "forearm",
                                              "wrist_1",  "wrist_2",   "wrist_3"};

KDL::Frame ur_origin(const YAML::Node& link) {
  return {
      KDL::Rotation::RPY(
          link["roll"].as<double>(), link["pitch"].as<double>(), link["yaw"].as<double>()),
      KDL::Vector(link["x"].as<double>(), link["y"].as<double>(), link["z"].as<double>()) *
          kMmPerM};
}

TEST(UrKinematics, IsReadBackAsTheSameArm) {
  const ExportedModel model = studies::made_model(studies::ur10());
  ASSERT_TRUE(model.robot().find_parameter("beta2"));  // a second angle, which it holds
  const Exported exported = export_model(model, "ur");
  const YAML::Node read = YAML::Load(exported.text)["kinematics"];
  ASSERT_EQ(read.size(), 7U);
  EXPECT_EQ(read["hash"].as<std::string>(), "sixdial_0123456789abcdef");
  for (const studies::ModelPose& pose : model.poses) {
    KDL::Frame at = frame_in(exported.text, 0);
    for (std::size_t i = 0; i < kUrNames.size(); ++i) {
      at = at * ur_origin(read[kUrNames[i]]) *
           KDL::Frame(KDL::Rotation::RotZ(pose.q[static_cast<Eigen::Index>(i)]));
    }
    expect_at(model, pose.q, at * frame_in(exported.text, 1));
  }
  ASSERT_EQ(exported.left_out.size(), 2U);
  EXPECT_EQ(exported.left_out[0].what, "where the arm stands");
  EXPECT_EQ(exported.left_out[1].what, "the tool on the last link");
  EXPECT_GT(exported.left_out[0].miss.max_mm, 0.1);
}

// Lengths and angles of the file that ur_description ships for this arm.
TEST(UrKinematics, OfTheNominalArmHasTheMakersNumbers) {
  ExportedModel model = studies::made_model(studies::ur10());
  model.model.head(model.nominal.size()) = model.nominal;
  const YAML::Node read = YAML::Load(export_model(model, "ur").text)["kinematics"];
  constexpr double kRight = std::numbers::pi / 2;
  const std::array makers{
      KDL::Frame(KDL::Vector(0, 0, 0.1273)),
      KDL::Frame(KDL::Rotation::RPY(kRight, 0, 0)),
      KDL::Frame(KDL::Vector(-0.612, 0, 0)),
      KDL::Frame(KDL::Vector(-0.5723, 0, 0.163941)),
      KDL::Frame(KDL::Rotation::RPY(kRight, 0, 0), KDL::Vector(0, -0.1157, 0)),
      KDL::Frame(
          KDL::Rotation::RPY(kRight, std::numbers::pi, std::numbers::pi),
          KDL::Vector(0, 0.0922, 0))};
  for (std::size_t i = 0; i < makers.size(); ++i) {
    const KDL::Frame ours = ur_origin(read[kUrNames[i]]);
    EXPECT_TRUE(KDL::Equal(ours.p, makers[i].p * kMmPerM, 1e-9)) << kUrNames[i];
    EXPECT_TRUE(KDL::Equal(ours.M, makers[i].M, 1e-12)) << kUrNames[i];
  }
}

/// "setp genserkins.ALPHA-2 0.5" and the zeros that stand in comments.
struct Genserkins {
  std::map<std::string, double> pins;
  std::map<int, double> theta_deg, nominal_deg, difference_deg;
};
Genserkins read_genserkins(const std::string& text) {
  static const std::regex pin(R"(setp genserkins\.(\S+) (\S+))");
  static const std::regex zero(
      R"(# \[JOINT_(\d)\] theta = (\S+) deg, nominal (\S+) deg, difference (\S+) deg)");
  Genserkins read;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_match(line, match, pin)) {
      read.pins[match[1]] = std::stod(match[2]);
    } else if (std::regex_match(line, match, zero)) {
      read.theta_deg[std::stoi(match[1])] = std::stod(match[2]);
      read.nominal_deg[std::stoi(match[1])] = std::stod(match[3]);
      read.difference_deg[std::stoi(match[1])] = std::stod(match[4]);
    } else {
      EXPECT_TRUE(line.empty() || line[0] == '#') << line;
    }
  }
  return read;
}

void expect_same_genserkins(const ExportedModel& model, double same_mm) {
  const Exported exported = export_model(model, "linuxcnc");
  const Genserkins read = read_genserkins(exported.text);
  ASSERT_EQ(read.pins.size(), 18U);
  ASSERT_EQ(read.theta_deg.size(), 6U);
  for (const studies::ModelPose& pose : model.poses) {
    KDL::Frame at = frame_in(exported.text, 0);
    for (int i = 0; i < 6; ++i) {
      const auto value = [&](const char* name) {
        return read.pins.at(fmt::format("{}-{}", name, i));
      };
      // LinuxCNC's joint: the encoder's angle plus theta.
      const double joint = pose.q[i] + read.theta_deg.at(i) * geometry::kRadPerDeg;
      at = at * KDL::Frame::DH_Craig1989(value("A"), value("ALPHA"), value("D"), joint);
    }
    expect_at(model, pose.q, at * frame_in(exported.text, 1), same_mm);
  }
}

TEST(Genserkins, IsReadBackAsTheSameArm) {
  // Six axes without parallel ones; the last joint of a Panda taken off.
  geometry::SerialRobot six =
      geometry::serial_robot(*studies::panda(), studies::panda()->nominal);
  six.rows.pop_back();
  expect_same_genserkins(studies::made_model(geometry::serial_model(six)), kSame_mm);
}

TEST(Genserkins, NearlyParallelAxesHaveTheirNormalFarAway) {
  const ExportedModel model = studies::made_model(studies::ur10());
  // Roundings of D, some 1e5 to 1e6 mm.
  expect_same_genserkins(model, 1e-7);
  EXPECT_THAT(export_model(model, "linuxcnc").text, HasSubstr("--fix beta2,beta3` finds"));
  // Calibrated so, the rows are the nominal ones, a little changed.
  ExportedModel without = model;
  for (const char* const beta : {"beta2", "beta3"}) {
    without.model[model.robot().find_parameter(beta).value()] = 0.0;
  }
  expect_same_genserkins(without, kSame_mm);
  const Genserkins read = read_genserkins(export_model(without, "linuxcnc").text);
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(std::abs(read.difference_deg.at(i)), 1.0);
    EXPECT_LT(std::abs(read.pins.at(fmt::format("D-{}", i))), 200.0);
  }
}

TEST(Genserkins, OfTheNominalArmHasItsRows) {
  ExportedModel model = studies::made_model(studies::ur10());
  model.model.head(model.nominal.size()) = model.nominal;
  const Exported exported = export_model(model, "linuxcnc");
  EXPECT_THAT(exported.text, Not(HasSubstr("nearly parallel")));
  const Genserkins read = read_genserkins(exported.text);
  const auto expect_pin = [&](const char* name, double value) {
    EXPECT_NEAR(read.pins.at(name), value, 1e-12) << name;
  };
  constexpr double kRight = std::numbers::pi / 2;
  expect_pin("D-0", 127.3);
  expect_pin("ALPHA-1", kRight);
  expect_pin("A-2", -612.0);
  expect_pin("A-3", -572.3);
  expect_pin("D-3", 163.941);
  expect_pin("ALPHA-4", kRight);
  expect_pin("D-4", 115.7);
  expect_pin("ALPHA-5", -kRight);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(read.difference_deg.at(i), 0.0, 1e-12);
  expect_same_genserkins(model, kSame_mm);
}

std::string refusal(const ExportedModel& model, const char* format) {
  try {
    static_cast<void>(export_model(model, format));
  } catch (const studies::StudyError& error) {
    EXPECT_EQ(error.code(), studies::StudyErrorCode::kInvalidParams);
    EXPECT_FALSE(error.hint().empty());
    return error.what();
  }
  return "not refused";
}

TEST(ExportFormats, SayWhichRobotTheyCannotHold) {
  const ExportedModel five_bar = studies::made_model(studies::example_of("five_bar"));
  const ExportedModel delta = studies::made_model(studies::example_of("linear_delta"));
  const ExportedModel panda = studies::made_model(studies::panda());
  const ExportedModel slanted = studies::made_model(studies::slanted_arm());
  EXPECT_EQ(
      refusal(five_bar, "urdf"),
      "a URDF cannot hold this robot (planar five-bar): it is a tree of joints, and this robot "
      "closes a loop");
  EXPECT_THAT(refusal(delta, "linuxcnc"), HasSubstr("six turning joints"));
  EXPECT_THAT(refusal(five_bar, "klipper"), HasSubstr("three carriages"));
  EXPECT_THAT(refusal(panda, "ur"), HasSubstr("it has 7 joints, and six are needed"));
  EXPECT_THAT(refusal(slanted, "linuxcnc"), HasSubstr("its joint slide slides"));
  EXPECT_THAT(refusal(panda, "step"), HasSubstr("there is no format 'step'"));
  for (const ExportFormat* each : export_formats()) {
    EXPECT_EQ(find_export_format(each->name), each);
  }
}

}  // namespace
}  // namespace sixdial::report
