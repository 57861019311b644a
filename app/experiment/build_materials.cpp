#include <algorithm>

#include "app/experiment/build_parts.h"
#include "renderer/bsdf/metals.h"
#include "renderer/core/check.h"
#include "renderer/io/texture_file.h"

namespace pathfit::app {
namespace {

using Role = TextureConfig::Role;

/// -1 for an empty name.
int TextureIndex(const std::string& name, const ExperimentConfig& config) {
  if (name.empty()) return -1;
  const auto found = std::ranges::find_if(
      config.textures, [&](const auto& texture) { return texture.name == name; });
  PATHFIT_CHECK(found != config.textures.end());  // the config is validated
  return static_cast<int>(found - config.textures.begin());
}

renderer::Metal MetalOf(const MaterialConfig& config) {
  if (config.metal.empty()) return {"", ToRgb(config.eta), ToRgb(config.k)};
  const auto metal = renderer::NamedMetal(config.metal);
  PATHFIT_CHECK(metal.has_value());  // the config is validated
  return *metal;
}

renderer::Bsdf BsdfOf(const MaterialConfig& config) {
  using Model = MaterialConfig::Model;
  switch (config.model) {
    case Model::kDiffuse:
      return renderer::LambertBsdf{};
    case Model::kMetallicRoughness:
      return config.gltf;
    case Model::kConductor:
      return renderer::RoughConductorBsdf{
          config.gltf.roughness, MetalOf(config).eta, MetalOf(config).k, config.distribution};
    case Model::kDielectric:
      return renderer::RoughDielectricBsdf{config.gltf.roughness, config.ior, config.distribution};
    case Model::kMirror:
      return renderer::MirrorBsdf{MetalOf(config).eta, MetalOf(config).k};
    case Model::kGlass:
      return renderer::SmoothDielectricBsdf{config.ior};
  }
  return renderer::LambertBsdf{};
}

}  // namespace

renderer::Texture BuildTexture(const TextureConfig& config, const BuildContext& context) {
  const bool scalar = config.role == Role::kRoughness || config.role == Role::kMetallic;
  renderer::Texture texture;
  if (config.file.empty()) {
    texture.width = config.size_px[0];
    texture.height = config.size_px[1];
    texture.texels.assign(
        static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height),
        ToRgb(config.init));
    texture.scalar = scalar;
  } else {
    context.files.push_back(config.file);
    texture = renderer::ReadTexture(config.file,
                                    scalar                         ? renderer::TextureRole::kData
                                    : config.role == Role::kNormal ? renderer::TextureRole::kNormal
                                                                   : renderer::TextureRole::kColor);
  }
  texture.name = config.name;
  texture.wrap = config.repeat ? renderer::TextureWrap::kRepeat : renderer::TextureWrap::kClamp;
  return texture;
}

renderer::Material BuildMaterial(const MaterialConfig& material, const ExperimentConfig& config) {
  using Source = MaterialConfig::BaseColor;
  renderer::Material out;
  out.name = material.name;
  out.bsdf = BsdfOf(material);
  out.base_color = ToRgb(material.base_color);
  out.vertex_colors = material.base_color_source == Source::kVertexConstant ||
                      material.base_color_source == Source::kVertexOfMesh;
  out.base_color_texture = TextureIndex(material.base_color_texture, config);
  out.roughness_texture = TextureIndex(material.roughness_texture, config);
  out.metallic_texture = TextureIndex(material.metallic_texture, config);
  out.normal_texture = TextureIndex(material.normal_texture, config);
  out.normal_scale = material.normal_scale;
  out.two_sided = material.two_sided;
  return out;
}

}  // namespace pathfit::app
