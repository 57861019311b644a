#include <algorithm>

#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "app/config/schema_parts.h"
#include "optim/observation/visual_hull.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::app {
namespace {

template <class Shape>
Shape& Become(GeometryConfig& geometry) {
  return geometry.geometry.emplace<Shape>();
}

SchemaNode PrimitiveSchema() {
  return Map("primitive",
             {MapOf("sphere",
                    {Key("radius_m", &SphereGeometry::radius) | Doc("Radius.") |
                         Between(0.0, kMaxLength) | Unit("metres"),
                     Key("subdivisions", &SphereGeometry::subdivisions) |
                         Doc("Each adds a factor 4 of triangles to an icosahedron.") | From(0, 8)},
                    Become<SphereGeometry>) |
                  Doc("Sphere of triangles around the origin.") | OneOf("primitive"),
              MapOf("rectangle", {}, Become<RectangleGeometry>) |
                  Doc("[-1, 1]² in the plane z = 0, seen from +z.") | OneOf("primitive"),
              MapOf("cube", {}, Become<CubeGeometry>) | Doc("[-1, 1]³.") | OneOf("primitive"),
              MapOf("disk",
                    {Key("segments", &DiskGeometry::segments) | Doc("Corners on the circle.") |
                     From(3, 65536)},
                    Become<DiskGeometry>) |
                  Doc("Radius 1 around the origin in the plane z = 0, seen from +z.") |
                  OneOf("primitive")}) |
         Doc("A simple shape with UVs; size and place come from `transform`.") | OneOf("shape");
}

void CheckInlineMesh(InlineGeometry& mesh, const CheckedMap& map) {
  if (map.Find("vertices") == nullptr) return;
  const auto count = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& corners = mesh.triangles[i];
    const int largest = *std::ranges::max_element(corners);
    if (largest < count) continue;
    map.Report("triangles",
               map.Find("triangles")->items[i],
               fmt::format("there is no vertex {}; there are {}, counted from 0", largest, count));
  }
  const auto one_per_vertex = [&](const char* key, const char* noun, std::size_t given) {
    if (map.Find(key) == nullptr || given == mesh.vertices.size()) return;
    map.Report(
        key,
        fmt::format(
            "{} {} for {} vertices; one for each is needed", given, noun, mesh.vertices.size()));
  };
  one_per_vertex("colors", "colours", mesh.colors.size());
  one_per_vertex("normals", "normals", mesh.normals.size());
  one_per_vertex("uvs", "UVs", mesh.uvs.size());
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    if (!IsZero(mesh.normals[i])) continue;
    map.Report("normals", map.Find("normals")->items[i], "a normal must not be [0, 0, 0]");
  }
}

SchemaNode InlineMeshSchema() {
  return MapOf(
             "mesh",
             {Point("vertices", &InlineGeometry::vertices) | Doc("Positions.") | Items(3, 0) |
                  Required(),
              Key("triangles", &InlineGeometry::triangles) |
                  Doc("Three vertex numbers each, counted from 0, counter-clockwise from "
                      "outside.") |
                  From(0, 2147483647) | Items(1, 0) | Required(),
              Key("colors", &InlineGeometry::colors) | Doc("One per vertex.") | AtLeast(0.0) |
                  Unit("linear Rec.709") | Optional(),
              Key("normals", &InlineGeometry::normals) |
                  Doc("One per vertex; their length does not matter.") | Optional(),
              Key("uvs", &InlineGeometry::uvs) |
                  Doc("One per vertex; 0, 0 is the bottom-left corner of a texture.") | Optional()},
             Become<InlineGeometry>) |
         Doc("A mesh written here.") | OneOf("shape") | Check(CheckInlineMesh);
}

SchemaNode TransformSchema() {
  return MapOf("transform",
               {Key("scale", &TransformConfig::scale) |
                    Doc("Factor, or one for each axis; applied first.") | Between(0.0, kMaxLength) |
                    OrOne(),
                Rotation<TransformConfig>("Applied second."),
                Point("translate_m", &TransformConfig::translate) | Doc("Applied last.")},
               &GeometryConfig::transform) |
         Doc("From the mesh's own frame to the world.");
}

/// Unless they are to be repaired.
void CheckTriangleAreas(const GeometryConfig& geometry, const CheckedMap& map) {
  const auto* mesh = std::get_if<InlineGeometry>(&geometry.geometry);
  if (mesh == nullptr || geometry.repair) return;
  for (std::size_t i = 0; i < mesh->triangles.size(); ++i) {
    std::array<Triple, 3> corners;
    bool has_all = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto index = static_cast<std::size_t>(mesh->triangles[i].at(c));
      has_all = has_all && index < mesh->vertices.size();
      if (has_all) corners.at(c) = mesh->vertices[index];
    }
    if (has_all &&
        Norm(Cross(Minus(corners[1], corners[0]), Minus(corners[2], corners[0]))) == 0.0) {
      map.Report("mesh.triangles",
                 map.Find("mesh")->Find("triangles")->items[i],
                 "the triangle has no area");
    }
  }
}

void CheckGeometry(GeometryConfig& geometry, const CheckedMap& map) {
  CheckTriangleAreas(geometry, map);
  if (!IsGltf(geometry)) {
    // One that is there but wrong is taken out before.
    const bool is_wrong = std::ranges::any_of(map.problems, [&map](const Problem& problem) {
      return problem.path == map.path + ".material";
    });
    if (map.Find("material") == nullptr && !is_wrong) {
      map.problems.push_back(
          {map.node.place, map.path, "required key 'material' is missing (a name)"});
    }
    if (geometry.lights) map.Report("lights", "only glTF files have lights");
    if (geometry.camera_height_px) {
      map.Report("camera_height_px", "only glTF files have cameras");
    }
  }
  const YamlNode* groups = map.Find("materials");
  if (groups == nullptr) return;
  for (const YamlEntry& group : groups->entries) {
    geometry.group_materials.emplace_back(group.key, group.value.text);
  }
}

}  // namespace

SchemaNode GeometrySchema() {
  using Normals = GeometryConfig::Normals;
  const std::string file =
      renderer::MeshFormatNames() +
      "; a glTF file has materials and textures, too: they keep their names, so "
      "that `MATERIAL.roughness` or `TEXTURE.texels` can be unknown. Several nodes or materials "
      "become meshes called `MESH-NODE` or `MESH-NODE-MATERIAL`.";
  SchemaNode group =
      binding::Make(SchemaNode::Type::kName, "USEMTL") | Doc("One of `scene.materials`.");
  SchemaNode groups =
      ByCheck(binding::Make(SchemaNode::Type::kNamedMap, "materials") |
              Doc("Materials of an OBJ file by the names of its `usemtl` lines; what is not named "
                  "here has `material`. Each becomes a mesh of its own, called `MESH-USEMTL`; they "
                  "should meet at creases, not on smooth surfaces. Of a glTF file: materials "
                  "instead of its own, by their names."));
  groups.children = {group};
  const char* own = "those of a glTF file; else **required**";
  const SchemaNode lights = Key("lights", &GeometryConfig::lights) |
                            Doc("Takes the lights of a glTF file, too: `MESH-LIGHT`.") |
                            Needs("file");
  const SchemaNode cameras =
      Key("camera_height_px", &GeometryConfig::camera_height_px) |
      Doc("Takes the cameras of a glTF file, too: `MESH-CAMERA`. Height of their pictures, whose "
          "width follows from the file.") |
      From(1, 32768) | DefaultIs("no cameras") | Needs("file");
  return NamedMap("geometry",
                  "MESH",
                  Map("",
                      {Key("file",
                           [](GeometryConfig& g) -> std::filesystem::path& {
                             return Become<FileGeometry>(g).path;
                           }) |
                           Doc(file) | OneOf("shape"),
                       PrimitiveSchema(),
                       InlineMeshSchema(),
                       MapOf("visual_hull",
                             {Key("resolution", &VisualHullGeometry::resolution) |
                                  Doc("Cells along the longest side of the box.") |
                                  From(optim::VisualHullOptions::kMinResolution,
                                       optim::VisualHullOptions::kMaxResolution) |
                                  DefaultIs("as wide as a pixel; 32 to 256"),
                              Key("dissent", &VisualHullGeometry::dissent) |
                                  Doc("Share of the photos whose masks may leave out what the "
                                      "others show; above 0 where masks are rough.") |
                                  From(0.0, optim::VisualHullOptions::kMaxDissent)},
                             Become<VisualHullGeometry>) |
                           Doc("Carved from the masks.") | OneOf("shape"),
                       Name("material", &GeometryConfig::material) |
                           Doc("One of `scene.materials`.") | DefaultIs(own),
                       lights,
                       cameras,
                       groups | FreeNames() | Needs("file"),
                       Choice("normals",
                              {{"file", Normals::kFile},
                               {"flat", Normals::kFlat},
                               {"smooth", Normals::kSmooth}},
                              &GeometryConfig::normals) |
                           Doc("How triangles are shaded: by the normals of the file (or of "
                               "`mesh`) if there are any, else flat; `flat`: each by its own; "
                               "`smooth`: by interpolated normals of the vertices.") |
                           DefaultIs("`file`; `flat` where `MESH.vertices` is unknown"),
                       Key("repair", &GeometryConfig::repair) |
                           Doc("Mend what else is refused (not manifold, degenerate, "
                               "inconsistently wound) and say what was mended."),
                       TransformSchema(),
                       Point("pivot_m", &GeometryConfig::pivot) |
                           Doc("What `MESH.rotation` and `MESH.scale` turn and grow about, in the "
                               "world.") |
                           DefaultIs("middle of the bounding box")}) |
                      Check(CheckGeometry) |
                      Refuse({{"uv", "; UVs come from the file or from `mesh.uvs`"},
                              {"from_points", "; write visual_hull, or give a file"}}),
                  &ExperimentConfig::geometry) |
         Doc("What is in the scene.") | Required() | Items(1, 0);
}

}  // namespace pathfit::app
