#include "report/documents/network_json.h"

namespace sixdial::report {

void check_network(const calibration::AnfisModel& model) {
  const auto refuse = [](const std::string& what) {
    throw studies::StudyError(
        studies::StudyErrorCode::kBadData, "a stored network cannot be used: " + what, {},
        "Calibrate the session again.");
  };
  const int inputs = model.inputs;
  const int functions = model.functions;
  if (inputs < 1 || functions < 0 || std::pow(functions, inputs) > calibration::kMostRules) {
    refuse("\"input_mean\" and \"functions\" make no network");
  }
  const auto fits = [&](const char* key, const auto& matrix, Eigen::Index rows,
                        Eigen::Index columns) {
    if (matrix.rows() != rows || matrix.cols() != columns) {
      refuse(fmt::format("\"{}\" should have {} x {} numbers", key, rows, columns));
    }
    if (!matrix.allFinite()) refuse(fmt::format("\"{}\" holds what is not a number", key));
  };
  fits("input_mean", model.input_mean, inputs, 1);
  fits("input_scale", model.input_scale, inputs, 1);
  fits("box_low", model.box_low, inputs, 1);
  fits("box_high", model.box_high, inputs, 1);
  if (functions == 0) return;
  fits("centre", model.centre, functions, inputs);
  fits("width", model.width, functions, inputs);
  if (model.kind == calibration::MembershipKind::kBell) {
    fits("slope", model.slope, functions, inputs);
  }
  fits("consequents", model.consequents, model.rules(), inputs + 1);
}

}  // namespace sixdial::report
