#include "app/output/config_json.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <regex.h>
#include <unistd.h>

#include "app/config/config_error.h"
#include "app/config/experiment_config.h"
#include "app/config/yaml_document.h"

namespace pathfit::app::config_json_test {
namespace {

namespace fs = std::filesystem;

/// POSIX's extended expressions: GCC 12 warns inside <regex> under the address sanitizer.
bool Matches(const std::string& pattern, const std::string& text) {
  regex_t expression;
  if (regcomp(&expression, pattern.c_str(), REG_EXTENDED | REG_NOSUB) != 0) {
    ADD_FAILURE() << pattern;
    return false;
  }
  const bool found = regexec(&expression, text.c_str(), 0, nullptr, 0) == 0;
  regfree(&expression);
  return found;
}

bool IsValid(const Json& schema, const Json& value);

bool HasType(const Json& value, const std::string& type) {
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "boolean") return value.is_boolean();
  if (type == "string") return value.is_string();
  return type == "array" ? value.is_array() : type == "object" && value.is_object();
}

bool HasAll(const Json& names, const Json& object) {
  return std::all_of(names.begin(), names.end(), [&](const Json& name) {
    return object.contains(name.get<std::string>());
  });
}

bool IsValidObject(const Json& schema, const Json& object) {
  const Json none = Json::object();
  const Json& properties = schema.contains("properties") ? schema["properties"] : none;
  for (const auto& [key, value] : object.items()) {
    if (properties.contains(key)) {
      if (!IsValid(properties[key], value)) return false;
    } else if (schema.contains("additionalProperties") &&
               !IsValid(schema["additionalProperties"], value)) {
      return false;
    }
    if (schema.contains("propertyNames") && !IsValid(schema["propertyNames"], key)) return false;
    if (schema.contains("dependentRequired") && schema["dependentRequired"].contains(key) &&
        !HasAll(schema["dependentRequired"][key], object)) {
      return false;
    }
  }
  return !schema.contains("required") || HasAll(schema["required"], object);
}

bool InBounds(const Json& schema, double value) {
  return !(value < schema.value("minimum", -INFINITY)) &&
         !(value <= schema.value("exclusiveMinimum", -INFINITY)) &&
         !(value > schema.value("maximum", INFINITY)) &&
         !(value >= schema.value("exclusiveMaximum", INFINITY));
}

/// The keywords of draft 2020-12 that the schema uses; another one is a failure.
bool IsValid(const Json& schema, const Json& value) {
  if (schema.is_boolean()) return schema.get<bool>();
  const std::string known =
      " $schema title description default type properties additionalProperties required enum "
      "minimum maximum exclusiveMinimum exclusiveMaximum minLength pattern items minItems maxItems "
      "uniqueItems minProperties propertyNames dependentRequired anyOf allOf not if then ";
  for (const auto& [keyword, unused] : schema.items()) {
    EXPECT_NE(known.find(" " + keyword + " "), std::string::npos) << keyword;
  }
  const auto fits = [&](const Json& one) { return IsValid(one, value); };
  if (schema.contains("type")) {
    const Json& type = schema["type"];
    const Json types = type.is_array() ? type : Json::array({type});
    if (std::none_of(types.begin(), types.end(), [&](const Json& t) {
          return HasType(value, t.get<std::string>());
        })) {
      return false;
    }
  }
  if (schema.contains("enum") &&
      std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end()) {
    return false;
  }
  if (schema.contains("anyOf") &&
      std::none_of(schema["anyOf"].begin(), schema["anyOf"].end(), fits)) {
    return false;
  }
  if (schema.contains("allOf") &&
      !std::all_of(schema["allOf"].begin(), schema["allOf"].end(), fits)) {
    return false;
  }
  if (schema.contains("not") && fits(schema["not"])) return false;
  if (schema.contains("if") && fits(schema["if"]) && !fits(schema["then"])) return false;
  if (value.is_number() && !InBounds(schema, value.get<double>())) return false;
  if (value.is_string()) {
    const auto text = value.get<std::string>();
    if (text.size() < schema.value("minLength", std::size_t{0})) return false;
    if (schema.contains("pattern") && !Matches(schema["pattern"].get<std::string>(), text)) {
      return false;
    }
  }
  if (value.is_array()) {
    if (value.size() < schema.value("minItems", std::size_t{0})) return false;
    if (value.size() > schema.value("maxItems", value.size())) return false;
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (schema.contains("items") && !IsValid(schema["items"], value[i])) return false;
      if (!schema.value("uniqueItems", false)) continue;
      if (std::count(value.begin(), value.end(), value[i]) > 1) return false;
    }
  }
  return !value.is_object() || (value.size() >= schema.value("minProperties", std::size_t{0}) &&
                                IsValidObject(schema, value));
}

Json FromYaml(const std::string& text) { return PlainJson(ParseYaml(text, "test.yaml").root); }

const char* const kScene =
    "schema: 1\n"
    "scene:\n"
    "  geometry: {ball: {primitive: {sphere: {}}, material: grey}}\n"
    "  materials: {grey: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}}\n"
    "  lights: {lamp: {type: point, position_m: [0, 3, 0]}}\n"
    "  sensors: {eye: {type: perspective, size_px: [4, 4], focal_px: 4, pose: {look_at: {origin_m: "
    "[0, 0, 4], target_m: [0, 0, 0]}}}}\n"
    "render: {spp: 16}\n";

std::string Changed(const std::string& from, const std::string& to) {
  std::string text = kScene;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ConfigJsonSchema, AcceptsEveryConfigOfTheRepository) {
  const Json schema = ConfigJsonSchema(ConfigSchema());
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  const fs::path root = PATHFIT_SOURCE_DIR;
  int count = 0;
  for (const fs::path& folder :
       {root / "configs", root / "tests" / "scenes", root / "tests/bench"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".yaml") continue;
      ++count;
      EXPECT_TRUE(IsValid(schema, PlainJson(LoadYamlFile(entry.path()).root))) << entry.path();
      const ExperimentConfig config = LoadExperimentConfig(entry.path(), {});
      EXPECT_TRUE(IsValid(schema, PlainJson(config.resolved))) << entry.path();
    }
  }
  EXPECT_GT(count, 20);
}

TEST(ConfigJsonSchema, RefusesWhatTheProgramRefuses) {
  const Json schema = ConfigJsonSchema(ConfigSchema());
  EXPECT_TRUE(IsValid(schema, FromYaml(kScene)));
  const fs::path path =
      fs::temp_directory_path() / ("pathfit_schema_" + std::to_string(getpid()) + ".yaml");
  std::ofstream(path) << kScene;
  EXPECT_NO_THROW(LoadExperimentConfig(path, {}));
  const std::pair<const char*, const char*> wrong[] = {
      {"spp: 16", "sppp: 16"},                                      // unknown key
      {"spp: 16", "spp: many"},                                     // wrong type
      {"spp: 16", "spp: 0"},                                        // out of range
      {"spp: 16", "terms: [interior, shadow]"},                     // no such word
      {"spp: 16", "terms: [interior, interior]"},                   // twice
      {"schema: 1", "schema: 2"},                                   //
      {"schema: 1\n", ""},                                          // required
      {", material: grey", ", material: a b"},                      // no name
      {"model: diffuse", "model: diffuse, ior: 1.3"},               // of another model
      {", base_color: {constant: [0.5, 0.5, 0.5]}", ""},            // required for this model
      {"[0.5, 0.5, 0.5]", "[0.5, 0.5]"},                            // too short
      {"{sphere: {}}", "{sphere: {}, cube: {}}"},                   // one of two
      {"primitive: {sphere: {}}, ", ""},                            // one of them is needed
      {"type: point", "type: spot"},                                // which needs outer_deg
      {"type: point, position_m: [0, 3, 0]", "type: directional"},  // which needs direction
      {"material: grey", "material: grey, camera_height_px: 64"},   // only with file
  };
  for (const auto& [from, to] : wrong) {
    const std::string text = Changed(from, to);
    EXPECT_FALSE(IsValid(schema, FromYaml(text))) << from << " -> " << to;
    std::ofstream(path) << text;
    EXPECT_THROW(LoadExperimentConfig(path, {}), ConfigError) << from << " -> " << to;
  }
  fs::remove(path);
}

TEST(ConfigJson, PlainScalarsReadAsTheProgramReadsThem) {
  const Json json =
      FromYaml("{a: 1, b: 1e-3, c: true, d: '1', e: yes, f: .inf, g: [x, 2], h: 012}");
  EXPECT_EQ(json["a"], 1);
  EXPECT_EQ(json["b"], 1e-3);
  EXPECT_EQ(json["c"], true);
  EXPECT_EQ(json["d"], "1");
  EXPECT_EQ(json["e"], "yes");
  EXPECT_EQ(json["f"], "inf") << "JSON has no infinity";
  EXPECT_EQ(json["g"], Json::array({"x", 2}));
  EXPECT_EQ(json["h"], "012");
}

TEST(ConfigJson, OriginsNameFileLineOverrideAndDefault) {
  const fs::path path = fs::path(PATHFIT_SOURCE_DIR) / "configs" / "axe_demo.yaml";
  const ExperimentConfig config = LoadExperimentConfig(path, {{"--set #1", "render.spp=9"}});
  const Json origins = OriginsJson(config.resolved, config.source);
  EXPECT_EQ(origins["render.spp"], "--set #1");
  EXPECT_EQ(origins["render.rr_depth"], "default");
  EXPECT_NE(origins["seed"].get<std::string>().find("axe_demo.yaml:4:"), std::string::npos);
  EXPECT_TRUE(origins.contains("stages[0].name")) << origins;
}

}  // namespace
}  // namespace pathfit::app::config_json_test
