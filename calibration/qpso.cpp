#include "calibration/qpso.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "calibration/random.h"
#include "calibration/workers.h"

namespace sixdial::calibration {
namespace {

constexpr Eigen::Index kGroup = 8;  // particles are shared out in whole vector loads

class Swarm {
 public:
  Swarm(
      const SwarmObjective& objective, const Eigen::ArrayXXd& start,
      const QpsoSettings& settings)
      : objective_(objective),
        settings_(settings),
        x_(start),
        value_(start.rows()),
        bad_(static_cast<std::size_t>(std::max(settings.threads, 1)), 0) {
    if (settings_.lower.size() > 0) clip(0, x_.rows());
  }

  void evaluate_start(Workers& workers) {
    workers.run([&](int share) {
      const auto [first, count] = rows_of(share, workers.count());
      evaluate(first, count, share);
    });
    best_x_ = x_;
    best_value_ = value_;
    find_leader();
  }

  void iterate(Workers& workers, int iteration) {
    const double part = static_cast<double>(settings_.iterations - iteration) /
                        static_cast<double>(settings_.iterations);
    const double alpha =
        settings_.alpha_end + (settings_.alpha_start - settings_.alpha_end) * part;
    mean_best_ = best_x_.colwise().mean();  // (28)
    leader_x_ = best_x_.row(leader_);
    workers.run([&](int share) {
      const auto [first, count] = rows_of(share, workers.count());
      move(first, count, iteration, alpha);
      evaluate(first, count, share);
      for (Eigen::Index i = first; i < first + count; ++i) {
        if (value_[i] <= best_value_[i]) {  // (26)
          best_value_[i] = value_[i];
          best_x_.row(i) = x_.row(i);
        }
      }
    });
    find_leader();
  }

  [[nodiscard]] double value() const { return best_value_[leader_]; }
  [[nodiscard]] Eigen::VectorXd position() const {
    return best_x_.row(leader_).matrix().transpose();
  }
  [[nodiscard]] std::int64_t bad() const {
    std::int64_t sum = 0;
    for (const std::int64_t each : bad_) sum += each;
    return sum;
  }

 private:
  struct Share {
    Eigen::Index first, count;
  };
  [[nodiscard]] Share rows_of(int share, int shares) const {
    const Eigen::Index groups = (x_.rows() + kGroup - 1) / kGroup;
    const Eigen::Index from = groups * share / shares * kGroup;
    const Eigen::Index to = std::min(x_.rows(), groups * (share + 1) / shares * kGroup);
    return {std::min(from, to), std::max<Eigen::Index>(to - from, 0)};
  }

  void clip(Eigen::Index first, Eigen::Index count) {
    for (Eigen::Index j = 0; j < x_.cols(); ++j) {
      auto column = x_.col(j).segment(first, count);
      column = column.max(settings_.lower[j]).min(settings_.upper[j]);
    }
  }

  void move(Eigen::Index first, Eigen::Index count, int iteration, double alpha) {
    for (Eigen::Index j = 0; j < x_.cols(); ++j) {
      for (Eigen::Index i = first; i < first + count; ++i) {
        const auto w = random_words(
            settings_.seed, static_cast<std::uint32_t>(i),
            static_cast<std::uint32_t>(iteration), static_cast<std::uint32_t>(j),
            settings_.stream);
        const double phi = open_unit(w[2]);
        const double attractor = phi * best_x_(i, j) + (1.0 - phi) * leader_x_[j];  // (25)
        const double jump =
            alpha * std::abs(mean_best_[j] - x_(i, j)) * -std::log(open_unit(w[0], w[1]));
        x_(i, j) = attractor + ((w[3] & 1U) != 0U ? jump : -jump);  // (24)
      }
    }
    if (settings_.lower.size() > 0) clip(first, count);
  }

  void evaluate(Eigen::Index first, Eigen::Index count, int share) {
    if (count == 0) return;
    objective_(x_.middleRows(first, count), value_.segment(first, count));
    for (Eigen::Index i = first; i < first + count; ++i) {
      if (std::isfinite(value_[i])) continue;
      value_[i] = std::numeric_limits<double>::infinity();
      ++bad_[static_cast<std::size_t>(share)];
    }
  }

  void find_leader() { best_value_.minCoeff(&leader_); }  // (27)

  const SwarmObjective& objective_;
  const QpsoSettings& settings_;
  Eigen::ArrayXXd x_;
  Eigen::ArrayXd value_;
  Eigen::ArrayXXd best_x_;
  Eigen::ArrayXd best_value_;
  Eigen::Array<double, 1, Eigen::Dynamic> mean_best_;
  Eigen::Array<double, 1, Eigen::Dynamic> leader_x_;
  Eigen::Index leader_ = 0;
  std::vector<std::int64_t> bad_;  // by thread
};

void check(const Eigen::ArrayXXd& start, const QpsoSettings& settings) {
  if (start.rows() < 1 || start.cols() < 1 || !start.allFinite()) {
    throw std::invalid_argument(
        "minimise_qpso: the start needs at least one particle with finite coordinates");
  }
  const auto fits = [&](const Eigen::VectorXd& bound) {
    return bound.size() == 0 || bound.size() == start.cols();
  };
  if (!fits(settings.lower) || settings.lower.size() != settings.upper.size() ||
      (settings.lower.size() > 0 && (settings.lower.array() > settings.upper.array()).any())) {
    throw std::invalid_argument(
        "minimise_qpso: lower and upper bound need one value for each coordinate, lower <= "
        "upper");
  }
  if (settings.iterations < 0) {
    throw std::invalid_argument("minimise_qpso: iterations must not be negative");
  }
}

}  // namespace

QpsoResult minimise_qpso(
    const SwarmObjective& objective, const Eigen::ArrayXXd& start, const QpsoSettings& settings,
    const std::function<void(const QpsoProgress&)>& progress, std::stop_token stop) {
  check(start, settings);
  Workers workers(settings.threads);
  Swarm swarm(objective, start, settings);
  QpsoResult result;
  const auto note = [&] {
    result.history.push_back(swarm.value());
    if (settings.keep_positions) result.best_positions.push_back(swarm.position());
  };
  swarm.evaluate_start(workers);
  note();
  int done = 0;
  for (int iteration = 1; iteration <= settings.iterations; ++iteration) {
    if (stop.stop_requested()) {
      result.cancelled = true;
      break;
    }
    swarm.iterate(workers, iteration);
    note();
    done = iteration;
    if (progress) progress({iteration, settings.iterations, swarm.value()});
  }
  result.best = swarm.position();
  result.value = swarm.value();
  result.evaluations = static_cast<std::int64_t>(start.rows()) * (done + 1);
  result.not_finite = swarm.bad();
  return result;
}

int settled_after(std::span<const double> history, double fraction) {
  if (history.empty()) return 0;
  const double limit = history.back() * (1.0 + fraction);
  const auto first =
      std::find_if(history.begin(), history.end(), [&](double v) { return v <= limit; });
  return static_cast<int>(first - history.begin());
}

}  // namespace sixdial::calibration
