#include <fmt/format.h>

#include "app/config/schema.h"
#include "app/config/unknown_names.h"

namespace pathfit::app {
namespace {

using Type = SchemaNode::Type;
using Presence = SchemaNode::Presence;

std::string Joined(const std::vector<std::string>& words, const std::string& between) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : between) + word;
  return out;
}

std::string DefaultText(const SchemaNode& node) {
  if (node.presence == Presence::kRequired) return "**required**";
  if (!node.default_doc.empty()) return node.default_doc;
  if (!node.one_of.empty()) return "one of these";
  const bool map = node.type == Type::kMap || node.type == Type::kNamedMap;
  if (node.presence == Presence::kDefaulted && !map) return "`" + node.default_yaml + "`";
  return map && node.presence == Presence::kDefaulted ? "as below" : "none";
}

std::string MeaningText(const SchemaNode& node) {
  std::string out = node.doc;
  if (!node.unit.empty()) out += " [" + node.unit + "]";
  if (!node.when_key.empty()) {
    out += fmt::format(" Only for {} {}.", node.when_key, Joined(node.when_values, ", "));
  }
  if (!node.needs.empty()) out += " Only with `" + node.needs + "`.";
  return out;
}

class ReferenceWriter {
 public:
  // Rows of the keys of a map and of everything below.
  void WriteRows(const SchemaNode& map, const std::string& prefix) {
    for (const SchemaNode& child : map.children) WriteRow(child, prefix + child.key);
  }
  [[nodiscard]] const std::string& text() const { return text_; }
  void Add(const std::string& line) { text_ += line + "\n"; }

 private:
  void WriteRow(const SchemaNode& node, const std::string& path) {
    Add(fmt::format(
        "| `{}` | {} | {} | {} |", path, DescribeType(node), DefaultText(node), MeaningText(node)));
    WriteBelow(node, path);
  }
  void WriteBelow(const SchemaNode& node, const std::string& path) {
    switch (node.type) {
      case Type::kMap:
        WriteRows(node, path + ".");
        break;
      case Type::kNamedMap:
        WriteRows(node.children.front(), path + "." + node.children.front().key + ".");
        break;
      case Type::kList:
        if (node.children.front().type == Type::kMap) {
          WriteRows(node.children.front(), path + "[].");
        }
        break;
      case Type::kEither:
        for (const SchemaNode& form : node.children) WriteBelow(form, path);
        break;
      default:
        break;
    }
  }

  std::string text_;
};

constexpr const char* kIntroduction =
    R"(# Configuration reference

One YAML file describes an experiment. This page is written from the schema in `app/config`; a test
keeps it up to date (`PATHFIT_UPDATE_DOCS=1` rewrites it).

* Keys must be known: anything misspelled, of the wrong type or out of range is an error with its
  place, and all errors are listed at once. Nothing is ignored.
* Numbers are plain (`0.1`, `1e-3`), never quoted, never `1,5` or `012`; `.inf` only in bounds.
  Booleans are `true` and `false`.
* Paths are relative to the file; `~/` and `${VAR}` are replaced in paths only.
* Default < file < `--set` < other flags. `--set stages.light.spp=16` (or `stages[0].spp`), `+=`
  appends to a list.
* Units are part of the names: `_px`, `_m`, `_deg`, `_ev`.
* Anchors and aliases work; merge keys (`<<`) and tags do not.

)";

std::string RangeText(const UnknownKind& kind) {
  if (kind.default_bounds.empty()) return "none";
  return "`" + kind.default_bounds + "`";
}

std::string UnknownsTable() {
  std::string out =
      "## Kinds of unknowns\n\n| name | bounds, if not given | transform, if not given | priors |\n"
      "|---|---|---|---|\n";
  for (const UnknownKind& kind : UnknownKinds()) {
    const std::string owner = kind.owner == UnknownKind::Owner::kMesh       ? "MESH."
                              : kind.owner == UnknownKind::Owner::kMaterial ? "MATERIAL."
                              : kind.owner == UnknownKind::Owner::kLight    ? "LIGHT."
                                                                            : "";
    const std::string transform = kind.default_bounds.empty() ? "none"
                                  : kind.default_log          ? "`log`"
                                                              : "`identity`";
    out += fmt::format("| `{}{}` | {} | {} | {} |\n",
                       owner,
                       kind.property,
                       RangeText(kind),
                       transform,
                       kind.priors.empty() ? "none" : Joined(kind.priors, ", "));
  }
  return out +
         "\n`MESH.colors` needs a material with `base_color: {vertex: …}`, `MATERIAL.base_color` "
         "one with\n`{constant: …}`; roughness and metallic need the model `metallic_roughness`, "
         "`LIGHT.texels` an\n`envmap`, `exposure` `input.exposure.model: gain`. Roughness below "
         "0.1 "
         "is refused.\n";
}

void CollectUnsupported(const SchemaNode& node,
                        const std::string& path,
                        std::vector<std::string>& out) {
  for (const Unsupported& u : node.unsupported) {
    const bool value = node.type == Type::kChoice;
    const std::string name =
        value ? path + ": " + u.name : (path.empty() ? u.name : path + "." + u.name);
    out.push_back("`" + name + "`");
  }
  for (const SchemaNode& child : node.children) {
    std::string below = path;
    if (!child.key.empty()) below += (path.empty() ? "" : ".") + child.key;
    CollectUnsupported(child, below, out);
  }
}

}  // namespace

std::string SchemaMarkdown() {
  const SchemaNode& schema = ConfigSchema();
  ReferenceWriter writer;
  const std::string header = "| key | type | default | meaning |\n|---|---|---|---|";
  writer.Add(std::string(kIntroduction) + "## Top level\n\n" + header);
  for (const SchemaNode& child : schema.children) {
    if (child.children.empty()) {
      SchemaNode alone;
      alone.children = {child};
      writer.WriteRows(alone, "");
    }
  }
  for (const SchemaNode& child : schema.children) {
    if (child.children.empty()) continue;
    writer.Add(fmt::format("\n## {}\n\n{}\n\n{}", child.key, child.doc, header));
    if (child.type == Type::kMap) {
      writer.WriteRows(child, child.key + ".");
    } else {
      const SchemaNode& item = child.children.front();
      const bool list = child.type == Type::kList;
      writer.WriteRows(item, list ? child.key + "[]." : child.key + "." + item.key + ".");
    }
  }
  std::vector<std::string> unsupported;
  CollectUnsupported(schema, "", unsupported);
  return writer.text() + "\n" + UnknownsTable() +
         "\n## Known, but not supported\n\nThese are refused with a message: " +
         Joined(unsupported, ", ") + ".\n";
}

}  // namespace pathfit::app
