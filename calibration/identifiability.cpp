#include "calibration/identifiability.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace sixdial::calibration {
namespace {

// Parts of a direction smaller than this (of its largest) are left out of its words.
constexpr double kNamedPart = 0.2;
constexpr double kSameDirection = 0.99;  // cosine
// A parameter counts as partly held when this much of it lies along held directions.
constexpr double kHeldPart = 0.1;

std::string list_of(const std::vector<std::string_view>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

/// The parts of a direction that has words, and nothing else to speak of.
bool is_along(
    const Eigen::VectorXd& direction, const geometry::NamedDirection& named,
    std::span<const std::string_view> names) {
  Eigen::VectorXd whole = Eigen::VectorXd::Zero(direction.size());
  for (const auto& [name, part] : named.parts) {
    const auto at = std::ranges::find(names, std::string_view(name));
    if (at == names.end()) return false;
    whole[at - names.begin()] = part;
  }
  return std::abs(direction.dot(whole.normalized())) > kSameDirection;
}

std::string words_for(
    const Eigen::VectorXd& direction, std::span<const std::string_view> names,
    std::span<const geometry::NamedDirection> known) {
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  // Signs so that the parameter named first rises.
  const double limit = kNamedPart * std::abs(direction[largest]);
  std::vector<std::string_view> rises;
  std::vector<std::string_view> falls;
  double sign = 0.0;
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    if (std::abs(direction[i]) < limit) continue;
    if (sign == 0.0) sign = direction[i] > 0 ? 1.0 : -1.0;
    (sign * direction[i] > 0 ? rises : falls).push_back(names[static_cast<std::size_t>(i)]);
  }
  std::string text = list_of(rises);
  if (falls.empty()) {
    return rises.size() > 1 ? text + " rise together" : text + " alone";
  }
  text += rises.size() > 1 ? " rise while " : " rises while ";
  text += list_of(falls);
  text += falls.size() > 1 ? " fall" : " falls";
  for (const geometry::NamedDirection& each : known) {
    if (is_along(direction, each, names)) return text + " (" + each.words + ")";
  }
  return text;
}

}  // namespace

Identifiability identifiability(
    const LeastSquaresFit& fit, std::span<const std::string_view> names, int samples,
    std::span<const geometry::NamedDirection> known) {
  Identifiability result;
  result.singular_values = fit.singular_values;
  result.condition = fit.condition();
  const auto n = fit.singular_values.size();
  if (n > 0 && samples > 0) {
    double log_sum = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      log_sum += std::log(std::max(fit.singular_values[i], 1e-300));
    }
    result.observability = std::exp(log_sum / static_cast<double>(n)) / std::sqrt(samples);
  }
  for (Eigen::Index k = n - fit.held; k < n; ++k) {
    const Eigen::VectorXd direction = fit.directions.col(k);
    result.held.push_back(
        {direction, fit.singular_values[k], words_for(direction, names, known)});
  }
  const Eigen::MatrixXd C = fit.unit_covariance();
  for (int i = 0; i < C.rows(); ++i) {
    for (int j = i + 1; j < C.cols(); ++j) {
      const double scale = std::sqrt(C(i, i) * C(j, j));
      if (scale > 0.0 && std::abs(C(i, j)) > kHighCorrelation * scale) {
        result.correlations.push_back({i, j, C(i, j) / scale});
      }
    }
  }
  std::ranges::sort(result.correlations, [](const Correlation& a, const Correlation& b) {
    return std::abs(a.coefficient) > std::abs(b.coefficient);
  });
  return result;
}

double student_95(int degrees_of_freedom) {
  if (degrees_of_freedom < 1) return 0.0;
  const boost::math::students_t distribution(std::min(degrees_of_freedom, 1'000'000));
  return boost::math::quantile(boost::math::complement(distribution, 0.025));
}

std::vector<ParameterEstimate> parameter_estimates(
    const LeastSquaresFit& fit, const Eigen::VectorXd& nominal,
    const Eigen::MatrixXd& covariance, std::span<const std::string_view> names) {
  std::vector<ParameterEstimate> result;
  const double t = student_95(fit.degrees_of_freedom());
  const Eigen::MatrixXd held = fit.directions.rightCols(fit.held);
  for (Eigen::Index i = 0; i < fit.x.size(); ++i) {
    ParameterEstimate each;
    each.name = names[static_cast<std::size_t>(i)];
    each.nominal = nominal[i];
    each.value = fit.x[i];
    each.sd = std::sqrt(std::max(covariance(i, i), 0.0));
    each.low_95 = each.value - t * each.sd;
    each.high_95 = each.value + t * each.sd;
    each.fixed = fit.directions.row(i).isZero(0.0);
    each.partly_held = held.cols() > 0 && held.row(i).norm() > kHeldPart;
    result.push_back(each);
  }
  return result;
}

}  // namespace sixdial::calibration
