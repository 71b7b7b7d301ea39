// Everything that a calibration report shows, as plain values. report_run.h fills it from a
// result; html_report.h, json_report.h and csv_report.h turn it into pages and tables.
//
// Sign: a residual is measured minus modelled position in W. (+0.010, 0) mm means that the tool
// stands 0.010 mm further along +x than the model says.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/robot_kind.h"
#include "report/document.h"
#include "report/facts.h"
#include "session/session.h"
#include "session/traceability.h"
#include "studies/calibration_result.h"
#include "studies/conformity.h"
#include "studies/dial_residuals.h"

namespace sixdial::report {

/// A dial as the certificate lists it.
struct ShownDial {
  std::string id{};           // "A"
  std::string description{};  // maker and type, or "digital dial indicator"
  std::string serial{};       // empty: not known
  std::string connection{};   // "modbus-tcp://…", empty: imported data
  std::optional<double> resolution_mm{}, accuracy_mm{}, repeatability_mm{}, travel_mm{},
      tip_radius_mm{};
};

/// What identifies the work. Empty texts are shown as "not recorded".
struct Head {
  std::string title = "Calibration report";
  std::string session_name{}, rig_name{}, robot{};
  std::string operator_name{}, place{};
  std::string measured_from{}, measured_to{};  // ISO 8601 UTC
  std::string reported{};                      // ISO 8601 UTC
  std::optional<double> temperature_min_c{}, temperature_max_c{};
  // From the first to the last dial's answer of a sample; empty: no times were kept.
  std::optional<double> readings_within_median_ms{}, readings_within_max_ms{};
  int times_that_go_back = 0;  // samples dated before the one above: a clock was set
  std::string software_version{};
  std::string data_hash{}, rig_hash{};  // "sha256:…"
  std::optional<std::uint64_t> seed{};
  std::string profile{};  // "default" or "paper"
  std::vector<std::pair<std::string, std::string>>
      settings;  // name, value: what else was chosen
  std::vector<ShownDial> instruments{};
  session::Traceability traced{};  // to what the figures go back, as far as the rig file says
};

/// One line of the paper's Table 2, in shown units (mm or deg).
struct ShownParameter {
  std::string name{}, unit{};
  std::string meaning{};  // "proximal link of leg 1"; empty: the kind has no words
  double nominal = 0.0, identified = 0.0;
  std::optional<double> sd{}, low{}, high{};  // standard deviation, 95 % interval
  bool held = false;                          // these poses cannot identify it: kept at nominal
};
/// Shown value over stored value (mm, rad) of a row's unit.
[[nodiscard]] double shown_per_unit(const ShownParameter& row);
/// A robot's parameters [mm, rad] as rows; sd and interval (1.96 sd) from the covariance.
/// `held` by parameter; empty: none.
[[nodiscard]] std::vector<ShownParameter> parameter_rows(
    const geometry::RobotModel& robot, const Eigen::VectorXd& nominal,
    const Eigen::VectorXd& identified, const std::optional<Eigen::MatrixXd>& covariance,
    const std::vector<bool>& held = {});

struct ShownCorrelation {
  std::string first{}, second{};
  double value = 0.0;
};

/// Absolute position error over a set, equation (41) [mm].
struct ErrorStatistics {
  double mean_mm = 0.0, std_mm = 0.0, max_mm = 0.0;
  std::optional<double> mean_low_mm{}, mean_high_mm{};  // 95 % interval of the mean
  int points = 0;
};

/// One line of the paper's Table 6. `points[i].residual_mm[m]` belongs to `methods[m]`.
struct ShownMethod {
  std::string id{};    // "before", "ekf_dqpso", "ekf_dqpso+anfis", …
  std::string name{};  // "EKF-DQPSO & ANFIS"
  std::optional<ErrorStatistics> g1{}, g2{};
  std::optional<double> seconds{};
  bool has_residual_model = false;  // ANFIS or a rival of it on top of the parameters
  bool on_map = true;               // a panel of the residual map
};

/// A joint, as the columns of its values are headed.
struct ShownJoint {
  std::string name{}, unit{};  // "q1"; "rad" or "mm"
};

struct PointRow {
  std::string set{};  // "G1", "G2" or another name
  int point = 0, repeat = 0;
  std::optional<Eigen::VectorXd> q{};               // joint by joint, as ReportData::joints
  std::optional<geometry::Position> target_mm{};    // in W
  std::optional<geometry::Position> measured_mm{};  // in W; empty: contacts allow no position
  std::string dials{};                              // those that gave the position: "CDB"
  std::optional<double> temperature_c{};
  std::optional<double> time_s{};  // since the first sample
  std::vector<int> approach{};     // sign of each joint's last move, 0 unknown
  std::vector<std::optional<geometry::Position>> residual_mm{};  // by method
  bool left_out = false;  // not used at all: a warning says why
};

struct BadReading {
  std::string set{};
  int point = 0, repeat = 0;
  std::string dial{}, reason{};
  std::optional<double> value_mm{};
};

/// A heading with lines under it in the box that is read first.
struct OpeningList {
  std::string heading{};
  std::string kind{};  // "to_do", "cautions", "not_judged": how it looks
  std::vector<std::string> lines{};
};

/// The box that is read first, where the page is not about a calibration.
struct Opening {
  std::string subject{};   // "Diagnosis"
  std::string title{};     // "Backlash of joint 2"
  std::string mood{};      // "plain", "good", "open" or "bad"
  std::string headline{};  // a few sentences
  std::string decision{};  // on the tolerance
  std::optional<double> before_mm{}, after_mm{};
  std::string basis{};  // what these two are
  std::vector<OpeningList> lists{};
};

/// The figures of the recommended model, which are read first.
struct Headline {
  std::string model{};                       // "robot and backlash of joint 2"
  ErrorStatistics before{}, after{};         // on G2's targets
  bool by_tool_shift = false;                // both are tool shifts, of a diagnosis
  std::optional<double> predicted_mm{};      // mean, where it was measured again
  std::optional<std::string> measured_in{};  // session that holds what was measured again
};

struct ReportData {
  Head head{};
  /// Instead of the state of the robot; the sections on a calibration are then left out.
  std::optional<Opening> opening{};
  /// In the same box below the state of the robot.
  std::vector<OpeningList> also{};
  /// Sentences that belong into the headline of the state of the robot.
  std::vector<std::string> headline_more{};
  /// More of what to do and of what could not be judged, in the same box.
  std::vector<std::string> to_do{}, not_judged{};
  /// What to do first: how to use what is recommended. Empty: by the delivered method.
  std::vector<std::string> first_to_do{};
  /// Instead of the figures of the delivered method; empty: these.
  std::optional<Headline> headline{};
  std::string parameters_note{};  // above the table of identified parameters

  std::vector<ShownParameter> parameters{};
  std::vector<ShownCorrelation> correlations{};  // those above 0.9 in absolute value
  std::vector<double> singular_values{};         // of the scaled Jacobian
  std::optional<double> condition_number{};
  std::vector<std::string> unidentifiable{};  // "length rises while offset1 falls"

  std::vector<ShownMethod> methods{};  // in the paper's order, "before" first
  std::vector<std::string> turns{};    // how far the tool's turn is off, a sentence a set
  std::string result_method{};         // id of the one that is delivered; empty: the last
  /// The robot was commanded with the result and measured again (Fig. 7). Else figures after
  /// calibration are differences between measured and modelled positions.
  bool measured_again = false;
  /// Against the user's tolerance; empty: none is stated.
  std::optional<studies::Conformity> conformity{};
  /// A diagnosis named a cause, or found something that it could not name.
  bool cause_remains = false;
  /// Standard deviation of a measured position from the dials alone, root of the mean trace.
  std::optional<double> position_noise_mm{};

  std::optional<double> rmse_mm{};                // of the identified parameters on G1
  std::optional<double> least_squares_rmse_mm{};  // the minimum of the same objective
  std::vector<studies::Convergence> convergence{};
  std::vector<studies::Trace> traces{};

  std::vector<ShownJoint> joints{};
  int axes = 2;  // coordinates of positions, targets and residuals
  std::vector<PointRow> points{};
  std::vector<studies::DialRow> dials{};
  int samples = 0;  // all that were kept
  std::vector<session::RejectedRow> rejected{};
  std::vector<BadReading> bad_readings{};
  Facts facts{};  // what several sections show

  std::vector<studies::Warning> warnings{};  // what speaks against the session
  bool plausibility_judged = true;           // false: nobody looked for warnings
  std::vector<Section> sections{};  // of later parts: comparison, uncertainty, diagnosis
};

/// Mean, standard deviation (n - 1) and maximum of |residual| of a method over a set, with the
/// 95 % interval of the mean (1.96 std / sqrt n; none for one point). Empty if no point has
/// one.
[[nodiscard]] std::optional<ErrorStatistics> error_statistics(
    const ReportData& data, std::string_view set, std::size_t method);
/// Index of the delivered method; none if there are no methods or the id is not among them.
[[nodiscard]] std::optional<std::size_t> result_index(const ReportData& data);
/// Samples that were used, but whose contacts allowed no position.
[[nodiscard]] int points_without_position(const ReportData& data);

}  // namespace sixdial::report
