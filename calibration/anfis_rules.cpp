#include "calibration/anfis_rules.h"

#include <algorithm>
#include <cstddef>

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

/// N sums over samples [0, n) of w * scaled * x_c, added to result[c].
template <std::size_t N>
HWY_INLINE HWY_ATTR void add_sums(
    std::size_t n, std::size_t stride, const double* w, const double* scaled, const double* x,
    double* result) {
  const D d;
  V sum[N];
  for (std::size_t c = 0; c < N; ++c) sum[c] = hn::Zero(d);
  for (std::size_t a = 0; a < n; a += hn::Lanes(d)) {
    const V wa = hn::Mul(hn::LoadU(d, w + a), hn::LoadU(d, scaled + a));
    for (std::size_t c = 0; c < N; ++c) {
      sum[c] = hn::MulAdd(wa, hn::LoadU(d, x + c * stride + a), sum[c]);
    }
  }
  for (std::size_t c = 0; c < N; ++c) result[c] += hn::GetLane(hn::SumOfLanes(d, sum[c]));
}

HWY_ATTR void add_any_sums(
    std::size_t count, std::size_t n, std::size_t stride, const double* w, const double* scaled,
    const double* x, double* result) {
  for (; count >= 4; count -= 4, x += 4 * stride, result += 4) {
    add_sums<4>(n, stride, w, scaled, x, result);
  }
  if (count == 3) add_sums<3>(n, stride, w, scaled, x, result);
  if (count == 2) add_sums<2>(n, stride, w, scaled, x, result);
  if (count == 1) add_sums<1>(n, stride, w, scaled, x, result);
}

HWY_ATTR void project_rules(
    std::size_t per_rule, std::size_t padded, const RuleTable& first, const RuleTable& second,
    const double* x, const double* alpha, double* result) {
  const D d;
  constexpr std::size_t kSamples = 512;  // their inputs stay in the first cache
  alignas(64) double scaled[kSamples];
  const std::size_t rules = first.size * second.size;
  std::fill(result, result + rules * per_rule, 0.0);
  for (std::size_t from = 0; from < padded; from += kSamples) {
    const std::size_t n = std::min(kSamples, padded - from);
    for (std::size_t j = 0; j < second.size; ++j) {
      const double* own = second.arrays + j * padded + from;
      for (std::size_t a = 0; a < n; a += hn::Lanes(d)) {
        hn::StoreU(
            hn::Mul(hn::LoadU(d, own + a), hn::LoadU(d, alpha + from + a)), d, scaled + a);
      }
      for (std::size_t i = 0; i < first.size; ++i) {
        add_any_sums(
            per_rule, n, padded, first.arrays + i * padded + from, scaled, x + from,
            result + (i + first.size * j) * per_rule);
      }
    }
  }
}

/// Outputs of one rule at N vectors of samples, added to either sum.
template <std::size_t N>
HWY_INLINE HWY_ATTR void add_outputs(
    std::size_t per_rule, std::size_t stride, const double* first, const double* second,
    const double* x, const double* b, double* by_first, double* by_second) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  V f[N];
  for (std::size_t k = 0; k < N; ++k) f[k] = hn::Zero(d);
  for (std::size_t c = 0; c < per_rule; ++c, x += stride) {
    const V factor = hn::Set(d, b[c]);
    for (std::size_t k = 0; k < N; ++k) {
      f[k] = hn::MulAdd(factor, hn::LoadU(d, x + k * lanes), f[k]);
    }
  }
  for (std::size_t k = 0; k < N; ++k) {
    const std::size_t a = k * lanes;
    const V strength = hn::Mul(hn::LoadU(d, first + a), hn::LoadU(d, second + a));
    const V out = hn::Mul(f[k], strength);
    hn::StoreU(hn::Add(hn::LoadU(d, by_first + a), out), d, by_first + a);
    hn::StoreU(hn::Add(hn::LoadU(d, by_second + a), out), d, by_second + a);
  }
}

HWY_ATTR void answer_rules(
    std::size_t per_rule, std::size_t padded, const RuleTable& first, const RuleTable& second,
    const double* x, const double* B, double* by_first, double* by_second) {
  constexpr std::size_t kSamples = 64;  // their tables stay in the first cache
  const std::size_t lanes = hn::Lanes(D());
  for (std::size_t from = 0; from < padded; from += kSamples) {
    const std::size_t to = std::min(from + kSamples, padded);
    for (std::size_t j = 0; j < second.size; ++j) {
      const double* right = second.arrays + j * padded;
      double* by_right = by_second + j * padded;
      for (std::size_t i = 0; i < first.size; ++i) {
        const double* left = first.arrays + i * padded;
        double* by_left = by_first + i * padded;
        const double* b = B + (i + first.size * j) * per_rule;
        std::size_t a = from;
        for (; a + 4 * lanes <= to; a += 4 * lanes) {
          add_outputs<4>(
              per_rule, padded, left + a, right + a, x + a, b, by_left + a, by_right + a);
        }
        for (; a < to; a += lanes) {
          add_outputs<1>(
              per_rule, padded, left + a, right + a, x + a, b, by_left + a, by_right + a);
        }
      }
    }
  }
}

}  // namespace sixdial::calibration::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sixdial::calibration {

HWY_EXPORT(project_rules);
HWY_EXPORT(answer_rules);

namespace {

int power(int base, int exponent) {
  int result = 1;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

RuleTable table(const Eigen::MatrixXd& arrays) {
  return {static_cast<std::size_t>(arrays.cols()), arrays.data()};
}

}  // namespace

RuleTables::RuleTables(int inputs, int functions, int padded)
    : inputs_(inputs),
      functions_(functions),
      padded_(padded),
      inputs_of_first_((inputs + 1) / 2),
      first_(padded, power(functions, inputs_of_first_)),
      second_(padded, power(functions, inputs - inputs_of_first_)),
      by_first_(padded, first_.cols()),
      by_second_(padded, second_.cols()) {}

void RuleTables::set(const Eigen::MatrixXd& nu) {
  anfis_rules(inputs_of_first_, functions_, padded_, nu.data(), first_.data());
  const int others = inputs_ - inputs_of_first_;
  if (others == 0) {
    second_.setOnes();
    return;
  }
  const Eigen::Index at = static_cast<Eigen::Index>(inputs_of_first_) * functions_;
  anfis_rules(others, functions_, padded_, nu.col(at).data(), second_.data());
}

void RuleTables::project(
    const Eigen::MatrixXd& x, const Eigen::VectorXd& alpha, Eigen::VectorXd& result) const {
  HWY_DYNAMIC_DISPATCH(project_rules)
  (static_cast<std::size_t>(inputs_) + 1, static_cast<std::size_t>(padded_), table(first_),
   table(second_), x.data(), alpha.data(), result.data());
}

void RuleTables::answer(
    const Eigen::MatrixXd& x, const Eigen::VectorXd& B, Eigen::VectorXd& out) {
  by_first_.setZero();
  by_second_.setZero();
  HWY_DYNAMIC_DISPATCH(answer_rules)
  (static_cast<std::size_t>(inputs_) + 1, static_cast<std::size_t>(padded_), table(first_),
   table(second_), x.data(), B.data(), by_first_.data(), by_second_.data());
  out = by_second_.rowwise().sum();
}

void RuleTables::add_rules_of(int input, int function, Eigen::VectorXd& sum) const {
  const bool of_first = input < inputs_of_first_;
  const Eigen::MatrixXd& by = of_first ? by_first_ : by_second_;
  const int stride = power(functions_, of_first ? input : input - inputs_of_first_);
  for (Eigen::Index r = 0; r < by.cols(); ++r) {
    if (r / stride % functions_ == function) sum += by.col(r);
  }
}

}  // namespace sixdial::calibration
#endif  // HWY_ONCE
