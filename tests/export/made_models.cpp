#include "tests/export/made_models.h"

#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <stdexcept>

#include "simulation/circumstances.h"

namespace sixdial::studies {
namespace {

constexpr double kRight_rad = std::numbers::pi / 2;

geometry::SerialRow row_of(
    const char* name, geometry::RowForm form, double a, double alpha, double d) {
  geometry::SerialRow row{.name = name, .form = form};
  row.a_mm = a;
  row.alpha_rad = alpha;
  row.d_mm = d;
  return row;
}

}  // namespace

geometry::Rig rig_with(std::shared_ptr<const geometry::RobotModel> robot) {
  geometry::Rig rig = geometry::default_rig();
  if (robot->kind == &geometry::five_bar) return rig;
  rig.robot.nominal = robot->nominal;
  rig.robot.assembly = geometry::Assembly{robot->assemblies.front().number};
  rig.robot.model = std::move(robot);
  rig.instrument.kind = "position";
  rig.instrument.dimensions = 3;
  rig.instrument.sd_mm = 0.02;
  rig.dials.clear();
  return rig;
}

std::shared_ptr<const geometry::RobotModel> example_of(const char* kind) {
  return geometry::find_robot_kind(kind)->example();
}

std::shared_ptr<const geometry::RobotModel> ur10(bool tool_is_frame) {
  geometry::SerialRobot arm =
      geometry::serial_robot(*example_of("serial"), example_of("serial")->nominal);
  arm.tool_is_frame = tool_is_frame;
  return geometry::serial_model(arm);
}

std::shared_ptr<const geometry::RobotModel> panda() {
  using enum geometry::RowForm;
  geometry::SerialRobot arm;
  arm.rows = {
      row_of("q1", kModifiedDh, 0, 0, 333),
      row_of("q2", kModifiedDh, 0, -kRight_rad, 0),
      row_of("q3", kModifiedDh, 0, kRight_rad, 316),
      row_of("q4", kModifiedDh, 82.5, kRight_rad, 0),
      row_of("q5", kModifiedDh, -82.5, -kRight_rad, 384),
      row_of("q6", kModifiedDh, 0, kRight_rad, 0),
      row_of("q7", kModifiedDh, 88, kRight_rad, 0)};
  arm.tool_mm = {10, -20, 107};
  return geometry::serial_model(arm);
}

std::shared_ptr<const geometry::RobotModel> slanted_arm() {
  geometry::SerialRobot arm;
  const auto add = [&](const char* name, const Eigen::Vector3d& origin,
                       const Eigen::Vector3d& turn, const Eigen::Vector3d& axis) {
    geometry::SerialRow row{.name = name, .form = geometry::RowForm::kOrigin};
    row.origin_mm = origin;
    row.turn_rad = turn;
    row.axis = axis.normalized();
    arm.rows.push_back(row);
  };
  add("swing", {0, 0, 200}, {0, 0, 0.3}, {0, 0, 1});
  // Its pitch is upright, where roll and yaw are not told apart.
  add("lift", {50, 0, 100}, {0, kRight_rad, 0}, {0, 1, 0.1});
  add("slide", {0, 30, 250}, {0.4, -0.2, 0.1}, {1, 0, 1});
  arm.rows.back().kind = geometry::JointKind::kPrismatic;
  arm.rows.back().low = -40.0;
  arm.rows.back().high = 60.0;
  add("twist", {120, 0, 40}, {0, 0, -kRight_rad}, {-1, 0.2, 0});
  add("finger", {60, 10, 0}, {0.1, 0.2, 0.3}, {0, 0, 1});
  arm.rows.back().follows = "twist";
  arm.rows.back().ratio = -0.5;
  arm.rows.back().offset = 0.2;
  arm.base_mm = {300, -100, 20};
  arm.base_turn_rad = {0.02, -0.03, 1.2};
  arm.tool_mm = {15, 25, 80};
  return geometry::serial_model(arm);
}

ExportedModel made_model(std::shared_ptr<const geometry::RobotModel> robot, int poses) {
  const geometry::Rig rig = rig_with(std::move(robot));
  std::mt19937_64 engine(14);
  std::normal_distribution<double> drawn;
  ExportedModel model;
  model.inputs = {
      .session = "made",
      .rig_name = rig.name,
      .rig_hash = "sha256:12",
      .data_hash = "sha256:0123456789abcdef0123"};
  model.created_utc = "2026-03-02T08:30:00.000Z";
  model.base = std::make_shared<const simulation::ForwardModel>(rig);
  model.model = model.base->nominal();
  model.nominal = rig.robot.nominal;
  model.order = poses - 1;
  model.time_h = 1.5;
  model.temperature_degC = 23.25;
  const auto& parameters = rig.robot.model->parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    model.model[static_cast<Eigen::Index>(k)] += drawn(engine) * parameters[k].change;
  }
  std::vector<simulation::Trial> trials;
  std::vector<geometry::Pose<double>> X(rig.robot.model->frames.size());
  for (int tries = 0; tries < 100'000 && std::ssize(trials) < poses; ++tries) {
    simulation::Trial trial;
    trial.q.resize(rig.robot.model->joint_count());
    for (Eigen::Index j = 0; j < trial.q.size(); ++j) {
      const auto& joint = rig.robot.model->joints[static_cast<std::size_t>(j)];
      trial.q[j] = std::uniform_real_distribution<double>(joint.low, joint.high)(engine);
    }
    trial.assembly = rig.robot.assembly;
    const bool reached =
        rig.robot.model->forward(model.parameters(), trial.q, trial.assembly, X) &&
        rig.robot.model->forward(rig.robot.nominal, trial.q, trial.assembly, X);
    if (!reached) continue;
    const auto i = static_cast<int>(trials.size());
    trial.time_s = 45.0 * i;
    trial.temperature_c = 20.0 + 0.1 * i;
    for (Eigen::Index j = 0; j < trial.q.size(); ++j) {
      trial.approach.push_back((i + j) % (j + 2) == 0 ? 1 : -1);
    }
    trials.push_back(std::move(trial));
  }
  if (std::ssize(trials) < poses) throw std::runtime_error("no poses are reached");
  auto samples = simulation::circumstances_of(*model.base, model.model, trials);
  for (std::size_t t = 0; t < trials.size(); ++t) {
    model.poses.push_back({trials[t].q, trials[t].assembly, samples[t]});
  }
  return model;
}

ExportedModel with_effects(ExportedModel model, std::vector<simulation::ActiveEffect> effects) {
  model.by = CompensateBy::kExtended;
  model.effects = std::move(effects);
  return model;
}

std::vector<double> three_sizes_of(
    const simulation::Effect& effect, const simulation::Place& place) {
  if (effect.is_curve && place.slides) return {-50.0, 480.0, 1.3, 0.1, 0.0, -0.05, 0.02};
  if (effect.is_curve) return {-2.0, 2.5, 1.3, 1e-3, 0.0, -5e-4, 2e-4};
  std::vector<double> x;
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k) {
    const auto info = simulation::parameter_at(effect, place, k);
    // Different, so that an exchanged one is seen.
    x.push_back(info ? (3 + k) * info->sigma * (k % 2 == 0 ? 1 : -1) : 0.0);
  }
  if (effect.is_step) x.back() = 7;
  return x;
}

std::vector<ModelPose> moments_of(const ExportedModel& model) {
  std::vector<ModelPose> result;
  for (std::size_t i = 0; i < model.poses.size(); ++i) {
    const ModelPose& measured = model.poses[i];
    const Eigen::VectorXd& sides = measured.sample.approach;
    ModelPose pose =
        commanded_pose(model, measured.q, measured.assembly, {sides.begin(), sides.end()});
    pose.sample.time_h = 0.01 * static_cast<double>(i);
    pose.sample.temperature_degC = 18.0 + 0.1 * static_cast<double>(i);
    const double angle = 0.7 * static_cast<double>(i);
    pose.sample.travel = {std::cos(angle), std::sin(angle), 0.0};
    result.push_back(std::move(pose));
  }
  return result;
}

std::vector<std::vector<double>> numbers_in(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::vector<double> row;
    for (std::string word; words >> word;) row.push_back(std::stod(word));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace sixdial::studies
