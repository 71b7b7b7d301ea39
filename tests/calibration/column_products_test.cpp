#include "calibration/column_products.h"

#include <gtest/gtest.h>

namespace sixdial::calibration {
namespace {

TEST(ColumnProducts, AreThoseOfEigenForEveryShape) {
  // Rows around the width of vectors and the length of a block; columns around a tile.
  for (const Eigen::Index rows : {0, 1, 7, 8, 511, 512, 513, 1200}) {
    for (const Eigen::Index p : {0, 1, 3, 4, 5, 17}) {
      for (const Eigen::Index q : {0, 1, 4, 6}) {
        const Eigen::MatrixXd A = Eigen::MatrixXd::Random(rows, p);
        const Eigen::MatrixXd B = Eigen::MatrixXd::Random(rows, q);
        const Eigen::MatrixXd AB = column_products(A, B);
        const Eigen::MatrixXd AA = column_products(A);
        ASSERT_EQ(AB.rows(), p);
        ASSERT_EQ(AB.cols(), q);
        constexpr double kRounding = 1e-11;  // of sums of a thousand numbers below 1
        if (rows == 0 || p == 0) {
          EXPECT_EQ(AA.squaredNorm(), 0.0);
          continue;
        }
        if (q > 0) {
          EXPECT_LT((AB - A.transpose() * B).cwiseAbs().maxCoeff(), kRounding);
        }
        EXPECT_LT((AA - A.transpose() * A).cwiseAbs().maxCoeff(), kRounding);
      }
    }
  }
}

}  // namespace
}  // namespace sixdial::calibration
