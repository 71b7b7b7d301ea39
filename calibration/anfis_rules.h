// What an ANFIS epoch does over all rules, by two tables: a rule's strength is a factor of the
// first inputs times one of the others, so that of 3^6 rules only 2 x 27 arrays are kept, which
// stay in the cache. Layout as in anfis_kernels.h: entry `a` of array `k` is at [k * padded +
// a].
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace sixdial::calibration {

/// So many arrays, one after the other.
struct RuleTable {
  std::size_t size;
  const double* arrays;
};

/// Strengths of all rules at `padded` samples: rule r = i + first() * j has the strength
/// first_[i] * second_[j].
class RuleTables {
 public:
  RuleTables(int inputs, int functions, int padded);

  /// From the normalised memberships, padded x (inputs * functions).
  void set(const Eigen::MatrixXd& nu);

  /// sum over samples of w_r x_c alpha, for each rule and each of (one, x_1 ..): rules x
  /// (inputs + 1), rule-major. `x`: padded x (inputs + 1), ones first.
  void project(
      const Eigen::MatrixXd& x, const Eigen::VectorXd& alpha, Eigen::VectorXd& result) const;

  /// Output at each sample (38) with consequents B, rule-major.
  void answer(const Eigen::MatrixXd& x, const Eigen::VectorXd& B, Eigen::VectorXd& out);
  /// After `answer`: what the rules that use function k of an input gave, added to `sum`.
  void add_rules_of(int input, int function, Eigen::VectorXd& sum) const;

 private:
  int inputs_, functions_, padded_;
  int inputs_of_first_;
  Eigen::MatrixXd first_, second_;        // padded x (functions ^ inputs of either)
  Eigen::MatrixXd by_first_, by_second_;  // outputs of the rules, summed over the other table
};

}  // namespace sixdial::calibration
