#include "app/config/experiment_config.h"

#include <charconv>
#include <utility>

#include "app/config/apply_schema.h"
#include "app/config/overrides.h"
#include "app/config/read_config.h"
#include "app/config/resolved_yaml.h"
#include "app/config/schema.h"
#include "app/config/yaml_document.h"

namespace pathfit::app {
namespace {

// With '_' for what a name may not hold.
std::string NameFrom(std::string text) {
  for (char& c : text) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '-') c = '_';
  }
  return text.empty() ? "run" : text;
}

void ReadIdentity(const std::filesystem::path& path, ConfigReading& reading) {
  if (reading.root.Find("name") == nullptr) {
    YamlNode name = DefaultValue("\"" + NameFrom(path.stem().string()) + "\"");
    reading.root.entries.push_back({"name", Place{}, std::move(name)});
  }
  reading.config.name = reading.root.Find("name")->text;
  if (const YamlNode* seed = reading.root.Find("seed")) {
    const std::string& text = seed->text;
    const char* first = text.data() + (text[0] == '+' ? 1 : 0);
    std::from_chars(first, text.data() + text.size(), reading.config.seed);
  }
}

// Keys in the order of the schema, wherever they came from.
void SortLikeSchema(const SchemaNode& schema, YamlNode& root) {
  std::vector<YamlEntry> sorted;
  for (const SchemaNode& child : schema.children) {
    for (YamlEntry& entry : root.entries) {
      if (entry.key == child.key) sorted.push_back(std::move(entry));
    }
  }
  root.entries = std::move(sorted);
}

}  // namespace

std::string GroupMeshName(const std::string& geometry, const std::string& usemtl) {
  return geometry + "-" + NameFrom(usemtl);
}

ExperimentConfig LoadExperimentConfig(const std::filesystem::path& path,
                                      const std::vector<ConfigOverride>& overrides) {
  YamlDocument document = LoadYamlFile(path);
  document.source.overrides = overrides;
  ConfigReading reading;
  reading.problems = std::move(document.problems);
  reading.root = std::move(document.root);
  reading.config.path = std::filesystem::absolute(path).lexically_normal();

  const SchemaNode& schema = ConfigSchema();
  ApplyOverrides(schema, overrides, reading.root, reading.problems);
  reading.has_input = reading.root.Find("input") != nullptr;
  ApplySchema(schema, reading.config.path.parent_path(), reading.root, reading.problems);
  ReadIdentity(path, reading);
  ReadInput(reading);
  ReadScene(reading);
  ReadSensors(reading);
  ReadUnknowns(reading);
  ReadStages(reading);
  ReadSettings(reading);
  if (!reading.problems.empty()) throw ConfigError(document.source, reading.problems);

  SortLikeSchema(schema, reading.root);
  reading.config.given_text = std::move(document.text);
  reading.config.resolved_yaml = WriteResolvedYaml(reading.root, document.source);
  reading.config.source = std::move(document.source);
  return std::move(reading.config);
}

}  // namespace pathfit::app
