// What a session can and cannot tell about the robot: uncertainty of each parameter and of the
// position over the workspace, directions that the poses leave open, readings that stand out.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/gross_errors.h"
#include "calibration/rig_spaces.h"
#include "calibration/uncertainty.h"
#include "diagnosis/rig_fit.h"
#include "session/session.h"
#include "studies/error.h"
#include "studies/mode_assessment.h"
#include "studies/plausibility.h"

namespace sixdial::studies {

/// One parameter of a fit, in its stored unit ("mm" or "rad").
struct ParameterRow {
  std::string name{}, unit{};
  double nominal = 0.0, identified = 0.0;
  double sd = 0.0, low_95 = 0.0, high_95 = 0.0;
  bool fixed = false;        // kept its nominal value because it was asked to
  bool partly_held = false;  // part of a direction held at nominal: sd has the prior in it
};
[[nodiscard]] std::vector<ParameterRow> parameter_rows(
    const std::vector<calibration::ParameterEstimate>& estimates,
    const calibration::ObservationSpace& space);

/// A direction in the parameters that no pose of the session determines; it was held at
/// nominal.
struct HeldRow {
  std::string words{};          // which parameters rise while which fall
  Eigen::VectorXd direction{};  // unit vector in scaled parameters
  double singular_value = 0.0;
  /// How far the tool moves at most for one unit along it [mm]; empty without a workspace.
  std::optional<double> effect_mm{};
};

struct CorrelationRow {
  std::string first{}, second{};  // names of parameters
  double coefficient = 0.0;
};
[[nodiscard]] std::vector<CorrelationRow> correlation_rows(
    const calibration::Identifiability& known, std::span<const std::string_view> names);

struct IdentifiabilityRow {
  Eigen::VectorXd singular_values{};             // of the scaled Jacobian, falling
  double condition = 0.0;                        // not finite: a direction is open
  std::optional<double> condition_determined{};  // without what is held
  double observability = 0.0;
  int free = 0, determined = 0;  // parameters, combinations of them
  std::vector<HeldRow> held{};
  std::vector<CorrelationRow> correlations{};
};

/// Uncertainty of the predicted position on a grid, row by row from low y; NaN where the robot
/// cannot go.
struct PositionMap {
  std::vector<double> x_mm{}, y_mm{};        // of columns, of rows
  std::vector<double> sd_x_mm{}, sd_y_mm{};  // by node
  std::vector<double> radius_95_mm{};        // by node
  double mean_sd_mm = 0.0, max_sd_mm = 0.0, max_radius_95_mm = 0.0;
  geometry::Position worst_mm;
};

struct Assessment {
  std::string space{};  // "positions", "poses" (with turns), "dials"
  int samples = 0;
  int readings = 0;  // coordinates of positions, or dial readings
  calibration::NoiseEstimate noise{};
  calibration::Structure structure{};  // what neighbouring poses share in the residuals
  std::vector<ParameterRow> parameters{};
  Eigen::MatrixXd covariance{};  // of the parameters; documents have that of the result
  std::vector<WorkingModeRow> working_modes{};
  IdentifiabilityRow identifiability{};
  std::optional<PositionMap> position_uncertainty{};
};

/// `fit`: of space.problem(weighting), at the parameters that are assessed. `g1`: the trials of
/// the space; `all`: those that show the workspace.
[[nodiscard]] Assessment assess(
    const calibration::ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    calibration::Weighting weighting, std::span<const simulation::Trial> g1,
    std::span<const simulation::Trial> all, const geometry::Rig& rig);

/// Standard deviation of each parameter from positions and from raw readings, side by side.
struct Precision {
  struct Row {
    std::string name{}, unit{};
    double positions_sd = 0.0, dials_sd = 0.0;
    double ratio = 0.0;  // positions over dials
  };
  std::vector<Row> parameters{};
  double geometric_mean_ratio = 0.0;
};
/// Empty where the session has only positions or only readings, or where one of the two leaves
/// a direction open. `space` and `fit`: the least-squares fit that was made already; the other
/// one is fitted here.
[[nodiscard]] std::optional<Precision> precision_of(
    const calibration::ObservationSpace& space, const calibration::Identified& fit,
    std::span<const simulation::Trial> g1, const session::Session& session,
    const calibration::IdentifySettings& settings);

/// What was done with a reading that stands out.
enum class Treatment {
  kSetAside,       // G1: not fitted
  kKept,           // G1: listed, but fitted
  kKeptValidates,  // G2 judges with all it has
};
/// "set aside", "kept", "kept, validates".
[[nodiscard]] std::string_view to_string(Treatment treatment);
[[nodiscard]] std::optional<Treatment> treatment_from(std::string_view text);

struct GrossErrors {
  struct Found {
    int sample = 0;  // row of the session
    std::string set{};
    int point = 0, repeat = 0;
    int line = 0;                        // of session.csv
    std::optional<std::string> dial{};   // empty: the position as a whole
    std::optional<double> reading_mm{};  // of that dial
    double size_mm = 0.0, times_sigma = 0.0;
    Treatment treatment = Treatment::kSetAside;
  };
  std::vector<Found> found{};
  int readings = 0;       // that were judged
  double sigma_mm = 0.0;  // robust standard deviation of a good reading
  double limit_times_sigma = 0.0;
  bool set_aside = true;
  /// Number of readings that stand out in G1 and G2 if these are too many to be accidents; else
  /// 0.
  int systematic_g1 = 0, systematic_g2 = 0;
  std::optional<std::string> not_possible{};  // why the check could not judge
};

/// The session with what stands out in G1 marked bad (positions and turns: removed), and all
/// that did; of turns `warnings` say it.
struct CheckedSession {
  session::Session session;  // its rig: as the readings see it
  GrossErrors found;
  std::optional<diagnosis::RigFit> rig{};            // empty: nothing of it is stated
  std::vector<simulation::Trial> all{}, g1{}, g2{};  // of `session`
  std::vector<Warning> warnings{};  // what changed while it was measured, turns that slipped
};
/// `set_aside` false: the list alone, the session is unchanged. `not_possible`: why nothing can
/// be judged; then nothing is accused.
[[nodiscard]] CheckedSession check_gross_errors(
    const session::Session& session, const calibration::IdentifySettings& settings,
    bool set_aside, const std::optional<std::string>& not_possible = {});

/// The space that a request names: "positions" (where the instrument gives none, its readings:
/// calibration/reading_space.h) or "dials". Throws StudyError bad_data where the
/// session has no dial readings for the latter.
[[nodiscard]] calibration::ObservationSpace space_of(
    const std::string& name, std::span<const simulation::Trial> trials,
    const session::Session& session, double noise_mm);

/// Parameters that keep their nominal value: those of `fix`, and where `free` is not empty all
/// that it does not name. Throws StudyError invalid_params with the nearest name, or where none
/// of the robot's (the first `robot_parameters` of the space) is left free.
[[nodiscard]] std::vector<char> fixed_parameters(
    const calibration::ObservationSpace& space, int robot_parameters,
    const std::vector<std::string>& fix, const std::vector<std::string>& free);

/// Standard deviation of one axis of a measured position [mm], from the rig file's figures for
/// the dials; of a reading where the instrument gives no positions; empty where nobody says it.
[[nodiscard]] std::optional<double> rig_noise_mm(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

}  // namespace sixdial::studies
