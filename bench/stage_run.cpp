// Runs single stages of the calibration and prints their times as JSON: for
// scripts/accuracy.sh, which reads the medians, counts the instructions of a run under
// callgrind, and takes the memory of the process.
//
//   stage_run [--stages a,b] [--runs 9] [--threads 1] [--points 100] [--data FILE] [--table6]
//
// FILE: "set,theta1_rad,theta2_rad,x_target_mm,y_target_mm,x_measured_mm,y_measured_mm".
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>

#include "bench/simulated.h"
#include "calibration/comparison.h"
#include "calibration/five_bar/spaces.h"
#include "calibration/pipeline.h"

namespace sixdial::bench {
namespace {

using namespace calibration;

struct Options {
  std::vector<std::string> stages{};
  int runs = 9;
  int threads = 1;
  int points = 100;
  int epochs = 500;
  std::string data{};
  bool table_6 = false;
};

struct Data {
  geometry::ParameterVector nominal = geometry::default_rig().robot.nominal;
  ObservationSpace g1, g2;
};

Data read(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  Data data;
  std::vector<simulation::Trial> g1;
  std::vector<simulation::Trial> g2;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::stringstream row(line);
    std::string set;
    std::getline(row, set, ',');
    std::array<double, 6> value{};
    for (double& each : value) {
      std::string cell;
      std::getline(row, cell, ',');
      each = std::stod(cell);
    }
    simulation::Trial trial;
    auto& trials = set == "G1" ? g1 : g2;
    trial.point = trial.sample = static_cast<int>(trials.size());
    trial.q = Eigen::Vector2d(value[0], value[1]);
    trial.target_mm = Eigen::Vector2d(value[2], value[3]);
    trial.position_mm = Eigen::Vector2d(value[4], value[5]);
    trial.assembly = geometry::assembly_at(data.nominal, trial.q, *trial.target_mm).value();
    trials.push_back(trial);
  }
  data.g1 = position_space(position_observations(g1), data.nominal);
  data.g2 = position_space(position_observations(g2), data.nominal);
  return data;
}

PipelineSettings settings_of(Profile profile, const Options& options) {
  PipelineSettings settings = settings_for(profile);
  settings.threads = options.threads;
  settings.anfis.epochs = options.epochs;
  settings.anfis.stop_at_target = false;  // all epochs, as the peers train
  return settings;
}

/// Each gives the RMSE on G1 that it reached [mm].
using Stage = std::function<double(const Data&, const Options&)>;

double noise_stage(const Data& data, const Options& options, Linearisation linearisation) {
  NoiseSearchSettings settings;
  settings.linearisation = linearisation;
  settings.threads = options.threads;
  return search_noise(data.g1, settings).rmse_mm;
}

double parameter_stage(const Data& data, const Options& options, SearchCoordinates where) {
  static const Eigen::VectorXd estimate = run_filter(data.g1).v;
  ParameterSearchSettings settings;
  settings.coordinates = where;
  settings.threads = options.threads;
  return search_parameters(data.g1, estimate, settings).rmse_mm;
}

double anfis_stage(const Data& data, const Options& options, bool cross_validate) {
  static const Eigen::MatrixXd residual = position_errors(data.g1, fit_space(data.g1).v);
  const Eigen::MatrixXd inputs = data.g1.joints.transpose();
  AnfisLearning learning;
  learning.anfis.epochs = options.epochs;
  learning.cross_validate = cross_validate;
  double sum = 0.0;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::VectorXd targets = residual.row(axis).transpose();
    const AnfisModel model = learn_anfis(inputs, targets, learning).model;
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      const double left = targets[i] - model.predict(inputs.row(i).transpose());
      sum += left * left;
    }
  }
  return std::sqrt(sum / static_cast<double>(inputs.rows()));
}

double whole(const Data& data, const Options& options, Profile profile) {
  const auto result = run_dqpso_anfis(data.g1, data.g2, settings_of(profile, options));
  if (!result) throw std::runtime_error(result.error().message);
  return result->errors("ekf_dqpso+anfis").g1.rmse_mm;
}

const std::vector<std::pair<std::string, Stage>>& stages() {
  static const std::vector<std::pair<std::string, Stage>> table{
      {"ekf_once",
       [](const Data& data, const Options&) {
         return position_rmse(data.g1, run_filter(data.g1).v);
       }},
      {"qpso1_at_nominal",
       [](const Data& data, const Options& options) {
         return noise_stage(data, options, Linearisation::kNominal);
       }},
      {"qpso1_at_estimate",
       [](const Data& data, const Options& options) {
         return noise_stage(data, options, Linearisation::kEstimate);
       }},
      {"qpso2_raw",
       [](const Data& data, const Options& options) {
         return parameter_stage(data, options, SearchCoordinates::kRaw);
       }},
      {"qpso2_whitened",
       [](const Data& data, const Options& options) {
         return parameter_stage(data, options, SearchCoordinates::kWhitened);
       }},
      {"anfis_paper", [](const Data& data,
                         const Options& options) { return anfis_stage(data, options, false); }},
      {"anfis_chosen", [](const Data& data,
                          const Options& options) { return anfis_stage(data, options, true); }},
      {"lm", [](const Data& data, const Options&) { return fit_space(data.g1).rmse_mm; }},
      {"whole_paper",
       [](const Data& data, const Options& options) {
         return whole(data, options, Profile::kPaper);
       }},
      {"whole_default", [](const Data& data, const Options& options) {
         return whole(data, options, Profile::kDefault);
       }}};
  return table;
}

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void run_stages(const Data& data, const Options& options) {
  const char* comma = "";
  for (const auto& [name, stage] : stages()) {
    if (!options.stages.empty() &&
        std::ranges::find(options.stages, name) == options.stages.end()) {
      continue;
    }
    std::vector<double> wall;
    std::vector<double> processor;
    double rmse_mm = 0.0;
    for (int run = 0; run < options.runs; ++run) {
      const auto began = std::chrono::steady_clock::now();
      const double processor_before = processor_seconds();
      rmse_mm = stage(data, options);
      processor.push_back(processor_seconds() - processor_before);
      wall.push_back(
          std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    }
    std::printf(
        "%s\n  \"%s\": {\"wall_s\": %.3e, \"least_wall_s\": %.3e, \"cpu_s\": %.3e, "
        "\"rmse_g1_mm\": %.9f}",
        comma, name.c_str(), median(wall), *std::ranges::min_element(wall), median(processor),
        rmse_mm);
    comma = ",";
  }
}

void print_table_6(const Data& data) {
  std::vector<MethodChoice> methods;
  methods.reserve(kComparedMethods.size() + 1);
  for (const std::string_view id : kComparedMethods) methods.push_back(*method_choice(id));
  methods.push_back(*method_choice("ekf_dqpso+anfis_paper"));
  const auto compared = compare_methods(data.g1, data.g1, data.g2, methods);
  if (!compared) throw std::runtime_error(compared.error().message);
  const char* comma = "";
  std::printf(" \"table6\": [");
  for (const ComparedMethod& method : compared->methods) {
    const ErrorStats& g1 = method.errors.g1;
    const ErrorStats& g2 = method.errors.g2;
    std::printf(
        "%s\n  {\"method\": \"%s\", \"g1\": [%.4f, %.4f, %.4f], \"g2\": [%.4f, %.4f, %.4f], "
        "\"seconds\": %.4f}",
        comma, method.choice.id.c_str(), g1.mean_mm, g1.std_mm, g1.max_mm, g2.mean_mm,
        g2.std_mm, g2.max_mm, method.identify_seconds + method.residual_seconds);
    comma = ",";
  }
  std::printf("],\n");
}

void print_minimum(const Data& data, const Options& options) {
  std::printf(" \"above_minimum_mm\": {");
  for (const Profile profile : {Profile::kPaper, Profile::kDefault}) {
    const auto result = run_dqpso_anfis(data.g1, data.g2, settings_of(profile, options));
    if (!result) throw std::runtime_error(result.error().message);
    std::printf(
        "%s\"%s\": %.3e", profile == Profile::kPaper ? "" : ", ",
        std::string(to_string(profile)).c_str(), result->above_minimum_mm);
  }
  std::printf("},\n");
}

int run(const Options& options) {
  Data data;
  if (options.data.empty()) {
    data.g1 = position_space(position_observations(simulated(options.points, 1)), data.nominal);
    data.g2 = position_space(position_observations(simulated(50, 2)), data.nominal);
  } else {
    data = read(options.data);
  }
  std::printf(
      "{\"points\": %d, \"threads\": %d, \"runs\": %d,\n", data.g1.samples(), options.threads,
      options.runs);
  if (options.table_6) {
    print_table_6(data);
    print_minimum(data, options);
  }
  std::printf(" \"stages\": {");
  if (!options.table_6) run_stages(data, options);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("},\n \"peak_mib\": %.1f}\n", static_cast<double>(usage.ru_maxrss) / 1024.0);
  return 0;
}

}  // namespace
}  // namespace sixdial::bench

int main(int argc, char** argv) {
  sixdial::bench::Options options;
  CLI::App app{"Times of single stages of the calibration, as JSON."};
  app.add_option("--stages", options.stages, "only these")->delimiter(',');
  app.add_option("--runs", options.runs)->check(CLI::PositiveNumber);
  app.add_option("--threads", options.threads)->check(CLI::PositiveNumber);
  app.add_option("--points", options.points)->check(CLI::Range(5, 1000000));
  app.add_option("--epochs", options.epochs, "of ANFIS")->check(CLI::PositiveNumber);
  app.add_option("--data", options.data, "measured positions instead of simulated ones");
  app.add_flag("--table6", options.table_6, "all methods instead of times");
  CLI11_PARSE(app, argc, argv);
  try {
    return sixdial::bench::run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stage_run: %s\n", error.what());
    return 1;
  }
}
