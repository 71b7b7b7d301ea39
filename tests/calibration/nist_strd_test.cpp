// The 27 certified nonlinear regressions of NIST's Statistical Reference Datasets, both starts,
// through the least-squares core. Derivatives by Ceres' jets, so a slip in a formula shows.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/least_squares.h"
#include "tests/support/paths.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
// Extended precision: Lanczos1's residuals (1e-13 of values about 1) are near double's
// rounding.
using Real = long double;
using Jet = ceres::Jet<Real, 9>;

// Of the 11 that are certified. Worst seen: 9.1; 6.5 (Lanczos1, of a residual near rounding).
// Issue 3 asks for 6 and 4.
constexpr double kParameterDigits = 8.0;
constexpr double kDeviationDigits = 6.0;

using Model = Jet (*)(const Jet* b, const Real* x);

Jet polynomial(const Jet* b, int count, Real x) {
  Jet sum(0.0L);
  for (int i = count; i-- > 0;) sum = sum * x + b[i];
  return sum;
}

struct Set {
  const char* name;
  Model model;
  int predictors = 1;
  bool log_response = false;
};

const Set kSets[] = {
    {"Misra1a", [](const Jet* b, const Real* x) { return b[0] * (1.0L - exp(-b[1] * x[0])); }},
    {"Chwirut2",
     [](const Jet* b, const Real* x) { return exp(-b[0] * x[0]) / (b[1] + b[2] * x[0]); }},
    {"Chwirut1",
     [](const Jet* b, const Real* x) { return exp(-b[0] * x[0]) / (b[1] + b[2] * x[0]); }},
    {"Lanczos3",
     [](const Jet* b, const Real* x) {
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-b[3] * x[0]) + b[4] * exp(-b[5] * x[0]);
     }},
    {"Gauss1",
     [](const Jet* b, const Real* x) {
       const Jet u = (x[0] - b[3]) / b[4];
       const Jet v = (x[0] - b[6]) / b[7];
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-u * u) + b[5] * exp(-v * v);
     }},
    {"Gauss2",
     [](const Jet* b, const Real* x) {
       const Jet u = (x[0] - b[3]) / b[4];
       const Jet v = (x[0] - b[6]) / b[7];
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-u * u) + b[5] * exp(-v * v);
     }},
    {"DanWood", [](const Jet* b, const Real* x) { return b[0] * pow(Jet(x[0]), b[1]); }},
    {"Misra1b",
     [](const Jet* b, const Real* x) {
       const Jet u = 1.0L + b[1] * x[0] / 2.0L;
       return b[0] * (1.0L - 1.0L / (u * u));
     }},
    {"Kirby2",
     [](const Jet* b, const Real* x) {
       return polynomial(b, 3, x[0]) / (1.0L + x[0] * polynomial(b + 3, 2, x[0]));
     }},
    {"Hahn1",
     [](const Jet* b, const Real* x) {
       return polynomial(b, 4, x[0]) / (1.0L + x[0] * polynomial(b + 4, 3, x[0]));
     }},
    {"Nelson",
     [](const Jet* b, const Real* x) { return b[0] - b[1] * x[0] * exp(-b[2] * x[1]); }, 2,
     true},
    {"MGH17",
     [](const Jet* b, const Real* x) {
       return b[0] + b[1] * exp(-x[0] * b[3]) + b[2] * exp(-x[0] * b[4]);
     }},
    {"Lanczos1",
     [](const Jet* b, const Real* x) {
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-b[3] * x[0]) + b[4] * exp(-b[5] * x[0]);
     }},
    {"Lanczos2",
     [](const Jet* b, const Real* x) {
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-b[3] * x[0]) + b[4] * exp(-b[5] * x[0]);
     }},
    {"Gauss3",
     [](const Jet* b, const Real* x) {
       const Jet u = (x[0] - b[3]) / b[4];
       const Jet v = (x[0] - b[6]) / b[7];
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-u * u) + b[5] * exp(-v * v);
     }},
    {"Misra1c",
     [](const Jet* b, const Real* x) {
       return b[0] * (1.0L - 1.0L / sqrt(1.0L + 2.0L * b[1] * x[0]));
     }},
    {"Misra1d",
     [](const Jet* b, const Real* x) { return b[0] * b[1] * x[0] / (1.0L + b[1] * x[0]); }},
    {"Roszman1",
     [](const Jet* b, const Real* x) {
       return b[0] - b[1] * x[0] - atan(b[2] / (x[0] - b[3])) / std::numbers::pi_v<Real>;
     }},
    {"ENSO",
     [](const Jet* b, const Real* x) {
       const Real year = 2.0L * std::numbers::pi_v<Real> * x[0] / 12.0L;
       const Jet u = 2.0L * std::numbers::pi_v<Real> * x[0] / b[3];
       const Jet v = 2.0L * std::numbers::pi_v<Real> * x[0] / b[6];
       return b[0] + b[1] * std::cos(year) + b[2] * std::sin(year) + b[4] * cos(u) +
              b[5] * sin(u) + b[7] * cos(v) + b[8] * sin(v);
     }},
    {"MGH09",
     [](const Jet* b, const Real* x) {
       return b[0] * (x[0] * x[0] + x[0] * b[1]) / (x[0] * x[0] + x[0] * b[2] + b[3]);
     }},
    {"Thurber",
     [](const Jet* b, const Real* x) {
       return polynomial(b, 4, x[0]) / (1.0L + x[0] * polynomial(b + 4, 3, x[0]));
     }},
    {"BoxBOD", [](const Jet* b, const Real* x) { return b[0] * (1.0L - exp(-b[1] * x[0])); }},
    {"Rat42",
     [](const Jet* b, const Real* x) { return b[0] / (1.0L + exp(b[1] - b[2] * x[0])); }},
    {"MGH10", [](const Jet* b, const Real* x) { return b[0] * exp(b[1] / (x[0] + b[2])); }},
    {"Eckerle4",
     [](const Jet* b, const Real* x) {
       const Jet u = (x[0] - b[2]) / b[1];
       return b[0] / b[1] * exp(-0.5L * u * u);
     }},
    {"Rat43",
     [](const Jet* b, const Real* x) {
       return b[0] / pow(1.0L + exp(b[1] - b[2] * x[0]), 1.0L / b[3]);
     }},
    {"Bennett5",
     [](const Jet* b, const Real* x) { return b[0] * pow(b[1] + x[0], -1.0L / b[2]); }},
};

struct Certified {
  VectorXd start[2];
  VectorXd b, sd;
  double rss = 0.0;
  std::vector<Real> y;
  std::vector<std::array<Real, 2>> x;
};

Certified read(const Set& set) {
  const std::string path = test_paths::test_data() + "/nist_strd/" + set.name + ".dat";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<std::array<double, 4>> parameters;
  Certified result;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (number > 40 && number <= 60) {
      const auto equals = line.find('=');
      const auto rss = line.find("Residual Sum of Squares:");
      if (rss != std::string::npos) {
        result.rss = std::stod(line.substr(rss + 24));
      } else if (equals != std::string::npos && line.find('b') < equals) {
        std::istringstream row(line.substr(equals + 1));
        std::array<double, 4> values{};
        for (double& value : values) row >> value;
        if (row) parameters.push_back(values);
      }
    } else if (number > 60) {
      std::istringstream row(line);
      Real y = 0.0L;
      std::array<Real, 2> x{};
      if (!(row >> y >> x[0])) continue;
      if (set.predictors == 2) row >> x[1];
      result.y.push_back(set.log_response ? std::log(y) : y);
      result.x.push_back(x);
    }
  }
  const auto n = static_cast<Eigen::Index>(parameters.size());
  for (VectorXd* each : {&result.start[0], &result.start[1], &result.b, &result.sd}) {
    each->resize(n);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& row = parameters[static_cast<std::size_t>(i)];
    result.start[0][i] = row[0];
    result.start[1][i] = row[1];
    result.b[i] = row[2];
    result.sd[i] = row[3];
  }
  return result;
}

LeastSquaresFit solve(
    const Set& set, const Certified& data, const VectorXd& start, double first_damping) {
  LeastSquaresProblem problem;
  problem.parameters = static_cast<int>(start.size());
  problem.residuals = static_cast<int>(data.y.size());
  problem.evaluate = [&](const VectorXd& b, VectorXd& r, MatrixXd* J) {
    std::vector<Jet> jets;
    for (int i = 0; i < b.size(); ++i) jets.emplace_back(static_cast<Real>(b[i]), i);
    for (std::size_t k = 0; k < data.y.size(); ++k) {
      const Jet value = set.model(jets.data(), data.x[k].data());
      const auto row = static_cast<Eigen::Index>(k);
      r[row] = static_cast<double>(value.a - data.y[k]);
      if (J != nullptr) J->row(row) = value.v.head(b.size()).transpose().cast<double>();
    }
    return r.allFinite();
  };
  LeastSquaresSettings settings;
  settings.max_iterations = 5000;
  settings.first_damping = first_damping;
  settings.hold_relative = 1e-15;
  return solve_least_squares(problem, start, settings);
}

/// Agreeing digits of the worst entry, 11 at most (as many as are certified).
double digits(const VectorXd& found, const VectorXd& certified) {
  const double worst = (found - certified).cwiseQuotient(certified).cwiseAbs().maxCoeff();
  return std::isfinite(worst) ? std::min(-std::log10(std::max(worst, 1e-300)), 11.0) : 0.0;
}

class NistStrd : public ::testing::TestWithParam<Set> {};

TEST_P(NistStrd, GivesTheCertifiedParametersAndDeviationsFromBothStarts) {
  const Set& set = GetParam();
  const Certified data = read(set);
  ASSERT_GT(data.b.size(), 1);
  ASSERT_GT(data.y.size(), static_cast<std::size_t>(data.b.size()));
  for (int k = 0; k < 2; ++k) {
    // MGH10's first start lies at the end of a valley so long and bent that only steps of
    // nearly full Gauss-Newton length leave it.
    const bool long_valley = std::string_view(set.name) == "MGH10" && k == 0;
    const auto fit = solve(set, data, data.start[k], long_valley ? 1e-12 : 1e-3);
    const VectorXd sd = (fit.variance() * fit.unit_covariance().diagonal()).cwiseSqrt();
    const double parameter_digits = digits(fit.x, data.b);
    const double deviation_digits = digits(sd, data.sd);
    std::printf(
        "%-9s start %d: %4.1f digits of the parameters, %4.1f of their deviations, %d "
        "iterations\n",
        set.name, k + 1, parameter_digits, deviation_digits, fit.iterations);
    EXPECT_GE(parameter_digits, kParameterDigits) << "start " << k + 1;
    EXPECT_GE(deviation_digits, kDeviationDigits) << "start " << k + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(, NistStrd, ::testing::ValuesIn(kSets), [](const auto& each) {
  return std::string{each.param.name};
});

TEST(NistStrdSets, AreAll27) { EXPECT_EQ(std::size(kSets), 27U); }

}  // namespace
}  // namespace sixdial::calibration
