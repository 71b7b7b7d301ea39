// What a diagnosis found, as values: ids, numbers and states. Words are made of them in
// report/words/, the document "sixdial.diagnosis" in report/documents/diagnosis_json.h.
// Numbers that are not known are NaN. Lists have as many joints, parameters and dials as the
// session's rig.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "studies/cross_validation.h"
#include "studies/inputs.h"
#include "studies/measured_joints.h"
#include "studies/plausibility.h"
#include "studies/stored_residual.h"

namespace sixdial::studies {

/// An effect somewhere, by the ids of both: "joint_backlash" at "joint2".
struct HypothesisId {
  std::string cause{};
  std::string where{};
  /// "joint_backlash@joint2".
  [[nodiscard]] std::string name() const { return cause + "@" + where; }
  friend bool operator==(const HypothesisId&, const HypothesisId&) = default;
};

enum class CauseKind {
  kEffect,         // of the catalogue (simulation/effect.h)
  kOutliers,       // single readings far from everything else
  kStaleReadings,  // a reading handed over a second time, after the tool had moved
  kRigGeometry,    // dials and cuboid are not where and as the rig file claims
};
enum class Certainty { kCertain, kTied };
enum class Standing {
  kConfirmed,  // points that were fitted and points that were not both show it
  kSuspected,
};

enum class RivalKind {
  kEffect,
  kUnknown,    // something smooth that nobody named
  kNothing,    // too weak to be sure that there is anything
  kUnsettled,  // the fit had not converged: another size, or another cause, may fit better
  kLeftOut,    // it rests on leaving out a large share of the readings, which may say else
};
struct Rival {
  RivalKind kind = RivalKind::kEffect;
  HypothesisId id{};                      // of kEffect
  std::vector<std::string> depends_on{};  // of kUnknown: covariates, "theta2", "time"
  double log_odds = 0.0;                  // natural, for the cause that was named
};

/// What is drawn along an axis, or what residuals are sorted by.
enum class CurveAxis {
  kJointAngle,        // [deg]
  kJointSlide,        // value of a sliding joint [mm]
  kToolX,             // [mm]
  kToolY,             // [mm]
  kToolZ,             // [mm]
  kOtherJoint,        // angle of the joint that another one is coupled with [deg]
  kTime,              // since the first sample [min]
  kSample,            // its number, where times are not known
  kTemperature,       // [degC]
  kTravel,            // direction of the tool's last move [deg]
  kForce,             // of the plungers, along the axis of the panel [N]
  kOtherCoordinate,   // of the tool: y in the panel of x, x in the panel of y [mm]
  kFaceRotation,      // against its nominal direction [deg]
  kReadingTimesFace,  // reading times rotation of the face [mm rad]
  kReading,           // of one dial [mm]
  kAnyReading,        // of whichever dial the residual belongs to [mm]
  kSimulatedReading,  // [mm]
  kJointArrival,      // the side that each joint came from
  kPlungerTravel,     // the way that the plunger went last
  kDial,
};
struct Along {
  CurveAxis axis = CurveAxis::kSample;
  int joint = -1;  // of kJointAngle, kJointSlide and kOtherJoint
  friend bool operator==(const Along&, const Along&) = default;
};

/// The quantity in which a cause shows.
enum class Quantity {
  kJointAngleError,  // [deg]
  kJointSlideError,  // of a sliding joint [mm]
  kToolShift,        // [mm]
  kResidual,         // of a dial [mm]
  kReading,          // of a dial [mm]
};
enum class CurveGroupOf {
  kSamples,
  kReadings,
  kTurningUp,  // samples at which the joint arrived turning up
  kTurningDown,
  kPlungerIn,  // readings whose plunger was going in
  kPlungerOut,
};
struct CurveGroup {
  CurveGroupOf of = CurveGroupOf::kSamples;
  std::vector<double> x{};         // in rising order
  std::vector<double> measured{};  // what the readings say if the model leaves the cause out
  std::vector<double> model{};     // the cause as fitted
};
enum class CurvePanelOf { kWhole, kToolX, kToolY, kToolZ, kDial };
struct CurvePanel {
  CurvePanelOf of = CurvePanelOf::kWhole;
  std::string dial{};  // of kDial: its id
  std::vector<CurveGroup> groups{};
};
/// How a cause shows, ready to be drawn.
struct SignatureCurve {
  Quantity quantity = Quantity::kResidual;
  int joint = -1;  // of kJointAngleError and kJointSlideError
  Along along{};
  bool is_function = false;  // of what it is drawn against: its fit is a line, not a cloud
  std::vector<CurvePanel> panels{};
};

struct FoundCause {
  CauseKind kind = CauseKind::kEffect;
  HypothesisId id{};
  std::vector<Rival> tied_with{};
  std::vector<diagnosis::Estimate> estimate{};
  double delta_bic = 0.0;  // BIC without it less BIC with it
  double gain_mm = 0.0;    // mean position error on held-out samples without it less with it
  Standing standing = Standing::kSuspected;
  std::optional<bool> on_g1{};  // G1 alone shows it too; empty: not asked
  double g2_log_odds = 0.0;
  double visible_ratio = 0.0;  // RMS of what only it explains, over the noise
  std::optional<SignatureCurve> signature{};

  /// Part of the fit with the causes.
  [[nodiscard]] bool is_in_fit() const { return kind == CauseKind::kEffect; }
  [[nodiscard]] Certainty certainty() const {
    return tied_with.empty() ? Certainty::kCertain : Certainty::kTied;
  }
  /// Of the readings, not of the robot or the instruments.
  [[nodiscard]] bool is_data_fault() const {
    return kind == CauseKind::kOutliers || kind == CauseKind::kStaleReadings;
  }
  /// The odds say that it is there, but the points that were fitted and those that were not do
  /// not show it alike.
  [[nodiscard]] bool is_only_suspected() const {
    return !is_data_fault() && !is_doubtful() && standing == Standing::kSuspected;
  }
  /// Its only rival is that there is nothing at all.
  [[nodiscard]] bool is_doubtful() const {
    return tied_with.size() == 1 && tied_with.front().kind == RivalKind::kNothing;
  }
};

struct GrossReading {
  int sample = 0;  // its number in the session
  std::string set{};
  int point = 0;
  int repeat = 0;
  std::string dial{};
  double size_mm = 0.0;
  bool stale = false;      // handed over twice
  bool near_edge = false;  // the tip touches at the end of the face, or beyond
};

/// What is left of the readings, and whether that is noise.
struct Unexplained {
  bool significant = false;
  bool scatter = false;  // larger than the noise, without structure
  std::optional<diagnosis::ScatterFound> scatter_size{};
  std::vector<std::string> depends_on{};  // covariates of something smooth that nobody named
  double rms_mm = 0.0;                    // of the good readings, after the named causes
  std::vector<diagnosis::NoisyDial> noisy_dials{};
};

struct NotTestable {
  HypothesisId id{};
  diagnosis::WhyNotTestable why = diagnosis::WhyNotTestable::kAbsorbed;
};

struct Limit {
  HypothesisId id{};
  std::string parameter{}, unit{};         // its size is that of this one
  double detect = 0.0;                     // not finite: at no size
  double name = 0.0;                       // not finite: a rival does the same
  std::optional<HypothesisId> rival{};     // the hardest to tell apart
  double surviving = 1.0;                  // share that the fitted parameters do not absorb
  std::vector<std::string> absorbed_by{};  // those that do, largest first
  double plausible = 0.0;
};

struct GainRow {
  diagnosis::GainModel model = diagnosis::GainModel::kNominal;
  bool network = false;
  std::optional<HypothesisId> without{};             // the cause left out
  double mean_mm = 0.0, std_mm = 0.0, max_mm = 0.0;  // position error
  double rms_mm = 0.0;                               // of the readings
  std::map<std::string, double> rms_by_dial_mm{};    // by id; x and y where there are no dials
  double difference_mm = 0.0, low_mm = 0.0, high_mm = 0.0;  // of the mean, against calibrated
  double removed_share = 0.0;
};

struct JudgedOn {
  int samples = 0;  // that were not fitted
  int fitted_samples = 0;
  bool held_out_by_program = false;  // the session has no G2
};

/// Of the robot alone, and with the causes.
struct FitSummary {
  double noise_mm = 0.0;
  double gross_share = 0.0;
  int fitted = 0;  // number of parameters that the data determine
  bool converged = false;
};

struct FittedEffect {
  HypothesisId id{};
  std::vector<double> x{};  // as the effect's parameters
};
/// What commanding needs (extended_command.h): robot and named causes fitted to all good
/// readings (diagnosis/command_fit.h), what a residual model learned of the rest, and what the
/// last sample knew of time and temperature.
struct ExtendedFit {
  std::vector<double> model{};  // parameters of the robot, then the clamp [mm, rad]
  std::vector<FittedEffect> effects{};
  std::optional<StoredResidualModel> residual_model{};  // empty: none was trained
  int last_order = 0;
  double last_time_h = 0.0;
  double last_temperature_degC = 20.0;
  // As CalibrationResult has them; empty in diagnoses of early versions.
  std::optional<std::vector<double>> nominal{};  // parameters of the nominal robot
  std::optional<std::vector<MeasuredJoints>> measured_joints{};
  std::optional<geometry::Similarity> frame{};
  /// Of `model` and of what the fit moved in `effects`, in this order; of robots in space.
  std::optional<Eigen::MatrixXd> covariance{};
  /// Standard deviation of what smooth errors without a name leave at a coordinate of the tool
  /// [mm]; of robots in space, empty in early versions.
  std::optional<double> left_sd_mm{};
  /// Where this fit has the dials: the frame that it commands in. Empty in early versions.
  std::optional<std::vector<diagnosis::RigSeen>> rig{};
  /// Whether it was fitted to turns of the tool, too; of robots in space. Empty in early
  /// versions.
  std::optional<bool> turns{};
};

/// One entry a reading.
struct Residuals {
  std::vector<int> sample{};
  std::vector<std::string> dial{};
  std::vector<double> measured_mm{};
  std::vector<double> before_mm{}, after_mm{};  // measured less simulated
  std::vector<bool> good{};
};

/// One entry a sample whose tool can be told.
struct ToolShifts {
  std::vector<int> sample{};
  std::vector<double> x_mm{}, y_mm{};                    // where the tool was
  std::optional<std::vector<double>> z_mm{};             // of a robot that works in space
  std::vector<Eigen::VectorXd> before_mm{}, after_mm{};  // in as many axes
};

/// RMS of the good readings that fall in one class.
struct LeftInClass {
  double at = 0.0;               // the mean of a number; the place in the order of others
  double low = 0.0, high = 0.0;  // of a number
  std::vector<int> signs{};      // of kJointArrival one a joint, of kPlungerTravel one
  std::string dial{};            // of kDial
  int readings = 0;
  double before_mm = 0.0, after_mm = 0.0;
  double smooth_mm = 0.0;  // less the smooth part that nobody named
};
struct LeftAlong {
  Along along{};
  bool has_smooth = false;
  std::vector<LeftInClass> classes{};
};

struct DiagnosisResult {
  std::string created_utc{};
  Inputs inputs{};
  bool has_dials = true;  // raw readings; else positions only
  diagnosis::DiagnosisSettings settings{};
  std::vector<FoundCause> causes{};
  diagnosis::Noise noise{};
  Unexplained unexplained{};
  std::vector<diagnosis::Dependence> dependence{};
  std::vector<GrossReading> gross_readings{};
  std::vector<NotTestable> not_testable{};
  std::vector<Limit> limits{};
  std::vector<diagnosis::ParameterChange> parameters{};
  /// The rig as the data see it; empty in results of early versions.
  std::optional<std::vector<diagnosis::RigSeen>> rig{};
  FitSummary baseline{}, extended{};
  std::vector<GainRow> gain{};                        // empty: not computed
  std::optional<CrossValidation> cross_validation{};  // within G1; empty: not computed
  JudgedOn judged_on{};
  double false_alarm_probability = 1.0;
  ExtendedFit extended_fit{};
  std::vector<LeftAlong> left_along{};
  ToolShifts tool_shifts{};
  Residuals residuals{};
  /// What speaks against the session; empty in results of early versions.
  std::optional<std::vector<Warning>> warnings{};
  double seconds = 0.0;
};

enum class VerdictKind {
  kNamed,    // no cause has rivals, and nothing is left unexplained
  kTied,     // at least one cause has rivals
  kUnknown,  // what is left depends on something: wins over causes that are named
  kScatter,  // what is left is larger than the noise, without structure: the same
  kNothing,
};
[[nodiscard]] VerdictKind verdict_kind(const DiagnosisResult& result);
/// True if the diagnosis names something that the robot or the instruments have, not only bad
/// readings.
[[nodiscard]] bool names_an_effect(const DiagnosisResult& result);
/// Share of the readings that the fit with the causes did without.
[[nodiscard]] double left_out(const DiagnosisResult& result);
/// The row of a model without a network, null if there is none.
[[nodiscard]] const GainRow* gain_row(
    const DiagnosisResult& result, diagnosis::GainModel model, bool network = false);
/// The limit of a hypothesis, null if there is none.
[[nodiscard]] const Limit* limit_of(const DiagnosisResult& result, const HypothesisId& id);
/// How far a parameter moves when the causes are fitted with it, and that in standard
/// deviations of the fit without them (NaN where that is none).
[[nodiscard]] double moved(const diagnosis::ParameterChange& change);
[[nodiscard]] double moved_sigma(const diagnosis::ParameterChange& change);

}  // namespace sixdial::studies
