// A way to learn what kinematics leaves over, from joint angles: one file in residual_models/
// and one row in the table for each. Whatever is learned is bounded outside the trained region.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/anfis.h"

namespace sixdial::calibration {

struct ResidualSettings {
  std::uint64_t seed = 1;
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
  /// Learned residual [mm] at joint angles [rad]: add it to f(v). Bounded.
  std::function<Eigen::Vector2d(const Eigen::Vector2d& q_rad)> correction;
  /// Its standard deviation [mm], noise of a measurement excluded; empty where the model has
  /// none.
  std::function<Eigen::Vector2d(const Eigen::Vector2d& q_rad)> sd;
  Eigen::Vector2d effective_parameters = Eigen::Vector2d::Zero();  // for x and for y
  std::string note;  // sizes and hyperparameters chosen, in words
  SavedResidual saved;
};

struct ResidualModel {
  std::string_view name;         // "anfis"
  std::string_view title;        // as tables name it: "Gaussian process"
  std::string_view description;  // for people
  /// q_rad: n x 2; residual_mm: n x 2 (measured - f(v)).
  TrainedResidual (*train)(
      const Eigen::MatrixX2d& q_rad, const Eigen::MatrixX2d& residual_mm,
      const ResidualSettings& settings, const std::stop_token& stop);
  /// `correction`, `sd` and `effective_parameters` from what `train` left in `saved`. Throws
  /// std::invalid_argument that names the matrix which is missing or has another size.
  TrainedResidual (*load)(const SavedResidual& saved);
};

[[nodiscard]] std::span<const ResidualModel* const> all_residual_models();
/// Null if there is none of that name.
[[nodiscard]] const ResidualModel* find_residual_model(std::string_view name);

/// Trains, and bounds the answer: angles clamped to the trained box, output to the range of the
/// residuals and a tenth of it beyond.
[[nodiscard]] TrainedResidual train_residual(
    const ResidualModel& model, const Eigen::MatrixX2d& q_rad,
    const Eigen::MatrixX2d& residual_mm, const ResidualSettings& settings = {},
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

struct HoldoutSplit {
  std::vector<int> train, check;  // each rising
};
/// A seeded shuffle of 0 .. n-1, of which `fraction` is for checking.
[[nodiscard]] HoldoutSplit holdout_split(int n, double fraction, std::uint64_t seed);

/// Columns shifted and scaled to mean 0 and standard deviation 1.
struct Standardiser {
  Eigen::RowVector2d mean = Eigen::RowVector2d::Zero();
  Eigen::RowVector2d scale = Eigen::RowVector2d::Ones();
  explicit Standardiser(const Eigen::MatrixX2d& columns);
  explicit Standardiser(const SavedResidual& saved);  // "input_mean", "input_scale"
  void save(SavedResidual& saved) const;
  [[nodiscard]] Eigen::MatrixX2d operator()(const Eigen::MatrixX2d& columns) const {
    return ((columns.rowwise() - mean).array().rowwise() / scale.array()).matrix();
  }
};

}  // namespace sixdial::calibration
