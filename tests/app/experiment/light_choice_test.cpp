#include "app/experiment/light_choice.h"

#include <gtest/gtest.h>

namespace pathfit::app::light_choice_test {
namespace {

TEST(LightChoice, SignsComeFromABackgroundWithSomethingInIt) {
  FoundInput input;
  input.observations.views.resize(3);
  input.background = Background{.change = 0.02, .structure = 0.05};
  ASSERT_TRUE(LightBySigns(input));
  EXPECT_EQ(LightBySigns(input)->light, DraftLight::kCamera);
  input.background->structure = 0.02;
  EXPECT_FALSE(LightBySigns(input));
  EXPECT_EQ(UsualLight(input).light, DraftLight::kCamera);
  input.background->change = 0.5;
  EXPECT_FALSE(LightBySigns(input));
  EXPECT_EQ(UsualLight(input).light, DraftLight::kWorld);
  input.background.reset();
  EXPECT_FALSE(LightBySigns(input));
  EXPECT_EQ(UsualLight(input).light, DraftLight::kWorld);
}

}  // namespace
}  // namespace pathfit::app::light_choice_test
