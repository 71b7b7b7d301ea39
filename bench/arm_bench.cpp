// A six-axis arm measured at 1,500 places: geometry with covariance, and curves of its joints.
#include <benchmark/benchmark.h>

#include <random>

#include "calibration/joint_curves.h"
#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "geometry/tool.h"

namespace sixdial {
namespace {

struct Measured {
  geometry::Rig rig;
  std::vector<simulation::Trial> trials;
};

const Measured& arm() {
  static const Measured made = [] {
    Measured result;
    geometry::Rig& rig = result.rig;
    rig.robot.model = geometry::find_robot_kind("serial")->example();
    rig.robot.nominal = rig.robot.model->nominal;
    rig.instrument.kind = "position";
    rig.instrument.dimensions = 3;
    std::mt19937_64 random(1);
    std::normal_distribution<double> noise(0.0, 0.02);
    std::uniform_real_distribution<double> angle(-2.0, 2.0);
    Eigen::VectorXd truth = rig.robot.nominal;
    for (Eigen::Index i = 0; i < truth.size(); ++i) {
      truth[i] +=
          0.2 * angle(random) * rig.robot.model->parameters[static_cast<std::size_t>(i)].change;
    }
    const geometry::Tool tool(rig);
    for (int i = 0; i < 1'500; ++i) {
      simulation::Trial trial;
      trial.sample = trial.point = i;
      trial.q.resize(6);
      for (double& each : trial.q) each = angle(random);
      trial.position_mm = *tool.position(truth, trial.q, trial.assembly);
      for (double& each : *trial.position_mm) each += noise(random);
      result.trials.push_back(std::move(trial));
    }
    return result;
  }();
  return made;
}

void geometry_with_covariance(benchmark::State& state) {
  const auto space = calibration::position_space(arm().trials, arm().rig);
  for ([[maybe_unused]] auto _ : state) {
    const auto fit = calibration::fit_space(space);
    benchmark::DoNotOptimize(fit.covariance.trace());
  }
}
BENCHMARK(geometry_with_covariance)->Unit(benchmark::kMillisecond);

void derivatives_of_one_pose(benchmark::State& state) {
  const geometry::RobotModel& robot = *arm().rig.robot.model;
  geometry::Frames frames(robot);
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(robot.forward_derivative(
        robot.nominal, arm().trials[0].q, geometry::Assembly::kLeft, frames));
  }
}
BENCHMARK(derivatives_of_one_pose)->Unit(benchmark::kMicrosecond);

void joint_curves(benchmark::State& state) {
  const auto space = calibration::position_space(arm().trials, arm().rig);
  const auto start = calibration::fit_space(space);
  for ([[maybe_unused]] auto _ : state) {
    const auto fit = calibration::fit_joint_curves(arm().trials, arm().rig, start.v);
    benchmark::DoNotOptimize(fit->sigma_mm);
  }
}
BENCHMARK(joint_curves)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace sixdial

BENCHMARK_MAIN();
