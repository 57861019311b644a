#include "app/config/schema_builders.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::app {
namespace {

SchemaNode PrimitiveSchema() {
  return Map("primitive",
             {Map("sphere",
                  {Number("radius_m", "Radius.").Above(0.0).Unit("metres").Default("1"),
                   Integer("subdivisions", "Each adds a factor 4 of triangles to an icosahedron.")
                       .From(0, 8)
                       .Default("4")},
                  "Sphere of triangles around the origin.")
                  .OneOf("primitive"),
              Map("rectangle", {}, "[-1, 1]² in the plane z = 0, seen from +z.").OneOf("primitive"),
              Map("cube", {}, "[-1, 1]³.").OneOf("primitive"),
              Map("disk",
                  {Integer("segments", "Corners on the circle.").From(3, 65536).Default("64")},
                  "Radius 1 around the origin in the plane z = 0, seen from +z.")
                  .OneOf("primitive")},
             "A simple shape with UVs; size and place come from `transform`.")
      .OneOf("shape");
}

SchemaNode InlineMeshSchema() {
  return Map("mesh",
             {List("vertices", Vector("", ""), "Positions.").Items(3, 0).Unit("metres").Required(),
              List("triangles",
                   List("", Integer("", "").From(0, 2147483647), "").Items(3, 3),
                   "Three vertex numbers each, counted from 0, counter-clockwise from outside.")
                  .Items(1, 0)
                  .Required(),
              List("colors", Colour("", ""), "One per vertex.").Unit("linear Rec.709"),
              List("normals", Vector("", ""), "One per vertex; their length does not matter."),
              List("uvs",
                   List("", Number("", ""), "").Items(2, 2),
                   "One per vertex; 0, 0 is the bottom-left corner of a texture.")},
             "A mesh written here.")
      .OneOf("shape");
}

SchemaNode TransformSchema() {
  const SchemaNode scale =
      Either("scale",
             {Number("", "").Above(0.0), List("", Number("", "").Above(0.0), "").Items(3, 3)},
             "Factor, or one for each axis; applied first.")
          .Default("1");
  return Map("transform",
             {scale,
              Rotation("rotate", "Applied second."),
              Vector("translate_m", "Applied last.").Unit("metres").Default("[0, 0, 0]")},
             "From the mesh's own frame to the world.");
}

}  // namespace

SchemaNode GeometrySchema() {
  return NamedMap(
             "geometry",
             "MESH",
             Map("",
                 {Path("file", renderer::MeshFormatNames() + ".").OneOf("shape"),
                  PrimitiveSchema(),
                  InlineMeshSchema(),
                  Map("visual_hull",
                      {Integer("resolution", "Cells along the longest side of the box.")
                           .From(8, 1024)
                           .Default("128")},
                      "Carved from the masks.")
                      .OneOf("shape"),
                  Name("material", "One of `scene.materials`.").Required(),
                  NamedMap("materials",
                           "USEMTL",
                           Name("", "One of `scene.materials`."),
                           "Materials of an OBJ file by the names of its `usemtl` lines; what is "
                           "not named here has `material`. Each becomes a mesh of its own, called "
                           "`MESH-USEMTL`; they should meet at creases, not on smooth surfaces.")
                      .FreeNames()
                      .Needs("file"),
                  Choice("normals",
                         {"file", "flat", "smooth"},
                         "How triangles are shaded: by the normals of the file (or of `mesh`) if "
                         "there are any, else flat; `flat`: each by its own; `smooth`: by "
                         "interpolated normals of the vertices.")
                      .DefaultIs("`file`; `flat` where `MESH.vertices` is unknown"),
                  Bool("repair",
                       "Mend what else is refused (not manifold, degenerate, inconsistently wound) "
                       "and say what was mended.")
                      .Default("false"),
                  TransformSchema(),
                  Vector("pivot_m",
                         "What `MESH.rotation` and `MESH.scale` turn and grow about, in the world.")
                      .Unit("metres")
                      .DefaultIs("middle of the bounding box")},
                 "A mesh.")
                 .Refuse({{"uv", "; UVs come from the file or from `mesh.uvs`"},
                          {"from_points", "; write visual_hull, or give a file"}}),
             "What is in the scene.")
      .Required()
      .Items(1, 0);
}

}  // namespace pathfit::app
