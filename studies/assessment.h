// What a session can and cannot tell about the robot, as JSON that results carry and reports
// show: uncertainty of each parameter and of the position over the workspace, directions that
// the poses leave open, readings that stand out.
#pragma once

#include <string>
#include <vector>

#include "calibration/five_bar/spaces.h"
#include "calibration/gross_errors.h"
#include "calibration/uncertainty.h"
#include "session/session.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::studies {

/// A session with the readings that stand out marked bad ("gross error"), and what was found.
struct CheckedSession {
  session::Session session;
  calibration::GrossErrorCheck g1;  // set aside
  calibration::GrossErrorCheck g2;  // listed only: G2 judges with all it has
};
/// `set_aside` false: the list alone, the session is unchanged.
[[nodiscard]] CheckedSession check_gross_errors(
    const session::Session& session, const calibration::IdentifySettings& settings,
    bool set_aside);
[[nodiscard]] Json gross_errors_json(
    const CheckedSession& checked, const session::Session& session, bool set_aside);

/// "assessment" of a result: noise, parameters, identifiability, position_uncertainty.
/// `trials`: of G1. `fit`: of the space at the parameters that are assessed.
[[nodiscard]] Json assessment_json(
    const calibration::ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    std::span<const simulation::Trial> g1, std::span<const simulation::Trial> all,
    const geometry::Rig& rig);

/// Standard deviation of each parameter from positions and from raw readings, side by side;
/// null where the session has only one of them, or one leaves something open.
[[nodiscard]] Json precision_json(
    std::span<const simulation::Trial> g1, const session::Session& session,
    const calibration::IdentifySettings& settings);
[[nodiscard]] std::string precision_line(const Json& precision);

/// The space that a request names: "positions" or "dials". Throws Error bad_data where the
/// session has no dial readings for the latter.
[[nodiscard]] calibration::ObservationSpace space_of(
    const std::string& name, std::span<const simulation::Trial> trials,
    const session::Session& session, double noise_mm);

/// Parameters that keep their nominal value: those of `fix`, and where `free` is not empty all
/// that it does not name. Throws Error invalid_params with the nearest name.
[[nodiscard]] std::vector<char> fixed_parameters(
    const calibration::ObservationSpace& space, const std::vector<std::string>& fix,
    const std::vector<std::string>& free);

/// Standard deviation of one axis of a measured position [mm], from the rig file's figures for
/// the dials; empty for an instrument that gives none.
[[nodiscard]] std::optional<double> rig_noise_mm(const calibration::PositionObservations& set);

/// What people read of it on the screen, a sentence a line.
[[nodiscard]] std::vector<std::string> assessment_lines(const Json& assessment);
[[nodiscard]] std::vector<std::string> gross_error_lines(const Json& gross_errors);

}  // namespace sixdial::studies
