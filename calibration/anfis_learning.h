// ANFIS on residuals as the project uses it: chosen by cross-validation, or the paper's
// setting.
#pragma once

#include <iterator>
#include <optional>

#include "calibration/anfis_selection.h"

namespace sixdial::calibration {

/// One network, of one output, and how it came about.
struct AnfisReport {
  AnfisModel model;
  std::optional<AnfisSelection> selection;  // where cross-validated
  std::vector<double> train_rmse_mm;        // by epoch
  std::vector<double> check_rmse_mm;
  int best_epoch = 0;
  int target_reached = 0;  // epoch; 0: never
  int samples = 0;         // that the consequents rest on
  /// No epoch was trained after the one that reached the target.
  [[nodiscard]] bool stopped_at_target() const {
    return target_reached > 0 && std::ssize(train_rmse_mm) == target_reached;
  }
};

struct AnfisLearning {
  AnfisSettings anfis;            // functions and ridge are replaced where cross_validate
  bool cross_validate = true;     // choose functions, ridge or no network at all
  double holdout_fraction = 0.2;  // for choosing the epoch
  std::uint64_t seed = 1;
};

/// inputs: samples x inputs; targets: samples [mm]. `selector`: of these inputs, where several
/// outputs are learned at them; null: their own.
[[nodiscard]] AnfisReport learn_anfis(
    const Eigen::MatrixXd& inputs, const Eigen::VectorXd& targets,
    const AnfisLearning& settings, const std::stop_token& stop = {},
    const AnfisSelector* selector = nullptr);

/// What networks, one an output, have learned at joint values [mm]: add it to f(v).
[[nodiscard]] Eigen::VectorXd anfis_correction(
    const std::vector<AnfisModel>& networks, const Eigen::VectorXd& joints);

}  // namespace sixdial::calibration
