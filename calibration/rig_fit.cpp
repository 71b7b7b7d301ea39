#include "calibration/rig_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibration/known_unknowns.h"
#include "calibration/reading_errors.h"
#include "calibration/rig_errors.h"
#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using simulation::RigQuantity;
using simulation::Trial;

constexpr std::size_t kMostTrials = 1500;  // as a diagnosis draws
constexpr int kRounds = 4;                 // of moving the dials and looking again
constexpr double kSettled = 1e-3;          // standard deviations

simulation::Scene scene_of(const geometry::Rig& rig) {
  simulation::Scene scene;
  scene.side_mm = rig.cuboid.side_mm;
  scene.dials = rig.dial_geometries();
  return scene;
}

void move_scene(const RigQuantity& quantity, double off, simulation::Scene& scene) {
  const double size[] = {off * quantity.sd};
  quantity.effect->before_contact(size, quantity.place, {}, scene);
}

/// A rig can say it: of the cuboid's squareness and centre only effects know.
bool in_the_rig(const RigQuantity& quantity, const geometry::Rig& rig) {
  simulation::Scene scene = scene_of(rig);
  move_scene(quantity, 1.0, scene);
  return scene.squareness_rad == 0.0 && scene.centre_offset_mm.isZero(0.0);
}

std::vector<Trial> spread_part(std::span<const Trial> trials) {
  if (trials.size() <= kMostTrials) return {trials.begin(), trials.end()};
  std::vector<Trial> part;
  for (std::size_t i = 0; i < kMostTrials; ++i) {
    part.push_back(trials[i * trials.size() / kMostTrials]);
  }
  return part;
}

/// Error curves of the dials within their limits, rows x shapes of all dials.
MatrixXd curve_columns(
    const ObservationSpace& space, std::span<const Trial> trials, const geometry::Rig& rig) {
  const std::vector<MatrixXd> by = by_readings(space, trials, rig);
  std::vector<MatrixXd> all;
  Index columns = 0;
  for (std::size_t d = 0; d < rig.dials.size(); ++d) {
    const double sd_mm = rig.dials[d].accuracy_mm / std::sqrt(3.0);  // GUM 4.3.7
    if (!(sd_mm > 0.0)) continue;
    const MatrixXd shapes = sd_mm * curve_shapes(space, trials, static_cast<int>(d));
    MatrixXd moved(space.rows(), shapes.cols());
    for (int i = 0; i < space.samples(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      moved.middleRows(space.first_row[k], space.rows(i)) =
          by[k].col(static_cast<Index>(d)) * shapes.row(i);
    }
    columns += moved.cols();
    all.push_back(std::move(moved));
  }
  MatrixXd result(space.rows(), columns);
  Index at = 0;
  for (const MatrixXd& each : all) {
    result.middleCols(at, each.cols()) = each;
    at += each.cols();
  }
  return result;
}

/// What one look at the readings says.
struct Look {
  VectorXd off;         // of the rig's quantities, in standard deviations from where they were
  MatrixXd covariance;  // of these
  double sigma_mm = 0.0;
};

std::optional<Look> look(
    const ObservationSpace& space, const MatrixXd& columns, const VectorXd& known,
    Index quantities, const SpaceFitSettings& settings) {
  const ObservationSpace all = with_known(space, columns, known);
  const SpaceFit found = fit_space(all, settings);
  if (found.fit.status == FitStatus::kBadStart || !found.v.allFinite()) return std::nullopt;
  const double unit_mm = known_unit_mm(space);
  const Index first = space.parameters();
  VectorXd e(space.rows());
  double weighted = 0.0;
  const VectorXd robot = found.v.head(first);
  for (int i = 0; i < space.samples(); ++i) {
    const int row = space.first_row[static_cast<std::size_t>(i)];
    if (!space.evaluate(i, robot, e.segment(row, space.rows(i)), nullptr)) return std::nullopt;
  }
  e -= columns * found.v.tail(columns.cols()) / unit_mm;
  std::vector<double> size(e.begin(), e.end());
  for (double& each : size) each = std::abs(each);
  std::ranges::nth_element(size, size.begin() + std::ssize(size) / 2);
  // A few gross readings leave the median as it is.
  constexpr double kSigmaPerMedian = 1.4826;
  weighted = kSigmaPerMedian * size[size.size() / 2];
  Look result;
  result.off = found.v.segment(first, quantities) / unit_mm;
  const double variance =
      std::max(found.fit.variance(), unit_mm * unit_mm) / (unit_mm * unit_mm);
  result.covariance =
      variance * found.fit.unit_covariance().block(first, first, quantities, quantities);
  result.sigma_mm = weighted;
  return result;
}

}  // namespace

geometry::Rig moved_rig(const geometry::Rig& rig, const VectorXd& off) {
  simulation::Scene scene = scene_of(rig);
  const auto quantities = simulation::stated_quantities(rig);
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    if (in_the_rig(quantities[k], rig)) {
      move_scene(quantities[k], off[static_cast<Index>(k)], scene);
    }
  }
  geometry::Rig result = rig;
  result.cuboid.side_mm = scene.side_mm;
  for (std::size_t d = 0; d < result.dials.size(); ++d) {
    result.dials[d].geometry = scene.dials[d];
  }
  return result;
}

MatrixXd RigFit::left_open() const {
  MatrixXd second = covariance;
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const auto i = static_cast<Index>(k);
    if (!in_the_rig(quantities[k], rig)) second(i, i) += off[i] * off[i];
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(second);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

std::optional<RigFit> fit_rig(
    std::span<const Trial> trials, const geometry::Rig& rig, const std::vector<char>& fixed,
    Loss loss) {
  RigFit result{rig, simulation::stated_quantities(rig), {}, {}, 0.0};
  const auto count = std::ssize(result.quantities);
  if (count == 0 || rig.dials.empty()) return std::nullopt;
  const std::vector<Trial> part = spread_part(trials);
  result.off = VectorXd::Zero(count);
  double sigma_mm = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    ObservationSpace space = dial_space(part, result.rig);
    if (space.rows() <= 2 * space.parameters()) return std::nullopt;
    // What is not in the model makes readings that much less certain than their noise.
    if (sigma_mm > space.mean_sigma()) space.sigma_mm *= sigma_mm / space.mean_sigma();
    const MatrixXd curves = curve_columns(space, part, result.rig);
    MatrixXd columns(space.rows(), count + curves.cols());
    columns.leftCols(count) = space.rig_mm;
    columns.rightCols(curves.cols()) = curves;
    VectorXd known = VectorXd::Zero(columns.cols());
    for (Index k = 0; k < count; ++k) {
      if (in_the_rig(result.quantities[static_cast<std::size_t>(k)], rig)) {
        known[k] = -result.off[k];
      }
    }
    SpaceFitSettings settings;
    settings.weighting = Weighting::kBySigma;
    settings.loss = loss;
    settings.fixed = fixed;
    settings.noise_mm = space.mean_sigma();
    const auto found = look(space, columns, known, count, settings);
    if (!found) return std::nullopt;
    const VectorXd before = result.off;
    for (Index k = 0; k < count; ++k) {
      result.off[k] = found->off[k] - known[k];
    }
    result.covariance = found->covariance;
    result.sigma_mm = found->sigma_mm;
    result.rig = moved_rig(rig, result.off);
    const bool settled = (result.off - before).cwiseAbs().maxCoeff() < kSettled;
    const bool same_noise = found->sigma_mm < 1.05 * std::max(sigma_mm, space.mean_sigma());
    sigma_mm = std::max(sigma_mm, found->sigma_mm);
    if (settled && same_noise) break;
  }
  return result;
}

}  // namespace sixdial::calibration
