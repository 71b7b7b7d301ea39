// Time of each stage of the paper's method on 100 points: Table 2's robot, smooth non-kinematic
// error of about 0.03 mm, noise 0.003 mm. One thread unless the name says otherwise.
//
//   calibration_bench                      every stage, default and paper profile
//   calibration_bench --benchmark_repetitions=9 --benchmark_report_aggregates_only=true
#include <benchmark/benchmark.h>

#include <cstdio>

#include "bench/simulated.h"
#include "calibration/five_bar/spaces.h"
#include "calibration/pipeline.h"
#include "geometry/rig.h"

namespace sixdial::calibration {
namespace {

struct Data {
  geometry::ParameterVector nominal = geometry::default_rig().robot.nominal;
  ObservationSpace g1 =
      position_space(position_observations(bench::simulated(100, 1)), nominal);
  ObservationSpace g2 = position_space(position_observations(bench::simulated(50, 2)), nominal);
  Eigen::VectorXd estimate = run_filter(g1).v;
  Eigen::MatrixXd inputs = g1.joints.transpose();
  Eigen::MatrixXd residual = position_errors(g1, fit_space(g1).v);
};
const Data& data() {
  static const Data instance;
  return instance;
}

void ekf_once(benchmark::State& state) {
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(run_filter(data().g1));
  }
}
BENCHMARK(ekf_once)->Unit(benchmark::kMicrosecond);

void qpso1(benchmark::State& state, Linearisation linearisation, int threads) {
  NoiseSearchSettings settings;
  settings.linearisation = linearisation;
  settings.threads = threads;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(search_noise(data().g1, settings));
  }
}
BENCHMARK_CAPTURE(qpso1, filter_at_nominal_50x100, Linearisation::kNominal, 1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(qpso1, filter_at_estimate_50x100, Linearisation::kEstimate, 1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(qpso1, filter_at_nominal_2_threads, Linearisation::kNominal, 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void qpso2(benchmark::State& state, SearchCoordinates coordinates, int threads) {
  ParameterSearchSettings settings;
  settings.coordinates = coordinates;
  settings.threads = threads;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(search_parameters(data().g1, data().estimate, settings));
  }
}
BENCHMARK_CAPTURE(qpso2, raw_50x400, SearchCoordinates::kRaw, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(qpso2, whitened_50x400, SearchCoordinates::kWhitened, 1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(qpso2, raw_2_threads, SearchCoordinates::kRaw, 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void anfis_x_and_y_500_epochs(benchmark::State& state) {
  const Data& d = data();
  for ([[maybe_unused]] auto _ : state) {
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::VectorXd targets = d.residual.row(axis).transpose();
      benchmark::DoNotOptimize(train_anfis(
          d.inputs.topRows(80), targets.head(80), d.inputs.bottomRows(20), targets.tail(20)));
    }
  }
}
BENCHMARK(anfis_x_and_y_500_epochs)->Unit(benchmark::kMillisecond);

void anfis_selection_x_and_y(benchmark::State& state) {
  const Data& d = data();
  for ([[maybe_unused]] auto _ : state) {
    for (int axis = 0; axis < 2; ++axis) {
      benchmark::DoNotOptimize(
          select_anfis(d.inputs, d.residual.row(axis).transpose(), MembershipKind::kGaussian));
    }
  }
}
BENCHMARK(anfis_selection_x_and_y)->Unit(benchmark::kMillisecond);

void levenberg_marquardt(benchmark::State& state) {
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(fit_space(data().g1));
  }
}
BENCHMARK(levenberg_marquardt)->Unit(benchmark::kMicrosecond);

void whole_method(benchmark::State& state, Profile profile, int threads) {
  PipelineSettings settings = settings_for(profile);
  settings.threads = threads;
  for ([[maybe_unused]] auto _ : state) {
    auto result = run_dqpso_anfis(data().g1, data().g2, settings);
    if (!result) state.SkipWithError(result.error().message.c_str());
    benchmark::DoNotOptimize(result);
  }
}
BENCHMARK_CAPTURE(whole_method, paper, Profile::kPaper, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_method, default, Profile::kDefault, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_method, paper_2_threads, Profile::kPaper, 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(whole_method, default_2_threads, Profile::kDefault, 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// What a user sees, in the form of Table 5.
void print_table_5() {
  for (const Profile profile : {Profile::kPaper, Profile::kDefault}) {
    const auto result = run_dqpso_anfis(data().g1, data().g2, settings_for(profile));
    if (!result) continue;
    std::printf(
        "profile %-8s QPSO-1 %.4f s, QPSO-2 %.4f s, ANFIS %.4f s, total %.4f s\n",
        std::string(to_string(profile)).c_str(), result->stage("ekf_qpso1").seconds,
        result->stage("ekf_dqpso").seconds, result->anfis_seconds, result->total_seconds);
  }
}

}  // namespace
}  // namespace sixdial::calibration

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  sixdial::calibration::print_table_5();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
