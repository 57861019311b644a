#include "optim/parameter/promotion.h"

#include <algorithm>
#include <cstddef>
#include <optional>

namespace pathfit::optim {
namespace {

using renderer::ParameterKind;

/// What of which material the unknown's numbers may stand for.
std::optional<Promotion> PropertyOf(const renderer::Scene& scene, const UnknownSpec& unknown) {
  if (renderer::TraitsOf(unknown.kind).texture != nullptr) {
    return Promotion{unknown.kind, unknown.object};
  }
  if (unknown.kind == ParameterKind::kVertexColors) {
    return Promotion{ParameterKind::kBaseColor,
                     scene.meshes[static_cast<std::size_t>(unknown.object)].material};
  }
  return unknown.promotion;
}

}  // namespace

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
  const renderer::ParameterTraits& traits = renderer::TraitsOf(property->property);
  switch (unknown.kind) {
    case ParameterKind::kTextureTexels:
      return traits.TextureOf(material) != unknown.object;
    case ParameterKind::kVertexColors:
      return !traits.IsPerVertex(material);
    default:
      return !traits.IsConstant(material);
  }
}

}  // namespace pathfit::optim
