// What the dials and the rig around the robot may do to the readings: curves and habits of the
// dials within their makers' limits, and places that the rig file claims exactly.
#include <algorithm>
#include <limits>
#include <string>

#include "diagnosis/rig_columns.h"
#include "diagnosis/search.h"
#include "diagnosis/unknown_search.h"

namespace sixdial::diagnosis {
namespace {

/// Own reading of each dial, trials x dials; its mean where it has none, which has no row.
Eigen::MatrixXd own_readings_mm(const Readings& readings) {
  const auto dials = static_cast<Eigen::Index>(readings.channel_count());
  Eigen::MatrixXd own(static_cast<Eigen::Index>(readings.trials().size()), dials);
  for (Eigen::Index d = 0; d < dials; ++d) {
    const auto& rows = readings.rows_of_dial(static_cast<std::size_t>(d));
    double sum = 0.0;
    for (const Eigen::Index row : rows) sum += readings.measured_mm()[row];
    own.col(d).setConstant(rows.empty() ? 0.0 : sum / static_cast<double>(rows.size()));
    for (const Eigen::Index row : rows) {
      own(readings.rows()[static_cast<std::size_t>(row)].trial, d) =
          readings.measured_mm()[row];
    }
  }
  return own;
}

/// d(reading)/d(first parameter) of an effect of dials, count x dials.
Eigen::MatrixXd habit_columns(const Readings& readings, const simulation::Effect& effect) {
  const auto places = effect.places(readings.model().rig());
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(readings.count(), static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto& rows = readings.rows_of_dial(static_cast<std::size_t>(places[k].dial));
    const Eigen::MatrixXd own = readings.reading_columns(at_rest({&effect, places[k]}), 1);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      columns(rows[i], static_cast<Eigen::Index>(k)) = own(static_cast<Eigen::Index>(i), 0);
    }
  }
  return columns;
}

}  // namespace

void along_rig(UnknownSearch& search, const Readings& readings, const JointFit& fit) {
  double limit_mm = std::numeric_limits<double>::infinity();
  for (const geometry::Dial& dial : readings.model().rig().dials) {
    limit_mm = std::min(limit_mm, dial.accuracy_mm);
  }
  if (limit_mm > 0) {
    search.dial_curves(own_readings_mm(readings), limit_mm);
    for (const simulation::Effect* effect : simulation::all_effects()) {
      if (effect->within_accuracy) {
        search.dial_habit(
            std::string(effect->cause), habit_columns(readings, *effect), limit_mm);
      }
    }
  }
  if (readings.rig_allowance()) return;  // part of every fit, or ruled out
  search.rig_geometry(
      rig_columns(readings, fit.model, simulation::claimed_quantities(readings.model().rig())));
}

}  // namespace sixdial::diagnosis
