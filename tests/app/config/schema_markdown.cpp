#include "tests/app/config/schema_markdown.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/schema.h"
#include "app/config/schema_builders.h"
#include "optim/parameter/unknown_spec.h"
#include "renderer/scene/parameter_kinds.h"

namespace pathfit::app {
namespace {

using Type = SchemaNode::Type;
using Presence = SchemaNode::Presence;

std::string DefaultText(const SchemaNode& node) {
  if (node.presence == Presence::kRequired && node.required_values.empty()) return "**required**";
  if (node.presence == Presence::kRequired) {
    const std::string otherwise =
        node.default_yaml.empty() ? "" : ", else `" + node.default_yaml + "`";
    return "**required** for " + JoinNames(node.required_values) + otherwise;
  }
  if (!node.default_doc.empty()) return node.default_doc;
  if (!node.one_of.empty()) return "one of these";
  const bool map =
      node.default_yaml.empty() && (node.type == Type::kMap || node.type == Type::kNamedMap);
  if (node.presence == Presence::kDefaulted && !map) return "`" + node.default_yaml + "`";
  return map && node.presence == Presence::kDefaulted ? "as below" : "none";
}

// `map` holds the key.
std::string MeaningText(const SchemaNode& map, const SchemaNode& node) {
  std::string out = node.doc;
  if (!node.unit.empty()) out += " [" + node.unit + "]";
  if (!node.when_key.empty() && node.when_values.size() < map.Child(node.when_key)->words.size()) {
    out += fmt::format(" Only for {} {}.", node.when_key, JoinNames(node.when_values));
  }
  if (!node.needs.empty()) out += " Only with `" + node.needs + "`.";
  return out;
}

class ReferenceWriter {
 public:
  // Rows of all below a node, which is at `path`.
  void WriteBelow(const SchemaNode& node, const std::string& path) {
    if (node.type == Type::kMap) return WriteRows(node, path + ".");
    for (const SchemaNode& child : node.children) {
      if (node.type == Type::kEither) {
        WriteBelow(child, path);
      } else if (child.type == Type::kMap) {
        WriteRows(child, path + (node.type == Type::kList ? "[]." : "." + child.key + "."));
      }
    }
  }
  // Rows of the keys of a map and of everything below.
  void WriteRows(const SchemaNode& map, const std::string& prefix) {
    for (const SchemaNode& child : map.children) WriteRow(map, child, prefix + child.key);
  }
  [[nodiscard]] const std::string& text() const { return text_; }
  void Add(const std::string& line) { text_ += line + "\n"; }

 private:
  void WriteRow(const SchemaNode& map, const SchemaNode& node, const std::string& path) {
    Add(fmt::format("| `{}` | {} | {} | {} |",
                    path,
                    DescribeType(node),
                    DefaultText(node),
                    MeaningText(map, node)));
    WriteBelow(node, path);
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

constexpr const char* kUnknownsNotes = R"(
* What a mesh, light or sensor must have is behind the name. `MESH.normals` and `MESH.uvs` need a
  mesh that has them. Roughness below 0.03 is refused.
* Positions and translations are in metres, rotations are rotation vectors (axis times radians),
  angles are radians, `focal` and `principal_point` are pixels. An object turns and grows about the
  middle of its bounding box, a light about its place, a camera about its centre.
* `exposure` needs `input.exposure.model: gain` where there are photos. `camera.PROPERTY` is that of
  all sensors; `SENSOR.PROPERTY` that of one of `scene.sensors`, or of one photo:
  `IMG_1.JPG.position`. `lamp_*.intensity` is that of all whose names fit the pattern; in `free` it is
  written alike.
* In a fit, cameras without a `gaussian` prior have one around their start, of sigma: `position` 2 %
  of the distance to the middle of the objects, `rotation` 0.02, `focal` 2 %, `principal_point` 1 %
  of the picture's width, `distortion` 0.05, `tangential` 0.01. It keeps what the photos leave open,
  such as where everything is together. Held-out views
  keep their lenses; `position` and `rotation` follow their own photos, of which nothing else learns.
* A spot's `angles` move such that the inner one stays below the outer one.
* `gradcheck.params` and `render --derivative` take these names with a component behind:
  `mug.vertices.x` (all vertices along x), `mug.vertices[17].y` (one number), `mug.rotation.y`,
  `paint.base_color.r`, `camera.principal_point.x`, `camera.distortion.1`, `lamp.angles.i` (inner)
  and `.o` (outer). Without a component all numbers change alike (`gloss.texels`: by the same at each
  texel); in `gradcheck` those of many vertices or texels by a fixed random number each.
)";

// "`MATERIAL.eta`, conductor, mirror".
std::string DescribeName(const renderer::ParameterTraits& row) {
  if (optim::IsOfExposure(row.kind)) return "`" + std::string(row.property) + "`";
  std::string object = renderer::ObjectWord(row.list);
  std::ranges::transform(object, object.begin(), ::toupper);
  if (row.list == renderer::ObjectList::kSensors) object = "camera";
  const std::string name = "`" + object + "." + row.property + "`";
  return *row.objects == '\0' ? name : name + ", " + row.objects;
}

std::string UnknownsTable() {
  std::string out =
      "## Kinds of unknowns\n\n| name | unit | bounds, if not given | transform, if not given | "
      "priors |\n|---|---|---|---|---|\n";
  for (const renderer::ParameterTraits& row : renderer::AllParameterTraits()) {
    const std::vector<std::string> priors(row.priors.begin(), row.priors.end());
    out += fmt::format(
        "| {} | {} | {} | {} | {} |\n",
        DescribeName(row),
        row.unit,
        row.bounded ? "`" + binding::Write(std::array{row.lower, row.upper}) + "`" : "none",
        !row.bounded ? "none" : (row.log ? "`log`" : "`identity`"),
        priors.empty() ? "none" : JoinNames(priors));
  }
  return out + kUnknownsNotes;
}

void CollectUnsupported(const SchemaNode& node,
                        const std::string& path,
                        std::vector<std::string>& out) {
  for (const Unsupported& u : node.unsupported) {
    const bool value = node.type == Type::kChoice;
    out.push_back("`" + (value ? path + ": " + u.name : JoinPath(path, u.name)) + "`");
  }
  for (const SchemaNode& child : node.children) {
    CollectUnsupported(child, child.key.empty() ? path : JoinPath(path, child.key), out);
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
    writer.WriteBelow(child, child.key);
  }
  std::vector<std::string> unsupported;
  CollectUnsupported(schema, "", unsupported);
  return writer.text() + "\n" + UnknownsTable() +
         "\n## Known, but not supported\n\nThese are refused with a message: " +
         JoinNames(unsupported) + ".\n";
}

}  // namespace pathfit::app
