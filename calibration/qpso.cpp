#include "calibration/qpso.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "calibration/random.h"
#include "calibration/swarm_kernels.h"
#include "calibration/workers.h"

namespace sixdial::calibration {
namespace {

constexpr Eigen::Index kGroup = kLanes;  // particles of one task: whole vector loads

class Swarm {
 public:
  Swarm(
      const SwarmObjective& objective, const Eigen::ArrayXXd& start,
      const QpsoSettings& settings)
      : objective_(objective),
        settings_(settings),
        x_(start),
        value_(start.rows()),
        groups_(static_cast<int>((start.rows() + kGroup - 1) / kGroup)),
        bad_(static_cast<std::size_t>(groups_), 0) {
    for (Draws& each : draws_) {
      each.phi.setOnes(kGroup, groups_ * start.cols());
      each.jump.setOnes(kGroup, groups_ * start.cols());
    }
    if (settings_.lower.size() > 0) clip(0, x_.rows());
  }

  void evaluate_start(Workers& workers) {
    workers.run(2 * groups_, [&](int task) {
      const auto [first, count] = rows_of(task);
      if (task < groups_) {
        evaluate(first, count, task);
      } else {
        draw(first, count, 1);
      }
    });
    best_x_ = x_;
    best_value_ = value_;
    find_leader();
  }

  /// Random numbers depend on nothing, so those of the next iteration fill the time of threads
  /// that have no particles left to try.
  void iterate(Workers& workers, int iteration) {
    const double part = static_cast<double>(settings_.iterations - iteration) /
                        static_cast<double>(settings_.iterations);
    const double alpha =
        settings_.alpha_end + (settings_.alpha_start - settings_.alpha_end) * part;
    mean_best_ = best_x_.colwise().mean();  // (28)
    leader_x_ = best_x_.row(leader_);
    const int tasks = iteration < settings_.iterations ? 2 * groups_ : groups_;
    workers.run(tasks, [&](int task) {
      const auto [first, count] = rows_of(task);
      if (task >= groups_) {
        draw(first, count, iteration + 1);
        return;
      }
      move(first, count, iteration, alpha);
      evaluate(first, count, task);
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
  /// phi of (25), with the sign of (24), and -ln(u) of (24), group after group: row = particle
  /// of the group, columns = coordinates.
  struct Draws {
    Eigen::ArrayXXd phi, jump;
  };
  struct Rows {
    Eigen::Index first, count;
  };
  [[nodiscard]] Rows rows_of(int task) const {
    const Eigen::Index first = (task % groups_) * kGroup;
    return {first, std::min(kGroup, x_.rows() - first)};
  }

  void clip(Eigen::Index first, Eigen::Index count) {
    for (Eigen::Index j = 0; j < x_.cols(); ++j) {
      auto column = x_.col(j).segment(first, count);
      column = column.max(settings_.lower[j]).min(settings_.upper[j]);
    }
  }

  void draw(Eigen::Index first, Eigen::Index count, int iteration) {
    Draws& draws = draws_[iteration % 2];
    const Eigen::Index at = first / kGroup * x_.cols();
    for (Eigen::Index j = 0; j < x_.cols(); ++j) {
      for (Eigen::Index i = 0; i < count; ++i) {
        const auto w = random_words(
            settings_.seed, static_cast<std::uint32_t>(first + i),
            static_cast<std::uint32_t>(iteration), static_cast<std::uint32_t>(j),
            settings_.stream);
        draws.jump(i, at + j) = open_unit(w[0], w[1]);
        const double phi = open_unit(w[2]);
        draws.phi(i, at + j) = (w[3] & 1U) != 0U ? phi : -phi;
      }
    }
    minus_logarithms(draws.jump.col(at).data(), kGroup * x_.cols());
  }

  void move(Eigen::Index first, Eigen::Index count, int iteration, double alpha) {
    const Draws& draws = draws_[iteration % 2];
    const Eigen::Index at = first / kGroup * x_.cols();
    for (Eigen::Index j = 0; j < x_.cols(); ++j) {
      for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::Index i = first + k;
        const double phi = std::abs(draws.phi(k, at + j));
        const double attractor = phi * best_x_(i, j) + (1.0 - phi) * leader_x_[j];  // (25)
        const double jump = std::copysign(draws.jump(k, at + j), draws.phi(k, at + j));
        x_(i, j) = attractor + alpha * std::abs(mean_best_[j] - x_(i, j)) * jump;  // (24)
      }
    }
    if (settings_.lower.size() > 0) clip(first, count);
  }

  void evaluate(Eigen::Index first, Eigen::Index count, int group) {
    objective_(x_.middleRows(first, count), value_.segment(first, count));
    for (Eigen::Index i = first; i < first + count; ++i) {
      if (std::isfinite(value_[i])) continue;
      value_[i] = std::numeric_limits<double>::infinity();
      ++bad_[static_cast<std::size_t>(group)];
    }
  }

  void find_leader() { best_value_.minCoeff(&leader_); }  // (27)

  const SwarmObjective& objective_;
  const QpsoSettings& settings_;
  Eigen::ArrayXXd x_;
  Eigen::ArrayXd value_;
  int groups_;
  std::vector<std::int64_t> bad_;  // by group
  Draws draws_[2];                 // of this iteration and the next
  Eigen::ArrayXXd best_x_;
  Eigen::ArrayXd best_value_;
  Eigen::Array<double, 1, Eigen::Dynamic> mean_best_;
  Eigen::Array<double, 1, Eigen::Dynamic> leader_x_;
  Eigen::Index leader_ = 0;
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
