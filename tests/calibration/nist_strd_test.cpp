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
#include <vector>

#include "calibration/least_squares.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Jet = ceres::Jet<double, 9>;

// Issue 3: certified parameters to 6 digits, standard deviations to 4.
constexpr double kParameterDigits = 6.0;
constexpr double kDeviationDigits = 4.0;

using Model = Jet (*)(const Jet* b, const double* x);

Jet polynomial(const Jet* b, int count, double x) {
  Jet sum(0.0);
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
    {"Misra1a", [](const Jet* b, const double* x) { return b[0] * (1.0 - exp(-b[1] * x[0])); }},
    {"Chwirut2",
     [](const Jet* b, const double* x) { return exp(-b[0] * x[0]) / (b[1] + b[2] * x[0]); }},
    {"Chwirut1",
     [](const Jet* b, const double* x) { return exp(-b[0] * x[0]) / (b[1] + b[2] * x[0]); }},
    {"Lanczos3",
     [](const Jet* b, const double* x) {
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-b[3] * x[0]) + b[4] * exp(-b[5] * x[0]);
     }},
    {"Gauss1",
     [](const Jet* b, const double* x) {
       const Jet u = (x[0] - b[3]) / b[4];
       const Jet v = (x[0] - b[6]) / b[7];
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-u * u) + b[5] * exp(-v * v);
     }},
    {"Gauss2",
     [](const Jet* b, const double* x) {
       const Jet u = (x[0] - b[3]) / b[4];
       const Jet v = (x[0] - b[6]) / b[7];
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-u * u) + b[5] * exp(-v * v);
     }},
    {"DanWood", [](const Jet* b, const double* x) { return b[0] * pow(Jet(x[0]), b[1]); }},
    {"Misra1b",
     [](const Jet* b, const double* x) {
       const Jet u = 1.0 + b[1] * x[0] / 2.0;
       return b[0] * (1.0 - 1.0 / (u * u));
     }},
    {"Kirby2",
     [](const Jet* b, const double* x) {
       return polynomial(b, 3, x[0]) / (1.0 + x[0] * polynomial(b + 3, 2, x[0]));
     }},
    {"Hahn1",
     [](const Jet* b, const double* x) {
       return polynomial(b, 4, x[0]) / (1.0 + x[0] * polynomial(b + 4, 3, x[0]));
     }},
    {"Nelson",
     [](const Jet* b, const double* x) { return b[0] - b[1] * x[0] * exp(-b[2] * x[1]); }, 2,
     true},
    {"MGH17",
     [](const Jet* b, const double* x) {
       return b[0] + b[1] * exp(-x[0] * b[3]) + b[2] * exp(-x[0] * b[4]);
     }},
    {"Lanczos1",
     [](const Jet* b, const double* x) {
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-b[3] * x[0]) + b[4] * exp(-b[5] * x[0]);
     }},
    {"Lanczos2",
     [](const Jet* b, const double* x) {
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-b[3] * x[0]) + b[4] * exp(-b[5] * x[0]);
     }},
    {"Gauss3",
     [](const Jet* b, const double* x) {
       const Jet u = (x[0] - b[3]) / b[4];
       const Jet v = (x[0] - b[6]) / b[7];
       return b[0] * exp(-b[1] * x[0]) + b[2] * exp(-u * u) + b[5] * exp(-v * v);
     }},
    {"Misra1c",
     [](const Jet* b, const double* x) {
       return b[0] * (1.0 - 1.0 / sqrt(1.0 + 2.0 * b[1] * x[0]));
     }},
    {"Misra1d",
     [](const Jet* b, const double* x) { return b[0] * b[1] * x[0] / (1.0 + b[1] * x[0]); }},
    {"Roszman1",
     [](const Jet* b, const double* x) {
       return b[0] - b[1] * x[0] - atan2(b[2], x[0] - b[3]) / std::numbers::pi;
     }},
    {"ENSO",
     [](const Jet* b, const double* x) {
       const double year = 2 * std::numbers::pi * x[0] / 12;
       const Jet u = 2 * std::numbers::pi * x[0] / b[3];
       const Jet v = 2 * std::numbers::pi * x[0] / b[6];
       return b[0] + b[1] * std::cos(year) + b[2] * std::sin(year) + b[4] * cos(u) +
              b[5] * sin(u) + b[7] * cos(v) + b[8] * sin(v);
     }},
    {"MGH09",
     [](const Jet* b, const double* x) {
       return b[0] * (x[0] * x[0] + x[0] * b[1]) / (x[0] * x[0] + x[0] * b[2] + b[3]);
     }},
    {"Thurber",
     [](const Jet* b, const double* x) {
       return polynomial(b, 4, x[0]) / (1.0 + x[0] * polynomial(b + 4, 3, x[0]));
     }},
    {"BoxBOD", [](const Jet* b, const double* x) { return b[0] * (1.0 - exp(-b[1] * x[0])); }},
    {"Rat42",
     [](const Jet* b, const double* x) { return b[0] / (1.0 + exp(b[1] - b[2] * x[0])); }},
    {"MGH10", [](const Jet* b, const double* x) { return b[0] * exp(b[1] / (x[0] + b[2])); }},
    {"Eckerle4",
     [](const Jet* b, const double* x) {
       const Jet u = (x[0] - b[2]) / b[1];
       return b[0] / b[1] * exp(-0.5 * u * u);
     }},
    {"Rat43",
     [](const Jet* b, const double* x) {
       return b[0] / pow(1.0 + exp(b[1] - b[2] * x[0]), 1.0 / b[3]);
     }},
    {"Bennett5",
     [](const Jet* b, const double* x) { return b[0] * pow(b[1] + x[0], -1.0 / b[2]); }},
};

struct Certified {
  VectorXd start[2];
  VectorXd b, sd;
  double rss = 0.0;
  std::vector<double> y;
  std::vector<std::array<double, 2>> x;
};

Certified read(const Set& set) {
  const std::string path = std::string(SIXDIAL_TEST_DATA) + "/nist_strd/" + set.name + ".dat";
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
      double y = 0.0;
      std::array<double, 2> x{};
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

LeastSquaresFit solve(const Set& set, const Certified& data, const VectorXd& start) {
  LeastSquaresProblem problem;
  problem.parameters = static_cast<int>(start.size());
  problem.residuals = static_cast<int>(data.y.size());
  problem.evaluate = [&](const VectorXd& b, VectorXd& r, MatrixXd* J) {
    std::vector<Jet> jets;
    for (int i = 0; i < b.size(); ++i) jets.emplace_back(b[i], i);
    for (std::size_t k = 0; k < data.y.size(); ++k) {
      const Jet value = set.model(jets.data(), data.x[k].data());
      const auto row = static_cast<Eigen::Index>(k);
      r[row] = value.a - data.y[k];
      if (J != nullptr) J->row(row) = value.v.head(b.size()).transpose();
    }
    return r.allFinite();
  };
  LeastSquaresSettings settings;
  settings.max_iterations = 5000;
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
    const auto fit = solve(set, data, data.start[k]);
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
