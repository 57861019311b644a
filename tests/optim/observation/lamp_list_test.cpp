#include "optim/observation/lamp_list.h"

#include <string>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/optim/observation/observation_files.h"

namespace pathfit::optim::lamp_list_test {
namespace {

using renderer::Rgb;
using renderer::Vec3;

LampList Read(const std::string& text) {
  const TempFolder folder;
  return ReadLampList(folder.WriteText("lamps.txt", text));
}

std::string Refusal(const std::string& text) {
  try {
    static_cast<void>(Read(text));
  } catch (const renderer::IoError& error) {
    return error.what();
  }
  return "";
}

void ExpectNear(const Vec3& a, const Vec3& b) {
  EXPECT_NEAR(a.x, b.x, 1e-12);
  EXPECT_NEAR(a.y, b.y, 1e-12);
  EXPECT_NEAR(a.z, b.z, 1e-12);
}

TEST(LampList, RowsOfDirections) {
  const LampList list = Read("# x y z\n0.6 0 0.8\n\n0, -0.6, 0.8\n 0 0 2\r\n");
  ASSERT_EQ(list.lamps.size(), 3U);
  ExpectNear(list.lamps[0].towards, {0.6, 0.0, 0.8});
  ExpectNear(list.lamps[1].towards, {0.0, -0.6, 0.8});
  ExpectNear(list.lamps[2].towards, {0.0, 0.0, 1.0});
  EXPECT_FALSE(list.lamps[0].strength);
  EXPECT_TRUE(list.lamps[0].photo.empty());
  EXPECT_FALSE(list.reversed);
}

TEST(LampList, LpFile) {
  const LampList list = Read("2\nphotos/my dome 01.jpg 0.6 0.0 0.8\nphotos/my dome 02.jpg 0 1 1\n");
  ASSERT_EQ(list.lamps.size(), 2U);
  EXPECT_EQ(list.lamps[0].photo, "photos/my dome 01.jpg");
  EXPECT_EQ(list.lamps[1].photo, "photos/my dome 02.jpg");
  ExpectNear(list.lamps[0].towards, {0.6, 0.0, 0.8});
  EXPECT_NE(Refusal("3\na.jpg 0 0 1\nb.jpg 0 0 1\n").find("has 2"), std::string::npos);
}

TEST(LampList, ColumnsAreLamps) {
  const LampList list = Read("0.6 0 -0.6 0\n0 0.6 0 -0.6\n0.8 0.8 0.8 0.8\n");
  ASSERT_EQ(list.lamps.size(), 4U);
  ExpectNear(list.lamps[2].towards, {-0.6, 0.0, 0.8});
  EXPECT_FALSE(list.lamps[2].strength);
}

TEST(LampList, NumbersNamesAndStrengths) {
  const LampList numbered = Read("1 0.6 0 0.8 0.5\n2 0 0.6 0.8 2\n3 0 0 1 1\n");
  ASSERT_EQ(numbered.lamps.size(), 3U);
  ExpectNear(numbered.lamps[1].towards, {0.0, 0.6, 0.8});
  ASSERT_TRUE(numbered.lamps[1].strength);
  EXPECT_EQ(numbered.lamps[1].strength->g, 2.0);

  const LampList colored = Read("a.png 0 0 1 1 2 3\nb.png 0 1 1 3 2 1\n");
  ASSERT_EQ(colored.lamps.size(), 2U);
  EXPECT_EQ(colored.lamps[0].photo, "a.png");
  ASSERT_TRUE(colored.lamps[1].strength);
  EXPECT_EQ(colored.lamps[1].strength->r, 3.0);
  EXPECT_EQ(colored.num_unused, 0U);

  EXPECT_EQ(Read("0 0 1 1 0.3\n0 1 1 2 0.4\n").num_unused, 1U);
}

TEST(LampList, NumbersMayHaveGapsAndNamesMayEndWithOne) {
  const LampList gaps = Read("2 0.6 0 0.8\n3 0 0.6 0.8\n7 0 0 1\n");
  ASSERT_EQ(gaps.lamps.size(), 3U);
  ExpectNear(gaps.lamps[0].towards, {0.6, 0.0, 0.8});
  EXPECT_FALSE(gaps.lamps[0].strength);
  const LampList named = Read(
      "\xEF\xBB\xBF"
      "2\nIMG 08 0.6 0 0.8\nIMG 09\t0 0 1 \n");
  ASSERT_EQ(named.lamps.size(), 2U);
  EXPECT_EQ(named.lamps[0].photo, "IMG 08");
  EXPECT_EQ(named.lamps[1].photo, "IMG 09");
  ExpectNear(named.lamps[0].towards, {0.6, 0.0, 0.8});
}

TEST(LampList, WhereTheLightGoes) {
  const LampList list = Read("0.6 0 -0.8\n0 0.6 -0.8\n");
  EXPECT_TRUE(list.reversed);
  ExpectNear(list.lamps[0].towards, {-0.6, 0.0, 0.8});
}

TEST(LampList, StrengthsOfAnotherFile) {
  const TempFolder folder;
  LampList list = ReadLampList(folder.WriteText("light_directions.txt", "0 0 1\n0 1 1\n"));
  ReadLampStrengths(folder.WriteText("a.txt", "1 2 3\n4 5 6\n"), list);
  ASSERT_TRUE(list.lamps[1].strength);
  EXPECT_EQ(list.lamps[1].strength->b, 6.0);
  ReadLampStrengths(folder.WriteText("b.txt", "2\n3\n"), list);
  EXPECT_EQ(list.lamps[0].strength->r, 2.0);
  EXPECT_EQ(list.lamps[0].strength->b, 2.0);
  EXPECT_THROW(ReadLampStrengths(folder.WriteText("c.txt", "2\n"), list), renderer::IoError);
  EXPECT_THROW(ReadLampStrengths(folder.WriteText("d.txt", "2\n0\n"), list), renderer::IoError);
  EXPECT_THROW(ReadLampStrengths(folder.WriteText("e.txt", "2\n1 2\n"), list), renderer::IoError);
}

TEST(LampList, RefusesWithPlace) {
  EXPECT_NE(Refusal("0 0 1\n0 0\n").find("lamps.txt:2"), std::string::npos);
  EXPECT_NE(Refusal("0 0 1\n0 0 0\n").find("must not be 0 0 0"), std::string::npos);
  EXPECT_NE(Refusal("0 0 1 1\n0 1 1 -1\n").find("above 0"), std::string::npos);
  EXPECT_NE(Refusal("0 0 1\nlamp one\n").find("lamps.txt:2"), std::string::npos);
  EXPECT_NE(Refusal("\n# nothing\n").find("holds no lamp"), std::string::npos);
}

}  // namespace
}  // namespace pathfit::optim::lamp_list_test
