#include "tests/calibration/support.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "calibration/random.h"
#include "geometry/instruments/contact.h"
#include "tests/support/paths.h"

namespace sixdial::calibration::testing {
namespace {

using Eigen::Vector2d;
using geometry::ParameterVector;

// Gear eccentricity [rad] and compliance under a side load, about 0.02 mm in all at scale 1.
constexpr double kFirstHarmonic_rad = 2.0e-4;
constexpr double kEighthHarmonic_rad = 3.6e-4;
const Vector2d kPhase1(0.3, 1.1);
const Vector2d kPhase8(0.7, 2.0);
constexpr double kCompliance_rad_per_nmm = 1.0e-6;
const Vector2d kLoad_n(0.8, -1.2);

Vector2d true_position(
    const ParameterVector& robot, const Vector2d& q, geometry::Assembly assembly,
    double scale) {
  Vector2d bent = q;
  for (int i = 0; i < 2; ++i) {
    bent[i] += scale * (kFirstHarmonic_rad * std::sin(q[i] + kPhase1[i]) +
                        kEighthHarmonic_rad * std::sin(8 * q[i] + kPhase8[i]));
  }
  const auto pose = geometry::forward(robot, bent, assembly);
  const auto unbent = geometry::forward_derivative(robot, q, assembly);
  if (!pose || !unbent)
    throw std::runtime_error("simulate: the true robot cannot reach a point");
  const Eigen::Matrix2d& J = unbent->J_q;
  return pose->p_WE + scale * kCompliance_rad_per_nmm * J * (J.transpose() * kLoad_n);
}

std::vector<simulation::Trial> trials(
    const SessionPlan& plan, int count, RandomSequence& random) {
  // One jittered point in each cell of a grid, in shuffled order.
  const int columns = std::max(1, static_cast<int>(std::lround(std::sqrt(count))));
  const int rows = (count + columns - 1) / columns;
  std::vector<int> cells;
  for (int i = 0; i < rows * columns; ++i) cells.push_back(i);
  for (int i = rows * columns - 1; i > 0; --i) {
    std::swap(
        cells[static_cast<std::size_t>(i)],
        cells[static_cast<std::size_t>(random.below(i + 1))]);
  }
  cells.resize(static_cast<std::size_t>(count));
  std::vector<simulation::Trial> result;
  for (const int cell : cells) {
    const int row = cell / columns;
    const double u = (cell % columns + random.uniform()) / columns;
    const double w = (row + random.uniform()) / rows;
    const Rectangle& box = plan.workspace;
    const Vector2d target(
        box.x_low_mm + (box.x_high_mm - box.x_low_mm) * u,
        box.y_low_mm + (box.y_high_mm - box.y_low_mm) * w);
    const auto q = geometry::inverse(plan.nominal, target, plan.mode);
    if (!q) throw std::runtime_error("simulate: nominal robot cannot reach a target");
    simulation::Trial trial;
    trial.point = trial.sample = static_cast<int>(result.size());
    trial.q = *q;
    trial.assembly = geometry::assembly_at(plan.nominal, *q, target).value();
    trial.target_mm = target;
    const Vector2d noise(random.normal(), random.normal());
    trial.position_mm = true_position(plan.robot, *q, trial.assembly, plan.non_kinematic) +
                        plan.noise_mm * noise;
    trial.position_covariance = plan.noise_mm * plan.noise_mm * Eigen::Matrix2d::Identity();
    result.push_back(trial);
  }
  return result;
}

}  // namespace

SimulatedSession simulate(const SessionPlan& plan, std::uint64_t seed) {
  RandomSequence random(seed, 900);
  SimulatedSession session;
  session.nominal = plan.nominal;
  session.robot = plan.robot;
  session.g1 = position_observations(trials(plan, plan.g1_points, random));
  session.g2 = position_observations(trials(plan, plan.g2_points, random));
  return session;
}

DialSession simulate_dials(const SessionPlan& plan, std::uint64_t seed, geometry::Mount mount) {
  DialSession session;
  session.rig = geometry::default_rig();
  session.rig.robot.nominal = plan.nominal;
  session.rig.robot.working_mode = plan.mode;
  session.rig.cuboid.mount = mount;
  session.robot = plan.robot;
  RandomSequence random(seed, 902);
  session.clamp_rad = random.uniform(-1.0, 1.0) * std::numbers::pi / 180.0;
  const double reference = geometry::reference_link_angle(session.rig).value();
  const auto dials = session.rig.dial_geometries();
  const auto measure = [&](int count) {
    SessionPlan exact = plan;
    exact.noise_mm = 0.0;
    std::vector<simulation::Trial> result = trials(exact, count, random);
    for (simulation::Trial& trial : result) {
      const auto pose = geometry::forward(plan.robot, trial.q, trial.assembly).value();
      const double gamma =
          mount == geometry::Mount::kFree
              ? random.uniform(-0.05, 0.05)
              : geometry::cuboid_angle(session.rig, reference, pose, session.clamp_rad);
      trial.reading.resize(dials.size());
      std::vector<geometry::DialReading> readings;
      for (std::size_t k = 0; k < dials.size(); ++k) {
        const auto contact =
            geometry::touch(dials[k], {*trial.position_mm, gamma}, session.rig.cuboid.side_mm);
        if (!contact) continue;
        const double reading_mm = contact->displacement_mm + plan.noise_mm * random.normal();
        trial.reading[k] = reading_mm;
        readings.push_back({static_cast<int>(k), reading_mm, plan.noise_mm});
      }
      trial.position_mm.reset();
      const auto estimate =
          geometry::best_active_three(dials, readings, session.rig.cuboid.side_mm, gamma);
      if (!estimate) continue;
      trial.position_mm = estimate->pose.p_WE;
      trial.position_covariance = estimate->covariance.topLeftCorner<2, 2>();
      trial.gamma_rad = estimate->pose.gamma_rad;
    }
    return result;
  };
  session.g1 = measure(plan.g1_points);
  session.g2 = measure(plan.g2_points);
  return session;
}

ParameterVector random_robot(const ParameterVector& nominal, std::uint64_t seed) {
  RandomSequence random(seed, 901);
  ParameterVector v = nominal;
  for (int i = 0; i < 5; ++i) v[i] += random.uniform(-0.5, 0.5);
  for (int i = 5; i < 7; ++i) v[i] += random.uniform(-1.0, 1.0);
  for (int i = 7; i < 10; ++i) {
    v[i] += random.uniform(-1.0, 1.0) * std::numbers::pi / 180.0;
  }
  return v;
}

Rectangle workspace_of(geometry::WorkingMode mode) {
  if (mode == geometry::WorkingMode{+1, +1}) return kDefaultWorkspace;
  if (mode == geometry::WorkingMode{-1, -1}) return {-40, -16, 30, 66};
  if (mode == geometry::WorkingMode{+1, -1}) return {-10, 10, 74, 100};
  return {-12, 12, 44, 74};
}

MeasuredSession measured_session_00() {
  const geometry::Rig rig = geometry::default_rig();
  MeasuredSession session;
  session.nominal = rig.robot.nominal;
  session.robot << 59.6285702027692, 59.99927786244012, 60.101498357623356, 59.52868900837194,
      89.64792608457745, 0.856422045920739, -0.8591588476916063, -0.0038769981357824287,
      0.01564961528063017, 0.0042545399969138465;
  const std::string path = test_paths::test_data() + "/session_00/session.csv";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::string line;
  std::getline(file, line);
  const auto dials = rig.dial_geometries();
  std::vector<simulation::Trial> g1;
  std::vector<simulation::Trial> g2;
  while (std::getline(file, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<std::string> cells;
    std::stringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    cells.resize(17);
    simulation::Trial trial;
    trial.point = std::stoi(cells[1]);
    trial.q = Vector2d(std::stod(cells[4]), std::stod(cells[5]));
    trial.target_mm = Vector2d(std::stod(cells[6]), std::stod(cells[7]));
    trial.assembly = geometry::assembly_at(session.nominal, trial.q, *trial.target_mm).value();
    std::vector<geometry::DialReading> readings;
    for (int dial = 0; dial < 6; ++dial) {
      const std::string& cell = cells[static_cast<std::size_t>(11 + dial)];
      if (!cell.empty()) readings.push_back({dial, std::stod(cell), 0.002});
    }
    const auto reference = geometry::reference_link_angle(rig).value();
    const auto nominal_pose = geometry::forward(session.nominal, trial.q, trial.assembly);
    const double gamma = geometry::cuboid_angle(rig, reference, *nominal_pose, 0.0);
    const auto pose = geometry::best_active_three(dials, readings, rig.cuboid.side_mm, gamma);
    if (pose) {
      trial.position_mm = pose->pose.p_WE;
      trial.position_covariance = pose->covariance.topLeftCorner<2, 2>();
    }
    (cells[0] == "G1" ? g1 : g2).push_back(trial);
  }
  session.g1 = position_observations(g1);
  session.g2 = position_observations(g2);
  return session;
}

std::vector<char> fixed(std::initializer_list<int> parameters) {
  std::vector<char> result(geometry::kParameterCount, 0);
  for (const int each : parameters) result[static_cast<std::size_t>(each)] = 1;
  return result;
}

}  // namespace sixdial::calibration::testing
