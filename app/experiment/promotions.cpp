#include "app/experiment/promotions.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/experiment/build_parts.h"
#include "app/experiment/parameter_names.h"
#include "renderer/core/error.h"
#include "renderer/scene/parameter_kinds.h"
#include "renderer/scene/texture_surface.h"

namespace pathfit::app {
namespace {

using renderer::ParameterKind;

class PromotionReader {
 public:
  PromotionReader(const YamlEntry& entry,
                  const renderer::Scene& scene,
                  std::vector<Problem>& problems)
      : entry_(entry), scene_(scene), problems_(problems), as_(*entry.value.Find("as")) {}

  std::optional<PromotedUnknown> Read(std::size_t index) const {
    PromotedUnknown unknown;
    unknown.index = index;
    const std::string problem = FindProperty(unknown.promotion);
    if (!problem.empty()) {
      problems_.push_back({entry_.key_place, "unknowns", problem});
      return std::nullopt;
    }
    const std::size_t before = problems_.size();
    if (as_.IsList()) {
      for (const YamlNode& item : as_.items) ReadForm(item, unknown);
    } else {
      ReadForm(as_, unknown);
    }
    if (problems_.size() > before) return std::nullopt;
    return unknown;
  }

 private:
  /// The material and its property; returns what is wrong with the name.
  std::string FindProperty(optim::Promotion& promotion) const {
    const std::size_t dot = entry_.key.rfind('.');
    const std::string object = entry_.key.substr(0, dot);
    const std::string word = dot == std::string::npos ? "" : entry_.key.substr(dot + 1);
    const auto rows = renderer::AllParameterTraits();
    const auto property = std::ranges::find_if(rows, [&](const renderer::ParameterTraits& row) {
      return row.texture != nullptr && word == row.property;
    });
    if (property == rows.end()) {
      return "'" + entry_.key +
             "' cannot have `as`: only base_color, roughness and metallic of a material have forms";
    }
    const std::vector<std::string> names =
        renderer::ObjectNames(scene_, renderer::ObjectList::kMaterials);
    const auto found = std::ranges::find(names, object);
    if (found == names.end())
      return "no material is called '" + object + "'" + NameHint(object, names);
    promotion = {property->kind, static_cast<int>(found - names.begin())};
    const auto& material = scene_.materials[static_cast<std::size_t>(promotion.material)];
    if (property->IsConstant(material)) return FindParameter(scene_, entry_.key).problem;
    const int texture = property->TextureOf(material);
    if (texture >= 0) {
      return "'" + entry_.key + "' is a texture already; write " +
             scene_.textures[static_cast<std::size_t>(texture)].name + ".texels";
    }
    return "";
  }

  void Report(const YamlNode& at, std::string text) const {
    problems_.push_back({at.place, "unknowns." + entry_.key + ".as", std::move(text)});
  }

  void ReadForm(const YamlNode& node, PromotedUnknown& unknown) const {
    const auto* word = std::ranges::find(kSurfaceForms, node.text);
    if (word == kSurfaceForms.end()) {
      return Report(node,
                    fmt::format("'{}' is not one of: {}",
                                node.text,
                                JoinNames({kSurfaceForms.begin(), kSurfaceForms.end()})));
    }
    const auto form = static_cast<SurfaceForm>(word - kSurfaceForms.begin());
    const optim::Promotion& promotion = unknown.promotion;
    const renderer::ParameterTraits& traits = renderer::TraitsOf(promotion.property);
    if (form == SurfaceForm::kVertices && !traits.by_vertex_colors) {
      return Report(node, "only base_color can be per vertex");
    }
    const auto& material = scene_.materials[static_cast<std::size_t>(promotion.material)];
    if (form == SurfaceForm::kConstant && traits.IsPerVertex(material)) {
      return Report(node, "the material's base_color is per vertex already");
    }
    if (form != SurfaceForm::kConstant &&
        renderer::MeshesOfMaterial(scene_, promotion.material).empty()) {
      return Report(node, "no mesh is made of '" + material.name + "'");
    }
    if (!unknown.forms.empty() && form < unknown.forms.back()) {
      return Report(node,
                    fmt::format("'{}' cannot follow '{}'; forms only become finer",
                                node.text,
                                kSurfaceForms.at(static_cast<std::size_t>(unknown.forms.back()))));
    }
    unknown.forms.push_back(form);
  }

  const YamlEntry& entry_;
  const renderer::Scene& scene_;
  std::vector<Problem>& problems_;
  const YamlNode& as_;
};

}  // namespace

std::vector<PromotedUnknown> ReadPromotions(const ExperimentConfig& config,
                                            const renderer::Scene& scene,
                                            std::vector<Problem>& problems) {
  std::vector<PromotedUnknown> promoted;
  const YamlNode* unknowns = config.resolved.Find("unknowns");
  if (unknowns == nullptr) return promoted;
  for (std::size_t i = 0; i < unknowns->entries.size(); ++i) {
    const YamlEntry& entry = unknowns->entries[i];
    if (entry.value.Find("as") == nullptr) continue;
    if (auto unknown = PromotionReader(entry, scene, problems).Read(i)) {
      promoted.push_back(std::move(*unknown));
    }
  }
  return promoted;
}

std::string PromotedTextureName(const renderer::Scene& scene, const optim::Promotion& promotion) {
  return scene.materials[static_cast<std::size_t>(promotion.material)].name + "_" +
         renderer::TraitsOf(promotion.property).property;
}

void AddPromotedTextures(const ExperimentConfig& config, renderer::Scene& scene) {
  std::vector<Problem> problems;  // ReadUnknowns says them
  for (const PromotedUnknown& unknown : ReadPromotions(config, scene, problems)) {
    if (std::ranges::find(unknown.forms, SurfaceForm::kTexture) == unknown.forms.end()) continue;
    renderer::Texture texture;
    texture.name = PromotedTextureName(scene, unknown.promotion);
    if (HasName(scene.textures, texture.name)) {
      throw renderer::SceneError(
          "texture '" + texture.name + "': it has the name of the one that '" +
          config.fit.unknowns[unknown.index].name + "' becomes; give it another name");
    }
    texture.wrap = renderer::TextureWrap::kClamp;
    texture.scalar = renderer::TraitsOf(unknown.promotion.property).NumComponents() == 1;
    texture.texels = {renderer::Rgb{0.5, 0.5, 0.5}};
    scene.textures.push_back(std::move(texture));
  }
}

}  // namespace pathfit::app
