#include "diagnosis/unnamed.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "diagnosis/estimates.h"
#include "diagnosis/search.h"

namespace sixdial::diagnosis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of the robot, and there all the time: what dials and the rig have is in the fit by itself,
/// and a knock is no habit.
bool is_a_habit_of_the_robot(const simulation::Effect& effect) {
  return !effect.is_step && !effect.searched && !effect.of_rig_geometry &&
         !effect.within_accuracy && !effect.exchanges_dials && !effect.after_reading &&
         !effect.before_contact;
}

/// One parameter of one cause: its column for one plausible size, and what the readings say.
struct Small {
  VectorXd column;
  double size = 0.0, sd = 0.0;  // in plausible sizes
};

std::vector<Small> small_ones(const Readings& readings, const JointFit& fit) {
  std::vector<Small> result;
  const Projector projector(fit);
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const VectorXd simulated = readings.simulate(fit.model, extended);
  const double s_mm = std::sqrt(projector.squares() / projector.freedom());
  std::vector<NotTestable> ignored;
  for (const Hypothesis& each : hypotheses_for(readings, ignored)) {
    if (!is_a_habit_of_the_robot(*each.effect)) continue;
    const bool named = std::ranges::any_of(fit.effects, [&](const auto& active) {
      return active.effect == each.effect && active.place.name == each.place.name;
    });
    if (named) continue;
    const MatrixXd columns =
        effect_columns(readings, fit.model, extended, at_rest(each), simulated);
    for (Index k = 0; k < columns.cols(); ++k) {
      const auto parameter = parameter_at(*each.effect, each.place, static_cast<int>(k));
      if (!parameter || !columns.col(k).allFinite()) continue;
      Small small{.column = parameter->sigma * columns.col(k)};
      VectorXd left = projector.whitening()(small.column);
      left -= projector.Q() * (projector.Q().transpose() * left);
      const double seen = left.squaredNorm();
      small.sd = seen > 0.0 ? s_mm / std::sqrt(seen) : 1e6;
      small.size = seen > 0.0 ? left.dot(projector.residual()) / seen : 0.0;
      result.push_back(std::move(small));
    }
  }
  return result;
}

/// Those that have a name, which say as much of how large causes are here.
void add_named(const JointFit& fit, std::vector<double>& size, std::vector<double>& sd) {
  for (std::size_t i = 0; i < fit.effects.size(); ++i) {
    const simulation::ActiveEffect& active = fit.effects[i];
    if (!is_a_habit_of_the_robot(*active.effect)) continue;
    const std::vector<Estimate> estimates = estimates_of(fit, i);
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      const auto parameter = parameter_at(*active.effect, active.place, static_cast<int>(k));
      if (!parameter || !(estimates[k].sd > 0.0)) continue;
      size.push_back(estimates[k].value / parameter->sigma);
      sd.push_back(estimates[k].sd / parameter->sigma);
    }
  }
}

/// Some causes are much larger than others: a scale mixture of normal laws, about Cauchy's.
constexpr std::array kSpread{0.3, 1.0, 3.0, 10.0};
constexpr std::array kShare{0.3, 0.4, 0.2, 0.1};

double log_density(double size, double variance) {
  return -0.5 * (size * size / variance + std::log(variance));
}

}  // namespace

SizesOnARobot sizes_on_a_robot(const VectorXd& size, const VectorXd& sd) {
  constexpr std::array kScales{0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0};
  SizesOnARobot result;
  result.scale = Eigen::Map<const VectorXd>(kScales.data(), std::ssize(kScales));
  result.weight.resize(result.scale.size());
  for (Index j = 0; j < result.scale.size(); ++j) {
    // A robot without any is as probable before as one with some.
    double log = j == 0 ? std::log(static_cast<double>(result.scale.size() - 1)) : 0.0;
    for (Index i = 0; i < size.size(); ++i) {
      const double noise = sd[i] * sd[i];
      double sum = 0.0;
      for (std::size_t m = 0; m < kSpread.size(); ++m) {
        const double spread = result.scale[j] * kSpread[m];
        sum += kShare[m] * std::exp(
                               log_density(size[i], noise + spread * spread) -
                               log_density(size[i], noise + 100.0));
      }
      log += std::log(std::max(sum, 1e-300));
    }
    result.weight[j] = log;
  }
  result.weight = (result.weight.array() - result.weight.maxCoeff()).exp();
  result.weight /= result.weight.sum();
  return result;
}

MatrixXd unnamed_columns(const Readings& readings, const JointFit& fit) {
  const std::vector<Small> small = small_ones(readings, fit);
  std::vector<double> size, sd;
  for (const Small& each : small) {
    size.push_back(each.size);
    sd.push_back(each.sd);
  }
  add_named(fit, size, sd);
  const SizesOnARobot here = sizes_on_a_robot(
      Eigen::Map<const VectorXd>(size.data(), std::ssize(size)),
      Eigen::Map<const VectorXd>(sd.data(), std::ssize(sd)));
  MatrixXd columns(readings.count(), std::ssize(small));
  for (std::size_t i = 0; i < small.size(); ++i) {
    // Mean square of the size, by what the readings say of it and how large causes are here.
    double square = 0.0;
    for (Index j = 0; j < here.scale.size(); ++j) {
      const double prior = here.scale[j] * here.scale[j];
      const double noise = small[i].sd * small[i].sd;
      const double share = prior / (prior + noise);
      square += here.weight[j] * (share * noise + std::pow(share * small[i].size, 2));
    }
    columns.col(static_cast<Index>(i)) = std::sqrt(square) * small[i].column;
  }
  return columns;
}

}  // namespace sixdial::diagnosis
