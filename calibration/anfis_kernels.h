// The inner loops of an ANFIS epoch, vectorised over samples; those over all rules:
// anfis_rules.h. Sample arrays are padded to whole vectors; entry `a` of array `k` is at [k *
// padded + a]. The padding has one[a] = 0, so it weighs nothing. calibration/anfis.cpp holds
// the plain formulas that tests compare with.
#pragma once

#include <Eigen/Core>

namespace sixdial::calibration {

inline constexpr int kSamplePad = 8;
[[nodiscard]] constexpr int padded_size(int n) {
  return (n + kSamplePad - 1) / kSamplePad * kSamplePad;
}

enum class MembershipKind {
  kGaussian,  // exp(-((x - c)/a)^2), equation (40)
  kBell,      // 1/(1 + |(x - c)/a|^(2b)), Jang's
};

/// One input's memberships at `padded` samples for `functions` functions: the normalised
/// memberships nu = mu / sum(mu) and the derivatives of ln(mu) by c, a (and b).
struct MembershipArrays {
  double* nu;
  double* by_centre;
  double* by_width;
  double* by_slope;  // bell only
};
void anfis_memberships(
    MembershipKind kind, int functions, int padded, const double* x, const double* centre,
    const double* width, const double* slope, const MembershipArrays& out);

/// Lower triangle of K = X X' o N1 N1' o N2 N2' ... (o entry by entry), padded x padded,
/// column-major: equals A A' without forming A. `x`: (inputs + 1) arrays, `one` first; `nu`:
/// inputs * functions arrays.
void anfis_gram_dual(
    int inputs, int functions, int padded, const double* x, const double* nu, double* K);

/// Lower triangle of G = A'A (columns x columns, leading dimension ld) from column arrays of
/// `padded` samples.
void gram_primal(int columns, int padded, const double* A, int ld, double* G);

/// Solves K z = b for symmetric positive definite K: lower triangle, column-major, n x n with
/// leading dimension ld (a multiple of kSamplePad, rows beyond n are scratch). K becomes its
/// Cholesky factor, b (ld long) the solution. False if K is not positive definite.
[[nodiscard]] bool cholesky_solve(int n, int ld, double* K, double* b);

/// Rule outputs: w_r = product of nu, for each rule r (input 0 varies fastest).
void anfis_rules(int inputs, int functions, int padded, const double* nu, double* w);

/// Dot product of three arrays.
[[nodiscard]] double dot3(int padded, const double* a, const double* b, const double* c);

}  // namespace sixdial::calibration
