#include <string>
#include <vector>

#include "app/config/schema_builders.h"
#include "renderer/bsdf/metals.h"

namespace pathfit::app {
namespace {

std::vector<std::string> Metals() {
  const auto names = renderer::NamedMetals();
  return {names.begin(), names.end()};
}

const std::vector<std::string>& Models() {
  static const std::vector<std::string> models = {
      "diffuse", "metallic_roughness", "conductor", "dielectric", "mirror", "glass"};
  return models;
}

SchemaNode ScalarSchema(const char* key,
                        double lower,
                        const char* value,
                        std::vector<std::string> models,
                        const char* doc) {
  return Map(key,
             {Number("constant", "The same everywhere.").From(lower, 1.0).OneOf("source"),
              Name("texture", "One of `scene.textures`, by the mesh's UVs.").OneOf("source")},
             doc)
      .Default(value)
      .When("model", std::move(models));
}

SchemaNode BaseColorSchema() {
  return Map("base_color",
             {List("constant", Number("", "").From(0.0, 1.0), "One colour everywhere.")
                  .Items(3, 3)
                  .Unit("linear Rec.709")
                  .OneOf("source"),
              Either("vertex",
                     {Choice("", {"mesh"}, ""),
                      List("", Number("", "").From(0.0, 1.0), "").Items(3, 3)},
                     "One colour per vertex: the start value of all, or `mesh` for those of the "
                     "file.")
                  .Unit("linear Rec.709")
                  .OneOf("source"),
              Name("texture", "One of `scene.textures`, by the mesh's UVs.").OneOf("source")},
             "Colour of the surface; a factor on what metals and glass reflect and let through.")
      .RequiredFor({"diffuse", "metallic_roughness"}, "{constant: [1, 1, 1]}")
      .When("model", Models());
}

SchemaNode SpectralIndex(const char* key, double lower, const char* other, const char* doc) {
  return List(key, Number("", "").From(lower, 100.0), doc)
      .Items(3, 3)
      .Unit("red, green, blue")
      .Needs(other)
      .When("model", {"conductor", "mirror"});
}

}  // namespace

SchemaNode MaterialsSchema() {
  return NamedMap(
             "materials",
             "MATERIAL",
             Map("",
                 {Choice("model",
                         Models(),
                         "`diffuse`: Lambert; `metallic_roughness`: glTF's (GGX); `conductor`: GGX "
                         "metal; `dielectric`: rough glass (GGX); `mirror` and `glass`: perfectly "
                         "smooth.")
                      .Required(),
                  BaseColorSchema(),
                  ScalarSchema("roughness",
                               0.1,
                               "{constant: 0.5}",
                               {"metallic_roughness", "conductor", "dielectric"},
                               "Perceptual roughness, alpha = roughness²."),
                  ScalarSchema("metallic",
                               0.0,
                               "{constant: 0}",
                               {"metallic_roughness"},
                               "0 = plastic, 1 = metal."),
                  Choice("metal",
                         Metals(),
                         "Measured eta and k. A mirror without metal reflects everything.")
                      .OneOfFor("metal", {"conductor"})
                      .When("model", {"conductor", "mirror"}),
                  SpectralIndex("eta", 0.0, "k", "Index of refraction of a metal.")
                      .OneOfFor("metal", {"conductor"}),
                  SpectralIndex("k", 0.0, "eta", "Extinction coefficient of a metal."),
                  Number("ior",
                         "Index of refraction of the inside, where the normals point away from, "
                         "over the outside; not 1.")
                      .From(0.1, 10.0)
                      .Default("1.5")
                      .When("model", {"dielectric", "glass"}),
                  Bool("two_sided", "Seen from behind too (else black there).")
                      .Default("true")
                      .When("model", {"diffuse", "metallic_roughness", "conductor", "mirror"})},
                 "A material.")
                 .Refuse({{"preset", "; write metal"}}),
             "What the meshes are made of.")
      .Required()
      .Items(1, 0);
}

SchemaNode TexturesSchema() {
  const SchemaNode init = Map("init",
                              {Either("constant",
                                      {Number("", "").AtLeast(0.0),
                                       List("", Number("", "").AtLeast(0.0), "").Items(3, 3)},
                                      "Every texel: a number, or red, green, blue.")
                                   .Default("0.5")},
                              "What the texels start from.")
                              .Always()
                              .Needs("size_px");
  return NamedMap(
      "textures",
      "TEXTURE",
      Map("",
          {Path("file",
                "PNG, JPEG, TIFF, EXR or HDR. As a colour or light, 8 and 16 bit are sRGB, EXR and "
                "HDR linear; as roughness or metallic the first channel is taken as it is.")
               .OneOf("source"),
           Size("size_px", "Size of a texture without file.").OneOf("source"),
           init,
           Choice("wrap",
                  {"repeat", "clamp"},
                  "Beside the picture: `repeat` it, or go on with its border.")
               .Default("repeat")},
          "A texture.")
          .Refuse({{"role", "; what uses the texture decides"},
                   {"transfer", "; what uses the texture decides"}}),
      "Pictures on surfaces and in lights, looked up by UVs (bilinear; 0, 0 is the bottom-left "
      "corner). Several materials and lights may use one.");
}

}  // namespace pathfit::app
