#include "optim/parameter/promotion.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "renderer/core/check.h"

namespace pathfit::optim {
namespace {

using renderer::ParameterKind;

/// What of which material the unknown's numbers may stand for.
std::optional<Promotion> PropertyOf(const renderer::Scene& scene, const UnknownSpec& unknown) {
  switch (unknown.kind) {
    case ParameterKind::kBaseColor:
    case ParameterKind::kRoughness:
    case ParameterKind::kMetallic:
      return Promotion{unknown.kind, unknown.object};
    case ParameterKind::kVertexColors:
      return Promotion{ParameterKind::kBaseColor,
                       scene.meshes[static_cast<std::size_t>(unknown.object)].material};
    default:
      return unknown.promotion;
  }
}

}  // namespace

int renderer::Material::*TextureSlot(ParameterKind property) {
  switch (property) {
    case ParameterKind::kRoughness:
      return &renderer::Material::roughness_texture;
    case ParameterKind::kMetallic:
      return &renderer::Material::metallic_texture;
    default:
      PATHFIT_CHECK(property == ParameterKind::kBaseColor);
      return &renderer::Material::base_color_texture;
  }
}

bool IsReplaced(const renderer::Scene& scene,
                const UnknownSpec& unknown,
                const std::vector<UnknownSpec>& unknowns) {
  const std::optional<Promotion> property = PropertyOf(scene, unknown);
  const bool is_promoted = property && std::ranges::any_of(unknowns, [&](const UnknownSpec& other) {
                             return other.promotion == property;
                           });
  if (!is_promoted) return false;
  const renderer::Material& material =
      scene.materials[static_cast<std::size_t>(property->material)];
  const int texture = material.*TextureSlot(property->property);
  const bool per_vertex =
      texture < 0 && property->property == ParameterKind::kBaseColor && material.vertex_colors;
  switch (unknown.kind) {
    case ParameterKind::kTextureTexels:
      return texture != unknown.object;
    case ParameterKind::kVertexColors:
      return !per_vertex;
    default:
      return texture >= 0 || per_vertex;
  }
}

}  // namespace pathfit::optim
