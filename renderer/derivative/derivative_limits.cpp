#include "renderer/derivative/derivative_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <variant>

#include "renderer/core/error.h"
#include "renderer/derivative/active_parameters.h"
#include "renderer/geometry/mesh_intersection.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/sensor/camera.h"

namespace pathfit::renderer {
namespace {

bool AnyMoves(const ParameterLayout& layout) { return layout.AnyKind(MovesGeometry); }

bool CameraMoves(const ParameterLayout& layout) {
  return layout.AnyKind([](ParameterKind kind) {
    return MovesGeometry(kind) && TraitsOf(kind).list == ObjectList::kSensors;
  });
}

bool MeshMoves(const ParameterLayout& layout, int mesh) {
  const auto& groups = layout.groups();
  return std::any_of(groups.begin(), groups.end(), [mesh](const ParameterGroup& g) {
    return MovesMeshes(g.kind) && g.object == mesh;
  });
}

// Mean angle, rad, beyond which triangles are coarse: about its square of the light is concerned.
constexpr double kCoarse = 0.1;

const Material& MaterialOf(const Scene& scene, const SceneMesh& mesh) {
  return scene.materials[static_cast<std::size_t>(mesh.material)];
}

// Roughness below which lobes are so narrow that boundary samples seldom meet them, and the share
// of a texture from which on it is worth a word.
constexpr double kNarrow = 0.1;
constexpr double kNarrowShare = 0.01;

bool HasNarrowLobes(const Scene& scene, const Material& material) {
  if (material.roughness_texture >= 0) {
    const Texture& texture = scene.textures[static_cast<std::size_t>(material.roughness_texture)];
    const auto narrow = std::count_if(texture.texels.begin(),
                                      texture.texels.end(),
                                      [](const Rgb& texel) { return texel.r < kNarrow; });
    return static_cast<double>(narrow) > kNarrowShare * static_cast<double>(texture.texels.size());
  }
  return std::visit(
      [](const auto& model) {
        if constexpr (requires { model.roughness; }) {
          return model.roughness < kNarrow;
        } else {
          return false;
        }
      },
      material.bsdf);
}

std::string Degrees(double radians) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f", radians * 180.0 * std::numbers::inv_pi);
  return text.data();
}

/// Meshes made of a delta material.
std::vector<std::string> DeltaMeshes(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneMesh& m : scene.meshes) {
    if (IsDelta(MaterialOf(scene, m).bsdf)) {
      names.push_back(m.name);
    }
  }
  return names;
}

bool HasMaterialForm(const Scene& scene) { return DeltaMeshes(scene).empty(); }

/// Whether the plane in which a parallel sensor's rays start cuts the mesh inside the picture.
bool SensorPlaneCuts(const CameraModel& camera, const Mesh& mesh) {
  const Ray ray = camera.RayThrough(0.5, 0.5);
  for (const Triangle& t : mesh.triangles) {
    double low_u = camera.camera().width, low_v = camera.camera().height;
    double high_u = 0.0, high_v = 0.0;
    bool cut = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = mesh.positions[static_cast<std::size_t>(t[i])];
      const Vec3& b = mesh.positions[static_cast<std::size_t>(t[(i + 1) % 3])];
      const double depth_a = Dot(ray.direction, a - ray.origin);
      const double depth_b = Dot(ray.direction, b - ray.origin);
      if (depth_a * depth_b >= 0.0) {
        continue;
      }
      cut = true;
      const Vec3 x = a + (b - a) * (depth_a / (depth_a - depth_b));
      // Rays do not reach the plane they start in: any point before it has the same pixel.
      if (const auto seen = camera.Project(x + ray.direction)) {
        low_u = std::min(low_u, seen->u);
        high_u = std::max(high_u, seen->u);
        low_v = std::min(low_v, seen->v);
        high_v = std::max(high_v, seen->v);
      }
    }
    if (cut && low_u < camera.camera().width && high_u > 0.0 && low_v < camera.camera().height &&
        high_v > 0.0) {
      return true;
    }
  }
  return false;
}

std::vector<Eye> EyesOf(const Scene& scene) {
  std::vector<Eye> eyes;
  for (const Camera& sensor : scene.sensors) {
    if (sensor.projection == ProjectionKind::kOrthographic) {
      eyes.push_back({-CameraModel(sensor).RayThrough(0.5, 0.5).direction, 0.0});
    } else {
      eyes.push_back({sensor.world_from_camera.translation, 1.0});
    }
  }
  return eyes;
}

std::vector<MeshContact> ContactsOf(const Scene& scene, const std::vector<Mesh>& placed) {
  std::vector<const Mesh*> meshes;
  for (const Mesh& m : placed) meshes.push_back(&m);
  return MeshContacts(meshes, EyesOf(scene));
}

void AddLimitsOf(const MeshContact& contact,
                 const Scene& scene,
                 const ParameterLayout& layout,
                 DerivativeForm form,
                 std::vector<std::string>& limits) {
  const auto name = [&](int mesh) {
    return "'" + scene.meshes[static_cast<std::size_t>(mesh)].name + "'";
  };
  const bool same = contact.i == contact.j;
  const std::string names = same ? name(contact.i) : name(contact.i) + " and " + name(contact.j);
  const bool move = MeshMoves(layout, contact.i) || MeshMoves(layout, contact.j);
  const bool sweep = move || CameraMoves(layout);
  if (contact.cut && sweep && (move || form == DerivativeForm::kImage)) {
    limits.push_back(names + (same ? " cuts itself" : " cut each other") +
                     (move ? ": that their common line moves is not in the derivative by moving "
                             "things"
                           : ": that their common line moves in the picture is not in the image "
                             "form's derivative by cameras; the material form has it"));
  }
  if (contact.overlap) {  // what moves before them may be any other thing
    limits.push_back(names + (same ? " lies on itself" : " lie on each other") +
                     " in one plane: which triangle is seen is left to rounding, and what borders "
                     "there do is not in the derivative by moving things");
  }
  if (contact.folded && sweep) {
    limits.push_back(names +
                     " touches itself where its triangles are joined: what edges do there is not "
                     "in the derivative by moving things");
  }
  if (contact.cut || contact.overlap || contact.folded) {
    return;
  }
  if (!same && move) {
    limits.push_back(names +
                     " touch: the derivative is the one of sliding along each other; that they "
                     "part or press into each other is not in it");
  } else if (same && layout.FirstBlock(ParameterKind::kVertexPositions, contact.i) >= 0) {
    limits.push_back("parts of " + names +
                     " touch: the derivative is the one of moving together; that they part or "
                     "press into each other is not in it");
  }
}

void AddPlaneCuts(const Scene& scene,
                  const std::vector<Mesh>& placed,
                  const ParameterLayout& layout,
                  std::vector<std::string>& limits) {
  for (const Camera& sensor : scene.sensors) {
    if (sensor.projection != ProjectionKind::kOrthographic) {
      continue;
    }
    const CameraModel camera(sensor);
    for (std::size_t m = 0; m < placed.size(); ++m) {
      if ((CameraMoves(layout) || MeshMoves(layout, static_cast<int>(m))) &&
          SensorPlaneCuts(camera, placed[m])) {
        limits.push_back(
            "'" + scene.meshes[m].name + "' is cut by the plane in which the rays of '" +
            sensor.name +
            "' start: that the line of the cut moves is not in the derivative by moving "
            "things; move the sensor back");
      }
    }
  }
}

/// Also where nothing but the index of a glass is a parameter.
void AddGlass(const Scene& scene, const ParameterLayout& layout, std::vector<std::string>& limits) {
  bool bends = false;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    bends = bends || BendsRays(scene, layout, static_cast<int>(i));
  }
  if (bends) {
    limits.push_back(
        "the index of smooth glass is a parameter: what is seen through the glass follows it, but "
        "edges and borders of shadows seen through it, and light that reaches rough surfaces "
        "through it, are not in the derivative by the index");
  }
  for (const SceneMesh& m : scene.meshes) {
    // Beckmann has no upright microfacets.
    const auto* glass = std::get_if<RoughDielectricBsdf>(&MaterialOf(scene, m).bsdf);
    if (glass != nullptr && glass->distribution == MicrofacetDistribution::kGgx &&
        (AnyMoves(layout) || layout.FirstBlock(ParameterKind::kEta, m.material) >= 0)) {
      limits.push_back(
          "'" + m.name +
          "' is rough glass: the light it lets through ends with a step where it would need "
          "upright microfacets; that this border moves is not in the derivative by moving things "
          "or by its index; the rougher and the more oblique, the more it is");
    }
  }
}

/// Of things that move, by what they are seen in.
void AddMirrors(const Scene& scene, std::vector<std::string>& limits) {
  for (const SceneMesh& m : scene.meshes) {
    if (HasNarrowLobes(scene, MaterialOf(scene, m))) {
      limits.push_back(
          "'" + m.name +
          "' is nearly a mirror in places (roughness below 0.1): the borders of things and lights "
          "seen in it are seldom met by boundary samples: with few of them most of what they do "
          "is missing from the derivative by moving things");
    }
  }
  for (const std::string& name : DeltaMeshes(scene)) {
    limits.push_back("'" + name +
                     "' is a mirror or smooth glass: what is seen in it follows moving things, but "
                     "edges and borders of shadows seen in it, and light and shadows that reach "
                     "rough surfaces by way of it, are not in the derivative by moving things and "
                     "cameras, which may be far off where there is much of them");
  }
}

void AddCoarseMeshes(const Scene& scene,
                     const std::vector<Mesh>& placed,
                     std::vector<std::string>& limits) {
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const SceneMesh& m = scene.meshes[i];
    const double deviation = MeanShadingDeviation(placed[i]);
    if (deviation > kCoarse && !IsDelta(MaterialOf(scene, m).bsdf)) {
      limits.push_back(
          "'" + m.name + "' is coarse for interpolated normals: its triangles lie " +
          Degrees(deviation) +
          " degrees off them on average, and each stops to reflect at its own horizon; that the "
          "horizon moves is not in the derivative by moving things; shade it flat or refine it");
    }
  }
}

/// Mean angle between a normal texture's directions and the frame's, rad.
double MeanTilt(const Texture& texture, double scale) {
  double sum = 0.0;
  for (const Rgb& texel : texture.texels.Items()) {
    const double x = scale * (2.0 * texel.r - 1.0), y = scale * (2.0 * texel.g - 1.0);
    sum += std::atan2(std::hypot(x, y), 2.0 * texel.b - 1.0);
  }
  return sum / static_cast<double>(texture.texels.size());
}

void AddNormalMaps(const Scene& scene,
                   const ParameterLayout& layout,
                   std::vector<std::string>& limits) {
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const SceneMesh& m = scene.meshes[i];
    const Material& material = MaterialOf(scene, m);
    if (material.normal_texture < 0) continue;
    const Texture& texture = scene.textures[static_cast<std::size_t>(material.normal_texture)];
    if (layout.FirstBlock(ParameterKind::kUvs, static_cast<int>(i)) >= 0) {
      limits.push_back("'" + m.name + "' has the normal texture '" + texture.name +
                       "': what that does is not in the derivative by its UVs");
    }
    if (!AnyMoves(layout)) continue;
    if (const double tilt = MeanTilt(texture, material.normal_scale); tilt > kCoarse) {
      limits.push_back("'" + m.name + "' has the normal texture '" + texture.name +
                       "', which turns its normals by " + Degrees(tilt) +
                       " degrees on average: triangles stop to reflect at their own "
                       "horizons; that the horizon moves is not in the "
                       "derivative by moving things");
    }
  }
}

bool HasProjector(const Scene& scene) {
  return std::ranges::any_of(scene.emitters, [](const Emitter& emitter) {
    return std::holds_alternative<ProjectorEmitter>(emitter.light);
  });
}

/// As DefaultForm says. Folds of one mesh are no reason to take the noisier form for all of it.
DerivativeForm FormThatFollows(const Scene& scene,
                               const ParameterLayout& layout,
                               const std::vector<MeshContact>& contacts) {
  const bool follows = CameraMoves(layout) && HasMaterialForm(scene) &&
                       (HasProjector(scene) || std::ranges::any_of(contacts, [](const auto& c) {
                          return c.cut && c.i != c.j;
                        }));
  return follows ? DerivativeForm::kMaterial : DerivativeForm::kImage;
}

bool MovesInTheWorld(ParameterKind kind) {
  return MovesGeometry(kind) && TraitsOf(kind).list != ObjectList::kSensors;
}

void AddProjectors(const Scene& scene,
                   const ParameterLayout& layout,
                   DerivativeForm form,
                   std::vector<std::string>& limits) {
  const bool moves = layout.AnyKind(MovesInTheWorld);
  if (!moves && form == DerivativeForm::kMaterial) return;
  for (const Emitter& emitter : scene.emitters) {
    if (std::holds_alternative<ProjectorEmitter>(emitter.light)) {
      limits.push_back("'" + emitter.name +
                       "' is a projector: the border of its picture is not in " +
                       (moves ? "the derivative by moving things"
                              : "the image form's derivative by cameras, the material form has "
                                "it") +
                       "; it does not matter where the picture is black there");
    }
  }
}

}  // namespace

std::vector<std::string> DerivativeLimits(const Scene& scene,
                                          const ParameterLayout& layout,
                                          std::optional<DerivativeForm> form) {
  std::vector<std::string> limits;
  AddGlass(scene, layout, limits);
  AddNormalMaps(scene, layout, limits);
  if (!AnyMoves(layout)) {
    return limits;
  }
  AddMirrors(scene, limits);
  const std::vector<Mesh> placed = WorldMeshes(scene);
  AddCoarseMeshes(scene, placed, limits);
  const std::vector<MeshContact> contacts = ContactsOf(scene, placed);
  const DerivativeForm taken = form ? *form : FormThatFollows(scene, layout, contacts);
  for (const MeshContact& contact : contacts) {
    AddLimitsOf(contact, scene, layout, taken, limits);
  }
  AddPlaneCuts(scene, placed, layout, limits);
  AddProjectors(scene, layout, taken, limits);
  return limits;
}

DerivativeForm DefaultForm(const Scene& scene, const ParameterLayout& layout) {
  const bool may_follow_cuts = CameraMoves(layout) && HasMaterialForm(scene);
  return FormThatFollows(
      scene,
      layout,
      may_follow_cuts ? ContactsOf(scene, WorldMeshes(scene)) : std::vector<MeshContact>());
}

void CheckDerivative(const Scene& scene,
                     const ParameterLayout& layout,
                     const RenderOptions& options) {
  if (options.form != DerivativeForm::kMaterial || !AnyMoves(layout)) {
    return;
  }
  const std::vector<std::string> names = DeltaMeshes(scene);
  if (!names.empty()) {
    throw SceneError("'" + names.front() +
                     "' is a mirror or smooth glass: its points do not keep what they reflect, so "
                     "the material form has no derivative; use the image form");
  }
}

}  // namespace pathfit::renderer
