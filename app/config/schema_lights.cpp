#include <numbers>

#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "app/config/schema_parts.h"

namespace pathfit::app {
namespace {

using Type = LightConfig::Type;

void CheckAim(LightConfig& light, const CheckedMap& map) {
  const YamlNode* target = map.Find("target_m");
  const YamlNode* aim = target != nullptr ? target : map.Find("direction");
  if (aim == nullptr || (target != nullptr && map.Find("position_m") == nullptr)) return;
  if (target != nullptr) light.direction = Minus(light.target, light.position);
  if (IsZero(light.direction)) {
    map.Report(target != nullptr ? "target_m" : "direction",
               target != nullptr ? "the target is where the light stands"
                                 : "the direction must not be [0, 0, 0]");
    return;
  }
  const YamlNode* up = map.Find("up");
  if (light.type == Type::kProjector && up != nullptr && AreParallel(light.direction, light.up)) {
    const bool given = up->place.source != Place::Source::kDefault;
    map.Report("up", given ? *up : *aim, "up must not be zero or along the direction of the light");
  }
}

void CheckCone(LightConfig& light, const CheckedMap& map) {
  constexpr double kInnerShare = 0.75;
  const YamlNode* outer = map.Find("outer_deg");
  if (outer == nullptr) return;
  const YamlNode* inner = map.Find("inner_deg");
  if (inner == nullptr) {
    double degrees = 0.0;
    binding::Read(*outer, degrees);
    degrees *= kInnerShare;
    // As it is read back: a share of the angle in radians may have another last bit.
    light.inner_angle = degrees * std::numbers::pi / 180.0;
    SetDefault(map.node, "inner_deg", fmt::format("{}", degrees));
  } else if (light.inner_angle >= light.outer_angle) {
    map.Report("inner_deg",
               fmt::format("inner_deg {} must be below outer_deg {}", inner->text, outer->text));
  }
}

void CheckLight(LightConfig& light, const CheckedMap& map) {
  CheckAim(light, map);
  if (light.type == Type::kSpot) CheckCone(light, map);
}

}  // namespace

SchemaNode LightsSchema() {
  return NamedMap(
             "lights",
             "LIGHT",
             Map("",
                 {Choice("type",
                         {{"envmap", Type::kEnvironment},
                          {"constant", Type::kConstant},
                          {"point", Type::kPoint},
                          {"directional", Type::kDirectional},
                          {"spot", Type::kSpot},
                          {"projector", Type::kProjector},
                          {"area", Type::kArea},
                          {"rectangle", Type::kArea}},
                         &LightConfig::type) |
                      Doc("`envmap`: picture of all directions; `constant`: the same from "
                          "everywhere; `spot`: point light with a cone; `projector`: casts a "
                          "texture like a slide; `area`: a mesh that shines; `rectangle`: a black "
                          "sheet that shines, with a place of its own, a mesh and a material of "
                          "the light's name: derivatives by its place and shape are those of "
                          "LIGHT.translation, LIGHT.rotation, LIGHT.scale and LIGHT.vertices.") |
                      Required(),
                  Key("file", &LightConfig::file) | Doc("Latitude-longitude picture, EXR or HDR.") |
                      OneOf("source") | When("type", {"envmap"}),
                  Size("size_px", &LightConfig::size_px) |
                      Doc("Size of an environment without file.") | OneOf("source") |
                      When("type", {"envmap"}),
                  Map("init",
                      {Colour("constant", &LightConfig::init) | Doc("Every texel.") |
                       From(0.0, kMaxRadiance)}) |
                      Doc("What the environment starts from.") | Always() | Needs("size_px") |
                      When("type", {"envmap"}),
                  Name("mesh", &LightConfig::mesh) |
                      Doc("One of `scene.geometry`; it shines where its normals point to.") |
                      Required() | When("type", {"area"}),
                  Light("radiance", "W/(sr m²), relative", &LightConfig::intensity) |
                      Doc("Radiance.") | When("type", {"constant", "area", "rectangle"}),
                  Name("texture", &LightConfig::texture) |
                      Doc("One of `scene.textures`: the projected picture, or a factor on the "
                          "radiance of the mesh by its UVs, which run once over a rectangle.") |
                      RequiredFor({"projector"}) | When("type", {"projector", "area", "rectangle"}),
                  Key("two_sided", &LightConfig::two_sided) |
                      Doc("The mesh shines from both sides.") | When("type", {"area", "rectangle"}),
                  Key("visible", &LightConfig::visible) |
                      Doc("Seen behind the objects (else black there, without coverage).") |
                      When("type", {"envmap", "constant"}),
                  Point("position_m", &LightConfig::position) |
                      Doc("Place of the light; the middle of a rectangle.") | Required() |
                      When("type", {"point", "spot", "projector", "rectangle"}),
                  Key("width_m", &LightConfig::width_m) | Doc("Along x, before `rotate`.") |
                      Between(0.0, 1e9) | Unit("metres") | Required() | When("type", {"rectangle"}),
                  Key("height_m", &LightConfig::height_m) | Doc("Along y, before `rotate`.") |
                      Between(0.0, 1e9) | Unit("metres") | Required() | When("type", {"rectangle"}),
                  Point("target_m", &LightConfig::target) |
                      Doc("What is in the middle of the cone or picture. An unknown `position` "
                          "keeps the direction, not the target: free `rotation`, too.") |
                      OneOf("aim") | When("type", {"spot", "projector"}),
                  Key("direction", &LightConfig::direction) |
                      Doc("Where the light goes; its length does not matter.") | OneOf("aim") |
                      When("type", {"directional", "spot", "projector"}),
                  Key("up", &LightConfig::up) | Doc("What is up in the projected picture.") |
                      When("type", {"projector"}),
                  Rotation<LightConfig>("Turns the light, after `direction` or `target_m`; a "
                                        "rectangle shines along +z without it.") |
                      When("type", {"envmap", "directional", "spot", "projector", "rectangle"}),
                  Degrees("outer_deg", &LightConfig::outer_angle) |
                      Doc("Angle from the axis beyond which a spot gives no light.") |
                      Between(0.0, 90.0) | Required() | When("type", {"spot"}),
                  Degrees("inner_deg", &LightConfig::inner_angle) |
                      Doc("Angle from the axis up to which it gives its full intensity.") |
                      From(0.0, 90.0) | DefaultIs("3/4 of `outer_deg`") | When("type", {"spot"}),
                  Degrees("fov_deg", &LightConfig::fov) | Doc("Angle of the projected picture.") |
                      Between(0.0, 180.0) | Required() | When("type", {"projector"}),
                  Choice("fov_axis", FovAxes(), &LightConfig::fov_axis) |
                      Doc("Along which side of the picture `fov_deg` is measured.") |
                      When("type", {"projector"}),
                  Light("intensity", "1, or W/sr", &LightConfig::intensity) |
                      Doc("Factor of an environment or of a projected picture; radiant intensity "
                          "of a point light or spot.") |
                      When("type", {"envmap", "point", "spot", "projector"}),
                  Light("irradiance", "W/m²", &LightConfig::intensity) |
                      Doc("On a surface facing the light.") | When("type", {"directional"}),
                  Choice(
                      "frame", {{"world", false}, {"camera", true}}, &LightConfig::camera_frame) |
                      Doc("`camera`: the light goes with the camera, as for an object on a "
                          "turntable.") |
                      When("type",
                           {"envmap", "constant", "point", "directional", "spot", "projector"}),
                  Key("photos", &LightConfig::photos) |
                      Doc("In which photos it shines (or sensors, without `input`): names or "
                          "globs, extensions may be left out. It is off in the others.") |
                      Items(1, 0) | Distinct() | DefaultIs("all")}) |
                 Check(CheckLight),
             &ExperimentConfig::lights) |
         Doc("What shines. At most one `envmap` or `constant`.");
}

}  // namespace pathfit::app
