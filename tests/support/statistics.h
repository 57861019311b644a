#pragma once

#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pathfit::tests {

struct MeanAndError {
  double mean = 0.0;
  double error = 0.0;  ///< standard error of the mean
};

inline MeanAndError EstimateMean(const std::vector<double>& samples) {
  const auto n = static_cast<double>(samples.size());
  MeanAndError out;
  for (const double x : samples) out.mean += x / n;
  double variance = 0.0;
  for (const double x : samples) variance += (x - out.mean) * (x - out.mean) / (n - 1.0);
  out.error = std::sqrt(variance / n);
  return out;
}

/// Acceptance of a known answer: |mean - exact| < 4 sigma with sigma < `share` of |exact|; where
/// the estimator has no noise, 1e-9 of the answer. `model` is the relative error that the test's
/// own model is known to have (a mesh for a sphere). All figures are printed when it fails.
inline ::testing::AssertionResult AgreesWithExact(const std::vector<double>& replicates,
                                                  double exact,
                                                  double share = 0.01,
                                                  double model = 1e-9) {
  const MeanAndError m = EstimateMean(replicates);
  std::ostringstream text;
  text.precision(9);
  text << "mean " << m.mean << " +- " << m.error << ", exact " << exact << ", z "
       << (m.mean - exact) / std::max(m.error, 1e-300) << ", sigma/|exact| "
       << m.error / std::abs(exact);
  ::testing::Test::RecordProperty("estimate", text.str());
  const bool close = std::abs(m.mean - exact) <= std::max(4.0 * m.error, model * std::abs(exact));
  const bool sharp = m.error <= share * std::abs(exact) + 1e-300;
  return (close && sharp ? ::testing::AssertionSuccess() : ::testing::AssertionFailure())
         << text.str();
}

/// Upper tail of the chi-square distribution by Wilson and Hilferty's cube-root normal
/// approximation, good to 1e-3 of itself for more than ten degrees of freedom.
inline double ChiSquareTail(double chi2, double degrees) {
  const double spread = 2.0 / (9.0 * degrees);
  const double z = (std::cbrt(chi2 / degrees) - (1.0 - spread)) / std::sqrt(spread);
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

/// Pearson's test of counts against expected counts; cells expecting fewer than five are pooled.
/// `num_tests` is the size of the suite: its common level 0.01 is shared out by Sidak's rule.
inline ::testing::AssertionResult ChiSquareAccepts(const std::vector<double>& observed,
                                                   const std::vector<double>& expected,
                                                   int num_tests) {
  double chi2 = 0.0;
  double pooled_observed = 0.0;
  double pooled_expected = 0.0;
  int cells = 0;
  const auto add = [&](double o, double e) {
    chi2 += (o - e) * (o - e) / e;
    ++cells;
  };
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (expected[i] >= 5.0) {
      add(observed[i], expected[i]);
    } else {
      pooled_observed += observed[i];
      pooled_expected += expected[i];
    }
  }
  if (pooled_expected >= 5.0) {
    add(pooled_observed, pooled_expected);
  } else if (pooled_observed > 30.0) {
    return ::testing::AssertionFailure()
           << pooled_observed << " samples where " << pooled_expected << " are expected";
  }
  const double p = ChiSquareTail(chi2, static_cast<double>(cells - 1));
  const double level = 1.0 - std::pow(0.99, 1.0 / num_tests);
  std::ostringstream text;
  text << "chi2 " << chi2 << ", cells " << cells << ", p " << p << ", level " << level;
  ::testing::Test::RecordProperty("chi2", text.str());
  return (p > level ? ::testing::AssertionSuccess() : ::testing::AssertionFailure()) << text.str();
}

}  // namespace pathfit::tests
