#include "studies/uncertainty_budget.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/reading_errors.h"
#include "calibration/uncertainty.h"
#include "geometry/coverage.h"
#include "session/stated_figures.h"
#include "simulation/rig_kinds.h"
#include "studies/budget_poses.h"

namespace sixdial::studies {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using simulation::RigQuantity;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
const double kOfStep = 1.0 / std::sqrt(12.0);  // GUM F.2.2.1

double square(double value) { return value * value; }

/// One budget, row by row.
class Making {
 public:
  Making(const BudgetInput& in, const BudgetPoses& poses, Measurand measurand)
      : in_(in),
        poses_(poses),
        by_(measurand == Measurand::kMeasured ? poses.measured() : poses.commanded()) {
    budget_.measurand = measurand;
    budget_.places = poses.places();
  }

  UncertaintyBudget make() {
    if (poses_.by_dials()) {
      add_dials();
      add_known();
    } else {
      add_instrument();
    }
    if (budget_.measurand == Measurand::kCommanded) {
      add_open();
      add_fit();
      add_arrival();
    }
    add_temperature();
    double variance = 0.0;
    for (const BudgetRow& row : budget_.rows) {
      if (row.state == BudgetState::kCounted) variance += of(row);
      if (row.state == BudgetState::kNotStated) budget_.complete = false;
    }
    for (BudgetRow& row : budget_.rows) {
      const bool counts =
          (row.state == BudgetState::kCounted || row.state == BudgetState::kPart) &&
          variance > 0.0;
      row.share = counts ? of(row) / variance : 0.0;
    }
    budget_.combined_mm = std::sqrt(std::max(variance, 0.0));
    budget_.expanded_mm = geometry::kCoverage * budget_.combined_mm;
    return std::move(budget_);
  }

 private:
  static double of(const BudgetRow& row) { return square(row.contribution_mm); }
  BudgetRow& add(BudgetSource source, std::string of, double standard, double variance_mm2) {
    BudgetRow row{
        .source = source,
        .of = std::move(of),
        .standard = standard,
        .contribution_mm = std::sqrt(std::max(variance_mm2, 0.0))};
    row.sensitivity = standard > 0.0 ? row.contribution_mm / standard : kUnknown;
    return budget_.rows.emplace_back(std::move(row));
  }
  BudgetRow& add_unknown(BudgetSource source, std::string of) {
    BudgetRow& row = add(source, std::move(of), kUnknown, 0.0);
    row.state = BudgetState::kNotStated;
    row.contribution_mm = kUnknown;
    return row;
  }
  void add_scatter(BudgetSource source, const VectorXd& sd_mm) {
    const double mean = std::sqrt(sd_mm.squaredNorm() / static_cast<double>(sd_mm.size()));
    BudgetRow& row = add(source, "", mean, by_.of_scatter(sd_mm));
    if (!(mean > 0.0)) row.state = BudgetState::kExact;
    of_dials_mm2_ += square(row.contribution_mm);
  }

  void add_dials() {
    const auto& dials = in_.session.rig.dials;
    VectorXd repeat(std::ssize(dials)), step(std::ssize(dials));
    for (Index d = 0; d < repeat.size(); ++d) {
      repeat[d] = dials[static_cast<std::size_t>(d)].repeatability_mm;
      step[d] = kOfStep * dials[static_cast<std::size_t>(d)].resolution_mm;
    }
    add_scatter(BudgetSource::kRepeatability, repeat);
    add_scatter(BudgetSource::kResolution, step);
  }

  /// The quantities of one kind.
  struct Kind {
    std::string unit{};
    std::vector<Index> stated{};
    int exact = 0;
    std::string unsaid{};
  };
  using Kinds = std::vector<std::pair<std::string_view, Kind>>;

  [[nodiscard]] Kinds kinds() const {
    Kinds kinds;
    const auto kind_of = [&](const RigQuantity& each) -> Kind& {
      for (auto& [name, kind] : kinds) {
        if (name == simulation::kind_of(each)) return kind;
      }
      return kinds.emplace_back(simulation::kind_of(each), Kind{.unit = each.unit}).second;
    };
    for (std::size_t k = 0; k < poses_.quantities().size(); ++k) {
      kind_of(poses_.quantities()[k]).stated.push_back(static_cast<Index>(k));
    }
    for (const RigQuantity& each : simulation::claimed_quantities(in_.session.rig)) {
      Kind& kind = kind_of(each);
      if (simulation::said_of(in_.session.rig, each)) {
        ++kind.exact;
      } else {
        kind.unsaid += (kind.unsaid.empty() ? "" : ", ") + each.place.name;
      }
    }
    return kinds;
  }

  /// What belongs together among the known: quantities of a kind, or the curve of a dial.
  struct Group {
    BudgetSource source = BudgetSource::kRig;
    std::string of{}, unit{"mm"};
    double standard = 0.0;
    std::vector<Index> members{};
  };

  /// Moments of the known before or, with a fit of the rig, after the readings.
  [[nodiscard]] MatrixXd moments() const {
    if (in_.rig != nullptr) return in_.rig->open;
    return MatrixXd::Identity(by_.of_known.rows(), by_.of_known.cols());
  }

  /// What is stated; rows for what is exact or not stated are added here.
  [[nodiscard]] std::vector<Group> stated_groups() {
    std::vector<Group> groups;
    for (const auto& [name, kind] : kinds()) {
      if (!kind.stated.empty()) {
        groups.push_back({BudgetSource::kRig, std::string(name), kind.unit, 0.0, kind.stated});
      } else if (kind.exact > 0) {
        add_exact(BudgetSource::kRig, std::string(name), kind.unit);
      }
      if (!kind.unsaid.empty()) {
        BudgetRow& row = add_unknown(BudgetSource::kRig, std::string(name));
        if (kind.exact > 0 || !kind.stated.empty()) row.not_stated = kind.unsaid;
        row.unit = kind.unit;
      }
    }
    const Index first = std::ssize(poses_.quantities());
    const auto& dials = in_.session.rig.dials;
    for (std::size_t d = 0; d < dials.size(); ++d) {
      const geometry::Dial& dial = dials[d];
      if (!session::states_figure(in_.session.rig_text, dial.id, "accuracy_mm")) {
        add_unknown(BudgetSource::kDialCurve, dial.id);
      } else if (!(dial.accuracy_mm > 0.0)) {
        add_exact(BudgetSource::kDialCurve, dial.id, "mm");
      } else {
        Group& group = groups.emplace_back(Group{BudgetSource::kDialCurve, dial.id});
        for (Index k = 0; k < calibration::kCurveShapes; ++k) {
          group.members.push_back(
              first + calibration::kCurveShapes * static_cast<Index>(d) + k);
        }
      }
    }
    return groups;
  }

  void add_known() {
    std::vector<Group> groups = stated_groups();
    const MatrixXd moment = moments();
    std::vector<Index> all;
    for (Group& group : groups) {
      all.insert(all.end(), group.members.begin(), group.members.end());
      group.standard = standard_of(group, moment);
    }
    const auto variance_of = [&](const std::vector<Index>& members, const MatrixXd& of) {
      return by_.of_known(members, members).cwiseProduct(of).sum();
    };
    if (in_.rig == nullptr) {
      for (const Group& group : groups) {
        const double variance =
            variance_of(group.members, moment(group.members, group.members));
        add(group.source, group.of, group.standard, variance).unit = group.unit;
        if (group.source == BudgetSource::kDialCurve) of_dials_mm2_ += variance;
      }
      return;
    }
    if (all.empty()) return;
    const double together = variance_of(all, moment(all, all));
    add(BudgetSource::kFittedAlong, "", std::sqrt(together), together);
    std::vector<Index> curves;
    for (const Group& group : groups) {
      const MatrixXd own = moment(group.members, group.members);
      const MatrixXd shared = moment(all, group.members);
      const MatrixXd explained =
          shared * own.completeOrthogonalDecomposition().pseudoInverse() * shared.transpose();
      BudgetRow& row =
          add(group.source, group.of, group.standard,
              std::clamp(variance_of(all, explained), 0.0, together));
      row.unit = group.unit;
      row.state = BudgetState::kPart;
      if (group.source != BudgetSource::kDialCurve) continue;
      curves.insert(curves.end(), group.members.begin(), group.members.end());
    }
    of_dials_mm2_ += variance_of(curves, moment(curves, curves));
  }

  /// Root mean square of what its members are known to, in its unit.
  [[nodiscard]] double standard_of(const Group& group, const MatrixXd& moment) const {
    double sum = 0.0;
    for (const Index k : group.members) {
      const bool is_curve = k >= std::ssize(poses_.quantities());
      const double sd =
          is_curve ? curve_sd_of(k) : poses_.quantities()[static_cast<std::size_t>(k)].sd;
      sum += moment(k, k) * square(sd);
    }
    return std::sqrt(sum / static_cast<double>(group.members.size()));
  }
  [[nodiscard]] double curve_sd_of(Index known) const {
    const Index d = (known - std::ssize(poses_.quantities())) / calibration::kCurveShapes;
    return calibration::curve_sd_mm(in_.session.rig.dials[static_cast<std::size_t>(d)]);
  }

  void add_exact(BudgetSource source, std::string of, std::string unit) {
    BudgetRow& row = add(source, std::move(of), 0.0, 0.0);
    row.unit = std::move(unit);
    row.state = BudgetState::kExact;
  }

  void add_instrument() {
    if (in_.space.sigma_is_assumed) {
      add_unknown(BudgetSource::kInstrument, "");
      return;
    }
    const double sd_mm = in_.space.mean_sigma();
    const bool measured = budget_.measurand == Measurand::kMeasured;
    const BudgetRow& row =
        add(BudgetSource::kInstrument, "", sd_mm,
            measured ? poses_.of_space() : poses_.of_space_in_fit(sd_mm));
    of_dials_mm2_ += square(row.contribution_mm);
  }

  void add_open() {
    const MatrixXd held = calibration::held_covariance(in_.fit, in_.space.parameter_info);
    const double variance = poses_.of_parameters(held);
    if (!(variance > 0.0)) return;
    add(BudgetSource::kOpen, "", std::sqrt(variance), variance);
  }

  void add_fit() {
    if (!in_.noise.known) {
      add_unknown(BudgetSource::kFit, "");
      return;
    }
    const double beyond = std::max(0.0, poses_.of_fit() - of_dials_mm2_);
    add(BudgetSource::kFit, "", std::sqrt(beyond), beyond).by_statistics = true;
  }

  void add_arrival() {
    const auto& repeats = in_.noise.repeats;
    if (!repeats) {
      add_unknown(BudgetSource::kArrival, "").by_statistics = true;
      return;
    }
    const double axes = in_.space.position_axes;
    const double beyond = std::max(0.0, axes * square(repeats->sigma_mm) - poses_.of_space());
    add(BudgetSource::kArrival, "", std::sqrt(beyond), beyond).by_statistics = true;
  }

  /// What moved with the thermometer; it is part of what the fit leaves.
  void add_temperature();

  const BudgetInput& in_;
  const BudgetPoses& poses_;
  Sensitivities by_;
  UncertaintyBudget budget_;
  double of_dials_mm2_ = 0.0;
};

void Making::add_temperature() {
  const MatrixXd left = calibration::position_errors(in_.space, in_.fit.x);
  std::vector<double> degc;
  std::vector<Index> at;
  for (Index i = 0; i < left.cols(); ++i) {
    const int sample = in_.space.sample[static_cast<std::size_t>(i)];
    const auto& read = in_.session.samples[static_cast<std::size_t>(sample)].temperature_c;
    if (!read || !left.col(i).allFinite()) continue;
    degc.push_back(*read);
    at.push_back(i);
  }
  constexpr std::size_t kFew = 5;
  if (budget_.measurand == Measurand::kMeasured || degc.size() < kFew) {
    BudgetRow& row = add_unknown(BudgetSource::kTemperature, "");
    row.unit = "degC";
    return;
  }
  const auto n = static_cast<double>(degc.size());
  double mean = 0.0, squares = 0.0;
  for (const double each : degc) mean += each / n;
  for (const double each : degc) squares += square(each - mean);
  const double sd = std::sqrt(squares / (n - 1));
  VectorXd slope = VectorXd::Zero(left.rows());
  for (std::size_t i = 0; i < degc.size() && squares > 0.0; ++i) {
    slope += (degc[i] - mean) / squares * left.col(at[i]);
  }
  BudgetRow& row = add(BudgetSource::kTemperature, "", sd, square(slope.norm() * sd));
  row.unit = "degC";
  row.by_statistics = true;
  row.state = BudgetState::kContained;
}

}  // namespace

std::vector<UncertaintyBudget> uncertainty_budgets(const BudgetInput& input) {
  const BudgetPoses poses(input);
  std::vector<UncertaintyBudget> result;
  for (const Measurand each : {Measurand::kMeasured, Measurand::kCommanded}) {
    result.push_back(Making(input, poses, each).make());
  }
  return result;
}

}  // namespace sixdial::studies
