// A way to learn what kinematics leaves over, from joint values: one file in residual_models/
// and one row in the table for each. Any number of joints in, any number of channels out.
// Whatever is learned is bounded outside the trained region.
//
// Example:
//   const ResidualModel& gp = *find_residual_model("gp");
//   const TrainedResidual learned = train_residual(gp, joints, residual_mm);
//   const Eigen::VectorXd q = joints.row(0).transpose();
//   learned.correction(q).size();  // -> residual_mm.cols()
//   load_residual(gp, learned.saved).correction(q);  // -> learned.correction(q)
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/anfis.h"

namespace sixdial::calibration {

struct ResidualSettings {
  std::uint64_t seed = 1;
  std::vector<int> inputs;                // joints that the model sees; empty: all
  std::vector<std::string> output_names;  // of the channels, for notes; empty: 1, 2, ...
  double holdout_fraction = 0.2;
  AnfisSettings anfis;  // anfis_paper as given; anfis chooses functions and ridge
  int bpnn_hidden = 40;
  int bpnn_epochs = 40000;
  double bpnn_target_mse = 1e-5;  // [mm^2]
};

/// What a trained model knows, as matrices by name: store these, and `load_residual` gives the
/// same answers again, bit for bit.
using SavedResidual = std::map<std::string, Eigen::MatrixXd>;

struct TrainedResidual {
  /// Learned residual (outputs x 1) [mm] at all joint values of the space: add it to f(v).
  /// Bounded.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& joints)> correction;
  /// Its standard deviation [mm], noise of a measurement excluded; empty where the model has
  /// none.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& joints)> sd;
  Eigen::VectorXd effective_parameters;  // by output
  std::string note;                      // sizes and hyperparameters chosen, in words
  SavedResidual saved;
};

/// joints: samples x inputs; residual_mm: samples x outputs (measured - f(v)), whose names are
/// in settings.output_names.
using TrainFunction = std::function<TrainedResidual(
    const Eigen::MatrixXd& joints, const Eigen::MatrixXd& residual_mm,
    const ResidualSettings& settings, const std::stop_token& stop)>;

/// `correction`, `sd` and `effective_parameters` from what training left in `saved`. Throws
/// std::invalid_argument that names the matrix which is missing or has another size.
using LoadFunction = std::function<TrainedResidual(const SavedResidual& saved)>;

/// What a row that is added at run time does.
struct MadeResidualModel {
  TrainFunction train;
  LoadFunction load;  // empty: what it learned cannot be stored
};

/// A row of the table: one for each file of residual_models/, and those that are added at run
/// time.
struct ResidualModel {
  std::string_view name;         // "anfis"
  std::string_view title;        // as tables name it: "Gaussian process"
  std::string_view description;  // for people
  TrainedResidual (*train)(
      const Eigen::MatrixXd& joints, const Eigen::MatrixXd& residual_mm,
      const ResidualSettings& settings, const std::stop_token& stop) = nullptr;
  TrainedResidual (*load)(const SavedResidual& saved) = nullptr;
  const MadeResidualModel* made = nullptr;  // of a row added at run time, instead of these
};

/// The program's own rows, then those added at run time.
[[nodiscard]] std::vector<const ResidualModel*> all_residual_models();
/// Null if there is none of that name.
[[nodiscard]] const ResidualModel* find_residual_model(std::string_view name);
/// Adds a row for as long as the program runs; every command takes it from then on. Throws
/// std::invalid_argument where the name is taken or no name.
const ResidualModel& add_residual_model(
    std::string name, std::string description, TrainFunction train, LoadFunction load = {});

/// Trains on the joints of settings.inputs, and bounds the answer: joint values clamped to the
/// trained box, output to the range of the residuals and a tenth of it beyond. `joints`:
/// samples x all joints of the space. Throws std::invalid_argument with what is wrong: too few
/// samples, or more inputs than the model can take (a grid of m functions for each of n joints
/// is m^n rules: name fewer inputs).
[[nodiscard]] TrainedResidual train_residual(
    const ResidualModel& model, const Eigen::MatrixXd& joints,
    const Eigen::MatrixXd& residual_mm, const ResidualSettings& settings = {},
    const std::stop_token& stop = {});

/// What was trained and stored, bounded as it was. Throws std::invalid_argument that names what
/// is missing.
[[nodiscard]] TrainedResidual load_residual(
    const ResidualModel& model, const SavedResidual& saved);

// Shared by the files of residual_models/.

/// The matrix of that name; rows or columns below 0: any number. Throws std::invalid_argument
/// where it is missing or has another size.
[[nodiscard]] const Eigen::MatrixXd& saved_matrix(
    const SavedResidual& saved, const std::string& name, Eigen::Index rows = -1,
    Eigen::Index columns = -1);
[[nodiscard]] double saved_number(const SavedResidual& saved, const std::string& name);
[[nodiscard]] Eigen::MatrixXd number_to_save(double value);
/// How many outputs a model has, and what the matrices of output `k` begin with: "output1.".
void save_outputs(Eigen::Index outputs, SavedResidual& saved);
[[nodiscard]] Eigen::Index saved_outputs(const SavedResidual& saved);
[[nodiscard]] std::string output_prefix(Eigen::Index output);

struct HoldoutSplit {
  std::vector<int> train, check;  // each rising
};
/// A seeded shuffle of the poses, of which `fraction` is for checking: repeats of a pose stay
/// together. joints: samples x joints.
[[nodiscard]] HoldoutSplit holdout_split(
    const Eigen::MatrixXd& joints, double fraction, std::uint64_t seed);

/// Columns shifted and scaled to mean 0 and standard deviation 1.
struct Standardiser {
  Eigen::RowVectorXd mean;
  Eigen::RowVectorXd scale;
  explicit Standardiser(const Eigen::MatrixXd& columns);
  explicit Standardiser(const SavedResidual& saved);  // "input_mean", "input_scale"
  void save(SavedResidual& saved) const;
  [[nodiscard]] Eigen::MatrixXd operator()(const Eigen::MatrixXd& columns) const {
    return ((columns.rowwise() - mean).array().rowwise() / scale.array()).matrix();
  }
};

/// "x: ...; y: ...", words(k) of each output under its name.
[[nodiscard]] std::string by_output(
    const ResidualSettings& settings, Eigen::Index outputs,
    const std::function<std::string(Eigen::Index output)>& words);

}  // namespace sixdial::calibration
