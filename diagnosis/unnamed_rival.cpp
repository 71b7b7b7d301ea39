#include "diagnosis/unnamed_rival.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/column_products.h"
#include "diagnosis/eliminated.h"
#include "geometry/long_work.h"

namespace sixdial::diagnosis {
namespace {

/// Mean of exp(value) over all that was added; as its logarithm.
class LogMean {
 public:
  void add(double value, double count) {
    if (!(count > 0)) return;
    if (value > top_) {
      sum_ *= std::exp(top_ - value);
      top_ = value;
    }
    sum_ += count * std::exp(value - top_);
    count_ += count;
  }
  [[nodiscard]] double value() const {
    return count_ > 0 ? top_ + std::log(sum_ / count_) : 0.0;
  }

 private:
  double top_ = -1e300;
  double sum_ = 0.0;
  double count_ = 0.0;
};

}  // namespace

UnnamedRival::UnnamedRival(
    UnknownKind kind, double cost, const Projector& projector, const Eigen::MatrixXd& noise,
    const std::vector<RandomBox>& boxes)
    : kind_(kind), cost_(cost) {
  for (const RandomBox& box : boxes) {
    geometry::check_end();
    Part part;
    part.weighted = projector.whitening()(box.columns);
    const Eigen::MatrixXd fitted = calibration::column_products(projector.Q(), part.weighted);
    const Eigen::MatrixXd normal = gram(part.weighted) - gram(fitted);
    // The noise is off everything fitted already, and so is each effect.
    part.noise = calibration::column_products(part.weighted, noise);
    for (const Eigen::VectorXd& spread : box.spread) {
      part.lengths.push_back(
          {spread,
           MarginalEvidence(spread.asDiagonal() * normal * spread.asDiagonal(), box.most)});
    }
    parts_.push_back(std::move(part));
  }
}

UnnamedRival::Shared UnnamedRival::shared_with(const Eigen::MatrixXd& columns) const {
  Shared result;
  for (const Part& part : parts_) {
    result.push_back(calibration::column_products(part.weighted, columns));
  }
  return result;
}

double UnnamedRival::evidence(
    const Shared& shared, const Eigen::VectorXd& x, double sse, double freedom) const {
  return evidence(shared, x, -1, sse, freedom);
}

double UnnamedRival::evidence(
    const Shared& shared, const Eigen::VectorXd& x, int draw, double sse,
    double freedom) const {
  LogMean mean;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Eigen::VectorXd right = shared[i] * x;
    if (draw >= 0) right += parts_[i].noise.col(draw);
    for (const Length& each : parts_[i].lengths) {
      mean.add(
          each.evidence(right.cwiseProduct(each.spread), sse, freedom),
          static_cast<double>(each.evidence.scale_count()));
    }
  }
  return mean.value() - cost_;
}

}  // namespace sixdial::diagnosis
