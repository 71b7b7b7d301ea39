#include "calibration/gross_errors.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "calibration/gross_error_parts.h"
#include "calibration/position_judge.h"
#include "calibration/reading_judge.h"
#include "calibration/reading_space.h"
#include "calibration/rig_spaces.h"
#include "geometry/long_work.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using simulation::Trial;

constexpr int kMostRounds = 25;
constexpr int kLeastFreedom = 8;        // readings more than parameters, to know what is usual
constexpr int kLeastOfADial = 15;       // readings for a standard deviation of its own
constexpr double kLeastLimit = 5.0;     // in standard deviations
constexpr std::size_t kNeighbours = 6;  // poses whose errors are compared
constexpr int kJudgedNeighbourhoods = 200;
constexpr double kTimesAccuracy = 5.0;  // of what the maker allows: less is no gross error
constexpr double kLeastShare = 0.4;     // of a dial's misfit that counts as its noise
constexpr double kNudge_mm = 1e-4;
constexpr double kSigmaOfMedian = 0.6744897501960817;  // median |r| of a normal distribution
constexpr double kLeastSigma_mm = 3e-4;                // rounding of a 0.001 mm display

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// So many standard deviations that `readings` normal ones pass it once in a hundred sessions.
double limit_of(int readings, int freedom) {
  const boost::math::students_t distribution(freedom);
  return std::max(
      kLeastLimit, boost::math::quantile(boost::math::complement(
                       distribution, kFalseAlarms / (2.0 * std::max(readings, 1)))));
}

/// A reading's error as its sample shows it: size of the one error that explains the sample
/// best, and the part of one millimetre of it that is visible (1, less where the sample's own
/// rotation takes some of it).
struct Seen {
  double size_mm = 0.0;
  double visible = 0.0;
};
/// What is left of 1 mm at a dial, by row of the sample's space; empty where nothing is.
VectorXd left_of_an_error(
    const Trial& trial, const geometry::Rig& rig, int dial, const VectorXd& x,
    VectorXd* at_x = nullptr) {
  const auto errors = [&](const Trial& of) -> std::optional<VectorXd> {
    const ObservationSpace space = dial_space(std::span(&of, 1), rig);
    if (space.samples() != 1) return std::nullopt;
    VectorXd e(space.rows());
    if (!space.evaluate(0, x, e, nullptr)) return std::nullopt;
    return e;
  };
  Trial nudged = trial;
  *nudged.reading[static_cast<std::size_t>(dial)] += kNudge_mm;
  const auto e = errors(trial);
  const auto e_nudged = errors(nudged);
  if (!e || !e_nudged) return {};
  if (at_x != nullptr) *at_x = *e;
  return (*e_nudged - *e) / kNudge_mm;
}

Seen seen_error(const Trial& trial, const geometry::Rig& rig, int dial, const VectorXd& x) {
  VectorXd e;
  const VectorXd g = left_of_an_error(trial, rig, dial, x, &e);
  const double norm2 = g.squaredNorm();
  if (!(norm2 > 1e-6)) return {};
  return {g.dot(e) / norm2, std::sqrt(norm2)};
}

bool has_readings(std::span<const Trial> trials) {
  return std::ranges::any_of(trials, [](const Trial& trial) {
    return std::ranges::any_of(
        trial.reading, [](const auto& value) { return value.has_value(); });
  });
}

struct DialSigma {
  std::vector<double> by_dial;
  double pooled = 0.0;
};

DialSigma robust_sigmas(const ObservationSpace& space, const VectorXd& r, int freedom) {
  const double inflate = std::sqrt(static_cast<double>(space.rows()) / freedom);
  std::vector<std::vector<double>> sizes(static_cast<std::size_t>(space.channels()));
  std::vector<double> all;
  for (int row = 0; row < space.rows(); ++row) {
    const auto channel = static_cast<std::size_t>(space.channel[static_cast<std::size_t>(row)]);
    sizes[channel].push_back(std::abs(r[row]));
    all.push_back(std::abs(r[row]));
  }
  DialSigma result;
  result.pooled = std::max(inflate * median(all) / kSigmaOfMedian, kLeastSigma_mm);
  for (const std::vector<double>& each : sizes) {
    const double own = static_cast<int>(each.size()) < kLeastOfADial
                           ? result.pooled
                           : inflate * median(each) / kSigmaOfMedian;
    result.by_dial.push_back(std::max(own, 0.5 * result.pooled));
  }
  return result;
}

/// Loss::kCauchy on every reading by itself.
LeastSquaresFit robust_fit(
    const ObservationSpace& space, const IdentifySettings& settings, const VectorXd& start,
    int block) {
  LeastSquaresSettings core = core_settings(space, settings);
  core.loss_scale = 0.0;
  core.enough = 1e-3;  // no reading is accused or cleared by a thousandth of that
  const LeastSquaresProblem problem = space.problem(weighting_of(space, settings));
  return solve_robustly(problem, start, core, Loss::kCauchy, block);
}

/// Errors of one dial at x, pose by pose.
struct DialErrors {
  std::vector<VectorXd> q;
  std::vector<double> error_mm;
  double local_sigma_mm = 0.0;  // of an error against its neighbours' median

  /// Error less the median of its nearest neighbours: what smooth misfit does not explain.
  [[nodiscard]] double against_neighbours(std::size_t i) const {
    geometry::check_end();
    std::vector<std::pair<double, double>> others;
    for (std::size_t k = 0; k < q.size(); ++k) {
      if (k != i) others.emplace_back((q[k] - q[i]).squaredNorm(), error_mm[k]);
    }
    if (others.size() < kNeighbours) return error_mm[i];
    std::ranges::partial_sort(others, others.begin() + kNeighbours);
    std::vector<double> near;
    for (std::size_t k = 0; k < kNeighbours; ++k) near.push_back(others[k].second);
    return error_mm[i] - median(std::move(near));
  }
};

std::vector<DialErrors> errors_by_dial(
    const std::map<int, const Trial*>& by_sample, const ObservationSpace& space,
    const VectorXd& x, std::vector<std::size_t>& place_of_row) {
  std::vector<DialErrors> dials(static_cast<std::size_t>(space.channels()));
  VectorXd e;
  for (int i = 0; i < space.samples(); ++i) {
    e.resize(space.rows(i));
    if (!space.evaluate(i, x, e, nullptr)) e.setZero();
    for (int row = 0; row < space.rows(i); ++row) {
      const auto at =
          static_cast<std::size_t>(space.first_row[static_cast<std::size_t>(i)] + row);
      DialErrors& dial = dials[static_cast<std::size_t>(space.channel[at])];
      place_of_row.push_back(dial.error_mm.size());
      dial.q.push_back(by_sample.at(space.sample[static_cast<std::size_t>(i)])->q);
      dial.error_mm.push_back(e[row]);
    }
  }
  for (DialErrors& dial : dials) {
    std::vector<double> sizes;
    const std::size_t step = 1 + dial.error_mm.size() / kJudgedNeighbourhoods;
    for (std::size_t i = 0; i < dial.error_mm.size(); i += step) {
      sizes.push_back(std::abs(dial.against_neighbours(i)));
    }
    if (!sizes.empty()) dial.local_sigma_mm = median(std::move(sizes)) / kSigmaOfMedian;
  }
  return dials;
}

/// The worst reading of each sample beyond the limit, by x and sigma.
std::vector<GrossError> worst_of_each(
    std::span<const Trial> trials, const geometry::Rig& rig, const ObservationSpace& space,
    const VectorXd& x, const DialSigma& sigma, double limit) {
  const bool free = rig.cuboid.mount == geometry::Mount::kFree;
  std::map<int, const Trial*> by_sample;
  for (const Trial& trial : trials) by_sample[trial.sample] = &trial;
  std::vector<std::size_t> place_of_row;
  const auto dials = errors_by_dial(by_sample, space, x, place_of_row);
  std::vector<GrossError> found;
  VectorXd e;
  for (int i = 0; i < space.samples(); ++i) {
    e.resize(space.rows(i));
    if (!space.evaluate(i, x, e, nullptr)) continue;
    const Trial& trial = *by_sample.at(space.sample[static_cast<std::size_t>(i)]);
    GrossError worst;
    for (int row = 0; row < space.rows(i); ++row) {
      const auto at =
          static_cast<std::size_t>(space.first_row[static_cast<std::size_t>(i)] + row);
      const int dial = space.channel[at];
      const auto k = static_cast<std::size_t>(dial);
      Seen seen{e[row], 1.0};
      // The sample's own rotation takes its part of a free cuboid's errors.
      if (free && e.cwiseAbs().maxCoeff() > 0.3 * limit * sigma.by_dial[k]) {
        seen = seen_error(trial, rig, dial, x);
      }
      // A dial that misfits everywhere is judged by how it misfits from pose to pose.
      const DialErrors& all = dials[k];
      const double local_mm = std::max(all.local_sigma_mm, kLeastSigma_mm);
      const double usual_mm =
          std::clamp(local_mm, kLeastShare * sigma.by_dial[k], sigma.by_dial[k]);
      const double times = std::abs(seen.size_mm) * seen.visible / usual_mm;
      if (times <= std::max(limit, worst.times_sigma)) continue;
      if (std::abs(seen.size_mm) < kTimesAccuracy * rig.dials[k].accuracy_mm) continue;
      if (std::abs(all.against_neighbours(place_of_row[at])) <= limit * local_mm) continue;
      worst = {trial.sample, dial, seen.size_mm, times};
    }
    if (worst.times_sigma > limit) found.push_back(worst);
  }
  return found;
}

void take_out(std::vector<Trial>& trials, const std::vector<GrossError>& bad) {
  for (const GrossError& each : bad) {
    const auto trial = std::ranges::find(trials, each.sample, &Trial::sample);
    trial->reading[static_cast<std::size_t>(each.dial)].reset();
  }
}

/// Trials of one sample, with one reading of it that is not among the good ones.
Trial with_reading(
    std::span<const Trial> trials, std::span<const Trial> good, const GrossError& each) {
  Trial trial = *std::ranges::find(good, each.sample, &Trial::sample);
  const auto dial = static_cast<std::size_t>(each.dial);
  trial.reading[dial] = std::ranges::find(trials, each.sample, &Trial::sample)->reading[dial];
  return trial;
}

/// Sizes against the last fit, each with the other bad readings of its sample taken out.
void measure_again(
    std::span<const Trial> trials, const std::vector<Trial>& good, const geometry::Rig& rig,
    const VectorXd& x, std::vector<GrossError>& found) {
  for (GrossError& each : found) {
    const Seen seen = seen_error(with_reading(trials, good, each), rig, each.dial, x);
    if (seen.visible <= 0.0) continue;  // too few readings are left: as found
    each.times_sigma *= std::abs(seen.size_mm / each.size_mm);
    each.size_mm = seen.size_mm;
  }
}

/// True if what all others say leaves no doubt that a reading is bad.
bool is_bad(
    const ReadingJudge& judge, const Trial& trial, const geometry::Rig& rig, int dial,
    double least_chance) {
  const ObservationSpace of = dial_space(std::span(&trial, 1), rig);
  if (of.samples() != 1) return true;  // too few readings are left to say anything else
  const auto chance = judge.chance(of, left_of_an_error(trial, rig, dial, judge.x()));
  return !chance || *chance < least_chance;
}

using SharedJudge = std::shared_ptr<const ReadingJudge>;

/// What good readings say; null where the robot that `x` is cannot reach all poses.
SharedJudge judge_by(
    std::span<const Trial> good, const geometry::Rig& rig, const IdentifySettings& settings,
    const VectorXd& x) {
  const ObservationSpace space = dial_space(good, rig);
  const LeastSquaresFit fit = solve_least_squares(
      space.problem(Weighting::kBySigma), x, core_settings(space, settings));
  if (fit.status == FitStatus::kBadStart) return nullptr;
  return std::make_shared<const ReadingJudge>(space, fit);
}

/// Readings that the good ones explain by something smooth are good as well: they come back,
/// and say more of it. Until nothing changes.
SharedJudge clear_what_is_smooth(
    std::span<const Trial> trials, const geometry::Rig& rig, const IdentifySettings& settings,
    std::vector<Trial>& good, GrossErrorCheck& result) {
  const double least = kFalseAlarms / std::max(result.readings, 1);
  SharedJudge judge;
  for (int round = 0; round < kMostRounds; ++round) {
    judge = judge_by(good, rig, settings, result.x);
    if (!judge) return nullptr;
    result.x = judge->x();
    std::vector<GrossError> bad, cleared;
    for (const GrossError& each : result.found) {
      const Trial trial = with_reading(trials, good, each);
      (is_bad(*judge, trial, rig, each.dial, least) ? bad : cleared).push_back(each);
    }
    for (const GrossError& each : cleared) {
      *std::ranges::find(good, each.sample, &Trial::sample) = with_reading(trials, good, each);
    }
    result.found = std::move(bad);
    if (cleared.empty()) break;
  }
  return judge;
}

GrossErrorCheck check_dials(
    std::span<const Trial> trials, const geometry::Rig& rig, const IdentifySettings& settings) {
  GrossErrorCheck result;
  std::vector<Trial> good(trials.begin(), trials.end());
  DialSigma sigma;
  VectorXd start;
  for (int round = 0; round < kMostRounds; ++round) {
    const ObservationSpace space = dial_space(good, rig);
    if (round == 0) result.readings = space.rows();
    const int own = rig.cuboid.mount == geometry::Mount::kFree ? space.samples() : 0;
    const int freedom = space.rows() - space.parameters() - own;
    if (freedom < kLeastFreedom) {
      if (round == 0)
        result.not_possible = too_few(space.rows(), space.parameters() + own, "readings");
      break;
    }
    if (start.size() == 0) start = space.nominal;
    const LeastSquaresFit fit = robust_fit(space, settings, start, 1);
    if (fit.status == FitStatus::kBadStart) {
      if (round == 0) result.not_possible = "the nominal robot cannot reach all poses";
      break;
    }
    start = result.x = fit.x;
    VectorXd r(space.rows());
    static_cast<void>(space.problem(Weighting::kAlike).evaluate(fit.x, r, nullptr));
    sigma = robust_sigmas(space, r, freedom);
    result.sigma_mm = sigma.pooled;
    result.limit_times_sigma = limit_of(space.rows(), freedom);
    const auto bad = worst_of_each(good, rig, space, fit.x, sigma, result.limit_times_sigma);
    if (bad.empty()) break;
    result.found.insert(result.found.end(), bad.begin(), bad.end());
    take_out(good, bad);
  }
  result.sigma_by_dial_mm = sigma.by_dial;
  judge_number(result.readings, result);
  SharedJudge judge;
  if (result.x.size() > 0 && !result.found.empty()) {
    judge = clear_what_is_smooth(trials, rig, settings, good, result);
  }
  if (result.x.size() > 0) measure_again(trials, good, rig, result.x, result.found);
  // Accused because of a worse one in the same sample, and cleared without it.
  std::erase_if(result.found, [&](const GrossError& each) {
    return each.times_sigma <= result.limit_times_sigma;
  });
  sort(result.found);
  if (result.x.size() > 0) {
    result.judge_of_dials = [judge, good, rig, settings, x = result.x] {
      return judge ? judge : judge_by(good, rig, settings, x);
    };
  }
  return result;
}

}  // namespace

GrossErrorCheck find_gross_errors(
    std::span<const Trial> trials, const geometry::Rig& rig, const IdentifySettings& settings) {
  return rig.on_cuboid() && has_readings(trials) ? check_dials(trials, rig, settings)
                                                 : check_positions(trials, rig, settings);
}

GrossErrorCheck judge_readings(
    std::span<const Trial> trials, const geometry::Rig& rig, const GrossErrorCheck& fitted) {
  GrossErrorCheck result = fitted;
  result.found.clear();
  result.systematic = 0;
  if (fitted.x.size() == 0) return result;
  if (!rig.on_cuboid() || !has_readings(trials)) {
    if (!fitted.positions) return result;
    const ObservationSpace space = measured_space(trials, rig);
    const int samples = measured_samples(space);
    result.readings = samples;
    list(space, fitted.positions->others(space), kFalseAlarms / std::max(samples, 1), result);
    judge_number(samples, result);
    return result;
  }
  std::vector<Trial> good(trials.begin(), trials.end());
  const DialSigma sigma{fitted.sigma_by_dial_mm, fitted.sigma_mm};
  for (int round = 0; round < kMostRounds; ++round) {
    const ObservationSpace space = dial_space(good, rig);
    if (space.parameters() != fitted.x.size()) break;  // fitted to positions alone
    if (round == 0) result.readings = space.rows();
    const auto bad = worst_of_each(good, rig, space, fitted.x, sigma, fitted.limit_times_sigma);
    if (bad.empty()) break;
    result.found.insert(result.found.end(), bad.begin(), bad.end());
    take_out(good, bad);
  }
  judge_number(result.readings, result);
  if (const auto judge = result.found.empty() ? nullptr : fitted.judge_of_dials()) {
    const double least = kFalseAlarms / std::max(result.readings, 1);
    std::erase_if(result.found, [&](const GrossError& each) {
      return !is_bad(*judge, with_reading(trials, good, each), rig, each.dial, least);
    });
  }
  sort(result.found);
  return result;
}

}  // namespace sixdial::calibration
