#include "renderer/bsdf/metals.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "renderer/bsdf/fresnel_kernel.h"

namespace pathfit::renderer::metals_test {
namespace {

double Reflectance(std::string_view name, int channel) {
  const auto metal = NamedMetal(name);
  return metal ? FresnelConductor(1.0, metal->eta[channel], metal->k[channel]) : -1.0;
}

TEST(Metals, EveryListedNameIsKnownAndReflects) {
  EXPECT_TRUE(std::ranges::is_sorted(NamedMetals(), {}, &Metal::name));
  for (const auto& [name, eta, k] : NamedMetals()) {
    ASSERT_TRUE(NamedMetal(name)) << name;
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(Reflectance(name, c), 0.35) << name;
      EXPECT_LT(Reflectance(name, c), 0.995) << name;
    }
  }
  EXPECT_FALSE(NamedMetal("unobtainium"));
  EXPECT_FALSE(NamedMetal(""));
}

/// Reflectances of metals in handbooks, to the spread between handbooks.
TEST(Metals, HaveTheirKnownColours) {
  const auto expect = [](std::string_view name, double r, double g, double b) {
    EXPECT_NEAR(Reflectance(name, 0), r, 0.03) << name;
    EXPECT_NEAR(Reflectance(name, 1), g, 0.03) << name;
    EXPECT_NEAR(Reflectance(name, 2), b, 0.03) << name;
  };
  expect("gold", 0.94, 0.79, 0.40);
  expect("silver", 0.985, 0.98, 0.975);
  expect("copper", 0.92, 0.62, 0.54);
  expect("aluminium", 0.91, 0.92, 0.925);
  expect("chromium", 0.55, 0.55, 0.55);
  expect("nickel", 0.65, 0.61, 0.53);
  expect("titanium", 0.63, 0.59, 0.54);
  expect("platinum", 0.69, 0.66, 0.60);
  expect("tungsten", 0.56, 0.49, 0.45);
}

}  // namespace
}  // namespace pathfit::renderer::metals_test
