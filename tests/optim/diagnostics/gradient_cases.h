#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "optim/diagnostics/gradient_check.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/probe.h"

namespace pathfit::tests {

/// Terms of which a derivative consists for sure: each must be missed when it is taken away or its
/// sign is flipped.
using ExpectedTerms = std::vector<optim::Term>;

/// The bounds of an image derivative: how far from the difference, in standard errors of both, its
/// tiles may be in the root mean square, and how clear its signal must be for that to mean
/// anything.
inline constexpr double kMaxZRms = 1.3;
inline constexpr double kMinSignalToNoise = 10.0;
inline constexpr int kTile = 2;

/// Of few tiles the rms itself scatters: what right estimates exceed once in 10^4 comparisons (the
/// chi-square quantile by Wilson and Hilferty), and never less than kMaxZRms.
inline double LargestZRms(double count) {
  constexpr double kQuantile = 3.7;
  const double spread = 2.0 / (9.0 * count);
  return std::max(kMaxZRms, std::pow(1.0 - spread + kQuantile * std::sqrt(spread), 1.5));
}

inline bool Accepts(const optim::GradientComparison& c) {
  return c.z_rms < LargestZRms(static_cast<double>(c.count)) && c.z_max < c.z_limit;
}

/// Random direction in [-1,1]^n: every scalar of the layout takes part with its own weight.
inline std::vector<double> RandomDirection(const renderer::ParameterLayout& layout,
                                           std::uint64_t seed) {
  renderer::CounterRng rng(seed, renderer::RandomDomain{77}, 0, 0, 0);
  std::vector<double> direction;
  for (std::int64_t i = 0; i < layout.NumScalars(); ++i)
    direction.push_back(2.0 * rng.Next() - 1.0);
  return direction;
}

/// The result with a term times `scale`.
inline optim::GradientCheckResult Mutant(optim::GradientCheckResult result,
                                         optim::Term term,
                                         double scale) {
  for (renderer::Film& film : result.terms[static_cast<std::size_t>(term)]) {
    for (renderer::Rgba& pixel : film.pixels) pixel *= scale;
  }
  return result;
}

/// Names of the terms that are missed when they are taken away.
inline std::string NeededTerms(const optim::GradientCheckResult& result, int tile) {
  std::string names;
  for (const auto& [name, term] : renderer::kDerivativeTerms) {
    if (!result[term].empty() && !Accepts(optim::Compare(Mutant(result, term, 0.0), tile))) {
      names += std::string(" ") + name;
    }
  }
  return names;
}

/// The estimate agrees with central differences tile by tile, sharply; and every mutant (a term off
/// or with its sign flipped) is found out by the same bounds.
inline void ExpectRightDerivative(const std::string& name,
                                  const optim::GradientCheckResult& result,
                                  const ExpectedTerms& terms,
                                  int tile = kTile,
                                  double min_signal = kMinSignalToNoise) {
  const optim::GradientComparison c = optim::Compare(result, tile);
  std::printf("%-34s z_rms %5.2f  z_max %5.2f  limit %5.2f  SNR %7.1f  tiles %4lld  needs%s\n",
              name.c_str(),
              c.z_rms,
              c.z_max,
              c.z_limit,
              c.signal_to_noise,
              static_cast<long long>(c.count),
              NeededTerms(result, tile).c_str());
  std::fflush(stdout);
  EXPECT_TRUE(Accepts(c)) << name << ": z_rms " << c.z_rms << " z_max " << c.z_max << " limit "
                          << c.z_limit;
  EXPECT_GT(c.signal_to_noise, min_signal) << name;
  EXPECT_GT(c.count, 0) << name;
  for (const optim::Term term : terms) {
    for (const double mutant : {0.0, -1.0}) {
      EXPECT_FALSE(Accepts(optim::Compare(Mutant(result, term, mutant), tile)))
          << name << ": " << renderer::NameOf(term) << " times " << mutant;
    }
  }
}

/// The same with a share of all samples.
inline optim::GradientCheckOptions Share(optim::GradientCheckOptions options, double share) {
  const auto of = [share](int spp) { return static_cast<int>(spp * share); };
  options.render.spp = of(options.render.spp);
  options.difference_spp = of(options.difference_spp);
  options.render.sppe *= share;
  options.render.spp_direct *= share;
  options.render.spp_indirect *= share;
  options.render.spp_pixel *= share;
  return options;
}

/// The result against the difference of another, which must be that of the same motion.
inline optim::GradientCheckResult Against(const optim::GradientCheckResult& other,
                                          optim::GradientCheckResult result) {
  result.difference = other.difference;
  result.quantum = other.quantum;
  return result;
}

using OptionsOfForm = std::function<optim::GradientCheckOptions(renderer::DerivativeForm)>;

/// Calls expect(result, form) for both forms of a derivative. Their difference, which has no form,
/// is drawn once.
template <class Expect>
void CheckInBothForms(const renderer::Scene& scene,
                      int sensor,
                      const renderer::ParameterLayout& layout,
                      const std::vector<double>& direction,
                      const OptionsOfForm& options_of,
                      const Expect& expect) {
  std::optional<optim::GradientCheckResult> first;
  for (const auto form : {renderer::DerivativeForm::kImage, renderer::DerivativeForm::kMaterial}) {
    optim::GradientCheckOptions options = options_of(form);
    if (first) options.difference_spp = 1;
    optim::GradientCheckResult result =
        optim::CheckGradient(scene, scene.sensors[0], sensor, layout, direction, options);
    if (first) {
      expect(Against(*first, std::move(result)), form);
    } else {
      first = std::move(result);
      expect(*first, form);
    }
  }
}
inline std::string InForm(const std::string& name, renderer::DerivativeForm form) {
  return name + (form == renderer::DerivativeForm::kImage ? ", image" : ", material");
}

/// All parameters of one kind of one object in a random direction of entries up to `scale`.
struct KindMotion {
  KindMotion(const renderer::Scene& scene, renderer::ParameterKind kind, int object, double scale)
      : layout(scene),
        sensor(renderer::TraitsOf(kind).list == renderer::ObjectList::kSensors ? 0 : -1) {
    layout.Add(kind, object);
    direction = RandomDirection(layout, 5);
    for (double& d : direction) d *= scale;
  }
  renderer::ParameterLayout layout;
  int sensor;
  std::vector<double> direction;
};

/// Checks the KindMotion.
inline void CheckKind(const std::string& name,
                      const renderer::Scene& scene,
                      renderer::ParameterKind kind,
                      int object,
                      const optim::GradientCheckOptions& options,
                      double scale = 1.0,
                      ExpectedTerms terms = {},
                      int tile = kTile,
                      double min_signal = kMinSignalToNoise) {
  const KindMotion motion(scene, kind, object, scale);
  const auto result = optim::CheckGradient(
      scene, scene.sensors[0], motion.sensor, motion.layout, motion.direction, options);
  if (terms.empty()) {
    terms = {optim::Term::kInterior};
    if (kind == renderer::ParameterKind::kVertexPositions) terms.push_back(optim::Term::kPrimary);
  }
  ExpectRightDerivative(name, result, terms, tile, min_signal);
}
inline void CheckKindInBothForms(const std::string& name,
                                 const renderer::Scene& scene,
                                 renderer::ParameterKind kind,
                                 int object,
                                 const OptionsOfForm& options_of,
                                 double scale,
                                 const ExpectedTerms& terms,
                                 double min_signal = kMinSignalToNoise) {
  const KindMotion motion(scene, kind, object, scale);
  CheckInBothForms(scene,
                   motion.sensor,
                   motion.layout,
                   motion.direction,
                   options_of,
                   [&](const auto& result, renderer::DerivativeForm form) {
                     ExpectRightDerivative(InForm(name, form), result, terms, kTile, min_signal);
                   });
}

/// What does not agree, and must be known and said by name: when it agrees one day, the test is to
/// be turned round.
inline void ExpectLimit(const std::string& name,
                        const renderer::Scene& scene,
                        const renderer::ParameterLayout& layout,
                        const std::vector<double>& direction,
                        const optim::GradientCheckOptions& options) {
  const optim::GradientComparison c = optim::Compare(
      optim::CheckGradient(scene, scene.sensors[0], -1, layout, direction, options), kTile);
  std::printf("%-34s z_rms %5.2f  z_max %5.2f  limit %5.2f  SNR %7.1f  (known limit)\n",
              name.c_str(),
              c.z_rms,
              c.z_max,
              c.z_limit,
              c.signal_to_noise);
  EXPECT_FALSE(Accepts(c)) << name;
  EXPECT_FALSE(renderer::DerivativeLimits(scene, layout).empty()) << name;
}

/// Samples for a thing that moves in a small scene.
inline optim::GradientCheckOptions OptionsForMotion(renderer::DerivativeForm form,
                                                    int max_bounces) {
  optim::GradientCheckOptions options;
  options.replicates = 24;
  options.render.spp = form == renderer::DerivativeForm::kImage ? 48 : 128;
  options.difference_spp = 384;
  options.render.sppe = 24.0;
  options.render.spp_direct = 48.0;
  options.render.spp_indirect = 48.0;
  options.render.spp_pixel = 24.0;
  options.step = 2.5e-3;
  options.render.max_bounces = max_bounces;
  options.render.form = form;
  return options;
}

}  // namespace pathfit::tests
