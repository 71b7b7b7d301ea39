#include "diagnosis/unknown.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "diagnosis/evidence.h"
#include "simulation/effect.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

constexpr double kPi = std::numbers::pi;
/// Half width of the basis' box in half ranges: beyond the data, so that ends are free.
constexpr double kBox = 1.3;

/// Covariate scaled to [-1, 1]; empty if it does not vary.
std::optional<Eigen::VectorXd> scaled(const Eigen::VectorXd& values) {
  const double low = values.minCoeff();
  const double high = values.maxCoeff();
  if (!(high - low > 1e-9 * (1 + std::abs(high)))) return std::nullopt;
  return Eigen::VectorXd((values.array() - 0.5 * (low + high)).matrix() / (0.5 * (high - low)));
}

/// sin basis on [-kBox, kBox], samples x count.
Eigen::MatrixXd basis_of(const Eigen::VectorXd& u, int count) {
  Eigen::MatrixXd basis(u.size(), count);
  for (int j = 0; j < count; ++j) {
    basis.col(j) = ((u.array() + kBox) * (kPi * (j + 1) / (2 * kBox))).sin() / std::sqrt(kBox);
  }
  return basis;
}

/// Spectral density: squared exponential (smooth), or for a negative length the exponential
/// kernel's (a wandering value, as of a random walk).
double spectrum(int j, double length) {
  const double omega = kPi * (j + 1) / (2 * kBox);
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

struct Model {
  std::vector<std::string> covariates;
  std::string enters;
  Eigen::MatrixXd columns;                // n x m, unscaled
  std::vector<std::array<int, 2>> order;  // basis numbers of each column; -1: not that axis
  std::vector<double> lengths;
};

}  // namespace

std::vector<UnknownCandidate> score_unknown(const Readings& readings, const JointFit& fit) {
  const auto& trials = readings.trials();
  const auto count = static_cast<Eigen::Index>(trials.size());
  const Eigen::Index n = readings.count();
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);

  // How a shift at each stage shows in every reading: what a step from the first sample does.
  const simulation::Effect& step = *simulation::find_effect("step");
  const auto stage = [&](const simulation::Place& place) {
    const ActiveEffect active{&step, place, {0.0, 0.0, -1.0}};
    return effect_columns(readings, fit.model, extended, active, simulated);
  };
  const Eigen::MatrixXd tool = stage({.name = "base"});
  const Eigen::MatrixXd joint1 = stage({.name = "joint1", .joint = 0}).leftCols(1);
  const Eigen::MatrixXd joint2 = stage({.name = "joint2", .joint = 1}).leftCols(1);

  // Covariates by trial.
  Eigen::VectorXd theta1(count), theta2(count), x(count), y(count), time(count), warm(count);
  simulation::Scene scene;
  for (Eigen::Index t = 0; t < count; ++t) {
    const auto i = static_cast<std::size_t>(t);
    theta1[t] = trials[i].q_rad[0];
    theta2[t] = trials[i].q_rad[1];
    time[t] = readings.circumstances()[i].time_h;
    warm[t] = readings.circumstances()[i].temperature_degC;
    const bool there =
        extended.run(fit.model, trials[i], readings.circumstances()[i], scene).has_value();
    x[t] = there ? scene.p_WE.x() : (t > 0 ? x[t - 1] : 0.0);
    y[t] = there ? scene.p_WE.y() : (t > 0 ? y[t - 1] : 0.0);
  }
  if (time.maxCoeff() <= 0) {
    for (Eigen::Index t = 0; t < count; ++t) time[t] = static_cast<double>(t);
  }

  std::vector<Model> models;
  const std::vector<double> lengths{0.08, 0.15, 0.3, 0.6, 1.2, -0.5, -2.0};
  const auto trial_of = [&](Eigen::Index row) {
    return static_cast<Eigen::Index>(readings.rows()[static_cast<std::size_t>(row)].trial);
  };
  const auto add = [&](const std::string& name, const std::string& enters,
                       const Eigen::VectorXd& covariate, const Eigen::MatrixXd& stage_columns,
                       int functions) {
    const auto u = scaled(covariate);
    if (!u) return;
    const Eigen::MatrixXd basis = basis_of(*u, functions);
    Model model{
        {name}, enters, Eigen::MatrixXd(n, functions * stage_columns.cols()), {}, lengths};
    for (Eigen::Index s = 0; s < stage_columns.cols(); ++s) {
      for (int j = 0; j < functions; ++j) {
        for (Eigen::Index row = 0; row < n; ++row) {
          model.columns(row, s * functions + j) =
              stage_columns(row, s) * basis(trial_of(row), j);
        }
        model.order.push_back({j, -1});
      }
    }
    models.push_back(std::move(model));
  };
  add("theta1", "joint1", theta1, joint1, 16);
  add("theta2", "joint2", theta2, joint2, 16);
  add("time", "tool", time, tool, 40);
  add("temperature", "tool", warm, tool, 8);
  {
    const auto ux = scaled(x);
    const auto uy = scaled(y);
    constexpr int kEach = 6;
    if (ux && uy) {
      const Eigen::MatrixXd bx = basis_of(*ux, kEach);
      const Eigen::MatrixXd by = basis_of(*uy, kEach);
      Model model{
          {"x", "y"},
          "tool",
          Eigen::MatrixXd(n, 2 * kEach * kEach),
          {},
          {0.3, 0.45, 0.6, 0.9, 1.3}};
      Eigen::Index column = 0;
      for (int axis = 0; axis < 2; ++axis) {
        for (int i = 0; i < kEach; ++i) {
          for (int j = 0; j < kEach; ++j, ++column) {
            for (Eigen::Index row = 0; row < n; ++row) {
              const Eigen::Index t = trial_of(row);
              model.columns(row, column) = tool(row, axis) * bx(t, i) * by(t, j);
            }
            model.order.push_back({i, j});
          }
        }
      }
      models.push_back(std::move(model));
    }
  }
  if (readings.has_dials()) {
    const auto& dials = readings.model().rig().dials;
    for (std::size_t d = 0; d < dials.size(); ++d) {
      Eigen::VectorXd own = Eigen::VectorXd::Zero(count);
      Eigen::MatrixXd rows_of_dial = Eigen::MatrixXd::Zero(n, 1);
      double sum = 0.0;
      int present = 0;
      for (Eigen::Index row = 0; row < n; ++row) {
        if (readings.rows()[static_cast<std::size_t>(row)].dial != static_cast<int>(d))
          continue;
        rows_of_dial(row, 0) = 1.0;
        own[trial_of(row)] = readings.measured_mm()[row];
        sum += readings.measured_mm()[row];
        ++present;
      }
      if (present < 12) continue;
      for (Eigen::Index t = 0; t < count; ++t) {
        if (own[t] == 0.0) own[t] = sum / present;  // not in contact: no row, no influence
      }
      add("dial " + dials[d].id + " reading", "dial " + dials[d].id, own, rows_of_dial, 16);
      add("time", "dial " + dials[d].id, time, rows_of_dial, 12);
    }
    add("time", "clamp", time, stage({.name = "cuboid"}).leftCols(1), 12);
  }

  const Projector projector(fit);
  const Eigen::MatrixXd& Q = projector.Q();
  const Eigen::VectorXd& e = projector.residual();
  const double sse = projector.squares();
  const double freedom = projector.freedom();

  std::vector<UnknownCandidate> result;
  for (const Model& model : models) {
    Eigen::MatrixXd B = projector.root_weight().asDiagonal() * model.columns;
    B -= Q * (Q.transpose() * B);
    const Eigen::MatrixXd A = B.transpose() * B;
    const Eigen::VectorXd b = B.transpose() * e;
    UnknownCandidate best;
    best.covariates = model.covariates;
    best.enters = model.enters;
    std::vector<double> all;
    double top = -1e300;
    for (const double length : model.lengths) {
      Eigen::VectorXd spread(A.rows());
      for (Eigen::Index j = 0; j < spread.size(); ++j) {
        const auto& order = model.order[static_cast<std::size_t>(j)];
        double s = spectrum(order[0], length);
        if (order[1] >= 0) s *= spectrum(order[1], length);
        spread[j] = std::sqrt(s);
      }
      const MarginalLikelihood found = marginal_likelihood(
          spread.asDiagonal() * A * spread.asDiagonal(), spread.cwiseProduct(b), sse, freedom);
      if (found.by_scale.empty()) continue;
      all.insert(all.end(), found.by_scale.begin(), found.by_scale.end());
      if (found.best > top) {
        top = found.best;
        best.length = length;
        best.rms_mm = std::sqrt(found.explained / std::max(1.0, fit.weight.sum()));
        best.columns = prominent(model.columns, spread * found.best_scale);
      }
    }
    if (all.empty()) continue;
    best.evidence = log_mean_exp(all) - std::log(static_cast<double>(models.size()));
    best.cost = top - best.evidence;
    result.push_back(std::move(best));
  }
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) {
    return a.evidence > b.evidence;
  });
  return result;
}

}  // namespace sixdial::diagnosis
