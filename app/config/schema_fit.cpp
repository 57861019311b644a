// What is computed and how: render, unknowns, loss, stages, solver, output, gradcheck.
#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"

namespace pathfit::app {
namespace {

using optim::FitSpec;
using optim::LinearSolverChoice;
using optim::LossSpec;
using optim::ResidualKind;
using optim::StageSpec;
using optim::UnknownSpec;
using renderer::DerivativeForm;
using renderer::DerivativeTerms;
using renderer::GuideKind;
using renderer::RenderOptions;
using renderer::SampleBudget;

constexpr auto kRender = &ExperimentConfig::render;

SchemaNode Weight(double UnknownSpec::*weight) {
  return Key("weight", "Strength; 0 = off.", weight).AtLeast(0.0).Required();
}

SchemaNode PriorSchema() {
  const auto weighted = [](const char* key, double UnknownSpec::*weight, const char* doc) {
    return Map(key, {Weight(weight)}, doc).OneOf("prior");
  };
  const SchemaNode number = binding::Described<double>::Node();
  return Map("",
             {weighted("laplacian",
                       &UnknownSpec::laplacian_weight,
                       "Vertices: each near the middle of its neighbours."),
              weighted("smooth",
                       &UnknownSpec::smooth_weight,
                       "Texels and vertex colours: neighbours alike."),
              weighted("total_variation",
                       &UnknownSpec::total_variation_weight,
                       "Texels: neighbours alike except at edges, which stay sharp."),
              weighted("neutral", &UnknownSpec::neutral_weight, "Texels: light near grey."),
              MapOf("gaussian",
                    {Bound(Either("mean",
                                  {SchemaNode(number).Words({"start"}),
                                   ListNode("", number, "").Items(2, 3)},
                                  "Expected value, or one for each component; `start`: what the "
                                  "fit begins with."),
                           &optim::GaussianPriorSpec::mean)
                         .Required(),
                     Key("sigma",
                         "How far from it the value is believed to be.",
                         &optim::GaussianPriorSpec::sigma)
                         .Above(0.0)
                         .Required()},
                    "Near a known value.",
                    &UnknownSpec::gaussian)
                  .OneOf("prior")},
             "")
      .Refuse({{"normal_consistency", "; write laplacian"}, {"binary", ""}});
}

void CheckStage(StageSpec& stage, const CheckedMap& map) {
  const YamlNode* spp = map.Find("spp");
  const YamlNode* max_spp = map.Find("max_spp");
  if (spp == nullptr || max_spp == nullptr || stage.samples.spp <= stage.max_spp) return;
  const bool max_given = max_spp->place.source != Place::Source::kDefault;
  map.Report("max_spp",
             max_given ? *max_spp : *spp,
             fmt::format("max_spp {} is below spp {}", stage.max_spp, stage.samples.spp));
}

}  // namespace

SchemaNode RenderSchema() {
  constexpr double kMost = 1 << 20;
  const auto samples = [&](const char* key, const char* doc, double SampleBudget::*budget) {
    return Key(key, doc, kRender, budget).From(0.0, kMost);
  };
  return Map("render",
             {Key("spp", "Samples per pixel of `pathfit render`.", kRender, &SampleBudget::spp)
                  .From(1, kMost),
              samples("sppe",
                      "Samples of primary boundaries in derivatives, per pixel of their length: "
                      "silhouettes, borders and creases as the camera sees them.",
                      &SampleBudget::sppe),
              samples("spp_direct",
                      "Samples per pixel of direct boundaries: edges between a light and a surface "
                      "(shadows).",
                      &SampleBudget::spp_direct),
              samples("spp_indirect",
                      "Samples per pixel of indirect boundaries: edges between two surfaces "
                      "(interreflections).",
                      &SampleBudget::spp_indirect),
              samples(
                  "spp_pixel",
                  "Samples per pixel of pixel boundaries: surfaces that move over the border of a "
                  "box filter; only with `form: material`.",
                  &SampleBudget::spp_pixel),
              Key("max_bounces",
                  "1 = direct light only, 0 = only what shines or is seen behind the objects.",
                  kRender,
                  &RenderOptions::max_bounces)
                  .From(0, 64),
              Key("rr_depth",
                  "Bounces after which Russian roulette may end a path.",
                  kRender,
                  &RenderOptions::rr_depth)
                  .From(1, 64),
              Flags<DerivativeTerms>("terms",
                                     {{"interior", &DerivativeTerms::interior},
                                      {"primary", &DerivativeTerms::primary},
                                      {"direct", &DerivativeTerms::direct},
                                      {"indirect", &DerivativeTerms::indirect},
                                      {"pixel", &DerivativeTerms::pixel}},
                                     "Parts of the derivative that are computed. Without one of "
                                     "them it is right only where that part is zero.",
                                     kRender,
                                     &RenderOptions::terms),
              Choice("form",
                     {{"image", DerivativeForm::kImage}, {"material", DerivativeForm::kMaterial}},
                     "Where the derivative is taken of the part of a path next to the camera: "
                     "`image`: at fixed pixels; `material`: at fixed points of the surfaces. Both "
                     "give the same. `material` is less noisy where detailed surfaces move, much "
                     "less with `max_bounces` above 1; `image` where cameras or plain surfaces do.",
                     kRender,
                     &RenderOptions::form),
              Choice("guiding",
                     {{"none", GuideKind::kNone},
                      {"grid", GuideKind::kGrid},
                      {"adaptive", GuideKind::kAdaptive}},
                     "How boundary samples find what contributes: not at all, by a regular grid, "
                     "or by one that is refined where it matters. All give the same mean.",
                     kRender,
                     &RenderOptions::guide),
              Key("guide_share",
                  "Share of the boundary samples spent on building the guide.",
                  kRender,
                  &RenderOptions::guide_share)
                  .Between(0.0, 1.0),
              Key("antithetic",
                  "Draws paths in pairs with mirrored reflections: derivatives of glossy surfaces "
                  "by shape lose most of their noise, pictures gain nothing.",
                  kRender,
                  &RenderOptions::antithetic)},
             "How pictures and derivatives are computed.")
      .Always()
      .Refuse({{"pixel_filter", "; photos are means over pixels, write filter in scene.sensors"},
               {"sppse", "; write spp_direct and spp_indirect"},
               {"sppse0", "; write spp_direct"},
               {"sppse1", "; write spp_indirect"},
               {"sppe0", "; write spp_pixel"},
               {"sppp", "; write sppe"},
               {"sppi", "; write spp_direct and spp_indirect"},
               {"sppc", "; write spp"},
               {"reseed", "; every round has its own samples"}});
}

SchemaNode LossSchema() {
  return MapOf(
             "loss",
             {Choice("residual",
                     {{"linear", ResidualKind::kLinear}, {"relative", ResidualKind::kRelative}},
                     "Model minus photo, or that divided by photo + relative_floor.",
                     &LossSpec::residual)
                  .Refuse({{"log", ""}, {"srgb", ""}}),
              Key("relative_floor",
                  "Brightness below which `relative` acts like `linear`.",
                  &LossSpec::relative_floor)
                  .Above(0.0),
              Map("silhouette",
                  {Key("weight", "Of the masks against the colours.", &LossSpec::silhouette_weight)
                       .AtLeast(0.0)},
                  "Coverage of the model against the masks.")
                  .Always()},
             "What is made small.",
             &ExperimentConfig::fit,
             &FitSpec::loss)
      .Always()
      .Refuse({{"robust", ""}});
}

SchemaNode SolverSchema() {
  return Map("solver",
             {Choice("linear_solver",
                     {{"auto", LinearSolverChoice::kAuto},
                      {"gram", LinearSolverChoice::kGram},
                      {"cholesky", LinearSolverChoice::kCholesky},
                      {"cgnr", LinearSolverChoice::kCgnr}},
                     "`auto` picks by size and coupling; the log says which.",
                     &ExperimentConfig::fit,
                     &FitSpec::linear_solver)
                  .Refuse({{"dense_qr", "; write gram"},
                           {"sparse_normal_cholesky", "; write cholesky"},
                           {"iterative", "; write cgnr"}}),
              Bytes("max_memory",
                    "Refuse to start above this, as `16 GiB`; `none` = no limit.",
                    &ExperimentConfig::fit,
                    &FitSpec::max_memory_bytes)
                  .OrWord("none"),
              Key("threads", "`auto`: those the machine or job gives.", &ExperimentConfig::threads)
                  .From(1, 1024)
                  .OrWord("auto")},
             "How the unknowns are found.")
      .Always()
      .Refuse({{"method", "; it is Ceres' Levenberg-Marquardt"}, {"uncertainty", ""}});
}

SchemaNode OutputSchema() {
  return MapOf("output",
               {Key("directory",
                    "Made for each run; `{name}` and `{timestamp}` are replaced. Relative to this "
                    "file, like all paths.",
                    &OutputConfig::directory),
                Map("images",
                    {Key("every_stage",
                         "Large pictures of held-out views after every stage, not only after the "
                         "last one.",
                         &OutputConfig::images_every_stage)},
                    "Pictures of the run.")
                    .Always()
                    .Refuse({{"every", "; write every_stage"}, {"views", ""}, {"kinds", ""}}),
                Key("report", "Write report.html.", &OutputConfig::report)},
               "What a run leaves behind.",
               &ExperimentConfig::output)
      .Always()
      .Refuse({{"mesh", "; glb and ply are always written"},
               {"environment", "; exr and hdr are always written"},
               {"checkpoint", "; one is written after every round"},
               {"metrics", "; metrics.csv is always written"}});
}

SchemaNode GradcheckSchema() {
  constexpr auto kCheck = &GradcheckConfig::check;
  return MapOf("gradcheck",
               {Key("params",
                    "Names or patterns (`*`, `?`) of unknowns; empty = all.",
                    &GradcheckConfig::params),
                Key("step",
                    "Of the finite difference, in units of the parameter.",
                    kCheck,
                    &optim::GradientCheckOptions::step)
                    .Above(0.0),
                Key("spp",
                    "Samples per pixel of each replicate.",
                    kCheck,
                    &optim::GradientCheckOptions::render,
                    &SampleBudget::spp)
                    .From(1, 1 << 20),
                Key("replicates",
                    "Independent renderings, for the error bars.",
                    kCheck,
                    &optim::GradientCheckOptions::replicates)
                    .From(2, 100000),
                Key("sigma", "Differences beyond so many error bars fail.", &GradcheckConfig::sigma)
                    .Above(0.0)},
               "Settings of `pathfit gradcheck`.",
               &ExperimentConfig::gradcheck)
      .Always();
}

SchemaNode UnknownsSchema() {
  const std::vector<Unsupported> elsewhere = {
      {"displacement", ""}, {"rigid", "; free MESH.translation and MESH.rotation"}};
  const SchemaNode parametrisation =
      Either("parametrisation",
             {Word("vertices").Refuse(elsewhere),
              Map("",
                  {Map("large_steps",
                       {Key("lambda", "Strength; 0 = off.", &UnknownSpec::large_steps_lambda)
                            .AtLeast(0.0)
                            .Default("19")},
                       "Steps in the metric I + lambda L of the mesh: smooth changes come first.")
                       .Required()},
                  "")
                  .Refuse(elsewhere)},
             "Vertices: how they move.")
          .DefaultIs("`vertices`: each alone");
  return NamedMap(
             "unknowns",
             "OBJECT.PROPERTY",
             Map("",
                 {ByCheck(ListNode("bounds",
                                   binding::Described<double>::Node(),
                                   "Lower and upper limit of each number."))
                      .OrInfinite()
                      .Items(2, 2)
                      .DefaultIs("by kind, see below"),
                  Choice("transform",
                         {{"identity", optim::Parameterization::kIdentity},
                          {"log", optim::Parameterization::kLog}},
                         "`log`: the logarithm is what the solver moves (never negative).",
                         &UnknownSpec::parameterization)
                      .DefaultIs("by kind, see below"),
                  Key("hold", "Known to the program, never freed.", &UnknownSpec::hold),
                  parametrisation,
                  Choice(
                      "mesh",
                      {{"keep", optim::MeshDetail::kKeep}, {"levels", optim::MeshDetail::kLevels}},
                      "Vertices. `levels`: every stage that frees them begins with a mesh of "
                      "the same surface whose edges are some pixels long, coarser or finer than "
                      "the one before. Meshes with borders or with textures on them stay as "
                      "they are; the log says which.",
                      &UnknownSpec::mesh_detail)
                      .DefaultIs("`levels`, but `keep` for files with UVs"),
                  ListNode("priors", PriorSchema(), "What is believed beforehand.").Default("[]")},
                 "What may change."),
             "What may move, how, and between which limits. Names: see \"Kinds of unknowns\" "
             "below.",
             &ExperimentConfig::fit,
             &FitSpec::unknowns)
      .FreeNames();
}

SchemaNode StagesSchema() {
  constexpr double kMost = 65536;
  constexpr auto kSamples = &StageSpec::samples;
  const auto samples = [&](const char* key, const char* doc, double SampleBudget::*budget) {
    return Key(key, doc, kSamples, budget).From(0.0, kMost);
  };
  return ListOf(
      "stages",
      Map("",
          {Name("name", "Different for every stage.", &StageSpec::name).Required(),
           ByCheck(Either("free",
                          {Word("all"), ListNode("", TextNode("", ""), "").Items(1, 0)},
                          "Names of the unknowns that move; `all`: those without `hold: true`."))
               .Required(),
           Key("image_scale", "Size of the photos in this stage.", &StageSpec::image_scale)
               .From(0.01, 1.0),
           Key("max_rounds", "Solves, each with new samples.", &StageSpec::max_rounds)
               .From(1, 10000),
           Key("spp",
               "Samples per pixel in the first round, of both halves together.",
               kSamples,
               &SampleBudget::spp)
               .From(2, kMost),
           Key("max_spp", "Samples per pixel that no round passes.", &StageSpec::max_spp)
               .From(2, kMost),
           Key("spp_growth", "Factor of spp from round to round.", &StageSpec::spp_growth)
               .From(1.0, 10.0),
           samples("sppe",
                   "Samples of silhouettes, borders and creases, per pixel of their length, in the "
                   "first round; grows as spp does, and so do the three below.",
                   &SampleBudget::sppe),
           samples("spp_direct",
                   "Samples per pixel of edges that throw shadows.",
                   &SampleBudget::spp_direct),
           samples("spp_indirect",
                   "Samples per pixel of edges between two surfaces.",
                   &SampleBudget::spp_indirect),
           samples("spp_pixel",
                   "Samples per pixel of pixel borders; only with `form: material` in `render`.",
                   &SampleBudget::spp_pixel),
           Map("stop",
               {Key("relative_cost",
                    "End when a round lowers the averaged cost by less than this share; 0 = never.",
                    &StageSpec::stop_relative_cost)
                    .From(0.0, 1.0)},
               "When to end before max_rounds.")
               .Always()
               .Refuse({{"gradient", ""}, {"patience", ""}})},
          "")
          .Refuse({{"max_iterations", "; write max_rounds"},
                   {"views_per_step", "; every round sees all photos"},
                   {"remesh", ""},
                   {"schedule", ""},
                   {"promote", ""}})
          .Check(CheckStage),
      "Steps of the fit, in this order; each starts from the result before it.",
      &ExperimentConfig::fit,
      &FitSpec::stages);
}

}  // namespace pathfit::app
