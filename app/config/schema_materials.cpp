#include <utility>

#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "renderer/bsdf/metals.h"
#include "renderer/scene/parameter_kinds.h"

namespace pathfit::app {
namespace {

using renderer::MetallicRoughnessBsdf;
using renderer::MicrofacetDistribution;
using renderer::ParameterKind;

WordsOf<std::string> Metals() {
  WordsOf<std::string> words;
  for (const auto& metal : renderer::NamedMetals()) words.emplace_back(metal.name, metal.name);
  return words;
}

/// A constant of the glTF model by the name and in the range that the parameter has.
SchemaNode GltfConstant(ParameterKind kind,
                        double MetallicRoughnessBsdf::*member,
                        const char* doc) {
  const renderer::ParameterTraits& traits = renderer::TraitsOf(kind);
  return Key(traits.property, &MaterialConfig::gltf, member) | Doc(doc) |
         From(traits.smallest, traits.largest);
}

/// The same, or a texture.
SchemaNode GltfInput(ParameterKind kind,
                     double MetallicRoughnessBsdf::*member,
                     std::string MaterialConfig::*texture,
                     const char* doc) {
  SchemaNode constant = GltfConstant(kind, member, "The same everywhere.") | OneOf("source");
  const std::string key = std::exchange(constant.key, "constant");
  return Map(key,
             {constant,
              Name("texture", texture) | Doc("One of `scene.textures`, by the mesh's UVs.") |
                  OneOf("source")}) |
         Doc(doc) | Default(fmt::format("{{constant: {}}}", MetallicRoughnessBsdf{}.*member));
}

SchemaNode BaseColorSchema() {
  return Map("base_color",
             {Key("constant", &MaterialConfig::base_color) | Doc("One colour everywhere.") |
                  From(0.0, 1.0) | Unit("linear Rec.709") | OneOf("source"),
              Either("vertex",
                     {Word("mesh"), Key("", &MaterialConfig::base_color) | From(0.0, 1.0)}) |
                  Doc("One colour per vertex: the start value of all, or `mesh` for those of the "
                      "file.") |
                  Unit("linear Rec.709") | OneOf("source"),
              Name("texture", &MaterialConfig::base_color_texture) |
                  Doc("One of `scene.textures`, by the mesh's UVs.") | OneOf("source")}) |
         Doc("Colour of the surface; a factor on what metals and glass reflect and let through.") |
         RequiredFor({"diffuse", "metallic_roughness"}, "{constant: [1, 1, 1]}");
}

SchemaNode SpectralIndex(const char* key, const char* other, Triple MaterialConfig::*index) {
  return Key(key, index) | From(0.0, 100.0) | Unit("red, green, blue") | Optional() | Needs(other) |
         When("model", {"conductor", "mirror"});
}

void CheckMaterial(MaterialConfig& material, const CheckedMap& map) {
  using Source = MaterialConfig::BaseColor;
  if (const YamlNode* color = map.Find("base_color")) {
    if (const YamlNode* vertex = color->Find("vertex")) {
      material.base_color_source =
          vertex->IsList() ? Source::kVertexConstant : Source::kVertexOfMesh;
    } else if (!material.base_color_texture.empty()) {
      material.base_color_source = Source::kTexture;
    }
  }
  if (material.ior == 1.0) {
    map.Report("ior", "an ior of 1 is no surface; take the mesh out of the scene instead");
  }
}

}  // namespace

SchemaNode MaterialsSchema() {
  using Model = MaterialConfig::Model;
  const WordsOf<Model> models = {{"diffuse", Model::kDiffuse},
                                 {"metallic_roughness", Model::kMetallicRoughness},
                                 {"conductor", Model::kConductor},
                                 {"dielectric", Model::kDielectric},
                                 {"mirror", Model::kMirror},
                                 {"glass", Model::kGlass}};
  std::vector<std::string> all;
  for (const auto& [word, model] : models) all.push_back(word);
  return NamedMap(
             "materials",
             "MATERIAL",
             Map("",
                 {Choice("model", models, &MaterialConfig::model) |
                      Doc("`diffuse`: Lambert; `metallic_roughness`: glTF's (GGX); `conductor`: "
                          "rough metal; `dielectric`: rough glass; `mirror` and `glass`: "
                          "perfectly smooth.") |
                      Required(),
                  BaseColorSchema() | When("model", all),
                  GltfInput(ParameterKind::kRoughness,
                            &MetallicRoughnessBsdf::roughness,
                            &MaterialConfig::roughness_texture,
                            "Perceptual roughness, alpha = roughness².") |
                      When("model", {"metallic_roughness", "conductor", "dielectric"}),
                  Choice("distribution",
                         {{"ggx", MicrofacetDistribution::kGgx},
                          {"beckmann", MicrofacetDistribution::kBeckmann}},
                         &MaterialConfig::distribution) |
                      Doc("Of the slopes of microfacets: `ggx` has wide highlights, those of "
                          "`beckmann` end as a Gaussian does.") |
                      When("model", {"conductor", "dielectric"}),
                  GltfInput(ParameterKind::kMetallic,
                            &MetallicRoughnessBsdf::metallic,
                            &MaterialConfig::metallic_texture,
                            "0 = plastic, 1 = metal.") |
                      When("model", {"metallic_roughness"}),
                  GltfConstant(ParameterKind::kSpecular,
                               &MetallicRoughnessBsdf::specular,
                               "Factor of what is reflected without taking the base colour on, 4 % "
                               "head-on at 1; glTF's specularFactor.") |
                      When("model", {"metallic_roughness"}),
                  Map("normal",
                      {Name("texture", &MaterialConfig::normal_texture) |
                           Doc("One of `scene.textures`: directions in the frames of the mesh's "
                               "UVs as (1 + n) / 2, green up. It cannot be unknown.") |
                           Optional(),
                       Key("scale", &MaterialConfig::normal_scale) |
                           Doc("Of the directions' x and y.") | From(-10.0, 10.0)}) |
                      Doc("Normal map, glTF's normalTexture; the mesh must have normals "
                          "(`normals: smooth`) and UVs.") |
                      When("model", {"metallic_roughness"}),
                  Choice("metal", Metals(), &MaterialConfig::metal) |
                      Doc("Measured eta and k. A mirror without metal reflects everything.") |
                      OneOfFor("metal", {"conductor"}) | When("model", {"conductor", "mirror"}),
                  SpectralIndex("eta", "k", &MaterialConfig::eta) |
                      Doc("Index of refraction of a metal.") | OneOfFor("metal", {"conductor"}),
                  SpectralIndex("k", "eta", &MaterialConfig::k) |
                      Doc("Extinction coefficient of a metal."),
                  Key("ior", &MaterialConfig::ior) |
                      Doc("Index of refraction of the inside, where the normals point away from, "
                          "over the outside; not 1.") |
                      From(0.1, 10.0) | When("model", {"dielectric", "glass"}),
                  Key("two_sided", &MaterialConfig::two_sided) |
                      Doc("Seen from behind too (else black there).") |
                      When("model", {"diffuse", "metallic_roughness", "conductor", "mirror"})}) |
                 Check(CheckMaterial) | Refuse({{"preset", "; write metal"}}),
             &ExperimentConfig::materials) |
         Doc("What the meshes are made of, if not of what their glTF file says.");
}

SchemaNode TexturesSchema() {
  return NamedMap(
             "textures",
             "TEXTURE",
             Map("",
                 {Key("file", &TextureConfig::file) |
                      Doc("PNG, JPEG, TIFF, EXR or HDR. As a colour or light, 8 and 16 bit are "
                          "sRGB, EXR and HDR linear; as roughness or metallic the first channel is "
                          "taken as it is, as normals all three are.") |
                      OneOf("source"),
                  Size("size_px", &TextureConfig::size_px) |
                      Doc("Size of a texture without file.") | OneOf("source"),
                  Map("init",
                      {Key("constant", &TextureConfig::init) |
                       Doc("Every texel: a number, or red, green, blue.") | AtLeast(0.0) |
                       OrOne()}) |
                      Doc("What the texels start from.") | Always() | Needs("size_px"),
                  Choice("wrap", {{"repeat", true}, {"clamp", false}}, &TextureConfig::repeat) |
                      Doc("Beside the picture: `repeat` it, or go on with its border.")}) |
                 Refuse({{"role", "; what uses the texture decides"},
                         {"transfer", "; what uses the texture decides"}}),
             &ExperimentConfig::textures) |
         Doc("Pictures on surfaces and in lights, looked up by UVs (bilinear; 0, 0 is the "
             "bottom-left corner). Several materials and lights may use one.");
}

}  // namespace pathfit::app
