#include "calibration/anfis_learning.h"

#include "calibration/residual_model.h"

namespace sixdial::calibration {

AnfisReport learn_anfis(
    const Eigen::MatrixXd& inputs, const Eigen::VectorXd& targets,
    const AnfisLearning& settings, const std::stop_token& stop, const AnfisSelector* selector) {
  AnfisReport report;
  report.samples = static_cast<int>(inputs.rows());
  AnfisSettings anfis = settings.anfis;
  if (settings.cross_validate) {
    report.selection = selector != nullptr ? selector->select(targets)
                                           : select_anfis(inputs, targets, anfis.kind);
    anfis.functions = report.selection->chosen.functions;
    anfis.ridge = report.selection->chosen.ridge;
    if (anfis.functions == 0) {
      report.model = zero_anfis(static_cast<int>(inputs.cols()));
      return report;
    }
  }
  const HoldoutSplit split = holdout_split(inputs, settings.holdout_fraction, settings.seed);
  AnfisTraining training = train_anfis(
      inputs(split.train, Eigen::all), targets(split.train), inputs(split.check, Eigen::all),
      targets(split.check), anfis, stop);
  report.train_rmse_mm = std::move(training.train_rmse);
  report.check_rmse_mm = std::move(training.check_rmse);
  report.best_epoch = training.best_epoch;
  report.target_reached = training.target_reached;
  report.model = std::move(training.model);
  if (report.selection) {
    // The epoch is chosen; now every sample may speak for the consequents.
    report.model = scaled(
        refit_consequents(report.model, inputs, targets, anfis.ridge, anfis.output_margin),
        report.selection->gain);
  } else {
    report.samples = static_cast<int>(split.train.size());
  }
  return report;
}

Eigen::VectorXd anfis_correction(
    const std::vector<AnfisModel>& networks, const Eigen::VectorXd& joints) {
  Eigen::VectorXd result(std::ssize(networks));
  for (std::size_t k = 0; k < networks.size(); ++k) {
    result[static_cast<Eigen::Index>(k)] = networks[k].predict(joints);
  }
  return result;
}

}  // namespace sixdial::calibration
