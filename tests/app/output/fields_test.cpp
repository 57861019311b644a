#include "app/output/fields.h"

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

}  // namespace
}  // namespace pathfit::app::fields_test
