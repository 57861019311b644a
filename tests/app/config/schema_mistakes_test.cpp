// Every key of three configs that between them name nearly all: the mistakes come from the schema.
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/config/schema.h"
#include "app/config/yaml_document.h"
#include "tests/app/config/config_text.h"
#include "tests/support/sanitized.h"

namespace pathfit::app::schema_mistakes_test {
namespace {

/// A text in place of what stands in the file, and what is then refused.
struct Mistake {
  Place place;
  std::string key;  ///< for people
  std::size_t length = 0;
  std::string text;
};

class MistakeFinder {
 public:
  explicit MistakeFinder(const std::string& text) : text_(text) {
    Visit(ConfigSchema(), ParseYaml(text, "test.yaml").root, "");
  }
  [[nodiscard]] const std::vector<Mistake>& found() const { return found_; }
  [[nodiscard]] const std::set<std::string>& keys() const { return keys_; }

 private:
  [[nodiscard]] bool StandsAt(const Place& place, const std::string& text) const {
    std::size_t at = 0;
    for (int line = 1; line < place.line; ++line) at = text_.find('\n', at) + 1;
    return text_.compare(at + static_cast<std::size_t>(place.column) - 1, text.size(), text) == 0;
  }

  void Visit(const SchemaNode& schema, const YamlNode& node, const std::string& path) {
    using Type = SchemaNode::Type;
    if (schema.type == Type::kEither) {
      for (const SchemaNode& child : schema.children) {
        const bool fits = child.type == Type::kList ? node.IsList()
                          : child.type == Type::kMap || child.type == Type::kNamedMap
                              ? node.IsMap()
                              : node.IsScalar();
        if (fits) return Visit(child, node, path);
      }
    } else if (schema.type == Type::kMap && node.IsMap()) {
      for (const YamlEntry& entry : node.entries) {
        const SchemaNode* child = schema.Child(entry.key);
        if (child == nullptr) continue;
        const std::string name = path + "." + entry.key;
        keys_.insert(name);
        found_.push_back({entry.key_place, name, entry.key.size(), entry.key + "q"});
        Visit(*child, entry.value, name);
      }
    } else if (schema.type == Type::kNamedMap && node.IsMap() && !schema.children.empty()) {
      for (const YamlEntry& entry : node.entries) {
        Visit(schema.children[0], entry.value, path + ".*");
      }
    } else if (schema.type == Type::kList && node.IsList() && !schema.children.empty()) {
      for (const YamlNode& item : node.items) Visit(schema.children[0], item, path + "[]");
    } else if (node.IsScalar() && !node.quoted && StandsAt(node.place, node.text)) {
      const auto add = [&](const std::string& text) {
        found_.push_back({node.place, path, node.text.size(), text});
      };
      add("{wrong_type: 1}");
      const bool is_number = schema.type == Type::kInteger || schema.type == Type::kNumber;
      if (is_number || schema.type == Type::kBool || schema.type == Type::kChoice) add("wrong");
      if (is_number) add(".nan");
      if (schema.type == Type::kInteger) add("1.5");
      if (!schema.has_range || !is_number) return;
      if (std::isfinite(schema.range.lower)) {
        add(std::to_string(std::llround(std::floor(schema.range.lower)) - 1));
      }
      if (std::isfinite(schema.range.upper) && std::abs(schema.range.upper) < 1e9) {
        add(std::to_string(std::llround(std::ceil(schema.range.upper)) + 1));
      }
    }
  }

  const std::string& text_;
  std::vector<Mistake> found_;
  std::set<std::string> keys_;
};

std::string Replaced(const std::string& text, const Mistake& mistake) {
  std::size_t at = 0;
  for (int line = 1; line < mistake.place.line; ++line) at = text.find('\n', at) + 1;
  std::string changed = text;
  return changed.replace(
      at + static_cast<std::size_t>(mistake.place.column) - 1, mistake.length, mistake.text);
}

TEST(SchemaMistakes, EveryKeyIsRefusedWithItsPlace) {
  const ConfigFile file("");
  std::set<std::string> keys;
  std::size_t count = 0;
  for (const char* source : {kFitConfig, kSceneConfig, kRichConfig}) {
    file.Write(source);
    // The resolved copy names what has a default, too.
    const std::string text = ResolvedText(LoadExperimentConfig(file.path(), {}));
    file.Write(text);
    ASSERT_NO_THROW(static_cast<void>(LoadExperimentConfig(file.path(), {})));
    const MistakeFinder mistakes(text);
    keys.insert(mistakes.keys().begin(), mistakes.keys().end());
    for (const Mistake& mistake : mistakes.found()) {
      if (++count % 5 != 0 && tests::kSanitized) continue;
      file.Write(Replaced(text, mistake));
      std::string said = "accepted";
      try {
        static_cast<void>(LoadExperimentConfig(file.path(), {}));
      } catch (const ConfigError& error) {
        said = error.what();
      }
      const std::string place = "test.yaml:" + std::to_string(mistake.place.line) + ":" +
                                std::to_string(mistake.place.column) + ": ";
      EXPECT_NE(said.find(place), std::string::npos)
          << mistake.key << " = " << mistake.text << " at " << place << "\n"
          << said;
    }
  }
  EXPECT_GT(keys.size(), 180U);
  EXPECT_GT(count, 1500U);
}

}  // namespace
}  // namespace pathfit::app::schema_mistakes_test
