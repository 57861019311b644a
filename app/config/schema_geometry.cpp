#include <algorithm>

#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "app/config/schema_parts.h"
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
                    {Key("radius_m", "Radius.", &SphereGeometry::radius)
                         .Between(0.0, kMaxLength)
                         .Unit("metres"),
                     Key("subdivisions",
                         "Each adds a factor 4 of triangles to an icosahedron.",
                         &SphereGeometry::subdivisions)
                         .From(0, 8)},
                    "Sphere of triangles around the origin.",
                    Become<SphereGeometry>)
                  .OneOf("primitive"),
              MapOf("rectangle",
                    {},
                    "[-1, 1]² in the plane z = 0, seen from +z.",
                    Become<RectangleGeometry>)
                  .OneOf("primitive"),
              MapOf("cube", {}, "[-1, 1]³.", Become<CubeGeometry>).OneOf("primitive"),
              MapOf("disk",
                    {Key("segments", "Corners on the circle.", &DiskGeometry::segments)
                         .From(3, 65536)},
                    "Radius 1 around the origin in the plane z = 0, seen from +z.",
                    Become<DiskGeometry>)
                  .OneOf("primitive")},
             "A simple shape with UVs; size and place come from `transform`.")
      .OneOf("shape");
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
  return MapOf("mesh",
               {Point("vertices", "Positions.", &InlineGeometry::vertices).Items(3, 0).Required(),
                Key("triangles",
                    "Three vertex numbers each, counted from 0, counter-clockwise from outside.",
                    &InlineGeometry::triangles)
                    .From(0, 2147483647)
                    .Items(1, 0)
                    .Required(),
                Key("colors", "One per vertex.", &InlineGeometry::colors)
                    .AtLeast(0.0)
                    .Unit("linear Rec.709")
                    .Optional(),
                Key("normals",
                    "One per vertex; their length does not matter.",
                    &InlineGeometry::normals)
                    .Optional(),
                Key("uvs",
                    "One per vertex; 0, 0 is the bottom-left corner of a texture.",
                    &InlineGeometry::uvs)
                    .Optional()},
               "A mesh written here.",
               Become<InlineGeometry>)
      .OneOf("shape")
      .Check(CheckInlineMesh);
}

SchemaNode TransformSchema() {
  return MapOf(
      "transform",
      {Key("scale", "Factor, or one for each axis; applied first.", &TransformConfig::scale)
           .Between(0.0, kMaxLength)
           .OrOne(),
       Rotation<TransformConfig>("Applied second."),
       Point("translate_m", "Applied last.", &TransformConfig::translate)},
      "From the mesh's own frame to the world.",
      &GeometryConfig::transform);
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
  const YamlNode* groups = map.Find("materials");
  if (groups == nullptr) return;
  for (const YamlEntry& group : groups->entries) {
    geometry.group_materials.emplace_back(group.key, group.value.text);
  }
}

}  // namespace

SchemaNode GeometrySchema() {
  using Normals = GeometryConfig::Normals;
  SchemaNode group = binding::Make(SchemaNode::Type::kName, "USEMTL", "One of `scene.materials`.");
  SchemaNode groups = ByCheck(binding::Make(
      SchemaNode::Type::kNamedMap,
      "materials",
      "Materials of an OBJ file by the names of its `usemtl` lines; what is not named here has "
      "`material`. Each becomes a mesh of its own, called `MESH-USEMTL`; they should meet at "
      "creases, not on smooth surfaces."));
  groups.children = {group};
  return NamedMap(
             "geometry",
             "MESH",
             Map("",
                 {Key("file",
                      renderer::MeshFormatNames() + ".",
                      [](GeometryConfig& g) -> std::filesystem::path& {
                        return Become<FileGeometry>(g).path;
                      })
                      .OneOf("shape"),
                  PrimitiveSchema(),
                  InlineMeshSchema(),
                  MapOf("visual_hull",
                        {Key("resolution",
                             "Cells along the longest side of the box.",
                             &VisualHullGeometry::resolution)
                             .From(8, 1024)},
                        "Carved from the masks.",
                        Become<VisualHullGeometry>)
                      .OneOf("shape"),
                  Name("material", "One of `scene.materials`.", &GeometryConfig::material)
                      .Required(),
                  groups.FreeNames().Needs("file"),
                  Choice("normals",
                         {{"file", Normals::kFile},
                          {"flat", Normals::kFlat},
                          {"smooth", Normals::kSmooth}},
                         "How triangles are shaded: by the normals of the file (or of `mesh`) if "
                         "there are any, else flat; `flat`: each by its own; `smooth`: by "
                         "interpolated normals of the vertices.",
                         &GeometryConfig::normals)
                      .DefaultIs("`file`; `flat` where `MESH.vertices` is unknown"),
                  Key("repair",
                      "Mend what else is refused (not manifold, degenerate, inconsistently wound) "
                      "and say what was mended.",
                      &GeometryConfig::repair),
                  TransformSchema(),
                  Point("pivot_m",
                        "What `MESH.rotation` and `MESH.scale` turn and grow about, in the world.",
                        &GeometryConfig::pivot)
                      .DefaultIs("middle of the bounding box")},
                 "A mesh.")
                 .Check(CheckGeometry)
                 .Refuse({{"uv", "; UVs come from the file or from `mesh.uvs`"},
                          {"from_points", "; write visual_hull, or give a file"}}),
             "What is in the scene.",
             &ExperimentConfig::geometry)
      .Required()
      .Items(1, 0);
}

}  // namespace pathfit::app
