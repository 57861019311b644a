#include "app/config/schema.h"

#include <cmath>

#include <fmt/format.h>

#include "app/config/schema_builders.h"

namespace pathfit::app {
namespace {

SchemaNode Budget(const char* key, const char* value, const char* doc) {
  return Number(key, doc).From(0.0, 1 << 20).Default(value);
}

SchemaNode RenderSchema() {
  return Map("render",
             {Integer("spp", "Samples per pixel of `pathfit render`.")
                  .From(1, 1 << 20)
                  .Default("64"),
              Budget("sppe",
                     "8",
                     "Samples of primary boundaries in derivatives, per pixel of their length: "
                     "silhouettes, borders and creases as the camera sees them."),
              Budget("spp_direct",
                     "8",
                     "Samples per pixel of direct boundaries: edges between a light and a surface "
                     "(shadows)."),
              Budget("spp_indirect",
                     "8",
                     "Samples per pixel of indirect boundaries: edges between two surfaces "
                     "(interreflections)."),
              Budget("spp_pixel",
                     "4",
                     "Samples per pixel of pixel boundaries: surfaces that move over the border of "
                     "a box filter; only with `form: material`."),
              Integer("max_bounces",
                      "1 = direct light only, 0 = only what shines or is seen behind the objects.")
                  .From(0, 64)
                  .Default("1"),
              Integer("rr_depth", "Bounces after which Russian roulette may end a path.")
                  .From(1, 64)
                  .Default("5"),
              List("terms",
                   Choice("", {"interior", "primary", "direct", "indirect", "pixel"}, ""),
                   "Parts of the derivative that are computed. Without one of them it is right "
                   "only where that part is zero.")
                  .Items(1, 5)
                  .Default("[interior, primary, direct, indirect, pixel]"),
              Choice("form",
                     {"image", "material"},
                     "Where the derivative is taken of the part of a path next to the camera: "
                     "`image`: at fixed pixels; `material`: at fixed points of the surfaces. Both "
                     "give the same. `material` is less noisy where detailed surfaces move, much "
                     "less with `max_bounces` above 1; `image` where cameras or plain surfaces do.")
                  .Default("image"),
              Choice("guiding",
                     {"none", "grid", "adaptive"},
                     "How boundary samples find what contributes: not at all, by a regular grid, "
                     "or by one that is refined where it matters. All give the same mean.")
                  .Default("adaptive"),
              Number("guide_share", "Share of the boundary samples spent on building the guide.")
                  .Between(0.0, 1.0)
                  .Default("0.25"),
              Bool("antithetic",
                   "Draws paths in pairs with mirrored reflections: derivatives of glossy surfaces "
                   "by shape lose most of their noise, pictures gain nothing.")
                  .Default("false"),
              Choice("pixel_filter",
                     {"box"},
                     "How samples become pixels of photos; sensors have their own `filter`.")
                  .Default("box")
                  .Refuse({{"tent", "; write filter in scene.sensors"},
                           {"gaussian", "; write filter in scene.sensors"}})},
             "How pictures and derivatives are computed.")
      .Always()
      .Refuse({{"sppse", "; write spp_direct and spp_indirect"},
               {"sppse0", "; write spp_direct"},
               {"sppse1", "; write spp_indirect"},
               {"sppe0", "; write spp_pixel"},
               {"sppp", "; write sppe"},
               {"sppi", "; write spp_direct and spp_indirect"},
               {"sppc", "; write spp"},
               {"reseed", "; every round has its own samples"}});
}

SchemaNode LossSchema() {
  return Map("loss",
             {Choice("residual",
                     {"linear", "relative"},
                     "Model minus photo, or that divided by photo + relative_floor.")
                  .Default("linear")
                  .Refuse({{"log", ""}, {"srgb", ""}}),
              Number("relative_floor", "Brightness below which `relative` acts like `linear`.")
                  .Above(0.0)
                  .Default("0.05"),
              Map("silhouette",
                  {Number("weight", "Of the masks against the colours.").AtLeast(0.0).Default("1")},
                  "Coverage of the model against the masks.")
                  .Always()},
             "What is made small.")
      .Always()
      .Refuse({{"robust", ""}});
}

SchemaNode SolverSchema() {
  return Map("solver",
             {Choice("linear_solver",
                     {"auto", "gram", "cholesky", "cgnr"},
                     "`auto` picks by size and coupling; the log says which.")
                  .Default("auto")
                  .Refuse({{"dense_qr", "; write gram"},
                           {"sparse_normal_cholesky", "; write cholesky"},
                           {"iterative", "; write cgnr"}}),
              Bytes("max_memory", "Refuse to start above this, as `16 GiB`; `none` = no limit.")
                  .Words({"none"})
                  .Default("none"),
              Integer("threads", "`auto`: those the machine or job gives.")
                  .From(1, 1024)
                  .Words({"auto"})
                  .Default("auto")},
             "How the unknowns are found.")
      .Always()
      .Refuse({{"method", "; it is Ceres' Levenberg-Marquardt"}, {"uncertainty", ""}});
}

SchemaNode OutputSchema() {
  return Map("output",
             {Path("directory",
                   "Made for each run; `{name}` and `{timestamp}` are replaced. Relative to this "
                   "file, like all paths.")
                  .Default("runs/{name}/{timestamp}"),
              Map("images",
                  {Bool("every_stage",
                        "Large pictures of held-out views after every stage, not only after the "
                        "last one.")
                       .Default("true")},
                  "Pictures of the run.")
                  .Always()
                  .Refuse({{"every", "; write every_stage"}, {"views", ""}, {"kinds", ""}}),
              Bool("report", "Write report.html.").Default("true")},
             "What a run leaves behind.")
      .Always()
      .Refuse({{"mesh", "; glb and ply are always written"},
               {"environment", "; exr and hdr are always written"},
               {"checkpoint", "; one is written after every round"},
               {"metrics", "; metrics.csv is always written"}});
}

SchemaNode GradcheckSchema() {
  return Map("gradcheck",
             {List("params", Text("", ""), "Names or patterns (`*`, `?`) of unknowns; empty = all.")
                  .Default("[]"),
              Number("step", "Of the finite difference, in units of the parameter.")
                  .Above(0.0)
                  .Default("1e-3"),
              Integer("spp", "Samples per pixel of each replicate.").From(1, 1 << 20).Default("64"),
              Integer("replicates", "Independent renderings, for the error bars.")
                  .From(2, 100000)
                  .Default("32"),
              Number("sigma", "Differences beyond so many error bars fail.")
                  .Above(0.0)
                  .Default("4")},
             "Settings of `pathfit gradcheck`.")
      .Always();
}

SchemaNode RootSchema() {
  return Map("",
             {Integer("schema", "Version of this format; must be 1.").From(1, 1).Required(),
              Name("name", "Used for the run directory.").DefaultIs("name of the file"),
              Integer("seed", "All random numbers are derived from it.")
                  .From(0, 9007199254740992.0)
                  .Default("0"),
              InputSchema(),
              SceneSchema(),
              RenderSchema(),
              UnknownsSchema(),
              LossSchema(),
              StagesSchema(),
              SolverSchema(),
              OutputSchema(),
              GradcheckSchema()},
             "")
      .Refuse({{"extends", "; write the values into this file"}});
}

std::string Joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

// "a number from 0 to 1" of a scalar node.
std::string DescribeScalar(const SchemaNode& node, const std::string& noun) {
  const std::string range = DescribeRange(node);
  std::string out = noun + (range.empty() ? "" : " " + range);
  if (!node.words.empty()) out += ", or " + Joined(node.words);
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
    case SchemaNode::Type::kChoice:
      return "a list of " + count + "words" + least + " out of " + Joined(item.words);
    default:
      return "a list of " + count + "texts" + least;
  }
}

}  // namespace

const SchemaNode& ConfigSchema() {
  static const SchemaNode schema = RootSchema();
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
                                    : "one of " + Joined(node.words);
    case SchemaNode::Type::kPath:
      return node.words.empty() ? "a path" : "a path, or " + Joined(node.words);
    case SchemaNode::Type::kBytes:
      return "a size such as 16 GiB" + (node.words.empty() ? "" : ", or " + Joined(node.words));
    case SchemaNode::Type::kList:
      return DescribeList(node);
    case SchemaNode::Type::kMap:
      return "a map";
    case SchemaNode::Type::kNamedMap:
      return "a map of names";
    case SchemaNode::Type::kEither:
      break;
  }
  std::string out;
  for (const SchemaNode& form : node.children) {
    out += (out.empty() ? "" : ", or ") + DescribeType(form);
  }
  return out;
}

}  // namespace pathfit::app
