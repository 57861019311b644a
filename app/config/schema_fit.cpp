#include "app/config/schema_builders.h"

namespace pathfit::app {
namespace {

SchemaNode Weight(const char* doc) { return Number("weight", doc).AtLeast(0.0).Required(); }

SchemaNode PriorSchema() {
  const auto weighted = [](const char* key, const char* doc) {
    return Map(key, {Weight("Strength; 0 = off.")}, doc).OneOf("prior");
  };
  return Map("",
             {weighted("laplacian", "Vertices: each near the middle of its neighbours."),
              weighted("smooth", "Texels and vertex colours: neighbours alike."),
              weighted("neutral", "Texels: light near grey."),
              Map("gaussian",
                  {Either(
                       "mean",
                       {Number("", "").Words({"start"}), List("", Number("", ""), "").Items(2, 3)},
                       "Expected value, or one for each component; `start`: what the fit begins "
                       "with.")
                       .Required(),
                   Number("sigma", "How far from it the value is believed to be.")
                       .Above(0.0)
                       .Required()},
                  "Near a known value.")
                  .OneOf("prior")},
             "")
      .Refuse({{"normal_consistency", "; write laplacian"},
               {"total_variation", "; write smooth"},
               {"binary", ""}});
}

}  // namespace

SchemaNode UnknownsSchema() {
  const SchemaNode parametrisation =
      Either("parametrisation",
             {Choice("", {"vertices"}, "")
                  .Refuse({{"displacement", ""},
                           {"rigid", "; free MESH.translation and MESH.rotation"}}),
              Map("",
                  {Map("large_steps",
                       {Number("lambda", "Strength; 0 = off.").AtLeast(0.0).Default("19")},
                       "Steps in the metric I + lambda L of the mesh: smooth changes come first.")
                       .Required()},
                  "")
                  .Refuse({{"displacement", ""},
                           {"rigid", "; free MESH.translation and MESH.rotation"}})},
             "Vertices: how they move.")
          .DefaultIs("`vertices`: each alone");
  return NamedMap("unknowns",
                  "OBJECT.PROPERTY",
                  Map("",
                      {List("bounds",
                            Number("", "").OrInfinite(),
                            "Lower and upper limit of each number.")
                           .Items(2, 2)
                           .DefaultIs("by kind, see below"),
                       Choice("transform",
                              {"identity", "log"},
                              "`log`: the logarithm is what the solver moves (never negative).")
                           .DefaultIs("by kind, see below"),
                       Bool("hold", "Known to the program, never freed.").Default("false"),
                       parametrisation,
                       List("priors", PriorSchema(), "What is believed beforehand.").Default("[]")},
                      "What may change."),
                  "What may move, how, and between which limits. Names: see \"Kinds of unknowns\" "
                  "below.")
      .FreeNames();
}

SchemaNode StagesSchema() {
  return List(
      "stages",
      Map("",
          {Name("name", "Different for every stage.").Required(),
           Either("free",
                  {Choice("", {"all"}, ""), List("", Text("", ""), "").Items(1, 0)},
                  "Names of the unknowns that move; `all`: those without `hold: true`.")
               .Required(),
           Number("image_scale", "Size of the photos in this stage.").From(0.01, 1.0).Default("1"),
           Integer("max_rounds", "Solves, each with new samples.").From(1, 10000).Default("10"),
           Integer("spp", "Samples per pixel in the first round, of both halves together.")
               .From(2, 65536)
               .Default("8"),
           Integer("max_spp", "Samples per pixel that no round passes.")
               .From(2, 65536)
               .Default("64"),
           Number("spp_growth", "Factor of spp from round to round.")
               .From(1.0, 10.0)
               .Default("1.5"),
           Number("sppe",
                  "Samples of silhouettes, borders and creases, per pixel of their length, in the "
                  "first round; grows as spp does, and so do the three below.")
               .From(0.0, 65536)
               .Default("4"),
           Number("spp_direct", "Samples per pixel of edges that throw shadows.")
               .From(0.0, 65536)
               .Default("0.25"),
           Number("spp_indirect", "Samples per pixel of edges between two surfaces.")
               .From(0.0, 65536)
               .Default("0.25"),
           Number("spp_pixel",
                  "Samples per pixel of pixel borders; only with `form: material` in `render`.")
               .From(0.0, 65536)
               .Default("4"),
           Map("stop",
               {Number(
                    "relative_cost",
                    "End when a round lowers the averaged cost by less than this share; 0 = never.")
                    .From(0.0, 1.0)
                    .Default("0")},
               "When to end before max_rounds.")
               .Always()
               .Refuse({{"gradient", ""}, {"patience", ""}})},
          "")
          .Refuse({{"max_iterations", "; write max_rounds"},
                   {"views_per_step", "; every round sees all photos"},
                   {"remesh", ""},
                   {"schedule", ""},
                   {"promote", ""}}),
      "Steps of the fit, in this order; each starts from the result before it.");
}

}  // namespace pathfit::app
