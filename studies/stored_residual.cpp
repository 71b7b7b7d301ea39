#include "studies/stored_residual.h"

#include <fmt/format.h>

#include <stdexcept>

#include "studies/error.h"

namespace sixdial::studies {

calibration::Correction correction_of(
    const StoredResidualModel& stored, const std::string& session, const std::string& again) {
  const auto refuse = [&](const std::string& what) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format("the stored residual model '{}' cannot be used: {}", stored.name, what),
        {{"session", session}}, again);
  };
  const calibration::ResidualModel* model = calibration::find_residual_model(stored.name);
  if (model == nullptr) refuse("this program does not know it");
  try {
    return calibration::load_residual(*model, stored.saved).correction;
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  return {};
}

}  // namespace sixdial::studies
