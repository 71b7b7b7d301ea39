#include "diagnosis/unknown.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "diagnosis/covariate.h"
#include "diagnosis/eliminated.h"
#include "diagnosis/evidence.h"
#include "diagnosis/rig_columns.h"
#include "diagnosis/search.h"
#include "diagnosis/stages.h"
#include "geometry/long_work.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kPi = std::numbers::pi;

/// Kernels of one box: sines on [-half_width, half_width] in half ranges of the covariate stand
/// for a Gaussian process, as long as its length is short against the box. A negative length is
/// the exponential kernel's (a wandering value, as of a random walk).
struct Box {
  double half_width;
  std::vector<double> lengths;
};
const std::vector<Box> kAlong{
    {1.3, {0.08, 0.15, 0.3, -0.5, -2.0}}, {2.0, {0.6}}, {3.5, {1.2, 2.5}}};
// A dial's curve is smooth over its travel; what is shorter is an error of its gear.
const std::vector<Box> kCurves{{1.3, {0.2, 0.35}}, {2.0, {0.6}}, {3.5, {1.2}}};
constexpr int kOfCurve = 10;
/// A maker's limit is kept by nearly all readings: two standard deviations.
constexpr double kShareOfLimit = 0.5;
/// Claimed exactly and off by more than so many standard deviations of a workshop: that is one
/// gross mistake, and no rig that was measured with a ruler.
constexpr double kMostOfAWorkshop = 3.0;
const std::vector<Box> kOver{{1.3, {0.3, 0.45}}, {2.0, {0.6, 0.9}}, {3.5, {1.3, 2.5}}};

/// Covariate scaled to [-1, 1]; empty if it does not vary.
std::optional<Eigen::VectorXd> scaled(const Eigen::VectorXd& values) {
  const double low = values.minCoeff();
  const double high = values.maxCoeff();
  if (!(high - low > 1e-9 * (1 + std::abs(high)))) return std::nullopt;
  return Eigen::VectorXd((values.array() - 0.5 * (low + high)).matrix() / (0.5 * (high - low)));
}

/// Samples x count.
Eigen::MatrixXd basis_of(const Eigen::VectorXd& u, double half_width, int count) {
  Eigen::MatrixXd basis(u.size(), count);
  for (int j = 0; j < count; ++j) {
    basis.col(j) = ((u.array() + half_width) * (kPi * (j + 1) / (2 * half_width))).sin() /
                   std::sqrt(half_width);
  }
  return basis;
}

/// Spectral density of a kernel at basis function j.
double spectrum(int j, double half_width, double length) {
  const double omega = kPi * (j + 1) / (2 * half_width);
  if (length < 0) return -length / (1 + omega * omega * length * length);
  return length * std::exp(-0.5 * omega * omega * length * length);
}

/// Columns scaled by their spread, without those that could not be seen.
Eigen::MatrixXd prominent(const Eigen::MatrixXd& columns, const Eigen::VectorXd& spread) {
  constexpr double kLeastShare = 1e-4;
  const Eigen::VectorXd size = columns.colwise().norm().transpose().cwiseProduct(spread);
  Eigen::MatrixXd result(columns.rows(), columns.cols());
  Eigen::Index kept = 0;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    if (size[j] > kLeastShare * size.maxCoeff()) {
      result.col(kept++) = columns.col(j) * spread[j];
    }
  }
  return result.leftCols(kept);
}

/// What each trial has that something could depend on.
struct Covariates {
  Eigen::MatrixXd q, approach;  // trials x joints
  Eigen::VectorXd x, y, gamma, time, temperature;
};

Covariates covariates_of(
    const Readings& readings, const JointFit& fit, const simulation::ExtendedModel& extended) {
  const auto& trials = readings.trials();
  const auto count = static_cast<Eigen::Index>(trials.size());
  Covariates at;
  for (Eigen::VectorXd* each : {&at.x, &at.y, &at.gamma, &at.time, &at.temperature}) {
    each->resize(count);
  }
  const Eigen::Index joints = trials.empty() ? 0 : trials.front().q.size();
  at.q.resize(count, joints);
  at.approach.resize(count, joints);
  simulation::Scene scene;
  for (Eigen::Index t = 0; t < count; ++t) {
    const auto i = static_cast<std::size_t>(t);
    const simulation::Circumstance& sample = readings.circumstances()[i];
    at.q.row(t) = trials[i].q.transpose();
    at.time[t] = sample.time_h;
    at.temperature[t] = sample.temperature_degC;
    at.approach.row(t) = sample.approach.transpose();
    const bool there = extended.run(fit.model, trials[i], sample, scene).has_value();
    const Eigen::Index before = std::max<Eigen::Index>(0, t - 1);
    at.x[t] = there ? scene.p_WE.x() : t > 0 ? at.x[before] : 0.0;
    at.y[t] = there ? scene.p_WE.y() : t > 0 ? at.y[before] : 0.0;
    at.gamma[t] = there ? scene.gamma_rad : t > 0 ? at.gamma[before] : 0.0;
  }
  if (at.time.maxCoeff() <= 0) {
    at.time = Eigen::VectorXd::LinSpaced(count, 0.0, static_cast<double>(count - 1));
  }
  return at;
}

/// Scores one smooth function after the other against the same residual.
class UnknownSearch {
 public:
  UnknownSearch(const Readings& readings, const JointFit& fit)
      : readings_(readings), projector_(fit), weight_(fit.weight.sum()) {}

  /// f(covariate), one for each column of the stage.
  void along(
      const std::string& name, const std::string& enters, const Eigen::VectorXd& covariate,
      const Eigen::MatrixXd& stage, int functions) {
    const auto u = scaled(covariate);
    if (!u) return;
    begin({name}, enters);
    for (const Box& box : kAlong) {
      geometry::check_end();
      const Eigen::MatrixXd basis = basis_of(*u, box.half_width, functions);
      Eigen::MatrixXd columns(readings_.count(), functions * stage.cols());
      std::vector<std::array<int, 2>> order;
      for (Eigen::Index s = 0; s < stage.cols(); ++s) {
        for (int j = 0; j < functions; ++j) {
          for (Eigen::Index row = 0; row < readings_.count(); ++row) {
            columns(row, s * functions + j) = stage(row, s) * basis(trial_of(row), j);
          }
          order.push_back({j, -1});
        }
      }
      score(columns, order, box);
    }
    end();
  }

  /// f(x, y), one for each column of the stage.
  void over(
      const Eigen::VectorXd& x, const Eigen::VectorXd& y, const std::string& enters,
      const Eigen::MatrixXd& stage) {
    constexpr int kEach = 6;
    const auto ux = scaled(x);
    const auto uy = scaled(y);
    if (!ux || !uy) return;
    begin({"x", "y"}, enters);
    for (const Box& box : kOver) {
      geometry::check_end();
      const Eigen::MatrixXd bx = basis_of(*ux, box.half_width, kEach);
      const Eigen::MatrixXd by = basis_of(*uy, box.half_width, kEach);
      Eigen::MatrixXd columns(readings_.count(), stage.cols() * kEach * kEach);
      std::vector<std::array<int, 2>> order;
      Eigen::Index column = 0;
      for (Eigen::Index s = 0; s < stage.cols(); ++s) {
        for (int i = 0; i < kEach; ++i) {
          for (int j = 0; j < kEach; ++j, ++column) {
            for (Eigen::Index row = 0; row < readings_.count(); ++row) {
              const Eigen::Index t = trial_of(row);
              columns(row, column) = stage(row, s) * bx(t, i) * by(t, j);
            }
            order.push_back({i, j});
          }
        }
      }
      score(columns, order, box);
    }
    end();
  }

  /// A smooth function of its own reading for each dial, all of one size, which is within the
  /// makers' limits.
  void dial_curves(const Eigen::MatrixXd& own_mm, double limit_mm) {
    const Eigen::Index dials = own_mm.cols();
    std::vector<std::optional<Eigen::VectorXd>> u;
    for (Eigen::Index d = 0; d < dials; ++d) u.push_back(scaled(own_mm.col(d)));
    begin({"dial readings"}, "dials", UnknownKind::kDialCurves);
    // A kernel's functions have this standard deviation where t is 1.
    const double of_scale_1 = std::pow(2 * kPi, -0.25);
    const double most = kShareOfLimit * limit_mm / (of_scale_1 * projector_sigma_mm());
    for (const Box& box : kCurves) {
      Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(readings_.count(), dials * kOfCurve);
      std::vector<std::array<int, 2>> order;
      for (Eigen::Index d = 0; d < dials; ++d) {
        for (int j = 0; j < kOfCurve; ++j) order.push_back({j, -1});
        if (!u[static_cast<std::size_t>(d)]) continue;
        const Eigen::MatrixXd basis =
            basis_of(*u[static_cast<std::size_t>(d)], box.half_width, kOfCurve);
        for (const Eigen::Index row : readings_.rows_of_dial(static_cast<std::size_t>(d))) {
          columns.row(row).segment(d * kOfCurve, kOfCurve) = basis.row(trial_of(row));
        }
      }
      score(columns, order, box, most);
    }
    end();
  }

  /// What every dial has some of, a column a dial for one mm of it.
  void dial_habit(const std::string& name, const Eigen::MatrixXd& columns, double limit_mm) {
    begin({name}, "dials", UnknownKind::kDialHabits);
    score(columns, {}, {1.0, {0.0}}, kShareOfLimit * limit_mm / projector_sigma_mm());
    end();
  }

  /// All that the rig file claims to know exactly, each as well as a workshop knows it.
  void rig_geometry(const Eigen::MatrixXd& columns) {
    if (columns.cols() == 0) return;
    begin({"rig geometry"}, "dials", UnknownKind::kRigGeometry);
    score(columns, {}, {1.0, {0.0}}, kMostOfAWorkshop / projector_sigma_mm());
    end();
  }

  /// Another constant for each sign of each joint's approach.
  void by_approach(
      const Eigen::MatrixXd& approach, const std::string& enters,
      const Eigen::MatrixXd& stage) {
    for (Eigen::Index joint = 0; joint < approach.cols(); ++joint) {
      if (!scaled(approach.col(joint))) continue;
      begin(
          {dependence_name({.on = DependsOn::kApproach, .joint = static_cast<int>(joint)})},
          enters);
      Eigen::MatrixXd columns = stage;
      for (Eigen::Index row = 0; row < readings_.count(); ++row) {
        columns.row(row) *= approach(trial_of(row), joint);
      }
      score(columns, {}, {1.0, {0.0}});
      end();
    }
  }

  [[nodiscard]] std::vector<UnknownCandidate> ranked() {
    const double tried = std::log(static_cast<double>(std::max<std::size_t>(1, found_.size())));
    for (UnknownCandidate& each : found_) {
      if (each.is_background()) continue;  // every rig has it: not picked out of many
      each.evidence -= tried;
      each.cost += tried;
    }
    std::stable_sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) {
      return a.evidence > b.evidence;
    });
    return std::move(found_);
  }

 private:
  [[nodiscard]] Eigen::Index trial_of(Eigen::Index row) const {
    return static_cast<Eigen::Index>(readings_.rows()[static_cast<std::size_t>(row)].trial);
  }

  /// Standard deviation of a good reading.
  [[nodiscard]] double projector_sigma_mm() const {
    return std::sqrt(projector_.squares() / projector_.freedom());
  }

  void begin(
      std::vector<std::string> covariates, const std::string& enters,
      UnknownKind kind = UnknownKind::kSmooth) {
    best_ = {};
    best_.kind = kind;
    best_.covariates = std::move(covariates);
    best_.enters = enters;
    top_ = -1e300;
    all_.clear();
    geometry::check_end();
  }
  /// One box of kernels; without `order` the columns as they are.
  void score(
      const Eigen::MatrixXd& columns, const std::vector<std::array<int, 2>>& order,
      const Box& box, double most = std::numeric_limits<double>::infinity()) {
    const Eigen::MatrixXd& Q = projector_.Q();
    const Eigen::MatrixXd weighted = projector_.whitening()(columns);
    const Eigen::MatrixXd shared = Q.transpose() * weighted;
    const Eigen::MatrixXd A = gram(weighted) - gram(shared);
    const Eigen::VectorXd b = weighted.transpose() * projector_.residual();
    for (const double length : box.lengths) {
      geometry::check_end();
      Eigen::VectorXd spread = Eigen::VectorXd::Ones(A.rows());
      for (std::size_t j = 0; j < order.size(); ++j) {
        double s = spectrum(order[j][0], box.half_width, length);
        if (order[j][1] >= 0) s *= spectrum(order[j][1], box.half_width, length);
        spread[static_cast<Eigen::Index>(j)] = std::sqrt(s);
      }
      const MarginalLikelihood found = marginal_likelihood(
          spread.asDiagonal() * A * spread.asDiagonal(), spread.cwiseProduct(b),
          projector_.squares(), projector_.freedom(), most);
      if (found.by_scale.empty()) continue;
      all_.insert(all_.end(), found.by_scale.begin(), found.by_scale.end());
      if (found.best > top_) {
        top_ = found.best;
        best_.length = length;
        best_.rms_mm = std::sqrt(found.explained / std::max(1.0, weight_));
        best_.scale = found.best_scale * projector_sigma_mm();
        best_.columns = prominent(columns, spread * found.best_scale);
      }
    }
  }
  void end() {
    if (all_.empty()) return;
    best_.evidence = log_mean_exp(all_);
    best_.cost = top_ - best_.evidence;
    found_.push_back(std::move(best_));
  }

  const Readings& readings_;
  Projector projector_;
  double weight_;
  UnknownCandidate best_;
  double top_ = 0.0;
  std::vector<double> all_;
  std::vector<UnknownCandidate> found_;
};

// Numbers of basis functions: a random walk in time is rough, a creep is not.
constexpr int kFunctions = 16;
constexpr int kOfTime = 40;
constexpr int kFew = 10;

bool is_shift_of_tool(const Eigen::VectorXd& column, const Eigen::MatrixXd& tool) {
  constexpr double kAlike = 1e-4;  // tool columns are differences, others are not
  for (Eigen::Index axis = 0; axis < tool.cols(); ++axis) {
    const double size = tool.col(axis).norm();
    if ((column * (size / std::max(1e-300, column.norm())) - tool.col(axis)).norm() <=
        kAlike * size) {
      return true;
    }
  }
  return false;
}

/// Anything of the robot may creep with time or temperature. Parameters that only shift the
/// tool (the base's position) have been tried as that already.
void along_robot(
    UnknownSearch& search, const Readings& readings, const JointFit& fit, const Covariates& at,
    const Eigen::MatrixXd& tool) {
  const simulation::ForwardModel& model = readings.model();
  const Eigen::MatrixXd& J = fit.J;  // the robot's columns come first
  for (Eigen::Index k = 0; k < model.robot_parameter_count(); ++k) {
    if (is_shift_of_tool(J.col(k), tool)) continue;
    const std::string name(model.parameters()[static_cast<std::size_t>(k)].name);
    search.along("time", name, at.time, J.col(k), kFew);
    search.along("temperature", name, at.temperature, J.col(k), kFew);
  }
}

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

/// What the rig's dials and the rig itself may do without a fault of the robot.
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

/// What one parameter of an effect does to the readings when what it goes by (the hour, the
/// temperature) is one unit larger.
Eigen::VectorXd per_unit(
    const Readings& readings, const JointFit& fit, const simulation::ExtendedModel& extended,
    const simulation::ActiveEffect& none, std::size_t parameter, bool by_temperature) {
  simulation::ActiveEffect moved = none;
  const double step = 1e-3 * none.effect->parameters[parameter].sigma;
  moved.x[parameter] += step;
  Eigen::VectorXd with(readings.count());
  Eigen::VectorXd without(readings.count());
  Eigen::VectorXd result = Eigen::VectorXd::Zero(readings.count());
  simulation::Scene scene;
  for (std::size_t t = 0; t < readings.trials().size(); ++t) {
    const Eigen::Index first = readings.first_row(t);
    const Eigen::Index rows = readings.first_row(t + 1) - first;
    const simulation::Trial& trial = readings.trials()[t];
    for (const double more : {1.0, 0.0}) {
      simulation::Circumstance sample = readings.circumstances()[t];
      (by_temperature ? sample.temperature_degC : sample.time_h) += more;
      const bool there = extended.run(fit.model, trial, sample, scene, &moved).has_value();
      if (there) readings.pick(scene, t, with);
      if (!there || !extended.run(fit.model, trial, sample, scene)) break;
      readings.pick(scene, t, without);
      result.segment(first, rows) +=
          (more > 0 ? 1 : -1) / step * (with - without).segment(first, rows);
    }
  }
  return result.unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
}

/// What a cause bends by time or temperature may bend by something smooth that no column shows:
/// else a slow change that only looks like the cause would be called by its name.
void along_causes(
    UnknownSearch& search, const Readings& readings, const JointFit& fit,
    const simulation::ExtendedModel& extended, const Covariates& at,
    const Eigen::MatrixXd& tool) {
  for (const simulation::Effect* effect : simulation::all_effects()) {
    const bool by_temperature = (effect->needs & simulation::kTemperature) != 0;
    const bool by_time = (effect->needs & simulation::kTime) != 0;
    if (effect->is_step || !(by_temperature || by_time)) continue;
    for (const simulation::Place& place : effect->places(readings.model().rig())) {
      const simulation::ActiveEffect none{
          effect, place, std::vector<double>(effect->parameters.size(), 0.0)};
      Eigen::MatrixXd stage(readings.count(), 0);
      for (std::size_t k = 0; k < static_cast<std::size_t>(linear_count(*effect)); ++k) {
        const Eigen::VectorXd column =
            per_unit(readings, fit, extended, none, k, by_temperature);
        if (is_shift_of_tool(column, tool)) continue;
        stage.conservativeResize(Eigen::NoChange, stage.cols() + 1);
        stage.rightCols(1) = column;
      }
      if (stage.cols() == 0 || !(stage.norm() > 0)) continue;
      search.along("time", place.name, at.time, stage, kFew);
      search.along("temperature", place.name, at.temperature, stage, kFew);
    }
  }
}

/// Anything of one dial that depends on its own reading, on time or on temperature.
void along_dial(
    UnknownSearch& search, const Readings& readings, const Covariates& at, std::size_t dial) {
  Eigen::VectorXd own = Eigen::VectorXd::Zero(at.time.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(readings.count(), 1);
  double sum = 0.0;
  int present = 0;
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    if (each.dial != static_cast<int>(dial)) continue;
    rows(row, 0) = 1.0;
    own[each.trial] = readings.measured_mm()[row];
    sum += readings.measured_mm()[row];
    ++present;
  }
  constexpr int kFewestReadings = 12;
  if (present < kFewestReadings) return;
  for (double& value : own) {
    if (value == 0.0) value = sum / present;  // not in contact: no row, no influence
  }
  const std::string& id = readings.model().rig().dials[dial].id;
  const std::string name = "dial " + id;
  search.along(
      dependence_name({.on = DependsOn::kReading, .dial = id}), name, own, rows, kFunctions);
  search.along("time", name, at.time, rows, kFew);
  search.along("temperature", name, at.temperature, rows, kFew);
}

}  // namespace

Eigen::MatrixXd random_columns(Eigen::Index readings, const std::vector<UnknownCandidate>& of) {
  Eigen::MatrixXd result(readings, 0);
  for (const UnknownCandidate& each : of) {
    const Eigen::Index before = result.cols();
    result.conservativeResize(Eigen::NoChange, before + each.columns.cols());
    result.rightCols(each.columns.cols()) = each.columns;
  }
  return result;
}

SmoothInTime smooth_in_time(const Readings& readings, const JointFit& fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Covariates at = covariates_of(readings, fit, extended);
  SmoothInTime result;
  // As score_unknown tries them, but for those whose covariate does not vary.
  const auto dials = readings.has_dials() ? readings.model().rig().dials.size() : 0;
  result.tried = static_cast<int>(
      3 + 2 * at.q.cols() + 2 * readings.model().robot_parameter_count() +
      static_cast<Eigen::Index>(dials > 0 ? 4 + 3 * dials : 0));
  const auto u = scaled(at.time);
  if (!u) return result;
  const Eigen::MatrixXd tool = stage_columns(
      readings, fit.model, extended, readings.simulate(fit.model, extended), Stage::kTool);
  for (const Box& box : kAlong) {
    const Eigen::MatrixXd basis = basis_of(*u, box.half_width, kOfTime);
    Eigen::MatrixXd columns(readings.count(), kOfTime * tool.cols());
    for (Eigen::Index row = 0; row < columns.rows(); ++row) {
      const auto trial = readings.rows()[static_cast<std::size_t>(row)].trial;
      for (Eigen::Index s = 0; s < tool.cols(); ++s) {
        columns.block(row, s * kOfTime, 1, kOfTime) = tool(row, s) * basis.row(trial);
      }
    }
    for (const double length : box.lengths) {
      Eigen::VectorXd spread(columns.cols());
      for (Eigen::Index k = 0; k < spread.size(); ++k) {
        const int j = static_cast<int>(k) % kOfTime;
        spread[k] = std::sqrt(spectrum(j, box.half_width, length));
      }
      result.columns.push_back(prominent(columns, spread));
    }
  }
  return result;
}

std::vector<UnknownCandidate> score_unknown(const Readings& readings, const JointFit& fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  const auto stage = [&](Stage where, int joint = -1) {
    return stage_columns(readings, fit.model, extended, simulated, where, joint);
  };
  const Covariates at = covariates_of(readings, fit, extended);

  UnknownSearch search(readings, fit);
  for (int joint = 0; joint < static_cast<int>(at.q.cols()); ++joint) {
    search.along(
        dependence_name({.on = DependsOn::kJointAngle, .joint = joint}),
        "joint" + std::to_string(joint + 1), at.q.col(joint), stage(Stage::kJointAngle, joint),
        kFunctions);
  }
  const Eigen::MatrixXd tool = stage(Stage::kTool);
  search.along("time", "tool", at.time, tool, kOfTime);
  search.along("temperature", "tool", at.temperature, tool, kFew);
  search.over(at.x, at.y, "tool", tool);
  search.by_approach(at.approach, "tool", tool);
  along_robot(search, readings, fit, at, tool);
  along_causes(search, readings, fit, extended, at, tool);
  if (readings.has_dials()) {
    const Eigen::MatrixXd side = stage(Stage::kCuboidSide);
    search.along("time", "cuboid", at.time, side, kFew);
    search.along("temperature", "cuboid", at.temperature, side, kFew);
    const Eigen::MatrixXd clamp = stage(Stage::kCuboidAngle);
    search.along("time", "clamp", at.time, clamp, kFew);
    search.along("gamma", "clamp", at.gamma, clamp, kFew);
    for (std::size_t d = 0; d < readings.model().rig().dials.size(); ++d) {
      along_dial(search, readings, at, d);
    }
    along_rig(search, readings, fit);
  }
  return search.ranked();
}

}  // namespace sixdial::diagnosis
