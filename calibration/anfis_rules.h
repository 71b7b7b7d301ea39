// What an ANFIS epoch does over all rules, without keeping them: a rule's strength is a product
// over the inputs, of which the first half is kept for each combination. Of 3^6 rules only 27
// arrays are kept, which stay in the cache; the rest is multiplied anew where it is needed.
// Layout as in anfis_kernels.h: entry `a` of array `k` is at [k * padded + a].
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace sixdial::calibration {

inline constexpr std::size_t kMostAnfisInputs = 64;

/// For the kernels. Rule r = i + first_count * j, with i of the first inputs and j of the
/// others.
struct RuleArrays {
  std::size_t inputs, functions, padded;
  std::size_t inputs_of_first, first_count, other_count;
  const double* first;  // first_count arrays
  const double* nu;     // inputs * functions arrays
};

/// All rules at `padded` samples. `nu`, `x`: as of the same samples in every call; nu: padded x
/// (inputs * functions), normalised memberships; x: padded x (inputs + 1), ones first.
class AnfisRules {
 public:
  /// std::invalid_argument for more than kMostAnfisInputs.
  AnfisRules(int inputs, int functions, int padded);

  /// From the normalised memberships, which must stay for the calls below.
  void set(const Eigen::MatrixXd& nu);

  /// sum over samples of w_r x_c alpha, for each rule and each of (one, x_1 ..): rules x
  /// (inputs + 1), rule-major.
  void project(
      const Eigen::MatrixXd& x, const Eigen::VectorXd& alpha, Eigen::VectorXd& result) const;

  /// Output at each sample (38) with consequents B, rule-major.
  void answer(const Eigen::MatrixXd& x, const Eigen::VectorXd& B, Eigen::VectorXd& out) const;
  /// Added to column i * functions + k of `sums`, padded x (inputs * functions): what the rules
  /// that use function k of input i give to that output.
  void add_by_function(
      const Eigen::MatrixXd& x, const Eigen::VectorXd& B, Eigen::MatrixXd& sums) const;

 private:
  int functions_, inputs_of_first_;
  Eigen::MatrixXd first_;
  RuleArrays arrays_{};
};

}  // namespace sixdial::calibration
