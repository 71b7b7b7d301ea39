// What each kind of robot's templates are filled with.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "geometry/rotation.h"
#include "report/export/holding.h"
#include "report/export/joint_chain.h"
#include "report/export/source_code.h"
#include "report/export/templates.h"

namespace sixdial::report {
namespace {

using Eigen::Vector3d;
using geometry::Pose;

/// Parameters whose names begin so, joined as values of a list: "rod_" a, b, c.
class Named {
 public:
  explicit Named(const studies::ExportedModel& model)
      : robot_(model.robot()), v_(model.parameters()) {}

  [[nodiscard]] double one(const std::string& name) const {
    return v_[robot_.find_parameter(name).value()];
  }
  [[nodiscard]] std::string towers(const std::string& front) const {
    return fmt::format(
        "{}, {}, {}", exactly(one(front + "a")), exactly(one(front + "b")),
        exactly(one(front + "c")));
  }
  [[nodiscard]] Vector3d triple(const std::string& front) const {
    return {one(front + "x"), one(front + "y"), one(front + "z")};
  }
  [[nodiscard]] Pose<double> frame(const std::string& name) const {
    return {triple(name + "_"), geometry::turned_by<double>(triple(name + "_r"))};
  }

 private:
  const geometry::RobotModel& robot_;
  Eigen::VectorXd v_;
};

std::string triple_of(const SourceLanguage& language, const Vector3d& value) {
  return list_of(language, std::span(value.data(), 3));
}

std::string link_row(const SourceLanguage& language, const ChainJoint& joint) {
  const bool slides = joint.kind == geometry::JointKind::kPrismatic;
  const std::string_view yes = language.is_python ? "True" : "1";
  const std::string_view no = language.is_python ? "False" : "0";
  return fmt::format(
      "{}{}{}, {}, {}, {}, {}, {}, {}{},\n", language.indent, language.open,
      frame_of(language, joint.origin), triple_of(language, joint.axis),
      triple_of(language, joint.mark_mm), slides ? yes : no, joint.joint,
      exactly(joint.follows.empty() ? 1.0 : joint.ratio),
      exactly(joint.follows.empty() ? 0.0 : joint.offset), language.close);
}

void fill_serial(
    const studies::ExportedModel& model, const SourceLanguage& language, bool with_weight,
    Marks& marks) {
  // Shifts stand with the other effects: these act one after the other.
  const JointChain chain = joint_chain(model, false);
  marks["FRAME"] = language.is_python ? templates::frame_py() : templates::frame_c();
  marks["LINKS"] = std::to_string(chain.joints.size());
  marks["BASE"] = frame_of(language, chain.base);
  marks["TOOL"] = frame_of(language, chain.tool);
  std::string& rows = marks["LINK_ROWS"];
  for (const ChainJoint& joint : chain.joints) rows += link_row(language, joint);
  const auto weight =
      language.is_python ? templates::serial_weight_py() : templates::serial_weight_c();
  std::string& text = marks["WEIGHT"];
  if (with_weight) text = filled(weight, {{"UPRIGHT", frame_of(language, chain.upright)}});
}

void fill_five_bar(
    const studies::ExportedModel& model, const SourceLanguage& language, bool, Marks& marks) {
  const auto& parameters = model.robot().parameters;
  std::string& rows = marks["PARAMETER_ROWS"];
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const std::string value = exactly(model.model[static_cast<Eigen::Index>(k)]);
    const std::string words = fmt::format("{} [{}]", parameters[k].name, parameters[k].unit);
    rows += fmt::format("{}{}, ", language.indent, value);
    rows += language.is_python ? " # " + words + "\n" : "/* " + words + " */\n";
  }
  marks["PARAMETER_COUNT"] = std::to_string(parameters.size());
}

void fill_delta(
    const studies::ExportedModel& model, const SourceLanguage& language, Marks& marks) {
  const Named named(model);
  marks["FRAME"] = language.is_python ? templates::frame_py() : templates::frame_c();
  marks["THREE_SPHERES"] =
      language.is_python ? templates::three_spheres_py() : templates::three_spheres_c();
  marks["BASE"] = frame_of(language, named.frame("base"));
  marks["RADIUS"] = exactly(named.one("radius"));
  marks["ANGLE"] = named.towers("angle_");
  marks["ROD"] = named.towers("rod_");
}

void fill_linear_delta(
    const studies::ExportedModel& model, const SourceLanguage& language, bool, Marks& marks) {
  fill_delta(model, language, marks);
  marks["STOP"] = Named(model).towers("stop_");
}

void fill_rotary_delta(
    const studies::ExportedModel& model, const SourceLanguage& language, bool, Marks& marks) {
  fill_delta(model, language, marks);
  marks["ARM"] = Named(model).towers("arm_");
  marks["ZERO"] = Named(model).towers("zero_");
}

/// Of a rig file's key that holds three numbers; lengths mm, angles rad.
Vector3d triple_in(const geometry::RobotFileText& file, const std::string& key) {
  const auto& list = std::get<std::vector<geometry::FileValue>>(file.robot.at(key).value);
  Vector3d result;
  for (std::size_t i = 0; i < 3; ++i) {
    result[static_cast<Eigen::Index>(i)] = std::get<double>(list.at(i).value);
  }
  return result;
}

void fill_stewart(
    const studies::ExportedModel& model, const SourceLanguage& language, bool, Marks& marks) {
  constexpr int kLegs = 6;
  const Named named(model);
  const geometry::RobotFileText file =
      model.robot().kind->to_file(model.robot(), model.nominal);
  const Pose<double> home{
      triple_in(file, "home_mm"),
      geometry::turned_by<double>(triple_in(file, "home_turn_deg"))};
  std::vector<std::string> base, platform, legs;
  for (int leg = 1; leg <= kLegs; ++leg) {
    const std::string number = std::to_string(leg);
    base.push_back(triple_of(language, named.triple("base" + number + "_")));
    platform.push_back(triple_of(language, named.triple("platform" + number + "_")));
    legs.push_back(exactly(named.one("leg" + number)));
  }
  marks["FRAME"] = language.is_python ? templates::frame_py() : templates::frame_c();
  marks["HOME"] = frame_of(language, home);
  marks["BASE_JOINTS"] = fmt::format("{}", fmt::join(base, ", "));
  marks["PLATFORM_JOINTS"] = fmt::format("{}", fmt::join(platform, ", "));
  marks["LEG"] = fmt::format("{}", fmt::join(legs, ", "));
}

constexpr std::array kKinds{
    KindSource{"five_bar", templates::five_bar_c, templates::five_bar_py, true, fill_five_bar},
    KindSource{
        "linear_delta", templates::linear_delta_c, templates::linear_delta_py, false,
        fill_linear_delta},
    KindSource{
        "rotary_delta", templates::rotary_delta_c, templates::rotary_delta_py, false,
        fill_rotary_delta},
    KindSource{"serial", templates::serial_c, templates::serial_py, false, fill_serial},
    KindSource{"stewart", templates::stewart_c, templates::stewart_py, false, fill_stewart}};

}  // namespace

const KindSource* find_kind_source(std::string_view kind) {
  const auto* const found = std::ranges::find(kKinds, kind, &KindSource::kind);
  return found == kKinds.end() ? nullptr : found;
}

}  // namespace sixdial::report
