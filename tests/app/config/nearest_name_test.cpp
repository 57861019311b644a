#include "app/config/nearest_name.h"

#include <string>

#include <gtest/gtest.h>

namespace pathfit::app::nearest_name_test {
namespace {

TEST(NearestName, FindsWhatWasMeant) {
  const std::vector<std::string> names = {"roughness", "metallic", "base_color", "spp", "sppe"};
  EXPECT_EQ(NearestName("roughnes", names), "roughness");
  EXPECT_EQ(NearestName("metalic", names), "metallic");
  EXPECT_EQ(NearestName("base_colour", names), "base_color");
  EXPECT_EQ(NearestName("sp", names), "spp");
  EXPECT_EQ(NearestName("psp", names), "spp");
  EXPECT_EQ(NearestName("rough", names), "roughness");
}

TEST(NearestName, SaysNothingWhenNothingIsNear) {
  EXPECT_EQ(NearestName("zzz", {"roughness", "ab"}), "");
  EXPECT_EQ(NearestName("", {"a"}), "");
  EXPECT_EQ(NearestName(std::string(5000, 'x'), {std::string(5000, 'x')}), "");
  EXPECT_EQ(NearestName("x", {}), "");
}

TEST(NearestName, HintsNameTheNearestOrAll) {
  EXPECT_EQ(NameHint("fti", {"fit", "check"}), " (did you mean 'fit'?)");
  EXPECT_EQ(NameHint("zzz", {"fit", "check"}), " (known: fit, check)");
  EXPECT_EQ(NameHint("zzz", {}), "");
  EXPECT_EQ(JoinNames({"a", "b", "c"}, 2), "a, b, …");
}

}  // namespace
}  // namespace pathfit::app::nearest_name_test
