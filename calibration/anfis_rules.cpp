#include "calibration/anfis_rules.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "calibration/anfis_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calibration/anfis_rules.cpp"
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace sixdial::calibration::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kSamplePad>;
using V = hn::Vec<D>;

constexpr std::size_t kSamples = 64;  // at a time: their arrays stay in the first cache

/// A rule's arrays: one of the first inputs' products, and one of each other input.
struct RuleFactors {
  const double* first;
  const double* other[kMostAnfisInputs];
  std::size_t others;
};

HWY_INLINE HWY_ATTR RuleFactors factors_of(const RuleArrays& rules, std::size_t j) {
  RuleFactors result{};
  result.others = rules.inputs - rules.inputs_of_first;
  for (std::size_t i = 0; i < result.others; ++i, j /= rules.functions) {
    const std::size_t column =
        (rules.inputs_of_first + i) * rules.functions + j % rules.functions;
    result.other[i] = rules.nu + column * rules.padded;
  }
  return result;
}

/// Strengths of a rule at one vector of samples, multiplied input by input.
HWY_INLINE HWY_ATTR V strength(const RuleFactors& rule, std::size_t a) {
  const D d;
  V w = hn::LoadU(d, rule.first + a);
  for (std::size_t i = 0; i < rule.others; ++i) w = hn::Mul(w, hn::LoadU(d, rule.other[i] + a));
  return w;
}

/// N sums over samples of w * alpha * x_c.
template <std::size_t N>
HWY_INLINE HWY_ATTR void sums_of(
    std::size_t padded, const RuleFactors& rule, const double* alpha, const double* x,
    double* result) {
  const D d;
  V sum[N];
  for (std::size_t c = 0; c < N; ++c) sum[c] = hn::Zero(d);
  for (std::size_t a = 0; a < padded; a += hn::Lanes(d)) {
    const V wa = hn::Mul(strength(rule, a), hn::LoadU(d, alpha + a));
    for (std::size_t c = 0; c < N; ++c) {
      sum[c] = hn::MulAdd(wa, hn::LoadU(d, x + c * padded + a), sum[c]);
    }
  }
  for (std::size_t c = 0; c < N; ++c) result[c] = hn::GetLane(hn::SumOfLanes(d, sum[c]));
}

HWY_ATTR void project_rules(
    const RuleArrays& rules, const double* x, const double* alpha, double* result) {
  const std::size_t padded = rules.padded;
  for (std::size_t j = 0; j < rules.other_count; ++j) {
    RuleFactors rule = factors_of(rules, j);
    for (std::size_t i = 0; i < rules.first_count; ++i) {
      rule.first = rules.first + i * padded;
      std::size_t left = rules.inputs + 1;
      const double* column = x;
      for (; left >= 4; left -= 4, column += 4 * padded, result += 4) {
        sums_of<4>(padded, rule, alpha, column, result);
      }
      if (left == 3) sums_of<3>(padded, rule, alpha, column, result);
      if (left == 2) sums_of<2>(padded, rule, alpha, column, result);
      if (left == 1) sums_of<1>(padded, rule, alpha, column, result);
      result += left;
    }
  }
}

/// Output of one rule at N vectors of samples, added to each of these sums.
template <std::size_t N>
HWY_INLINE HWY_ATTR void add_output(
    const RuleArrays& rules, const RuleFactors& rule, const double* x, const double* b,
    std::size_t a, std::size_t groups, double* const* sums) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  V f[N];
  for (std::size_t k = 0; k < N; ++k) f[k] = hn::Zero(d);
  for (std::size_t c = 0; c <= rules.inputs; ++c) {
    const V factor = hn::Set(d, b[c]);
    const double* column = x + c * rules.padded + a;
    for (std::size_t k = 0; k < N; ++k) {
      f[k] = hn::MulAdd(factor, hn::LoadU(d, column + k * lanes), f[k]);
    }
  }
  for (std::size_t k = 0; k < N; ++k) f[k] = hn::Mul(f[k], strength(rule, a + k * lanes));
  for (std::size_t g = 0; g < groups; ++g) {
    double* sum = sums[g] + a;
    for (std::size_t k = 0; k < N; ++k) {
      hn::StoreU(hn::Add(hn::LoadU(d, sum + k * lanes), f[k]), d, sum + k * lanes);
    }
  }
}

/// Adds the output of each rule with consequents B to one array of each group: arrays
/// into + group_of(r, g) * padded.
template <class GroupOf>
HWY_INLINE HWY_ATTR void add_outputs(
    const RuleArrays& rules, const double* x, const double* B, std::size_t groups,
    const GroupOf& group_of, double* into) {
  const std::size_t lanes = hn::Lanes(D());
  const std::size_t padded = rules.padded;
  for (std::size_t from = 0; from < padded; from += kSamples) {
    const std::size_t to = std::min(from + kSamples, padded);
    for (std::size_t j = 0; j < rules.other_count; ++j) {
      RuleFactors rule = factors_of(rules, j);
      for (std::size_t i = 0; i < rules.first_count; ++i) {
        rule.first = rules.first + i * padded;
        const std::size_t r = i + rules.first_count * j;
        const double* b = B + r * (rules.inputs + 1);
        double* sums[kMostAnfisInputs];
        for (std::size_t g = 0; g < groups; ++g) sums[g] = into + group_of(r, g) * padded;
        std::size_t a = from;
        for (; a + 4 * lanes <= to; a += 4 * lanes) {
          add_output<4>(rules, rule, x, b, a, groups, sums);
        }
        for (; a < to; a += lanes) add_output<1>(rules, rule, x, b, a, groups, sums);
      }
    }
  }
}

HWY_ATTR void answer_rules(
    const RuleArrays& rules, const double* x, const double* B, double* out) {
  add_outputs(
      rules, x, B, 1, [](std::size_t, std::size_t) { return std::size_t{0}; }, out);
}

HWY_ATTR void add_rules(
    const RuleArrays& rules, const double* x, const double* B, double* sums) {
  const auto column = [&](std::size_t r, std::size_t input) {
    for (std::size_t i = 0; i < input; ++i) r /= rules.functions;
    return input * rules.functions + r % rules.functions;
  };
  add_outputs(rules, x, B, rules.inputs, column, sums);
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(project_rules);
HWY_EXPORT(answer_rules);
HWY_EXPORT(add_rules);

namespace {

int power(int base, int exponent) {
  int result = 1;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

}  // namespace

AnfisRules::AnfisRules(int inputs, int functions, int padded)
    : functions_(functions),
      inputs_of_first_((inputs + 1) / 2),
      first_(padded, power(functions, inputs_of_first_)) {
  if (inputs > static_cast<int>(kMostAnfisInputs)) {
    throw std::invalid_argument(
        "ANFIS: " + std::to_string(inputs) + " inputs; at most " +
        std::to_string(kMostAnfisInputs) + " can be learned from");
  }
  const auto number = [](auto value) { return static_cast<std::size_t>(value); };
  arrays_ = {
      number(inputs),
      number(functions),
      number(padded),
      number(inputs_of_first_),
      number(first_.cols()),
      number(power(functions, inputs - inputs_of_first_)),
      nullptr,
      nullptr};
}

void AnfisRules::set(const Eigen::MatrixXd& nu) {
  anfis_rules(
      inputs_of_first_, functions_, static_cast<int>(first_.rows()), nu.data(), first_.data());
  arrays_.first = first_.data();
  arrays_.nu = nu.data();
}

void AnfisRules::project(
    const Eigen::MatrixXd& x, const Eigen::VectorXd& alpha, Eigen::VectorXd& result) const {
  HWY_DYNAMIC_DISPATCH(project_rules)(arrays_, x.data(), alpha.data(), result.data());
}

void AnfisRules::answer(
    const Eigen::MatrixXd& x, const Eigen::VectorXd& B, Eigen::VectorXd& out) const {
  out.setZero();
  HWY_DYNAMIC_DISPATCH(answer_rules)(arrays_, x.data(), B.data(), out.data());
}

void AnfisRules::add_by_function(
    const Eigen::MatrixXd& x, const Eigen::VectorXd& B, Eigen::MatrixXd& sums) const {
  HWY_DYNAMIC_DISPATCH(add_rules)(arrays_, x.data(), B.data(), sums.data());
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
