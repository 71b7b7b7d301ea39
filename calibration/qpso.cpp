#include "calibration/qpso.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "calibration/lanes.h"
#include "calibration/logarithms.h"
#include "calibration/random.h"
#include "calibration/workers.h"

namespace sixdial::calibration {
namespace {

constexpr int kDrawGroups = 2;           // groups of one task that draws random numbers
constexpr Eigen::Index kGroup = kLanes;  // particles of one task: whole vector loads

class Swarm {
 public:
  Swarm(
      const SwarmObjective& objective, const Eigen::ArrayXXd& start,
      const QpsoSettings& settings)
      : objective_(objective),
        settings_(settings),
        particles_(start.rows()),
        dimensions_(start.cols()),
        value_(start.rows()),
        groups_(static_cast<int>((particles_ + kGroup - 1) / kGroup)),
        bad_(static_cast<std::size_t>(groups_), 0) {
    x_.setZero(kGroup, groups_ * dimensions_);
    for (Draws& each : draws_) {
      each.phi.setOnes(kGroup, groups_ * dimensions_);
      each.jump.setOnes(kGroup, groups_ * dimensions_);
    }
    for (int group = 0; group < groups_; ++group) {
      const auto [first, count] = rows_of(group);
      of(x_, group) = start.middleRows(first, count);
      if (settings_.lower.size() > 0) clip(group);
    }
  }

  void evaluate_start(Workers& workers) {
    share_out(workers, 1, [&](int group) {
      const auto [first, count] = rows_of(group);
      evaluate(first, count, group);
    });
    best_x_ = x_;
    best_value_ = value_;
    sums_.resize(dimensions_, groups_);
    for (int group = 0; group < groups_; ++group) sum(group);
    find_leader();
  }

  /// Random numbers depend on nothing, so those of the next iteration fill the time of threads
  /// that have no particles left to try.
  void iterate(Workers& workers, int iteration) {
    const double part = static_cast<double>(settings_.iterations - iteration) /
                        static_cast<double>(settings_.iterations);
    const double alpha =
        settings_.alpha_end + (settings_.alpha_start - settings_.alpha_end) * part;
    mean_best_ = sums_.rowwise().sum() / static_cast<double>(particles_);  // (28)
    share_out(workers, iteration + 1, [&](int group) {
      const auto [first, count] = rows_of(group);
      move(group, iteration, alpha);
      evaluate(first, count, group);
      for (Eigen::Index i = first; i < first + count; ++i) {
        if (value_[i] <= best_value_[i]) {  // (26)
          best_value_[i] = value_[i];
          of(best_x_, group).row(i - first) = of(x_, group).row(i - first);
        }
      }
      sum(group);
    });
    find_leader();
  }

  [[nodiscard]] double value() const { return best_value_[leader_]; }
  [[nodiscard]] Eigen::VectorXd position() const { return leader_x_.matrix(); }
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
    const Eigen::Index first = task * kGroup;
    return {first, std::min(kGroup, particles_ - first)};
  }
  /// The particles of a group, count x dimensions.
  [[nodiscard]] Eigen::Block<Eigen::ArrayXXd> of(Eigen::ArrayXXd& matrix, int group) const {
    return {matrix, 0, group * dimensions_, rows_of(group).count, dimensions_};
  }
  [[nodiscard]] Eigen::Block<const Eigen::ArrayXXd> of(
      const Eigen::ArrayXXd& matrix, int group) const {
    return {matrix, 0, group * dimensions_, rows_of(group).count, dimensions_};
  }

  void clip(int group) {
    auto x = of(x_, group);
    for (Eigen::Index j = 0; j < dimensions_; ++j) {
      x.col(j) = x.col(j).max(settings_.lower[j]).min(settings_.upper[j]);
    }
  }

  /// Tasks in this order: half of the groups, the random numbers of iteration `next` (unless it
  /// is past the last), the other groups.
  void share_out(Workers& workers, int next, const std::function<void(int)>& try_group) {
    const int draws =
        next <= settings_.iterations ? (groups_ + kDrawGroups - 1) / kDrawGroups : 0;
    const int half = (groups_ + 1) / 2;
    workers.run(groups_ + draws, [&](int task) {
      if (task >= half && task < half + draws) {
        draw_task(task - half, next);
      } else {
        try_group(task < half ? task : task - draws);
      }
    });
  }

  void draw_task(int task, int iteration) {
    const int end = std::min((task + 1) * kDrawGroups, groups_);
    for (int group = task * kDrawGroups; group < end; ++group) draw(group, iteration);
  }

  void draw(int group, int iteration) {
    Draws& draws = draws_[iteration % 2];
    const auto [first, count] = rows_of(group);
    const Eigen::Index at = group * dimensions_;
    for (Eigen::Index j = 0; j < dimensions_; ++j) {
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
    minus_logarithms(draws.jump.col(at).data(), kGroup * dimensions_);
  }

  void move(int group, int iteration, double alpha) {
    const Draws& draws = draws_[iteration % 2];
    const Eigen::Index count = rows_of(group).count;
    const Eigen::Index at = group * dimensions_;
    for (Eigen::Index j = 0; j < dimensions_; ++j) {
      for (Eigen::Index i = 0; i < count; ++i) {
        const double phi = std::abs(draws.phi(i, at + j));
        const double attractor = phi * best_x_(i, at + j) + (1.0 - phi) * leader_x_[j];  // (25)
        const double jump = std::copysign(draws.jump(i, at + j), draws.phi(i, at + j));
        double& x = x_(i, at + j);
        x = attractor + alpha * std::abs(mean_best_[j] - x) * jump;  // (24)
      }
    }
    if (settings_.lower.size() > 0) clip(group);
  }

  void evaluate(Eigen::Index first, Eigen::Index count, int group) {
    objective_(of(x_, group), value_.segment(first, count));
    for (Eigen::Index i = first; i < first + count; ++i) {
      if (std::isfinite(value_[i])) continue;
      value_[i] = std::numeric_limits<double>::infinity();
      ++bad_[static_cast<std::size_t>(group)];
    }
  }

  /// Of the best positions, by the thread that has them at hand.
  void sum(int group) { sums_.col(group) = of(best_x_, group).colwise().sum().transpose(); }

  void find_leader() {  // (27)
    const Eigen::Index old = leader_;
    const double before = leader_value_;
    leader_value_ = best_value_.minCoeff(&leader_);
    if (leader_x_.size() > 0 && leader_ == old && leader_value_ == before) return;
    const auto group = static_cast<int>(leader_ / kGroup);
    leader_x_ = of(best_x_, group).row(leader_ % kGroup).transpose();
  }

  const SwarmObjective& objective_;
  const QpsoSettings& settings_;
  Eigen::Index particles_, dimensions_;
  Eigen::ArrayXd value_;
  int groups_;
  Eigen::ArrayXXd x_;              // group beside group: eight particles x dimensions each
  std::vector<std::int64_t> bad_;  // by group
  Draws draws_[2];                 // of this iteration and the next
  Eigen::ArrayXXd best_x_;
  Eigen::ArrayXd best_value_;
  Eigen::ArrayXXd sums_;  // dimensions x groups
  Eigen::ArrayXd mean_best_;
  Eigen::ArrayXd leader_x_;
  double leader_value_ = 0.0;
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
