// What the dials and the rig around the robot may do to the readings: curves and habits of the
// dials within their makers' limits, and places that the rig file claims exactly.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "diagnosis/rig_columns.h"
#include "diagnosis/search.h"
#include "diagnosis/unknown_search.h"

namespace sixdial::diagnosis {
namespace {

/// Own reading of each dial, trials x dials, as own_reading_mm tells it.
Eigen::MatrixXd own_readings_mm(const Readings& readings, const Eigen::VectorXd& simulated_mm) {
  const auto dials = static_cast<Eigen::Index>(readings.channel_count());
  Eigen::MatrixXd own(static_cast<Eigen::Index>(readings.trials().size()), dials);
  for (Eigen::Index d = 0; d < dials; ++d) {
    own.col(d) = own_reading_mm(readings, simulated_mm, static_cast<std::size_t>(d));
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

Eigen::VectorXd own_reading_mm(
    const Readings& readings, const Eigen::VectorXd& simulated_mm, std::size_t dial) {
  const auto& rows = readings.rows_of_dial(dial);
  Eigen::VectorXd own = Eigen::VectorXd::Constant(
      static_cast<Eigen::Index>(readings.trials().size()),
      std::numeric_limits<double>::quiet_NaN());
  double sum = 0.0;
  for (const Eigen::Index row : rows) {
    const double simulated = simulated_mm[row];
    const double value = std::isfinite(simulated) ? simulated : readings.measured_mm()[row];
    own[readings.rows()[static_cast<std::size_t>(row)].trial] = value;
    sum += value;
  }
  const double mean = rows.empty() ? 0.0 : sum / static_cast<double>(rows.size());
  return own.unaryExpr([mean](double v) { return std::isfinite(v) ? v : mean; });
}

void along_background(
    UnknownSearch& search, const Readings& readings, const Eigen::VectorXd& simulated_mm) {
  double limit_mm = std::numeric_limits<double>::infinity();
  for (const geometry::Dial& dial : readings.model().rig().dials) {
    limit_mm = std::min(limit_mm, dial.accuracy_mm);
  }
  if (limit_mm > 0) {
    search.dial_curves(own_readings_mm(readings, simulated_mm), limit_mm);
    for (const simulation::Effect* effect : simulation::all_effects()) {
      if (effect->within_accuracy) {
        search.dial_habit(
            std::string(effect->cause), habit_columns(readings, *effect), limit_mm);
      }
    }
  }
}

void along_rig(UnknownSearch& search, const Readings& readings, const JointFit& fit) {
  if (readings.has_rig_allowance()) return;  // part of every fit, or ruled out
  search.rig_geometry(
      rig_columns(readings, fit.model, simulation::claimed_quantities(readings.model().rig())));
}

std::vector<UnknownCandidate> score_background(const Readings& readings, const JointFit& fit) {
  if (!readings.has_dials() && !gives_under_weight(fit)) return {};
  UnknownSearch search(readings, fit);
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  if (readings.has_dials()) along_background(search, readings, simulated);
  along_masses(search, readings, fit, extended, simulated);
  return search.ranked();
}

std::vector<RigRival> rig_rivals(const Readings& readings, const JointFit& fit) {
  if (!readings.has_dials() && !gives_under_weight(fit)) return {};
  UnknownSearch search(readings, fit);
  search.keep_tried();
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  if (readings.has_dials()) {
    along_background(search, readings, simulated);
    along_rig(search, readings, fit);
  }
  along_masses(search, readings, fit, extended, simulated);
  return search.tried();
}

}  // namespace sixdial::diagnosis
