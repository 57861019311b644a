#include "app/output/fields.h"

#include <cstdint>
#include <string>

#include <gtest/gtest.h>

namespace pathfit::app::fields_test {
namespace {

const std::string kBroken =
    "a\xff"
    "b\xc3";
const std::string kReplacement = "\xef\xbf\xbd";

TEST(JsonText, ReplacesWhatIsNoUtf8) {
  EXPECT_EQ(JsonText(Json{{"cpu", kBroken}, {kBroken, 1}}, -1),
            "{\"cpu\":\"a" + kReplacement + "b" + kReplacement + "\",\"a" + kReplacement + "b" +
                kReplacement + "\":1}");
  EXPECT_EQ(JsonText(Json("\xe2\x82\xac 5")), "\"\xe2\x82\xac 5\"") << "text stays as it is";
  EXPECT_TRUE(Json::accept(JsonText(Json(kBroken))));
}

TEST(JsonText, KeepsTheOrderOfKeysAndIndents) {
  const Json json = {{"b", {1, 2}}, {"a", nullptr}};
  EXPECT_EQ(JsonText(json), "{\n  \"b\": [\n    1,\n    2\n  ],\n  \"a\": null\n}");
  EXPECT_EQ(JsonText(json, -1), "{\"b\":[1,2],\"a\":null}");
}

TEST(FromJson, RefusesNumbersThatTheirMemberCannotHold) {
  int whole = 0;
  FromJson(Json(-7), whole);
  EXPECT_EQ(whole, -7);
  for (const char* wrong : {"1e30", "-1e30", "0.5", "2147483648", "18446744073709551615", "true"}) {
    EXPECT_THROW(FromJson(Json::parse(wrong), whole), Json::exception) << wrong;
  }
  std::uint64_t seed = 0;
  FromJson(Json::parse("18446744073709551615"), seed);
  EXPECT_EQ(seed, 18446744073709551615U);
  EXPECT_THROW(FromJson(Json(-1), seed), Json::exception);
}

}  // namespace
}  // namespace pathfit::app::fields_test
