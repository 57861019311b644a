// What is computed and how: render, unknowns, loss, stages, solver, output, gradcheck.
#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "optim/prior/prior_terms.h"
#include "optim/round/round_policy.h"

namespace pathfit::app {
namespace {

// Its square must be a number that others can be added to.
constexpr double kLeastSigma = 1e-20;

using optim::FitSpec;
using optim::LinearSolverChoice;
using optim::LossSpec;
using optim::ResidualKind;
using optim::StageBudget;
using optim::StageSpec;
using optim::UnknownSpec;
using renderer::BoundaryBudgets;
using renderer::DerivativeChoice;
using renderer::DerivativeForm;
using renderer::GuideKind;
using renderer::RenderOptions;
using renderer::SampleBudget;

constexpr auto kRender = &ExperimentConfig::render;
constexpr auto kDerivative = &ExperimentConfig::derivative;

SchemaNode PriorSchema() {
  const SchemaNode number = binding::Described<double>::Node();
  std::vector<SchemaNode> priors;
  for (const auto& [name, doc, weight] : optim::WeightedPriors()) {
    const SchemaNode strength =
        Key("weight", weight) | Doc("Strength; 0 = off.") | AtLeast(0.0) | Required();
    priors.push_back(Map(name, {strength}) | Doc(doc) | OneOf("prior"));
  }
  priors.push_back(
      MapOf("gaussian",
            {Bound(Either("mean",
                          {SchemaNode(number) | Words({"start"}),
                           ListNode("", number) | Items(2, 3)}) |
                       Doc("Expected value, or one for each component; `start`: what the fit "
                           "begins with."),
                   &optim::GaussianPriorSpec::mean) |
                 Required(),
             Key("sigma", &optim::GaussianPriorSpec::sigma) |
                 Doc("How far from it the value is believed to be.") | AtLeast(kLeastSigma) |
                 Required()},
            &UnknownSpec::gaussian) |
      Doc("Near a known value.") | OneOf("prior"));
  return Map("", std::move(priors)) | Refuse({{"normal_consistency", "; write laplacian"}});
}

void CheckStage(StageSpec& stage, const CheckedMap& map) {
  const YamlNode* spp = map.Find("spp");
  const YamlNode* max_spp = map.Find("max_spp");
  if (spp == nullptr || max_spp == nullptr || *stage.samples.spp <= stage.max_spp) return;
  const bool max_given = max_spp->place.source != Place::Source::kDefault;
  map.Report("max_spp",
             max_given ? *max_spp : *spp,
             fmt::format("max_spp {} is below spp {}", stage.max_spp, *stage.samples.spp));
}

}  // namespace

SchemaNode RenderSchema() {
  constexpr double kMost = 1 << 20;
  return Map("render",
             {Key("spp", kRender, &SampleBudget::spp) |
                  Doc("Samples per pixel of `pathfit render`.") | From(1, kMost),
              Key("sppe", kDerivative, &BoundaryBudgets::sppe) |
                  Doc("Samples of primary boundaries in derivatives, per pixel of their length: "
                      "silhouettes, borders and creases as the camera sees them. Found from "
                      "measured "
                      "variances, as are the three below, unless given: what makes the error least "
                      "for its time; where many numbers are derived by at once, 8, 8, 8 and 4.") |
                  From(0.0, kMost),
              Key("spp_direct", kDerivative, &BoundaryBudgets::spp_direct) |
                  Doc("Samples per pixel of direct boundaries: edges between a light and a surface "
                      "(shadows).") |
                  From(0.0, kMost),
              Key("spp_indirect", kDerivative, &BoundaryBudgets::spp_indirect) |
                  Doc("Samples per pixel of indirect boundaries: edges between two surfaces "
                      "(interreflections).") |
                  From(0.0, kMost),
              Key("spp_pixel", kDerivative, &BoundaryBudgets::spp_pixel) |
                  Doc("Samples per pixel of pixel boundaries: surfaces that move over the border "
                      "of a box filter; only with `form: material`.") |
                  From(0.0, kMost) | UselessWith("render.form", {"image"}),
              Key("max_bounces", kRender, &RenderOptions::max_bounces) |
                  Doc("1 = direct light only, 0 = only what shines or is seen behind the "
                      "objects.") |
                  From(0, 64),
              Key("rr_depth", kRender, &RenderOptions::rr_depth) |
                  Doc("Bounces after which Russian roulette may end a path.") | From(1, 64),
              WordSet("terms",
                      WordsOf<renderer::DerivativeTerm>(renderer::kDerivativeTerms.begin(),
                                                        renderer::kDerivativeTerms.end()),
                      kRender,
                      &RenderOptions::terms) |
                  Doc("Parts of the derivative that are computed. Without one of them it is right "
                      "only where that part is zero."),
              Choice("form",
                     {{"auto", std::nullopt},
                      {"image", DerivativeForm::kImage},
                      {"material", DerivativeForm::kMaterial}},
                     kDerivative,
                     &DerivativeChoice::form) |
                  Doc("Where the derivative is taken of the part of a path next to the camera: "
                      "`image`: at fixed pixels; `material`: at fixed points of the surfaces. Both "
                      "give the same, but that by cameras only `material` has lines along which "
                      "meshes cut each other and the border of a projector's picture; `auto`: "
                      "`material` there, else found for derivative images, and `image` in fits and "
                      "checks. `material` is less noisy where detailed surfaces move, much "
                      "less with `max_bounces` above 1; `image` where cameras or plain surfaces "
                      "do."),
              Choice("guiding",
                     {{"none", GuideKind::kNone},
                      {"grid", GuideKind::kGrid},
                      {"adaptive", GuideKind::kAdaptive}},
                     kRender,
                     &RenderOptions::guide) |
                  Doc("How boundary samples find what contributes: not at all, by a regular grid, "
                      "or by one that is refined where it matters. All give the same mean."),
              Key("guide_share", kRender, &RenderOptions::guide_share) |
                  Doc("Share of the boundary samples spent on building the guide.") |
                  Between(0.0, 1.0) | UselessWith("render.guiding", {"none"}),
              Key("antithetic", kRender, &RenderOptions::antithetic) |
                  Doc("Draws paths in pairs with mirrored reflections: derivatives of glossy "
                      "surfaces by shape lose most of their noise, pictures gain nothing.")}) |
         Doc("How pictures and derivatives are computed.") | Always() |
         Refuse({{"pixel_filter", "; photos are means over pixels, write filter in scene.sensors"},
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
  return MapOf("loss",
               {Choice("residual",
                       {{"linear", ResidualKind::kLinear}, {"relative", ResidualKind::kRelative}},
                       &LossSpec::residual) |
                    Doc("Model minus photo, or that divided by photo + relative_floor.") |
                    Refuse({{"log", ""}, {"srgb", ""}}),
                Key("relative_floor", &LossSpec::relative_floor) |
                    Doc("Brightness below which `relative` acts like `linear`.") | Above(0.0) |
                    UselessWith("loss.residual", {"linear"}),
                Map("silhouette",
                    {Key("weight", &LossSpec::silhouette_weight) |
                     Doc("Of the masks against the colours.") | AtLeast(0.0)}) |
                    Doc("Coverage of the model against the masks.") | Always(),
                Either("robust",
                       {Word("none"),
                        Map("",
                            {Key("huber", &LossSpec::robust_huber) |
                             Doc("Residual of a pixel's colour (root of its channels' mean square) "
                                 "from which it counts by its size instead of its square, so that "
                                 "what the model cannot explain pulls no harder the worse it fits. "
                                 "Some times the photos' usual residual.") |
                             Above(0.0) | Required()}) |
                            Refuse({{"cauchy", "; write huber"}, {"tukey", "; write huber"}})}) |
                    Doc("What large residuals of colours count. A wrong mask pulls an outline by "
                        "no more than a right one does, however far it is off.") |
                    Default("none")},
               &ExperimentConfig::fit,
               &FitSpec::loss) |
         Doc("What is made small.") | Always();
}

SchemaNode GaugeSchema() {
  using optim::ColorGauge;
  const SchemaNode number = binding::Described<double>::Node() | Above(0.0);
  return MapOf("gauge",
               {Choice("rule",
                       {{"auto", ColorGauge::Rule::kAuto},
                        {"photos", ColorGauge::Rule::kPhotos},
                        {"mean_color", ColorGauge::Rule::kMeanColor}},
                       &ColorGauge::rule) |
                    Doc("`photos`: what they say, by highlights, light between surfaces or lights "
                        "that are seen. `mean_color`: the mean base colour is that of `mean`, "
                        "whatever photos say. `auto`: `mean_color` where photos say nothing at "
                        "all, else `photos`. Of matt surfaces under lights that are not seen, "
                        "`photos` say nothing, and the report says so."),
                Bound(Either("mean",
                             {SchemaNode(number) | Words({"start"}),
                              ListNode("", number) | Items(3, 3)}) |
                          Doc("Mean base colour, one number or one per channel, as that of a grey "
                              "card; `start`: that which the fit begins with."),
                      &ColorGauge::mean) |
                    Default("start"),
                Key("material", &ColorGauge::material) | Doc("Whose mean colour it is.") |
                    DefaultIs("all surfaces")},
               &ExperimentConfig::fit,
               &FitSpec::gauge) |
         Doc("What tells the scale that base colours and lights share where all of both are "
             "unknown; a colour that is known does, or a light in photos of known exposure. What "
             "it came to stands in the log, run.json and the report.") |
         Always();
}

SchemaNode SolverSchema() {
  return Map("solver",
             {Choice("linear_solver",
                     {{"auto", LinearSolverChoice::kAuto},
                      {"gram", LinearSolverChoice::kGram},
                      {"cholesky", LinearSolverChoice::kCholesky},
                      {"cgnr", LinearSolverChoice::kCgnr},
                      {"sparse_gram", LinearSolverChoice::kSparseGram}},
                     &ExperimentConfig::fit,
                     &FitSpec::linear_solver) |
                  Doc("`gram`: dense normal equations; `cholesky`, `cgnr`: a factor of, or "
                      "conjugate "
                      "gradients on, the rows of all photos collapsed; `sparse_gram`: conjugate "
                      "gradients on sparse normal equations, which take least. `auto`: `gram` up "
                      "to "
                      "500 unknown numbers, else `sparse_gram`.") |
                  Refuse({{"dense_qr", "; write gram"},
                          {"sparse_normal_cholesky", "; write cholesky"},
                          {"iterative", "; write cgnr"}}),
              Bytes("max_memory", &ExperimentConfig::max_memory_bytes) |
                  Doc("Refuse to start above this, as `16 GiB`; `auto`: above what the machine, a "
                      "control group or `ulimit -v` gives; `none`: never.") |
                  Words({"auto", "none"}) | Default("auto"),
              Key("threads", &ExperimentConfig::threads) |
                  Doc("`auto`: those the machine or job gives.") | From(1, 1024) |
                  OrWord("auto")}) |
         Doc("How the unknowns are found.") | Always() |
         Refuse({{"method", "; it is Ceres' Levenberg-Marquardt"}, {"uncertainty", ""}});
}

SchemaNode OutputSchema() {
  return MapOf("output",
               {Key("directory", &OutputConfig::directory) |
                    Doc("Made for each run; `{name}` and `{timestamp}` are replaced. Relative to "
                        "this file, like all paths."),
                Map("images",
                    {Key("every_stage", &OutputConfig::images_every_stage) |
                     Doc("Large pictures of held-out views after every stage, not only after the "
                         "last one.")}) |
                    Doc("Pictures of the run.") | Always() |
                    Refuse({{"every", "; write every_stage"}, {"views", ""}, {"kinds", ""}}),
                Key("report", &OutputConfig::report) | Doc("Write report.html.")},
               &ExperimentConfig::output) |
         Doc("What a run leaves behind.") | Always() |
         Refuse({{"mesh", "; glb and ply are always written"},
                 {"environment", "; exr and hdr are always written"},
                 {"checkpoint", "; one is written after every round"},
                 {"metrics", "; metrics.csv is always written"}});
}

SchemaNode GradcheckSchema() {
  constexpr auto kCheck = &GradcheckConfig::check;
  return MapOf("gradcheck",
               {Key("params", &GradcheckConfig::params) |
                    Doc("Names or patterns (`*`, `?`) of unknowns; empty = all."),
                Key("step", kCheck, &optim::GradientCheckOptions::step) |
                    Doc("Of the finite difference, in units of the parameter.") | Above(0.0),
                Key("spp", kCheck, &optim::GradientCheckOptions::render, &SampleBudget::spp) |
                    Doc("Samples per pixel of each replicate.") | From(1, 1 << 20),
                Key("replicates", kCheck, &optim::GradientCheckOptions::replicates) |
                    Doc("Independent renderings, for the error bars.") | From(2, 100000),
                Key("sigma", &GradcheckConfig::sigma) |
                    Doc("Differences beyond so many error bars fail.") | Above(0.0)},
               &ExperimentConfig::gradcheck) |
         Doc("Settings of `pathfit gradcheck`.") | Always();
}

SchemaNode UnknownsSchema() {
  const std::vector<Unsupported> elsewhere = {
      {"displacement", ""}, {"rigid", "; free MESH.translation and MESH.rotation"}};
  const SchemaNode parametrisation =
      Either(
          "parametrisation",
          {Word("vertices") | Refuse(elsewhere),
           Map("",
               {Map("large_steps",
                    {Key("lambda", &UnknownSpec::large_steps_lambda) | Doc("Strength; 0 = off.") |
                     AtLeast(0.0) | Default(binding::Write(optim::kDefaultLargeSteps))}) |
                Doc("Steps in the metric I + lambda L of the mesh: smooth changes come first.") |
                Required()}) |
               Refuse(elsewhere)}) |
      Doc("Vertices: how they move. `vertices`: each alone.") |
      DefaultIs(fmt::format("`large_steps` of lambda {}", optim::kDefaultLargeSteps));
  const SchemaNode form = ByCheck(binding::Make(SchemaNode::Type::kChoice, "") |
                                  Words({kSurfaceForms.begin(), kSurfaceForms.end()}));
  return NamedMap("unknowns",
                  "OBJECT.PROPERTY",
                  Map("",
                      {ByCheck(ListNode("bounds", binding::Described<double>::Node()) |
                               Doc("Lower and upper limit of each number.")) |
                           OrInfinite() | Items(2, 2) | DefaultIs("by kind, see below"),
                       Choice("transform",
                              {{"identity", optim::Parameterization::kIdentity},
                               {"log", optim::Parameterization::kLog}},
                              &UnknownSpec::parameterization) |
                           Doc("`log`: the logarithm is what the solver moves (never negative).") |
                           DefaultIs("by kind, see below"),
                       Key("hold", &UnknownSpec::hold) | Doc("Known to the program, never freed."),
                       ByCheck(Either("as", {form, ListNode("", form) | Items(1, 0)}) |
                               Doc("base_color, roughness and metallic of a material: what the "
                                   "numbers are. `texture`: from the first stage that frees it on, "
                                   "a texture named `MATERIAL_PROPERTY`, on UVs that are made if "
                                   "there are none, with texels as large as the photos' pixels. "
                                   "`vertices`: colours of the vertices. A list: one for each "
                                   "stage that frees it, the last for all further ones, as "
                                   "`[constant, texture]`. What was found before is carried "
                                   "over.")) |
                           DefaultIs("what the material says"),
                       parametrisation,
                       Choice("mesh",
                              {{"keep", optim::MeshDetail::kKeep},
                               {"levels", optim::MeshDetail::kLevels}},
                              &UnknownSpec::mesh_detail) |
                           Doc("Vertices. `levels`: every stage that frees them begins with a mesh "
                               "of the same surface whose edges are some pixels long, coarser or "
                               "finer than the one before. Meshes with borders or with given "
                               "textures on them stay as they are; the log says which.") |
                           DefaultIs("`levels`, but `keep` for files with UVs"),
                       ByCheck(binding::Make(SchemaNode::Type::kBool, "shared") |
                               Doc("What `camera.` has, of all photos. `true`: pictures of one "
                                   "size that begin with the same lens have one lens (focal, "
                                   "principal_point, distortion, tangential, vignetting), those of "
                                   "one camera that stood still its place, too. `false`: each has "
                                   "its own.")) |
                           DefaultIs("`true` where that can be"),
                       ListNode("priors", PriorSchema()) | Doc("What is believed beforehand.") |
                           DefaultIs(fmt::format(
                               "`laplacian` of weight {} for vertices, `smooth` of weight {} for "
                               "vertex colours, `total_variation` of weight {} for what is `as: "
                               "texture` ({} for roughness), "
                               "`log_smooth` of weight {} for the texels of an envmap, else none",
                               optim::kDefaultLaplacian,
                               optim::kDefaultColorSmooth,
                               optim::kDefaultTexelVariation,
                               optim::kDefaultRoughnessVariation,
                               optim::kDefaultLogSmooth))}),
                  &ExperimentConfig::fit,
                  &FitSpec::unknowns) |
         Doc("What may move, how, and between which limits. Names: see \"Kinds of unknowns\" "
             "below.") |
         FreeNames();
}

SchemaNode StagesSchema() {
  constexpr double kMost = 65536;
  constexpr auto kSamples = &StageSpec::samples;
  return ListOf(
             "stages",
             Map("",
                 {Name("name", &StageSpec::name) | Doc("Different for every stage.") | Required(),
                  ByCheck(
                      Either("free", {Word("all"), ListNode("", TextNode("")) | Items(1, 0)}) |
                      Doc("Names of the unknowns that move; `all`: those without `hold: true`.")) |
                      Required(),
                  Key("image_scale", &StageSpec::image_scale) |
                      Doc("Size of the photos in this stage, at its end if `coarse_to_fine`.") |
                      From(0.01, 1.0),
                  Key("coarse_to_fine", &StageSpec::coarse_to_fine) |
                      Doc("Whether a stage in which something moves, or that makes a texture, "
                          "begins with photos of some 8 to 32 pixels and doubles them up to "
                          "`image_scale`, each size until its steps move nothing any more: what "
                          "starts far off is then found, too. Lights and the like begin with small "
                          "photos as well; if the next stage frees all of them again, and begins "
                          "small, they also end there."),
                  Key("max_rounds", &StageSpec::max_rounds) |
                      Doc("Solves at most, each with new samples; a stage ends by itself.") |
                      From(1, 10000),
                  Key("spp", kSamples, &StageBudget::spp) |
                      Doc("Samples per pixel in the first round, of both halves together. Unless "
                          "given, 8, and fewer where few unknowns are seen by more than some "
                          "50 000 pixels.") |
                      From(2, kMost),
                  Key("max_spp", &StageSpec::max_spp) |
                      Doc(fmt::format("Samples per pixel that no round passes. A stage of many "
                                      "unknowns ends after {} rounds that would have needed more, "
                                      "unless stop.relative_cost is 0.",
                                      optim::kRoundsShortOfSamples)) |
                      From(2, kMost),
                  Key("spp_growth", &StageSpec::spp_growth) |
                      Doc("Factor of spp from one round to the next that needs more: in stages of "
                          "few unknowns until errors are small, where something moves after a "
                          "step within its error; in those of many after a step that lowers the "
                          "cost by less than the noise.") |
                      From(1.0, 10.0),
                  Key("sppe", kSamples, &StageBudget::sppe) |
                      Doc("Samples of silhouettes, borders and creases, per pixel of their length, "
                          "in the first round; grows as spp does. Found from measured variances, "
                          "as are "
                          "the three below, unless given.") |
                      From(0.0, kMost),
                  Key("spp_direct", kSamples, &StageBudget::spp_direct) |
                      Doc("Samples per pixel of edges that throw shadows.") | From(0.0, kMost),
                  Key("spp_indirect", kSamples, &StageBudget::spp_indirect) |
                      Doc("Samples per pixel of edges between two surfaces.") | From(0.0, kMost),
                  Key("spp_pixel", kSamples, &StageBudget::spp_pixel) |
                      Doc("Samples per pixel of pixel borders; only with `form: material` in "
                          "`render`.") |
                      From(0.0, kMost) | UselessWith("render.form", {"auto", "image"}),
                  Map("stop",
                      {Key("relative_cost", &StageSpec::stop_relative_cost) |
                       Doc("More than 500 unknowns: end when three rounds lower the mean cost of "
                           "fitted or of held-out photos by less than this share; 0 = never. Fewer "
                           "end when their steps are within their error, which is small or has "
                           "been so for twelve rounds, and, where nothing moves, when steps lower "
                           "the cost by less than this; 0 = by small errors alone.") |
                       From(0.0, 1.0)}) |
                      Doc("When to end before max_rounds.") | Always() |
                      Refuse({{"gradient", ""}, {"patience", ""}})}) |
                 Refuse({{"max_iterations", "; write max_rounds"},
                         {"views_per_step", "; every round sees all photos"},
                         {"remesh", ""},
                         {"schedule", ""},
                         {"promote", ""}}) |
                 Check(CheckStage),
             &ExperimentConfig::fit,
             &FitSpec::stages) |
         Doc("Steps of the fit, in this order; each starts from the result before it.");
}

}  // namespace pathfit::app
