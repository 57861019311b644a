#include "app/config/schema_builders.h"

namespace pathfit::app {

SchemaNode LightsSchema() {
  const std::vector<std::string> environments = {"envmap", "constant"};
  const std::vector<std::string> aimed = {"spot", "projector"};
  const SchemaNode init = Map("init",
                              {Colour("constant", "Every texel.").Default("[1, 1, 1]")},
                              "What the environment starts from.")
                              .Always()
                              .Needs("size_px")
                              .When("type", {"envmap"});
  return NamedMap(
      "lights",
      "LIGHT",
      Map("",
          {Choice(
               "type",
               {"envmap",
                "constant",
                "point",
                "directional",
                "spot",
                "projector",
                "area",
                "rectangle"},
               "`envmap`: picture of all directions; `constant`: the same from everywhere; "
               "`spot`: point light with a cone; `projector`: casts a texture like a slide; "
               "`area`: a mesh that shines; `rectangle`: a black sheet that shines, with a place "
               "of "
               "its own, a mesh and a material of the light's name: derivatives by its place and "
               "shape are those of LIGHT.translation, LIGHT.rotation, LIGHT.scale and "
               "LIGHT.vertices.")
               .Required(),
           Path("file", "Latitude-longitude picture, EXR or HDR.")
               .OneOf("source")
               .When("type", {"envmap"}),
           Size("size_px", "Size of an environment without file.")
               .OneOf("source")
               .When("type", {"envmap"}),
           init,
           Name("mesh", "One of `scene.geometry`; it shines where its normals point to.")
               .Required()
               .When("type", {"area"}),
           Colour("radiance", "Radiance.")
               .Unit("W/(sr m²), relative")
               .Default("[1, 1, 1]")
               .When("type", {"constant", "area", "rectangle"}),
           Name("texture",
                "One of `scene.textures`: the projected picture, or a factor on the radiance of "
                "the mesh by its UVs, which run once over a rectangle.")
               .RequiredFor({"projector"})
               .When("type", {"projector", "area", "rectangle"}),
           Bool("two_sided", "The mesh shines from both sides.")
               .Default("false")
               .When("type", {"area", "rectangle"}),
           Bool("visible", "Seen behind the objects (else black there, without coverage).")
               .Default("true")
               .When("type", environments),
           Vector("position_m", "Place of the light; the middle of a rectangle.")
               .Unit("metres")
               .Required()
               .When("type", {"point", "spot", "projector", "rectangle"}),
           Number("width_m", "Along x, before `rotate`.")
               .Between(0.0, 1e9)
               .Unit("metres")
               .Required()
               .When("type", {"rectangle"}),
           Number("height_m", "Along y, before `rotate`.")
               .Between(0.0, 1e9)
               .Unit("metres")
               .Required()
               .When("type", {"rectangle"}),
           Vector("target_m", "What is in the middle of the cone or picture.")
               .Unit("metres")
               .OneOf("aim")
               .When("type", aimed),
           Vector("direction", "Where the light goes; its length does not matter.")
               .OneOf("aim")
               .When("type", {"directional", "spot", "projector"}),
           Vector("up", "What is up in the projected picture.")
               .Default("[0, 1, 0]")
               .When("type", {"projector"}),
           Rotation("rotate",
                    "Turns the light, after `direction` or `target_m`; a rectangle shines along +z "
                    "without it.")
               .When("type", {"envmap", "directional", "spot", "projector", "rectangle"}),
           Number("outer_deg", "Angle from the axis beyond which a spot gives no light.")
               .Between(0.0, 90.0)
               .Unit("degrees")
               .Required()
               .When("type", {"spot"}),
           Number("inner_deg", "Angle from the axis up to which it gives its full intensity.")
               .From(0.0, 90.0)
               .Unit("degrees")
               .DefaultIs("3/4 of `outer_deg`")
               .When("type", {"spot"}),
           Number("fov_deg", "Angle of the projected picture.")
               .Between(0.0, 180.0)
               .Unit("degrees")
               .Required()
               .When("type", {"projector"}),
           Choice("fov_axis",
                  {"x", "y", "smaller", "larger", "diagonal"},
                  "Along which side of the picture `fov_deg` is measured.")
               .Default("smaller")
               .When("type", {"projector"}),
           Colour("intensity",
                  "Factor of an environment or of a projected picture; radiant intensity of a "
                  "point light or spot.")
               .Unit("1, or W/sr")
               .Default("[1, 1, 1]")
               .When("type", {"envmap", "point", "spot", "projector"}),
           Colour("irradiance", "On a surface facing the light.")
               .Unit("W/m²")
               .Default("[1, 1, 1]")
               .When("type", {"directional"}),
           Choice("frame",
                  {"world", "camera"},
                  "`camera`: the light goes with the camera, as for an object on a turntable.")
               .Default("world")
               .When("type", {"envmap", "constant", "point", "directional", "spot", "projector"})},
          "A light."),
      "What shines. At most one `envmap` or `constant`.");
}

}  // namespace pathfit::app
