#include "app/config/schema.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/config/experiment_config.h"
#include "app/config/nearest_name.h"
#include "app/config/schema_builders.h"

namespace pathfit::app {
namespace {

SchemaNode RootSchema() {
  return Map("",
             {Version("schema", 1) | Doc("Version of this format; must be 1."),
              Name("name", &ExperimentConfig::name) | Doc("Used for the run directory.") |
                  DefaultIs("name of the file"),
              Key("seed", &ExperimentConfig::render, &renderer::RenderOptions::seed) |
                  Doc("All random numbers are derived from it.") | From(0, 9007199254740992.0),
              InputSchema(),
              Map("scene",
                  {GeometrySchema(),
                   MaterialsSchema(),
                   TexturesSchema(),
                   LightsSchema(),
                   SensorsSchema()}) |
                  Doc("The model that the fit starts from. Right-handed, y up, metres.") |
                  Required(),
              RenderSchema(),
              UnknownsSchema(),
              LossSchema(),
              GaugeSchema(),
              StagesSchema(),
              SolverSchema(),
              OutputSchema(),
              GradcheckSchema()}) |
         Refuse({{"extends", "; write the values into this file"}});
}

// "a number from 0 to 1" of a scalar node.
std::string DescribeScalar(const SchemaNode& node, const std::string& noun) {
  const std::string range = DescribeRange(node);
  std::string out = noun + (range.empty() ? "" : " " + range);
  if (!node.words.empty()) out += ", or " + JoinNames(node.words);
  return out;
}

std::string DescribeList(const SchemaNode& node) {
  const SchemaNode& item = node.children.front();
  const bool exact = node.min_items > 0 && node.min_items == node.max_items;
  const std::string count = exact ? fmt::format("{} ", node.min_items) : "";
  const std::string least =
      !exact && node.min_items > 0 ? fmt::format(" (at least {})", node.min_items) : "";
  switch (item.type) {
    case SchemaNode::Type::kNumber:
      return "a list of " + count + DescribeScalar(item, "numbers") + least;
    case SchemaNode::Type::kInteger:
      return "a list of " + count + DescribeScalar(item, "whole numbers") + least;
    case SchemaNode::Type::kList:
      return "a list of " + count + "lists" + least + ", each " + DescribeType(item);
    case SchemaNode::Type::kMap:
      return "a list of " + count + "maps" + least;
    case SchemaNode::Type::kEither:
      return "a list of " + count + "values" + least + ", each " + DescribeType(item);
    case SchemaNode::Type::kChoice:
      return "a list of " + count + "words" + least + " out of " + JoinNames(item.words);
    default:
      return "a list of " + count + "texts" + least;
  }
}

/// The value of a path of maps; null if there is none.
const YamlNode* FindPath(const YamlNode& root, const std::string& path) {
  const YamlNode* node = &root;
  for (std::size_t at = 0; at <= path.size() && node != nullptr;) {
    const std::size_t dot = std::min(path.find('.', at), path.size());
    node = node->Find(path.substr(at, dot - at));
    at = dot + 1;
  }
  return node;
}

/// Calls `visit` for each value below a node, with its line of the schema and its path.
template <class Visit>
void VisitValues(const SchemaNode& schema,
                 const YamlNode& node,
                 const std::string& path,
                 const Visit& visit) {
  visit(schema, node, path);
  if (schema.type == SchemaNode::Type::kMap || schema.type == SchemaNode::Type::kNamedMap) {
    for (const YamlEntry& entry : node.entries) {
      const SchemaNode* child = schema.type == SchemaNode::Type::kMap ? schema.Child(entry.key)
                                                                      : &schema.children.front();
      if (child != nullptr) VisitValues(*child, entry.value, JoinPath(path, entry.key), visit);
    }
  } else if (schema.type == SchemaNode::Type::kList) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      VisitValues(schema.children.front(), node.items[i], fmt::format("{}[{}]", path, i), visit);
    }
  }
}

}  // namespace

const SchemaNode& ConfigSchema() {
  static const SchemaNode schema = [] {
    SchemaNode root = RootSchema();
    CheckBindings(root, typeid(ExperimentConfig));
    CheckReferences(root);
    return root;
  }();
  return schema;
}

std::string DescribeRange(const SchemaNode& node) {
  if (!node.has_range) return {};
  const NumberRange& range = node.range;
  if (range.lower == range.upper) return fmt::format("equal to {}", range.lower);
  if (std::isinf(range.upper)) {
    return fmt::format("{} {}", range.lower_open ? "above" : "of at least", range.lower);
  }
  if (range.lower_open && range.upper_open) {
    return fmt::format("between {} and {}", range.lower, range.upper);
  }
  return fmt::format(
      "from {} to {}",
      range.lower_open ? fmt::format("above {}", range.lower) : fmt::format("{}", range.lower),
      range.upper);
}

std::string DescribeType(const SchemaNode& node) {
  switch (node.type) {
    case SchemaNode::Type::kBool:
      return "true or false";
    case SchemaNode::Type::kInteger:
      return DescribeScalar(node, "a whole number");
    case SchemaNode::Type::kNumber:
      return DescribeScalar(node, "a number");
    case SchemaNode::Type::kText:
      return "text";
    case SchemaNode::Type::kName:
      return "a name";
    case SchemaNode::Type::kChoice:
      return node.words.size() == 1 ? "'" + node.words.front() + "'"
                                    : "one of " + JoinNames(node.words);
    case SchemaNode::Type::kPath:
      return node.words.empty() ? "a path" : "a path, or " + JoinNames(node.words);
    case SchemaNode::Type::kBytes:
      return "a size such as 16 GiB" + (node.words.empty() ? "" : ", or " + JoinNames(node.words));
    case SchemaNode::Type::kList:
      return DescribeList(node);
    case SchemaNode::Type::kMap:
      return "a map";
    case SchemaNode::Type::kNamedMap:
      switch (const SchemaNode& value = node.children.front(); value.type) {
        case SchemaNode::Type::kNumber:
          return "a map of names to " + DescribeScalar(value, "numbers");
        case SchemaNode::Type::kList:
          return "a map of names, each to " + DescribeType(value);
        default:
          return "a map of names";
      }
    case SchemaNode::Type::kEither:
      break;
  }
  std::string out;
  for (const SchemaNode& form : node.children) {
    out += (out.empty() ? "" : ", or ") + DescribeType(form);
  }
  return out;
}

std::vector<std::string> UselessValues(const ExperimentConfig& config) {
  std::vector<std::string> out;
  VisitValues(ConfigSchema(),
              config.resolved,
              "",
              [&](const SchemaNode& line, const YamlNode& node, const std::string& path) {
                if (line.useless_key.empty() || node.place.source == Place::Source::kDefault ||
                    node.text == line.default_yaml) {
                  return;
                }
                const YamlNode* other = FindPath(config.resolved, line.useless_key);
                if (other == nullptr || std::ranges::find(line.useless_values, other->text) ==
                                            line.useless_values.end()) {
                  return;
                }
                out.push_back(fmt::format("{}: {} has no use with {}: {}",
                                          FormatPlace(config.source, node.place),
                                          path,
                                          line.useless_key,
                                          other->text));
              });
  return out;
}

}  // namespace pathfit::app
