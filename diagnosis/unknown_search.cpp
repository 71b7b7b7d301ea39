#include "diagnosis/unknown_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "calibration/column_products.h"
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

void UnknownSearch::along(
    const std::string& name, const std::string& enters, const Eigen::VectorXd& covariate,
    const Eigen::MatrixXd& stage, int functions, const std::vector<Box>& boxes) {
  const auto u = scaled(covariate);
  if (!u) return;
  begin({name}, enters);
  for (const Box& box : boxes) {
    geometry::check_end();
    const Eigen::MatrixXd basis = basis_of(readings_.of_used(*u), box.half_width, functions);
    Eigen::MatrixXd columns(readings_.count(), functions * stage.cols());
    std::vector<std::array<int, 2>> order;
    for (Eigen::Index s = 0; s < stage.cols(); ++s) {
      for (int j = 0; j < functions; ++j) {
        for (Eigen::Index row = 0; row < readings_.count(); ++row) {
          columns(row, s * functions + j) = stage(row, s) * basis(readings_.place_of(row), j);
        }
        order.push_back({j, -1});
      }
    }
    score(columns, order, box);
  }
  end();
}

void UnknownSearch::over(
    const Eigen::VectorXd& x, const Eigen::VectorXd& y, const std::string& enters,
    const Eigen::MatrixXd& stage) {
  constexpr int kEach = 6;
  const auto ux = scaled(x);
  const auto uy = scaled(y);
  if (!ux || !uy) return;
  begin({"x", "y"}, enters);
  for (const Box& box : kOver) {
    geometry::check_end();
    const Eigen::MatrixXd bx = basis_of(readings_.of_used(*ux), box.half_width, kEach);
    const Eigen::MatrixXd by = basis_of(readings_.of_used(*uy), box.half_width, kEach);
    Eigen::MatrixXd columns(readings_.count(), stage.cols() * kEach * kEach);
    std::vector<std::array<int, 2>> order;
    Eigen::Index column = 0;
    for (Eigen::Index s = 0; s < stage.cols(); ++s) {
      for (int i = 0; i < kEach; ++i) {
        for (int j = 0; j < kEach; ++j, ++column) {
          for (Eigen::Index row = 0; row < readings_.count(); ++row) {
            const Eigen::Index t = readings_.place_of(row);
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

void UnknownSearch::dial_curves(const Eigen::MatrixXd& own_mm, double limit_mm) {
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
      const Eigen::MatrixXd basis = basis_of(
          readings_.of_used(*u[static_cast<std::size_t>(d)]), box.half_width, kOfCurve);
      for (const Eigen::Index row : readings_.rows_of_dial(static_cast<std::size_t>(d))) {
        columns.row(row).segment(d * kOfCurve, kOfCurve) = basis.row(readings_.place_of(row));
      }
    }
    score(columns, order, box, most);
  }
  end();
}

void UnknownSearch::dial_habit(
    const std::string& name, const Eigen::MatrixXd& columns, double limit_mm) {
  begin({name}, "dials", UnknownKind::kDialHabits);
  score(columns, {}, {1.0, {0.0}}, kShareOfLimit * limit_mm / projector_sigma_mm());
  end();
}

void UnknownSearch::rig_geometry(const Eigen::MatrixXd& columns) {
  if (columns.cols() == 0) return;
  begin({"rig geometry"}, "dials", UnknownKind::kRigGeometry);
  score(columns, {}, {1.0, {0.0}}, kMostOfAWorkshop / projector_sigma_mm());
  end();
}

void UnknownSearch::by_approach(
    const Eigen::MatrixXd& approach, const std::string& enters, const Eigen::MatrixXd& stage) {
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

std::vector<UnknownCandidate> UnknownSearch::ranked() {
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

void UnknownSearch::begin(
    std::vector<std::string> covariates, const std::string& enters, UnknownKind kind) {
  best_ = {};
  best_.kind = kind;
  best_.covariates = std::move(covariates);
  best_.enters = enters;
  top_ = -1e300;
  all_.clear();
  if (keeps_) tried_.push_back({kind, {}});
  geometry::check_end();
}

void UnknownSearch::score(
    const Eigen::MatrixXd& columns, const std::vector<std::array<int, 2>>& order,
    const Box& box, double most) {
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
      double s = spectrum(order[j][0], box.half_width, length);
      if (order[j][1] >= 0) s *= spectrum(order[j][1], box.half_width, length);
      spread[static_cast<Eigen::Index>(j)] = std::sqrt(s);
    }
    if (keeps_) spreads.push_back(spread);
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
  if (keeps_) tried_.back().boxes.push_back({columns, std::move(spreads), most});
}

void UnknownSearch::end() {
  if (all_.empty()) return;
  best_.evidence = log_mean_exp(all_);
  best_.cost = top_ - best_.evidence;
  if (best_.kind == UnknownKind::kSmooth) {
    // Of many smooth functions only the best enters a fit; the columns of all would be the
    // largest thing in memory.
    UnknownCandidate* const before = best_smooth_ ? &found_[*best_smooth_] : nullptr;
    if (before && before->evidence >= best_.evidence) {
      best_.columns.resize(0, 0);
    } else {
      if (before) before->columns.resize(0, 0);
      best_smooth_ = found_.size();
    }
  }
  found_.push_back(std::move(best_));
}

}  // namespace sixdial::diagnosis
