#include "diagnosis/unknown_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "calibration/column_products.h"
#include "calibration/crew.h"
#include "diagnosis/covariate.h"
#include "diagnosis/eliminated.h"
#include "diagnosis/evidence.h"
#include "geometry/long_work.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kPi = std::numbers::pi;

const std::vector<Box> kOver{{1.3, {0.3, 0.45}}, {2.0, {0.6, 0.9}}, {3.5, {1.3, 2.5}}};

// A dial's curve is smooth over its travel; what is shorter is an error of its gear.
const std::vector<Box> kCurves{{1.3, {0.2, 0.35}}, {2.0, {0.6}}, {3.5, {1.2}}};
constexpr int kOfCurve = 10;
/// A maker's limit is kept by nearly all readings: two standard deviations.
constexpr double kShareOfLimit = 0.5;
/// Claimed exactly and off by more than so many standard deviations of a workshop: that is one
/// gross mistake, and no rig that was measured with a ruler.
constexpr double kMostOfAWorkshop = 3.0;

}  // namespace

Eigen::MatrixXd UnknownSearch::columns_along(
    const Eigen::MatrixXd& basis, const Eigen::MatrixXd& stage, int first,
    std::vector<Order>& order) const {
  const auto functions = static_cast<int>(basis.cols());
  Eigen::MatrixXd columns(readings_.count(), functions * stage.cols());
  for (Eigen::Index s = 0; s < stage.cols(); ++s) {
    for (int j = 0; j < functions; ++j) {
      for (Eigen::Index row = 0; row < readings_.count(); ++row) {
        columns(row, s * functions + j) = stage(row, s) * basis(readings_.place_of(row), j);
      }
      order.push_back({first + j, -1, -1});
    }
  }
  return columns;
}

void UnknownSearch::along(
    const std::string& name, const std::string& enters, const Eigen::VectorXd& covariate,
    const Eigen::MatrixXd& stage, int functions, const std::vector<Box>& boxes) {
  const auto scaled_covariate = scaled(covariate);
  if (!scaled_covariate) return;
  const std::array<double, 2> range{covariate.minCoeff(), covariate.maxCoeff()};
  const Eigen::VectorXd u = readings_.of_used(*scaled_covariate);
  ask({name}, enters, UnknownKind::kSmooth, [=, this](Trial& trial) {
    trial.range = range;
    for (const Box& box : boxes) {
      geometry::check_end();
      std::vector<Order> order;
      const Eigen::MatrixXd columns =
          columns_along(basis_of(u, box.half_width, functions), stage, 0, order);
      score(trial, columns, order, box);
    }
  });
}

namespace {

/// By sine of a box: its product with the residual, and its own square.
struct Power {
  Eigen::VectorXd shown, whole;
};
/// `of`: by place, the product of the residual with what enters there; `size`: the square of
/// what enters. Each sine comes from the two before it.
Power power_of_sines(
    const Eigen::VectorXd& u, const Eigen::VectorXd& of, const Eigen::VectorXd& size,
    double half_width, int count) {
  Power power{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count)};
  const double scale = 1 / std::sqrt(half_width);
  for (Eigen::Index place = 0; place < u.size(); ++place) {
    const double step = kPi * (u[place] + half_width) / (2 * half_width);
    const double twice = 2 * std::cos(step);
    double before = 0.0;
    double here = scale * std::sin(step);
    for (int j = 0; j < count; ++j) {
      power.shown[j] += of[place] * here;
      power.whole[j] += size[place] * here * here;
      before = std::exchange(here, twice * here - before);
    }
  }
  return power;
}

}  // namespace

void UnknownSearch::along_waves(
    const std::string& name, const std::string& enters, const Eigen::VectorXd& covariate,
    const Eigen::VectorXd& stage, int from) {
  // Waves over the whole range of the covariate: a strain-wave drive errs twice for each turn
  // of its motor, up to 200 times a turn of the joint.
  constexpr int kMostWaves = 250;
  constexpr double kHalfWidth = 1.3;
  constexpr int kSines = static_cast<int>(4 * kHalfWidth * kMostWaves / 2);
  constexpr int kReach = 6;  // sines beside the strongest one that a wave is made of
  constexpr int kTried = 2;  // the strongest waves
  constexpr double kCell = 2 * kHalfWidth;  // sines that the data can tell apart
  const auto scaled_covariate = scaled(covariate);
  if (!scaled_covariate || from + kReach >= kSines) return;
  const std::array<double, 2> range{covariate.minCoeff(), covariate.maxCoeff()};
  const Eigen::VectorXd u = readings_.of_used(*scaled_covariate);
  ask({name}, enters, UnknownKind::kSmooth, [=, this](Trial& trial) {
    trial.range = range;
    const Eigen::VectorXd weighted = projector_.whitening()(stage);
    const Eigen::VectorXd& residual = projector_.residual();
    Eigen::VectorXd of = Eigen::VectorXd::Zero(u.size());
    Eigen::VectorXd size = of;
    for (Eigen::Index row = 0; row < readings_.count(); ++row) {
      const Eigen::Index place = readings_.place_of(row);
      of[place] += weighted[row] * residual[row];
      size[place] += weighted[row] * weighted[row];
    }
    const Power power = power_of_sines(u, of, size, kHalfWidth, kSines);
    // What so many sines side by side show together.
    Eigen::VectorXd shown = Eigen::VectorXd::Zero(kSines);
    constexpr int kTogether = 2;
    for (int j = from + kTogether; j + kTogether < kSines; ++j) {
      for (int k = j - kTogether; k <= j + kTogether; ++k) {
        shown[j] += power.shown[k] * power.shown[k] / std::max(1e-300, power.whole[k]);
      }
    }
    for (int tried = 0; tried < kTried; ++tried) {
      geometry::check_end();
      Eigen::Index strongest = 0;
      if (!(shown.maxCoeff(&strongest) > 0)) break;
      const int centre = static_cast<int>(strongest);
      const int first = std::max(from, centre - kReach);
      const int count = std::min(kSines, centre + kReach + 1) - first;
      std::vector<Order> order;
      const Eigen::MatrixXd columns =
          columns_along(basis_of(u, kHalfWidth, count, first), stage, first, order);
      score(trial, columns, order, {kHalfWidth, {1.0, 2.5}, centre});
      shown.segment(first, count).setZero();
    }
    // Any other wave could as well have been the one, and was as likely before.
    trial.price = std::log(std::max(1.0, (kSines - from) / kCell / kTried));
  });
}

void UnknownSearch::over(
    const Eigen::MatrixXd& coordinates, const std::string& enters,
    const Eigen::MatrixXd& stage) {
  static const std::vector<std::string> kNames{"x", "y", "z"};
  const Eigen::Index axes = coordinates.cols();
  const int each = axes == 2 ? 6 : 4;
  std::vector<Eigen::VectorXd> u;
  for (Eigen::Index axis = 0; axis < axes; ++axis) {
    auto along = scaled(coordinates.col(axis));
    if (!along) return;
    u.push_back(readings_.of_used(*along));
  }
  std::vector<Order> products;
  for (int i = 0; i < each; ++i) {
    for (int j = 0; j < each; ++j) {
      if (axes == 2) products.push_back({i, j, -1});
      for (int k = 0; axes == 3 && k < each; ++k) products.push_back({i, j, k});
    }
  }
  const std::vector<std::string> names{kNames.begin(), kNames.begin() + axes};
  ask(names, enters, UnknownKind::kSmooth, [=, this](Trial& trial) {
    for (const Box& box : kOver) {
      geometry::check_end();
      std::vector<Eigen::MatrixXd> basis;
      basis.reserve(u.size());
      for (const Eigen::VectorXd& along : u)
        basis.push_back(basis_of(along, box.half_width, each));
      Eigen::MatrixXd columns(readings_.count(), stage.cols() * std::ssize(products));
      std::vector<Order> order;
      Eigen::Index column = 0;
      for (Eigen::Index s = 0; s < stage.cols(); ++s) {
        for (const Order& product : products) {
          for (Eigen::Index row = 0; row < readings_.count(); ++row) {
            const Eigen::Index t = readings_.place_of(row);
            double value = stage(row, s);
            for (std::size_t axis = 0; axis < basis.size(); ++axis) {
              value *= basis[axis](t, product[axis]);
            }
            columns(row, column) = value;
          }
          order.push_back(product);
          ++column;
        }
      }
      score(trial, columns, order, box);
    }
  });
}

void UnknownSearch::dial_curves(const Eigen::MatrixXd& own_mm, double limit_mm) {
  const Eigen::Index dials = own_mm.cols();
  std::vector<std::optional<Eigen::VectorXd>> u;
  for (Eigen::Index d = 0; d < dials; ++d) u.push_back(scaled(own_mm.col(d)));
  // A kernel's functions have this standard deviation where t is 1.
  const double of_scale_1 = std::pow(2 * kPi, -0.25);
  const double most = kShareOfLimit * limit_mm / (of_scale_1 * projector_sigma_mm());
  ask({"dial readings"}, "dials", UnknownKind::kDialCurves, [=, this](Trial& trial) {
    for (const Box& box : kCurves) {
      Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(readings_.count(), dials * kOfCurve);
      std::vector<Order> order;
      for (Eigen::Index d = 0; d < dials; ++d) {
        for (int j = 0; j < kOfCurve; ++j) order.push_back({j, -1, -1});
        if (!u[static_cast<std::size_t>(d)]) continue;
        const Eigen::MatrixXd basis = basis_of(
            readings_.of_used(*u[static_cast<std::size_t>(d)]), box.half_width, kOfCurve);
        for (const Eigen::Index row : readings_.rows_of_dial(static_cast<std::size_t>(d))) {
          columns.row(row).segment(d * kOfCurve, kOfCurve) = basis.row(readings_.place_of(row));
        }
      }
      score(trial, columns, order, box, most);
    }
  });
}

void UnknownSearch::dial_habit(
    const std::string& name, const Eigen::MatrixXd& columns, double limit_mm) {
  const double most = kShareOfLimit * limit_mm / projector_sigma_mm();
  ask({name}, "dials", UnknownKind::kDialHabits, [=, this](Trial& trial) {
    score(trial, columns, {}, {1.0, {0.0}}, most);
  });
}

void UnknownSearch::masses(
    int joint, const std::string& enters, const Eigen::MatrixXd& columns, double size) {
  if (columns.cols() == 0) return;
  const double most = size / projector_sigma_mm();
  ask({dependence_name({.on = DependsOn::kWeight, .joint = joint})}, enters,
      UnknownKind::kMasses, [=, this](Trial& trial) {
        score(trial, columns, {}, {1.0, {0.0}}, most);
      });
}

void UnknownSearch::rig_geometry(const Eigen::MatrixXd& columns) {
  if (columns.cols() == 0) return;
  const double most = kMostOfAWorkshop / projector_sigma_mm();
  ask({"rig geometry"}, "dials", UnknownKind::kRigGeometry, [=, this](Trial& trial) {
    score(trial, columns, {}, {1.0, {0.0}}, most);
  });
}

void UnknownSearch::by_approach(
    const Eigen::MatrixXd& approach, const std::string& enters, const Eigen::MatrixXd& stage) {
  for (Eigen::Index joint = 0; joint < approach.cols(); ++joint) {
    if (!scaled(approach.col(joint))) continue;
    Eigen::MatrixXd columns = stage;
    for (Eigen::Index row = 0; row < readings_.count(); ++row) {
      columns.row(row) *= approach(trial_of(row), joint);
    }
    ask({dependence_name({.on = DependsOn::kApproach, .joint = static_cast<int>(joint)})},
        enters, UnknownKind::kSmooth, [this, columns = std::move(columns)](Trial& trial) {
          score(trial, columns, {}, {1.0, {0.0}});
        });
  }
}

std::vector<UnknownCandidate> UnknownSearch::ranked() {
  try_asked();
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

void UnknownSearch::ask(
    std::vector<std::string> covariates, const std::string& enters, UnknownKind kind,
    std::function<void(Trial&)> score) {
  geometry::check_end();
  Asked& asked = asked_.emplace_back();
  asked.score = std::move(score);
  asked.trial.tried.kind = kind;
  asked.trial.best.kind = kind;
  asked.trial.best.covariates = std::move(covariates);
  asked.trial.best.enters = enters;
  // Those of one thread are tried at once; more threads share a few. Their columns are the
  // largest thing in memory.
  constexpr Eigen::Index kFewReadings = 20'000;
  const int threads = calibration::crew_size();
  const int each = threads > 1 && readings_.count() < kFewReadings ? 4 : 1;
  if (std::ssize(asked_) >= threads * each) try_asked();
}

void UnknownSearch::try_asked() {
  calibration::in_parallel(static_cast<int>(asked_.size()), [&](int i) {
    Asked& asked = asked_[static_cast<std::size_t>(i)];
    asked.score(asked.trial);
  });
  for (Asked& asked : asked_) take(std::move(asked.trial));
  asked_.clear();
}

void UnknownSearch::score(
    Trial& trial, const Eigen::MatrixXd& columns, const std::vector<Order>& order,
    const Box& box, double most) const {
  const Eigen::MatrixXd& Q = projector_.Q();
  const Eigen::MatrixXd weighted = projector_.whitening()(columns);
  const Eigen::MatrixXd shared = calibration::column_products(Q, weighted);
  const Eigen::MatrixXd A = gram(weighted) - gram(shared);
  const Eigen::VectorXd b = weighted.transpose() * projector_.residual();
  std::vector<Eigen::VectorXd> spreads;
  for (const double length : box.lengths) {
    geometry::check_end();
    Eigen::VectorXd spread = Eigen::VectorXd::Ones(A.rows());
    for (std::size_t j = 0; j < order.size(); ++j) {
      double s = 1.0;
      for (const int function : order[j]) {
        if (function >= 0) s *= spectrum(function, box, length);
      }
      spread[static_cast<Eigen::Index>(j)] = std::sqrt(s);
    }
    if (keeps_) spreads.push_back(spread);
    const MarginalLikelihood found = marginal_likelihood(
        spread.asDiagonal() * A * spread.asDiagonal(), spread.cwiseProduct(b),
        projector_.squares(), projector_.freedom(), most);
    if (found.by_scale.empty()) continue;
    trial.all.insert(trial.all.end(), found.by_scale.begin(), found.by_scale.end());
    if (found.best > trial.top) {
      UnknownCandidate& best = trial.best;
      trial.top = found.best;
      best.length = length;
      best.rms_mm = std::sqrt(found.explained / std::max(1.0, weight_));
      best.scale = found.best_scale * projector_sigma_mm();
      const Eigen::VectorXd size = spread * found.best_scale;
      const std::vector<Eigen::Index> which = prominent(columns, size);
      best.columns = scaled_columns(columns, size, which);
      best.kernel = {trial.range[0], trial.range[1], box.half_width, {}, size(which), box.wave};
      for (const Eigen::Index j : which) {
        if (static_cast<std::size_t>(j) >= order.size()) break;
        best.kernel.functions.push_back(order[static_cast<std::size_t>(j)][0]);
      }
    }
  }
  if (keeps_) trial.tried.boxes.push_back({columns, std::move(spreads), most});
}

void UnknownSearch::take(Trial trial) {
  if (keeps_) tried_.push_back(std::move(trial.tried));
  if (trial.all.empty()) return;
  UnknownCandidate& own = trial.best;
  own.evidence = log_mean_exp(trial.all) - trial.price;
  own.cost = trial.top - own.evidence;
  if (own.kind == UnknownKind::kSmooth) {
    // Of many smooth functions only the best enters a fit; the columns of all would be the
    // largest thing in memory.
    UnknownCandidate* const before = best_smooth_ ? &found_[*best_smooth_] : nullptr;
    if (before && before->evidence >= own.evidence) {
      own.columns.resize(0, 0);
    } else {
      if (before) before->columns.resize(0, 0);
      best_smooth_ = found_.size();
    }
  }
  found_.push_back(std::move(own));
}

}  // namespace sixdial::diagnosis
