// Which grid and which ridge a network gets: by what it errs on poses that it was not shown.
#include "calibration/anfis_selection.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "calibration/anfis.h"
#include "tests/calibration/anfis_data.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(AnfisSelection, LeaveOneOutErrorsAreThoseOfLeavingOneOut) {
  for (const int functions : {2, 6}) {  // primal and dual
    const MatrixXd x = random_inputs(40, 2, 11);
    const VectorXd y = smooth(x);
    const MatrixXd A = design_matrix(initial_anfis(x, MembershipKind::kGaussian, functions), x);
    const std::vector<double> ridges{1e-3, 1e-1};
    std::vector<double> effective;
    const MatrixXd errors = LeaveOneOut(A).errors(y, ridges, {}, effective);
    for (std::size_t k = 0; k < 2; ++k) {
      for (const int left : {0, 17, 39}) {
        std::vector<int> rest;
        for (int i = 0; i < 40; ++i) {
          if (i != left) rest.push_back(i);
        }
        const MatrixXd B = A(rest, Eigen::all);
        const VectorXd theta =
            (B.transpose() * B + ridges[k] * MatrixXd::Identity(B.cols(), B.cols()))
                .llt()
                .solve(B.transpose() * y(rest));
        EXPECT_NEAR(
            errors(left, static_cast<Eigen::Index>(k)), y[left] - A.row(left).dot(theta), 1e-8);
      }
    }
  }
}

TEST(AnfisSelection, IsTheSameFromTheProductsOfTheDesign) {
  const MatrixXd x = random_inputs(40, 3, 13);
  const AnfisModel model = initial_anfis(x, MembershipKind::kGaussian, 3);
  const MatrixXd A = design_matrix(model, x);
  const std::vector<double> ridges{1e-4, 1e-1};
  const std::vector<std::vector<int>> poses{{0, 1, 2}, {5, 9}};
  std::vector<double> effective, by_products;
  const MatrixXd errors = LeaveOneOut(A).errors(smooth(x), ridges, poses, effective);
  const MatrixXd same = LeaveOneOut::of_products(design_products(model, x))
                            .errors(smooth(x), ridges, poses, by_products);
  EXPECT_LT((errors - same).norm(), 1e-8 * errors.norm());
  EXPECT_NEAR(effective[0], by_products[0], 1e-8);
  EXPECT_NEAR(effective[1], by_products[1], 1e-8);
}

TEST(AnfisSelection, LeavesAPoseOutWithAllItsRepeats) {
  const std::vector<std::vector<int>> poses{{0, 1, 2}, {5, 9}, {20}};
  for (const int functions : {2, 6}) {  // primal and dual
    const MatrixXd x = random_inputs(40, 2, 12);
    const VectorXd y = smooth(x);
    const MatrixXd A = design_matrix(initial_anfis(x, MembershipKind::kGaussian, functions), x);
    const std::vector<double> ridges{1e-2};
    std::vector<double> effective;
    const MatrixXd errors = LeaveOneOut(A).errors(y, ridges, poses, effective);
    for (const std::vector<int>& left : poses) {
      std::vector<int> rest;
      for (int i = 0; i < 40; ++i) {
        if (std::ranges::find(left, i) == left.end()) rest.push_back(i);
      }
      const MatrixXd B = A(rest, Eigen::all);
      const VectorXd theta =
          (B.transpose() * B + ridges[0] * MatrixXd::Identity(B.cols(), B.cols()))
              .llt()
              .solve(B.transpose() * y(rest));
      for (const int i : left) EXPECT_NEAR(errors(i, 0), y[i] - A.row(i).dot(theta), 1e-8);
    }
  }
}

TEST(AnfisSelection, ChoosesNoNetworkForNoiseAndOneForASmoothError) {
  int networks = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const MatrixXd x = random_inputs(100, 2, seed);
    RandomSequence random(seed + 500);
    VectorXd noise(100);
    for (double& each : noise) each = 0.003 * random.normal();
    networks += select_anfis(x, noise, MembershipKind::kGaussian).chosen.functions > 0 ? 1 : 0;
    const VectorXd y = smooth(x) + noise;
    const auto selection = select_anfis(x, y, MembershipKind::kGaussian);
    ASSERT_GT(selection.chosen.functions, 0);
    EXPECT_LT(selection.chosen.loo_rmse, 0.5 * selection.rmse_without);
    EXPECT_GT(selection.gain, 0.9);
  }
  EXPECT_LE(networks, 5);
}

}  // namespace
}  // namespace sixdial::calibration
