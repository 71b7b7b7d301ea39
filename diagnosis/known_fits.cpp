#include "diagnosis/known_fits.h"

#include <algorithm>
#include <utility>

namespace sixdial::diagnosis {
namespace {

// A session of 150 points has fits of a megabyte. Of a long one the last few are kept, or none.
constexpr double kMostBytes = 24e6;

bool same(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && (a.array() == b.array()).all();
}

/// A place is known by its name.
bool same(const simulation::ActiveEffect& a, const simulation::ActiveEffect& b) {
  return a.effect == b.effect && a.place.name == b.place.name && a.x == b.x;
}

}  // namespace

bool KnownFits::Question::operator==(const Question& other) const {
  return near == other.near && near_s_mm == other.near_s_mm &&
         near_gross_share == other.near_gross_share &&
         near_shared_ratio == other.near_shared_ratio && near_shared == other.near_shared &&
         std::ranges::equal(
             effects, other.effects, [](const auto& a, const auto& b) { return same(a, b); }) &&
         same(start, other.start) && same(random, other.random);
}

double KnownFits::bytes_of(const Question& question, const JointFit& fit) {
  const Eigen::Index numbers = question.random.size() + fit.random.size() + fit.J.size() +
                               fit.covariance.size() + 4 * fit.residual_mm.size();
  return static_cast<double>(numbers) * sizeof(double);
}

JointFit KnownFits::fit(
    const Readings& readings, const simulation::ModelVector& start,
    std::vector<simulation::ActiveEffect> effects, const JointFit* near,
    const Eigen::MatrixXd& random) {
  Question question{start, std::move(effects), near != nullptr, 0.0, 0.0, 0.0, nullptr, random};
  if (near != nullptr) {
    question.near_s_mm = near->s_mm;
    question.near_gross_share = near->gross_share;
    question.near_shared_ratio = near->shared_ratio;
    question.near_shared = near->shared;
  }
  ++asked_;
  {
    const std::lock_guard lock(using_);
    const auto found = std::ranges::find(known_, question, &Known::question);
    if (found != known_.end()) {
      known_.splice(known_.begin(), known_, found);
      return found->fit;
    }
  }
  ++fitted_;
  JointFit fit = fit_jointly(readings, start, question.effects, near, random);
  const double bytes = bytes_of(question, fit);
  if (bytes > kMostBytes) return fit;
  const std::lock_guard lock(using_);
  known_.push_front({std::move(question), fit, bytes});
  bytes_ += bytes;
  while (bytes_ > kMostBytes) {
    bytes_ -= known_.back().bytes;
    known_.pop_back();
  }
  return fit;
}

}  // namespace sixdial::diagnosis
