// Unknowns are looked up in the scene that was built; what is wrong keeps its place in the file.
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/experiment/experiment.h"
#include "tests/app/config/config_text.h"

namespace pathfit::app::read_unknowns_test {
namespace {

using optim::Parameterization;
using renderer::ParameterKind;

/// Something of every kind; the unknowns begin on line 38.
const char* const kScene = R"(schema: 1
scene:
  geometry:
    floor: {primitive: {rectangle: {}}, material: wood}
    pane: {primitive: {disk: {segments: 12}}, material: clear}
    tri:
      mesh:
        vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        triangles: [[0, 1, 2]]
        normals: [[0, 0, 1], [0, 0, 2], [1, 0, 1]]
        uvs: [[0, 0], [1, 0], [0, 1]]
      material: chrome
    bulb: {primitive: {sphere: {subdivisions: 1}}, material: wall}
    mug: {primitive: {sphere: {subdivisions: 1}}, material: glaze}
  materials:
    wood: {model: metallic_roughness, base_color: {texture: oak}, roughness: {texture: worn}, metallic: {constant: 0.1}}
    glaze: {model: metallic_roughness, base_color: {vertex: [0.5, 0.4, 0.3]}, roughness: {constant: 0.4}}
    wall: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}
    brass: {model: conductor, metal: copper, roughness: {constant: 0.3}}
    chrome: {model: mirror, metal: chromium}
    plain: {model: mirror}
    clear: {model: glass}
  textures:
    oak: {size_px: [4, 4], init: {constant: [0.5, 0.4, 0.3]}}
    worn: {size_px: [8, 4], init: {constant: 0.4}}
    slide: {size_px: [4, 2], init: {constant: [3, 2, 1]}}
    spare: {size_px: [4, 2], init: {constant: [0.1, 0.2, 0.3]}}
  lights:
    room: {type: envmap, size_px: [16, 8]}
    lamp: {type: spot, position_m: [0, 2, 0], target_m: [0, 0, 0], outer_deg: 40, intensity: [9, 8, 7]}
    beamer: {type: projector, position_m: [0, 0, 3], target_m: [0, 0, 0], fov_deg: 30, texture: slide}
    glow: {type: area, mesh: bulb, radiance: [3, 3, 3]}
  sensors:
    front: {size_px: [64, 32], fov_deg: 90, pose: {look_at: {origin_m: [0, 1, 3], target_m: [0, 0, 0]}}}
    plan: {type: orthographic, size_px: [40, 20], height_m: 5, pose: {look_at: {origin_m: [0, 9, 0], target_m: [0, 0, 0], up: [0, 0, -1]}}}
render: {spp: 16}
unknowns:
  floor.uvs: {}
)";

Experiment Build(const std::string& text, const std::vector<std::string>& sets = {}) {
  const ConfigFile file(text);
  return BuildExperiment(LoadExperimentConfig(file.path(), Sets(sets)));
}

/// All of them joined by newlines; empty if accepted.
std::string ProblemOf(const std::string& text, const std::vector<std::string>& sets = {}) {
  const ConfigFile file(text);
  try {
    BuildExperiment(LoadExperimentConfig(file.path(), Sets(sets)));
    return {};
  } catch (const ConfigError& error) {
    std::string out;
    for (const std::string& line : ProblemsIn(error, file)) out += (out.empty() ? "" : "\n") + line;
    return out;
  }
}

/// The scene with these lines in place of its unknown.
std::string With(const std::string& unknowns) {
  return Replaced(kScene, "  floor.uvs: {}", "  " + unknowns);
}

optim::UnknownSpec Only(const std::string& name, const std::string& settings = "{}") {
  return Build(With(name + ": " + settings)).fit.unknowns.at(0);
}

TEST(ReadUnknowns, DefaultsFollowTheUse) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto expect = [&](const char* name, double lower, double upper, bool log) {
    const optim::UnknownSpec unknown = Only(name);
    EXPECT_EQ(unknown.name, name);
    EXPECT_DOUBLE_EQ(unknown.lower, lower) << name;
    EXPECT_DOUBLE_EQ(unknown.upper, upper) << name;
    EXPECT_EQ(unknown.parameterization == Parameterization::kLog, log) << name;
  };
  expect("oak.texels", 0.01, 0.99, false);
  expect("worn.texels", 0.03, 1.0, false);
  expect("slide.texels", 1e-4, infinity, true);
  expect("brass.eta", 0.02, 20.0, true);
  expect("clear.eta", 1.01, 3.0, true);
  expect("bulb.scale", 1e-3, infinity, true);
  expect("bulb.rotation", -infinity, infinity, false);
  expect("lamp.position", -infinity, infinity, false);
  expect("mug.vertices", -infinity, infinity, false);
  expect("mug.colors", 0.01, 0.99, false);
  expect("wall.base_color", 0.01, 0.99, false);
  expect("glaze.roughness", 0.03, 1.0, false);
  expect("glaze.specular", 0.0, 1.0, false);
  expect("room.texels", 1e-4, infinity, true);
  expect("front.focal", 1.0, infinity, false);
}

TEST(ReadUnknowns, PatternsNameAllThatFit) {
  const Unknowns unknowns = ReadUnknowns(
      LoadText(kFitConfig,
               {"unknowns={'*.position': {bounds: [-1, 1]}, mug.vertices: {}, 'b*.intensity': {}}",
                "stages=[]"}),
      Build(kScene).scene);
  std::vector<std::string> names;
  for (const optim::UnknownSpec& unknown : unknowns.specs) names.push_back(unknown.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{"lamp.position",
                                      "mug.vertices",
                                      "beamer.intensity",
                                      "beamer.position",
                                      "front.position",
                                      "plan.position"}));
  EXPECT_EQ(unknowns.of_config,
            (std::vector<std::vector<std::vector<int>>>{{{0, 3, 4, 5}}, {{1}}, {{2}}}));
  EXPECT_EQ(unknowns.specs[5].lower, -1.0) << "what is written is that of each";
  const auto resolved = [](const char* pattern) {
    return ResolvedYaml(
        LoadText(kFitConfig, {std::string("unknowns={'") + pattern + "': {}}", "stages=[]"}),
        Build(kScene).scene);
  };
  EXPECT_NE(resolved("l*.intensity").find("bounds: [0.0001, .inf]"), std::string::npos);
  EXPECT_EQ(resolved("*.texels").find("bounds:"), std::string::npos)
      << "each has its own, which it must have again when the fit continues";
  EXPECT_EQ(ProblemOf(kScene, {"unknowns={'l*.intensity': {}, lamp.intensity: {}}"}),
            "--set #1: unknowns: 'lamp.intensity' is that of 'l*.intensity' and of "
            "'lamp.intensity'");
  EXPECT_EQ(ProblemOf(kScene, {"unknowns={'x*.intensity': {}}"}),
            "--set #1: unknowns: no light is called 'x*' (known: room, lamp, beamer, glow)");
  EXPECT_EQ(ProblemOf(kScene, {"unknowns={'*.position': {bounds: [1, -1]}}"}),
            "--set #1: unknowns.*.position.bounds: lower bound 1 is above upper bound -1");
}

TEST(ReadUnknowns, ReadsWhatIsWritten) {
  EXPECT_EQ(Only("camera.position").object, -1);
  EXPECT_EQ(Only("plan.position").object, 1);
  EXPECT_EQ(Only("exposure").kind, ParameterKind::kExposure);
  EXPECT_EQ(Only("white_balance").kind, ParameterKind::kWhiteBalance);
  EXPECT_TRUE(Only("glaze.metallic", "{hold: true}").hold);
  const optim::UnknownSpec mug =
      Only("mug.vertices",
           "{parametrisation: {large_steps: {lambda: 3}}, priors: [{laplacian: {weight: 1e-2}}]}");
  EXPECT_DOUBLE_EQ(mug.large_steps_lambda, 3.0);
  EXPECT_DOUBLE_EQ(mug.laplacian_weight, 1e-2);
  const optim::UnknownSpec room = Only(
      "room.texels",
      "{bounds: [0, 7], transform: identity, priors: [{smooth: {weight: 2}}, {neutral: {weight: "
      "3}}]}");
  EXPECT_EQ(room.lower, 0.0);
  EXPECT_EQ(room.upper, 7.0);
  EXPECT_EQ(room.parameterization, Parameterization::kIdentity);
  EXPECT_EQ(room.smooth_weight, 2.0);
  EXPECT_EQ(room.neutral_weight, 3.0);
  for (const char* texels : {"oak.texels", "worn.texels", "slide.texels", "room.texels"}) {
    const optim::UnknownSpec flat = Only(texels, "{priors: [{total_variation: {weight: 0.5}}]}");
    EXPECT_EQ(flat.total_variation_weight, 0.5) << texels;
    EXPECT_EQ(flat.smooth_weight, 0.0) << texels;
  }
  const optim::UnknownSpec wall =
      Only("wall.base_color", "{priors: [{gaussian: {mean: [0.2, 0.3, 0.4], sigma: 0.1}}]}");
  ASSERT_TRUE(wall.gaussian);
  EXPECT_EQ(wall.gaussian->mean, (std::vector<double>{0.2, 0.3, 0.4}));
  EXPECT_EQ(wall.gaussian->sigma, 0.1);
}

TEST(ReadUnknowns, VerticesHaveAMetricAndAPriorUnlessTheConfigSaysOtherwise) {
  const optim::UnknownSpec mug = Only("mug.vertices");
  EXPECT_EQ(mug.large_steps_lambda, optim::kDefaultLargeSteps);
  EXPECT_EQ(mug.laplacian_weight, optim::kDefaultLaplacian);
  const optim::UnknownSpec alone = Only("mug.vertices", "{parametrisation: vertices, priors: []}");
  EXPECT_EQ(alone.large_steps_lambda, 0.0);
  EXPECT_EQ(alone.laplacian_weight, 0.0);
  EXPECT_EQ(Only("mug.colors").laplacian_weight, 0.0);
}

TEST(ReadUnknowns, NeighboursInAMapOfTheSurroundingsAreAlikeUnlessTheConfigSaysOtherwise) {
  EXPECT_EQ(Only("room.texels").log_smooth_weight, optim::kDefaultLogSmooth);
  EXPECT_EQ(Only("room.texels", "{priors: []}").log_smooth_weight, 0.0);
  EXPECT_EQ(Only("room.texels", "{transform: identity}").log_smooth_weight, 0.0);
  EXPECT_EQ(Only("room.texels", "{priors: [{log_smooth: {weight: 4}}]}").log_smooth_weight, 4.0);
  EXPECT_EQ(Only("slide.texels").log_smooth_weight, 0.0);
  const std::string problem =
      ProblemOf(With("room.texels: {transform: identity, priors: [{log_smooth: {weight: 4}}]}"));
  EXPECT_NE(problem.find("prior 'log_smooth' needs transform: log"), std::string::npos) << problem;
}

TEST(ReadUnknowns, TheResolvedCopyHoldsWhatIsUsedAndIsReadAlike) {
  std::string all;
  for (const char* name :
       {"floor.uvs",       "tri.normals",      "mug.vertices",    "mug.colors",      "bulb.scale",
        "bulb.rotation",   "wall.base_color",  "glaze.roughness", "glaze.metallic",  "brass.eta",
        "clear.eta",       "chrome.k",         "oak.texels",      "worn.texels",     "slide.texels",
        "room.texels",     "lamp.intensity",   "lamp.angles",     "beamer.position", "exposure",
        "camera.position", "front.distortion", "camera.focal"}) {
    all += std::string(all.empty() ? "" : "\n  ") + name + ": {}";
  }
  const ConfigFile file(
      Replaced(Replaced(With(all), "bulb.scale: {}", "bulb.scale: {bounds: [0.5, .inf]}"),
               "room.texels: {}",
               "room.texels: {transform: identity}"));
  const ExperimentConfig config = LoadExperimentConfig(file.path(), {});
  const Experiment first = BuildExperiment(config);
  const std::string yaml = ResolvedYaml(config, first.scene);
  const auto expect = [&](const std::string& name, const std::string& lines) {
    const std::size_t at = yaml.find("\n  " + name + ":");
    ASSERT_NE(at, std::string::npos) << name;
    EXPECT_EQ(yaml.compare(yaml.find("bounds", at), lines.size(), lines), 0)
        << yaml.substr(at, 200);
  };
  expect("mug.colors", "bounds: [0.01, 0.99]  # default\n    transform: identity  # default\n");
  expect("slide.texels", "bounds: [0.0001, .inf]  # default\n    transform: log  # default\n");
  expect("bulb.scale", "bounds: [0.5, .inf]  # test.yaml:");
  EXPECT_NE(yaml.find("lambda: 19  # default\n"), std::string::npos) << yaml;

  const ConfigFile copy(yaml);
  const ExperimentConfig again = LoadExperimentConfig(copy.path(), {});
  const Experiment second = BuildExperiment(again);
  ASSERT_EQ(second.fit.unknowns.size(), first.fit.unknowns.size());
  for (std::size_t i = 0; i < first.fit.unknowns.size(); ++i) {
    const optim::UnknownSpec& a = first.fit.unknowns[i];
    const optim::UnknownSpec& b = second.fit.unknowns[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.lower, b.lower) << a.name;
    EXPECT_EQ(a.upper, b.upper) << a.name;
    EXPECT_EQ(a.parameterization, b.parameterization) << a.name;
    EXPECT_EQ(a.hold, b.hold) << a.name;
    EXPECT_EQ(a.large_steps_lambda, b.large_steps_lambda) << a.name;
    EXPECT_EQ(a.laplacian_weight, b.laplacian_weight) << a.name;
  }
  EXPECT_EQ(ResolvedYaml(again, second.scene).find("# default"), std::string::npos)
      << "every value is written in the copy";
  EXPECT_EQ(ResolvedYaml(LoadText(kSceneConfig), first.scene).find("bounds"), std::string::npos);
}

TEST(ReadUnknowns, WhatChangesItsFormIsOneUnknownForEach) {
  const Experiment built =
      Build(With("wall.base_color: {as: [constant, vertices, texture]}\n"
                 "  glaze.base_color: {as: texture, bounds: [0.1, 0.8]}\n"
                 "  glaze.roughness: {as: texture, priors: [{smooth: {weight: 0.1}}]}"));
  const std::vector<optim::UnknownSpec>& unknowns = built.fit.unknowns;
  ASSERT_EQ(unknowns.size(), 5U);
  EXPECT_EQ(unknowns[0].name, "wall.base_color");
  EXPECT_EQ(unknowns[0].kind, ParameterKind::kBaseColor);
  EXPECT_FALSE(unknowns[0].promotion.has_value());
  EXPECT_EQ(unknowns[3].name, "bulb.colors") << "the mesh that is made of it";
  EXPECT_EQ(unknowns[3].kind, ParameterKind::kVertexColors);
  EXPECT_EQ(unknowns[4].name, "wall_base_color.texels");
  EXPECT_EQ(unknowns[4].total_variation_weight, optim::kDefaultTexelVariation);
  ASSERT_TRUE(unknowns[1].promotion.has_value());
  EXPECT_EQ(unknowns[1].name, "glaze_base_color.texels");
  EXPECT_EQ(unknowns[1].lower, 0.1);
  EXPECT_EQ(unknowns[1].upper, 0.8);
  EXPECT_EQ(unknowns[2].promotion->property, ParameterKind::kRoughness);
  EXPECT_EQ(unknowns[2].smooth_weight, 0.1);
  EXPECT_EQ(unknowns[2].total_variation_weight, 0.0) << "priors of its own";
  const auto& textures = built.scene.textures;
  ASSERT_EQ(textures.size(), 7U);
  EXPECT_EQ(textures[6].name, "glaze_roughness");
  EXPECT_TRUE(textures[6].scalar);
  EXPECT_EQ(unknowns[2].object, 6);
}

TEST(ReadUnknowns, TexelsOfRoughnessAreBelievedToBeSmoother) {
  const ExperimentConfig config =
      LoadText(With("glaze.base_color: {as: texture}\n  glaze.roughness: {as: texture}"));
  const Experiment built = BuildExperiment(config);
  ASSERT_EQ(built.fit.unknowns.size(), 2U);
  EXPECT_EQ(built.fit.unknowns[0].total_variation_weight, optim::kDefaultTexelVariation);
  EXPECT_EQ(built.fit.unknowns[1].total_variation_weight, optim::kDefaultRoughnessVariation);
  EXPECT_GT(optim::kDefaultRoughnessVariation, optim::kDefaultTexelVariation);
  const std::string shown = ResolvedYaml(config, built.scene);
  EXPECT_NE(shown.find(fmt::format("weight: {}", optim::kDefaultTexelVariation)), std::string::npos)
      << shown;
  EXPECT_NE(shown.find(fmt::format("weight: {}", optim::kDefaultRoughnessVariation)),
            std::string::npos)
      << shown;
}

TEST(ReadUnknowns, MistakesOfFormsAreSaidAtTheirPlace) {
  const auto expect = [](const std::string& unknown, const std::string& said) {
    const std::string problem = ProblemOf(With(unknown));
    EXPECT_NE(problem.find(said), std::string::npos) << unknown << ": " << problem;
    EXPECT_NE(problem.find("38:"), std::string::npos) << problem;
  };
  expect("mug.colors: {as: texture}", "'mug.colors' cannot have `as`");
  expect("wal.base_color: {as: texture}", "no material is called 'wal' (did you mean 'wall'?)");
  expect("wood.base_color: {as: texture}", "is a texture already; write oak.texels");
  expect("glaze.roughness: {as: vertices}", "only base_color can be per vertex");
  expect("glaze.base_color: {as: constant}", "per vertex already");
  expect("plain.base_color: {as: texture}", "no mesh is made of 'plain'");
  expect("wall.base_color: {as: [texture, vertices]}", "'vertices' cannot follow 'texture'");
  expect("wall.base_color: {as: picture}", "'picture'");
  expect("wall.base_color: {as: texture, priors: [{laplacian: {weight: 1}}]}",
         "prior 'laplacian' does not fit base_color");
  expect("wall.base_color: {as: texture, priors: [{gaussian: {mean: start, sigma: 1}}]}",
         "give a mean");
  expect("wall.metallic: {as: texture}", "metallic_roughness");
}

TEST(ReadUnknowns, PhotosOfOneSizeAndLensHaveOne) {
  renderer::Scene scene = Build(kScene).scene;
  scene.sensors.resize(1);
  scene.sensors.resize(4, scene.sensors[0]);
  for (std::size_t i = 1; i < 4; ++i) scene.sensors[i].name += std::to_string(i);
  scene.sensors[2].width += 1;
  const auto read = [&](const std::string& unknowns) {
    return ReadUnknowns(LoadText(kFitConfig, {"unknowns=" + unknowns, "stages=[]"}), scene).specs;
  };
  for (const char* property :
       {"focal", "principal_point", "distortion", "tangential", "vignetting"}) {
    const std::string name = std::string("camera.") + property;
    EXPECT_EQ(read("{" + name + ": {}}")[0].sharing, (std::vector<int>{0, 0, 2, 0})) << name;
    EXPECT_EQ(read("{" + name + ": {shared: true}}")[0].sharing.size(), 4U) << name;
    EXPECT_TRUE(read("{" + name + ": {shared: false}}")[0].sharing.empty()) << name;
  }
  for (const char* name : {"camera.position", "camera.rotation", "front.focal"}) {
    EXPECT_TRUE(read("{" + std::string(name) + ": {}}")[0].sharing.empty()) << name;
  }
  EXPECT_NE(ResolvedYaml(LoadText(kFitConfig, {"unknowns={camera.focal: {}}", "stages=[]"}), scene)
                .find("shared: true  # default"),
            std::string::npos);
  EXPECT_EQ(ProblemOf(kScene, {"unknowns={camera.position: {shared: true}}"}),
            "--set #1: unknowns.camera.position.shared: the photos have no position in common");
  EXPECT_EQ(ProblemOf(kScene, {"unknowns={front.focal: {shared: true}}"}),
            "--set #1: unknowns.front.focal.shared: this is that of one photo alone; write "
            "camera.focal");
  EXPECT_EQ(ProblemOf(kScene, {"unknowns={mug.vertices: {shared: false}}"}),
            "--set #1: unknowns.mug.vertices.shared: only photos share what their camera has, not "
            "vertices");
}

// Sensors are then called as the photos.
TEST(ReadUnknowns, KnowsPhotosAndTheirExposures) {
  renderer::Scene scene = Build(kScene).scene;
  scene.sensors[0].name = "IMG_1.JPG";
  const auto read = [&](const std::string& unknowns, const std::string& model) {
    return ReadUnknowns(
               LoadText(kFitConfig,
                        {"unknowns=" + unknowns, "stages=[]", "input.exposure.model=" + model}),
               scene)
        .specs;
  };
  const auto unknowns = read("{IMG_1.JPG.position: {}, exposure: {}}", "gain");
  ASSERT_EQ(unknowns.size(), 2U);
  EXPECT_EQ(unknowns[0].kind, ParameterKind::kCameraPosition);
  EXPECT_EQ(unknowns[0].object, 0);
  EXPECT_EQ(unknowns[1].kind, ParameterKind::kExposure);
  EXPECT_EQ(read("{white_balance: {}}", "gain_rgb")[0].kind, ParameterKind::kWhiteBalance);
  const auto refuses = [&](const std::string& unknown, const char* model, const char* needed) {
    try {
      read("{" + unknown + ": {}}", model);
      FAIL() << "not refused";
    } catch (const ConfigError& error) {
      const std::string said = "unknowns: '" + unknown + "' needs input.exposure.model: " + needed;
      EXPECT_NE(std::string(error.what()).find(said), std::string::npos) << error.what();
    }
  };
  refuses("exposure", "none", "gain");
  refuses("white_balance", "gain", "gain_rgb");
}

TEST(ReadUnknowns, NamesMustFitTheScene) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"wood.base_color", "'wood.base_color' is a texture; write oak.texels"},
      {"wood.roughness", "'wood.roughness' is a texture; write worn.texels"},
      {"glaze.base_color",
       "'glaze.base_color' needs base_color: {constant: …}; this one is per vertex, write "
       "MESH.colors"},
      {"wall.eta", "'wall.eta' needs a material of model conductor, mirror, dielectric or glass"},
      {"wall.roughness",
       "'wall.roughness' needs a material of model metallic_roughness, conductor or dielectric"},
      {"plain.eta", "'plain.eta' needs a mirror with metal, or eta and k"},
      {"spare.texels", "'spare.texels' is used by no material and no light"},
      {"glow.position", "'glow.position' needs a light of type point, spot or projector"},
      {"lamp.texels", "'lamp.texels' needs a light of type envmap; write lamp.intensity"},
      {"lamp.angels", "nothing in the scene is called 'lamp.angels' (did you mean 'lamp.angles'?)"},
      {"room.radiance",
       "nothing in the scene is called 'room.radiance' (known: room.intensity, room.rotation, "
       "room.texels)"},
      {"plan.distortion", "'plan.distortion' needs a perspective sensor"},
      {"camera.distortion", "'camera.distortion' needs a perspective sensor"},
      {"fornt.position", "no light or sensor is called 'fornt' (did you mean 'front'?)"},
      {"front.exposure", "'front.exposure' is not known here; write exposure, for all sensors"},
      {"slid.texels", "no texture or light is called 'slid' (did you mean 'slide'?)"},
      {"mgu.colors", "no mesh is called 'mgu' (did you mean 'mug'?)"},
      {"mug.normals", "'mug.normals' needs a mesh with normals"},
      {"bulb.colors",
       "'bulb.colors' needs a material with base_color: {vertex: …}; 'wall' has one colour "
       "everywhere"},
      {"floor.colors",
       "'floor.colors' needs a material with base_color: {vertex: …}; 'wood' has a texture"},
  };
  for (const auto& [name, expected] : cases) {
    EXPECT_EQ(ProblemOf(With(name + ": {}")), "38:3: unknowns: " + expected) << name;
  }
  EXPECT_EQ(ProblemOf(Replaced(With("front.position: {}"), "    plan: {", "    lamp: {")), "");
  EXPECT_EQ(ProblemOf(Replaced(With("lamp.position: {}"), "    plan: {", "    lamp: {")),
            "38:3: unknowns: 'lamp.position' could be that of a light or of a sensor; give them "
            "different names");
  const std::string constant =
      Replaced(kScene, "room: {type: envmap, size_px: [16, 8]}", "room: {type: constant}");
  EXPECT_EQ(ProblemOf(Replaced(constant, "floor.uvs", "room.rotation")),
            "38:3: unknowns: 'room.rotation' needs a light of type envmap, directional, spot or "
            "projector");
  EXPECT_EQ(ProblemOf(Replaced(constant, "floor.uvs", "room.texels")),
            "38:3: unknowns: 'room.texels' needs a light of type envmap; write room.intensity");
}

TEST(ReadUnknowns, SettingsMustFitTheKindAndAreListedTogether) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"glaze.roughness: {bounds: [0.02, 1]}",
       "38:30: unknowns.glaze.roughness.bounds: 0.02 is out of range (allowed: from 0.03 to 1)"},
      {"clear.eta: {bounds: [0.5, 2]}",
       "38:24: unknowns.clear.eta.bounds: 0.5 is out of range (allowed: at least 1.001)"},
      {"mug.colors: {bounds: [0.5, 0.5]}",
       "38:24: unknowns.mug.colors.bounds: both bounds are 0.5; to keep a value, write hold: true"},
      {"mug.colors: {bounds: [0.95, 0.02]}",
       "38:24: unknowns.mug.colors.bounds: lower bound 0.95 is above upper bound 0.02"},
      {"mug.vertices: {bounds: [-1, 1]}",
       "38:26: unknowns.mug.vertices.bounds: bounds of vertices are not supported"},
      {"exposure: {bounds: [-1, 1]}",
       "38:22: unknowns.exposure.bounds: bounds of exposure are not supported; write "
       "input.exposure.max_ev"},
      {"mug.vertices: {transform: log}",
       "38:29: unknowns.mug.vertices.transform: log does not fit vertices"},
      {"lamp.position: {transform: log}",
       "38:30: unknowns.lamp.position.transform: log does not fit position"},
      {"mug.colors: {parametrisation: vertices}",
       "38:33: unknowns.mug.colors.parametrisation: only vertices have one, not colors"},
      {"glaze.roughness: {priors: [{laplacian: {weight: 1}}]}",
       "38:31: unknowns.glaze.roughness.priors[0]: prior 'laplacian' does not fit roughness "
       "(allowed: gaussian)"},
      {"mug.colors: {priors: [{total_variation: {weight: 1}}]}",
       "38:26: unknowns.mug.colors.priors[0]: prior 'total_variation' does not fit colors "
       "(allowed: smooth)"},
      {"mug.vertices: {priors: [{laplacian: {weight: 1}}, {laplacian: {weight: 1}}]}",
       "38:54: unknowns.mug.vertices.priors[1]: prior 'laplacian' is given twice"},
      {"glaze.roughness: {priors: [{gaussian: {mean: [1, 1, 1], sigma: 1}}]}",
       "38:48: unknowns.glaze.roughness.priors[0].gaussian.mean: roughness is one number"},
      {"wall.base_color: {priors: [{gaussian: {mean: [1, 1], sigma: 1}}]}",
       "38:48: unknowns.wall.base_color.priors[0].gaussian.mean: base_color has 3 numbers, not 2"},
      {"mug.color: {}\n  oak.texels: {bounds: [-1, 1]}\n  wall.k: {}",
       "38:3: unknowns: nothing in the scene is called 'mug.color' (did you mean 'mug.colors'?)\n"
       "39:25: unknowns.oak.texels.bounds: -1 is out of range (allowed: from 0 to 1)\n"
       "40:3: unknowns: 'wall.k' needs a material of model conductor or mirror"},
  };
  for (const auto& [text, expected] : cases) EXPECT_EQ(ProblemOf(With(text)), expected) << text;
  EXPECT_EQ(ProblemOf(kScene, {"unknowns={oak.texel: {}}"}),
            "--set #1: unknowns: nothing in the scene is called 'oak.texel' (did you mean "
            "'oak.texels'?)");
}

}  // namespace
}  // namespace pathfit::app::read_unknowns_test
