#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/app/config/config_text.h"

namespace pathfit::app::config_mistakes_test {
namespace {

using Cases = std::vector<std::pair<std::string, std::string>>;

// Each case is one override and the message behind "--set #1: ".
void ExpectProblems(const char* text, const Cases& cases) {
  for (const auto& [assignment, expected] : cases) {
    EXPECT_EQ(ProblemOf(text, {assignment}), "--set #1: " + expected) << assignment;
  }
}

TEST(ConfigMistakes, ScalarsAreReadStrictly) {
  ExpectProblems(
      kFitConfig,
      {{"stages.all.spp=\"8\"", "stages[1].spp: \"8\" is text, because it is in quotes; write 8"},
       {"stages.all.spp='x'",
        "stages[1].spp: \"x\" is text, because it is in quotes; a whole number is needed"},
       {"stages.all.spp=012", "stages[1].spp: '012' has a leading zero; write 12"},
       {"stages.all.spp=8.5", "stages[1].spp: '8.5' is not a whole number"},
       {"stages.all.spp=0x10", "stages[1].spp: '0x10' is not a whole number"},
       {"stages.all.spp=99999999999999999999",
        "stages[1].spp: '99999999999999999999' has too many digits"},
       {"stages.all.sppe=1,5", "stages[1].sppe: '1,5' is not a number; write 1.5"},
       {"stages.all.sppe=.nan", "stages[1].sppe: NaN is not allowed"},
       {"stages.all.sppe=nan", "stages[1].sppe: NaN is not allowed"},
       {"stages.all.sppe=.inf",
        "stages[1].sppe: '.inf' is not allowed here; a finite number is needed"},
       {"stages.all.sppe=1e999", "stages[1].sppe: '1e999' does not fit a double-precision number"},
       {"stages.all.sppe=-007.5", "stages[1].sppe: '-007.5' has a leading zero; write -7.5"},
       {"stages.all.sppe=[1]", "stages[1].sppe: a number from 0 to 65536 is needed, not a list"},
       {"stages.all.sppe=null", "stages[1].sppe: a number from 0 to 65536 is needed, not nothing"},
       {"unknowns.lamp.intensity.bounds=[0, inf]",
        "unknowns.lamp.intensity.bounds[1]: 'inf' is not a number; write .inf"},
       {"output.report=yes", "output.report: 'yes' is not a boolean here; write true"},
       {"output.report=off", "output.report: 'off' is not a boolean here; write false"},
       {"output.report=True", "output.report: 'True' is not a boolean here; write true"},
       {"output.report=\"true\"", "output.report: \"true\" is not a boolean here; write true"},
       {"output.report=maybe", "output.report: 'maybe' is not a boolean; write true or false"},
       {"solver.max_memory=16",
        "solver.max_memory: '16' is not a size; write a number and a unit, as 16 GiB or 500 MiB"},
       {"solver.threads=many",
        "solver.threads: 'many' is not a whole number (allowed: a whole number from 1 to 1024, or "
        "auto)"},
       {"name=a/b", "name: 'a/b' may hold only letters, digits, '_' and '-'"},
       {"input.images=''", "input.images: a path is needed, not empty text"}});
}

TEST(ConfigMistakes, RangesAndChoicesSayWhatIsAllowed) {
  ExpectProblems(
      kFitConfig,
      {{"schema=2", "schema: 2 is out of range (allowed: a whole number equal to 1)"},
       {"render.max_bounces=-1",
        "render.max_bounces: -1 is out of range (allowed: a whole number from 0 to 64)"},
       {"loss.relative_floor=0",
        "loss.relative_floor: 0 is out of range (allowed: a number above 0)"},
       {"loss.silhouette.weight=-1",
        "loss.silhouette.weight: -1 is out of range (allowed: a number of at least 0)"},
       {"scene.materials.glaze.roughness.constant=0.02",
        "scene.materials.glaze.roughness.constant: 0.02 is out of range (allowed: a number from "
        "0.03 to 1)"},
       {"scene.materials.paint.base_color.constant=[0.1, 0.2]",
        "scene.materials.paint.base_color.constant: a list of 3 numbers from 0 to 1 is needed, "
        "not 2 items"},
       {"scene.materials.paint.base_color.constant=[0.1, 0.2, 1.2]",
        "scene.materials.paint.base_color.constant[2]: 1.2 is out of range (allowed: a number from "
        "0 to 1)"},
       {"loss.residual=relativ",
        "loss.residual: 'relativ' is not allowed; one of linear, relative is needed (did you mean "
        "'relative'?)"},
       {"scene.materials.paint.base_color=[0.1, 0.2, 0.3]",
        "scene.materials.paint.base_color: a map is needed, not a list; write {constant: [...]} "
        "(known: constant, vertex, texture)"},
       {"scene.materials.paint.base_color=bricks",
        "scene.materials.paint.base_color: a map is needed, not 'bricks'; write {texture: bricks} "
        "(known: constant, vertex, texture)"},
       {"solver=fast",
        "solver: a map is needed, not 'fast' (known: linear_solver, max_memory, threads)"},
       {"stages=none", "stages: a list of maps is needed, not 'none'"}});
  ExpectProblems(kSceneConfig,
                 {{"scene.sensors.front.fov_deg=180",
                   "scene.sensors.front.fov_deg: 180 is out of range (allowed: a number between 0 "
                   "and 180)"},
                  // The type that decides is not given.
                  {"scene.sensors.front.height_m=5",
                   "scene.sensors.front: key 'height_m' does not belong to type 'perspective', "
                   "only to orthographic"}});
}

TEST(ConfigMistakes, WhatIsPlannedIsNotSupported) {
  ExpectProblems(
      kFitConfig,
      {{"input.cameras.refine={pose: true}",
        "input.cameras.refine: key 'refine' is not supported; free camera.position and "
        "camera.rotation in unknowns"},
       {"input.cameras={path: a, up: +y}", "input.cameras: key 'up' is not supported"},
       {"input.cameras.format=bundler", "input.cameras.format: 'bundler' is not supported"},
       {"input.colour.white_balance=as_shot",
        "input.colour.white_balance: 'as_shot' is not supported; write camera"},
       {"scene.materials.paint.preset=Au",
        "scene.materials.paint.preset: key 'preset' is not supported; write metal"},
       {"render.sppse=8",
        "render.sppse: key 'sppse' is not supported; write spp_direct and spp_indirect"},
       {"render.pixel_filter=tent",
        "render.pixel_filter: key 'pixel_filter' is not supported; photos are means over pixels, "
        "write filter in scene.sensors"},
       {"unknowns.mug.vertices.parametrisation=rigid",
        "unknowns.mug.vertices.parametrisation: 'rigid' is not supported; free "
        "MESH.translation and MESH.rotation"},
       {"unknowns.mug.vertices.priors+={normal_consistency: {weight: 1}, laplacian: {weight: 1}}",
        "unknowns.mug.vertices.priors[1]: key 'normal_consistency' is not supported; write "
        "laplacian"},
       {"unknowns.paint.base_color.priors=[{gaussian: {mean: begin, sigma: 1}}]",
        "unknowns.paint.base_color.priors[0].gaussian.mean: 'begin' is not a number "
        "(allowed: a number, or start, or a list of numbers (at least 2))"},
       {"loss.residual=srgb", "loss.residual: 'srgb' is not supported"},
       {"loss.robust=tukey", "loss.robust: 'tukey' is not allowed; 'none', or a map is needed"},
       {"loss.robust={huber: 1, tukey: 1}",
        "loss.robust: key 'tukey' is not supported; write huber"},
       {"loss.robust={huber: 0}",
        "loss.robust.huber: 0 is out of range (allowed: a number above 0)"},
       {"loss.robust={}", "loss.robust: required key 'huber' is missing (a number above 0)"},
       {"stages.all.remesh={every: 3}", "stages.all.remesh: key 'remesh' is not supported"},
       {"solver.method=adam",
        "solver.method: key 'method' is not supported; it is Ceres' Levenberg-Marquardt"},
       {"output.metrics=[csv]",
        "output.metrics: key 'metrics' is not supported; metrics.csv is always written"},
       {"extends=base.yaml",
        "extends: key 'extends' is not supported; write the values into this file"},
       {"input.images=photos/*.exr",
        "input.images: file name patterns are not supported; give the folder"}});
}

TEST(ConfigMistakes, KeysThatDependOnOthersAreChecked) {
  ExpectProblems(
      kFitConfig,
      {{"scene.geometry.disc.file=a.ply",
        "scene.geometry.disc: 'file' and 'primitive' cannot be given together"},
       {"scene.geometry.disc={material: paint}",
        "scene.geometry.disc: one of the keys file, primitive, mesh, visual_hull is needed"},
       {"scene.geometry.disc={fil: a.ply, material: paint}",
        "scene.geometry.disc: unknown key 'fil' (did you mean 'file'?)"},
       {"scene.geometry.disc={file: a.ply}",
        "scene.geometry.disc: required key 'material' is missing (a name)"},
       {"scene.geometry.disc={file: a.ply, material: my paint}",
        "scene.geometry.disc.material: 'my paint' may hold only letters, digits, '_' and '-'"},
       {"scene.geometry.disc={file: a.ply, material: paint, lights: true}",
        "scene.geometry.disc.lights: only glTF files have lights"},
       {"scene.geometry.disc={file: a.ply, material: paint, camera_height_px: 9}",
        "scene.geometry.disc.camera_height_px: only glTF files have cameras"},
       {"scene.geometry.disc={file: a.glb, camera_height_px: 9}",
        "scene.geometry.disc.camera_height_px: cameras of a file are not supported together with "
        "input; the photos are the cameras"},
       {"scene.geometry.disc={file: a.glb, material: pain}",
        "scene.geometry.disc.material: no material is called 'pain' (did you mean 'paint'?)"},
       {"scene.geometry={}", "scene.geometry: at least one MESH is needed"},
       {"scene.lights.lamp.size_px=[4, 2]",
        "scene.lights.lamp: key 'size_px' does not belong to type 'point', only to envmap"},
       {"scene.lights.lamp={type: constant}",
        "scene.lights.lamp: only one light may be an envmap or constant; 'room' is one already"},
       {"scene.lights.lamp={type: directional, direction: [0, 0, 0]}",
        "scene.lights.lamp.direction: the direction must not be [0, 0, 0]"},
       {"scene.lights.lamp={type: directional}",
        "scene.lights.lamp: required key 'direction' is missing (a list of 3 numbers)"},
       {"scene.lights.room={type: envmap, file: a.exr, init: {}}",
        "scene.lights.room: key 'init' needs key 'size_px'"},
       {"scene.materials.paint.roughness={constant: 0.5}",
        "scene.materials.paint: key 'roughness' does not belong to model 'diffuse', only to "
        "metallic_roughness, conductor, dielectric"},
       {"scene.materials.glaze.distribution=beckmann",
        "scene.materials.glaze: key 'distribution' does not belong to model 'metallic_roughness', "
        "only to conductor, dielectric"},
       {"scene.materials.paint={model: conductor, metal: gold, distribution: bekmann}",
        "scene.materials.paint.distribution: 'bekmann' is not allowed; one of ggx, beckmann is "
        "needed (did you mean 'beckmann'?)"},
       {"scene.geometry.disc.transform={rotate: {axis: [0, 0, 0], angle_deg: 1}}",
        "scene.geometry.disc.transform.rotate.axis: the axis must not be [0, 0, 0]"},
       {"scene.materials.a b={}",
        "scene.materials: the name 'a b' may hold only letters, digits, '_' and '-'\n"
        "--set #1: scene.materials.a b: required key 'model' is missing (one of diffuse, "
        "metallic_roughness, conductor, dielectric, mirror, glass)"},
       {"scene.sensors={}",
        "scene.sensors: sensors are not supported together with input; the photos are the cameras, "
        "unless input.cameras.sensor names one that took them all"},
       {"input.split.validation=every 1",
        "input.split.validation: 'every 1' is not understood; write every 8 (a number of at least "
        "2), a list of file names, or none"}});
  EXPECT_EQ(
      ProblemOf(kFitConfig, {"input.masks.meaning=ignore"}),
      "12:20: scene.geometry.mug.visual_hull: a visual hull is carved from masks; input.masks "
      "with meaning: silhouette is needed");
}

TEST(ConfigMistakes, StagesAreChecked) {
  ExpectProblems(
      kFitConfig,
      {{"stages.all.name=light", "stages[1].name: another stage is called 'light' already"},
       {"stages.all.name=start",
        "stages[1].name: 'start' is what the scene before the first stage is called; choose "
        "another"},
       {"stages.light.free=[exposure, exposure]", "stages[0].free: 'exposure' is given twice"},
       {"stages.light.free=[glaze.metallic]",
        "stages[0].free: 'glaze.metallic' is held (hold: true)"},
       {"stages.light.free=[]",
        "stages[0].free: 'all', or a list of texts (at least 1) is needed, not 0 items"},
       {"stages.light.free=every",
        "stages[0].free: 'every' is not allowed; 'all', or a list of texts (at least 1) is needed"},
       {"stages.all.max_spp=4", "stages[1].max_spp: max_spp 4 is below spp 16"}});
  EXPECT_EQ(ProblemOf(kSceneConfig, {"stages=[]"}), "");
  EXPECT_EQ(ProblemOf(kSceneConfig, {"stages=[{name: a, free: all}]"}),
            "--set #1: stages[0].free: there are no unknowns to free\n"
            "--set #1: stages: a fit needs photos; give input");
}

TEST(ConfigMistakes, SensorsAndMeshesAreChecked) {
  ExpectProblems(
      kSceneConfig,
      {{"scene.sensors.front.focal_px=3",
        "scene.sensors.front: 'focal_px' and 'fov_deg' cannot be given together"},
       {"scene.sensors.front={size_px: [8, 8], focal_px: 3, fov_axis: x, pose: {look_at: "
        "{origin_m: "
        "[0, 0, 1], target_m: [0, 0, 0]}}}",
        "scene.sensors.front: key 'fov_axis' needs key 'fov_deg'"},
       {"scene.sensors.front.crop_px=[60, 0, 8, 8]",
        "scene.sensors.front.crop_px: the part [x, y, width, height] must not be empty and must "
        "lie "
        "inside the 64x32 picture"},
       {"scene.sensors.front.pose.look_at.target_m=[0, 1, 3]",
        "scene.sensors.front.pose.look_at.target_m: the target is where the camera stands"},
       {"scene.sensors.front.pose.look_at.up=[0, 1, 3]",
        "scene.sensors.front.pose.look_at.up: up must not be zero or along the viewing direction"},
       {"scene.sensors.front.pose={world_from_camera: [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], "
        "[0, "
        "0, 0, 1]]}",
        "scene.sensors.front.pose.world_from_camera: the first three columns must be a rotation "
        "(no "
        "scale, no mirror) and the last row [0, 0, 0, 1]"},
       {"scene.geometry.floor={material: grey, mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "
        "triangles: [[0, 1, 3]]}}",
        "scene.geometry.floor.mesh.triangles: there is no vertex 3; there are 3, counted from 0"},
       {"scene.geometry.floor={material: grey, mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "
        "triangles: [[0, 1, 2]], colors: [[0, 0, 0]]}}",
        "scene.geometry.floor.mesh.colors: 1 colours for 3 vertices; one for each is needed"},
       {"scene.geometry.floor={material: grey, primitive: {cube: {}, rectangle: {}}}",
        "scene.geometry.floor.primitive: 'rectangle' and 'cube' cannot be given together"}});
  EXPECT_EQ(ProblemOf(Replaced(kSceneConfig, "  sensors:", "  sensor:")),
            "3:3: scene: there is no camera; give input or scene.sensors\n"
            "7:3: scene: unknown key 'sensor' (did you mean 'sensors'?)");
}

TEST(ConfigMistakes, TheFormOfTheFileIsChecked) {
  EXPECT_EQ(ProblemOf("schema: 1\n"), "1:1: required key 'scene' is missing (a map)");
  EXPECT_EQ(ProblemOf("[]\n"),
            "1:1: a map is needed, not a list (known: schema, name, seed, input, scene, render, "
            "unknowns, loss, gauge, stages, solver, output, gradcheck)");
  EXPECT_EQ(ProblemOf(Replaced(kSceneConfig, "schema: 1", "schema: 1\nschema: 1")),
            "2:1: key 'schema' is given twice (first at 1:1)");
  EXPECT_EQ(ProblemOf(Replaced(kSceneConfig, "schema: 1\n", "")),
            "1:1: required key 'schema' is missing (a whole number equal to 1)");
}

TEST(ConfigMistakes, WhatIsWrongIsNotAlsoMissing) {
  // A wrong input is an input: no complaint about cameras or stages without photos.
  EXPECT_EQ(ProblemOf(kFitConfig, {"input.cameras=5"}),
            "--set #1: input.cameras: a map is needed, not '5'; write {path: 5} (known: path, "
            "sensor, photos, format, "
            "calibration, distortion, orientation)");
  // A wrong mesh still has a name, a wrong material one too.
  EXPECT_EQ(ProblemOf(kFitConfig, {"scene.materials.glaze=5"}),
            "--set #1: scene.materials.glaze: a map is needed, not '5'");
}

}  // namespace
}  // namespace pathfit::app::config_mistakes_test
