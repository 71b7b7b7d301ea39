// A residual model as a result keeps it: what training left, by the name of its row.
#pragma once

#include <Eigen/Core>
#include <string>

#include "calibration/compensation.h"
#include "calibration/residual_model.h"

namespace sixdial::studies {

struct StoredResidualModel {
  std::string name{};                      // row of the registry, "gp"
  std::string note{};                      // sizes that it chose, for people
  Eigen::VectorXd effective_parameters{};  // of each coordinate
  calibration::SavedResidual saved{};
};

/// What it adds to a position. Throws StudyError bad_data where this program cannot load it;
/// `session`, `again`: whose it is and what to do, for the error.
[[nodiscard]] calibration::Correction correction_of(
    const StoredResidualModel& stored, const std::string& session, const std::string& again);

}  // namespace sixdial::studies
