#include "app/config/schema_builders.h"

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
              Map("cube", {}, "[-1, 1]³.").OneOf("primitive")},
             "A simple solid; size and place come from `transform`.")
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
              List("colors", Colour("", ""), "One per vertex.").Unit("linear Rec.709")},
             "A mesh written here.")
      .OneOf("shape");
}

SchemaNode GeometrySchema() {
  const SchemaNode scale =
      Either("scale",
             {Number("", "").Above(0.0), List("", Number("", "").Above(0.0), "").Items(3, 3)},
             "Factor, or one for each axis; applied first.")
          .Default("1");
  return NamedMap(
             "geometry",
             "MESH",
             Map("",
                 {Path("file", "OBJ or PLY.").OneOf("shape"),
                  PrimitiveSchema(),
                  InlineMeshSchema(),
                  Map("visual_hull",
                      {Integer("resolution", "Cells along the longest side of the box.")
                           .From(8, 1024)
                           .Default("128")},
                      "Carved from the masks.")
                      .OneOf("shape"),
                  Name("material", "One of `scene.materials`.").Required(),
                  Map("transform",
                      {scale,
                       Rotation("rotate", "Applied second."),
                       Vector("translate_m", "Applied last.").Unit("metres").Default("[0, 0, 0]")},
                      "From the mesh's own frame to the world.")},
                 "A mesh.")
                 .Refuse({{"uv", "; colours are per vertex or constant"},
                          {"from_points", "; write visual_hull, or give a file"}}),
             "What is in the scene.")
      .Required()
      .Items(1, 0);
}

SchemaNode MaterialsSchema() {
  const std::vector<Unsupported> no_textures = {
      {"texture", "; write constant, or vertex for a base colour"}};
  const auto number = [&](const char* key, double lower, const char* value, const char* doc) {
    return Map(key,
               {Number("constant", doc).From(lower, 1.0).Default(value)},
               "The same everywhere.")
        .Always()
        .When("model", {"metallic_roughness"})
        .Refuse(no_textures);
  };
  const SchemaNode base_color =
      Map("base_color",
          {List("constant", Number("", "").From(0.0, 1.0), "One colour everywhere.")
               .Items(3, 3)
               .Unit("linear Rec.709")
               .OneOf("source"),
           Either(
               "vertex",
               {Choice("", {"mesh"}, ""), List("", Number("", "").From(0.0, 1.0), "").Items(3, 3)},
               "One colour per vertex: the start value of all, or `mesh` for those of the file.")
               .Unit("linear Rec.709")
               .OneOf("source")},
          "Colour of the surface.")
          .Required()
          .Refuse(no_textures);
  return NamedMap(
             "materials",
             "MATERIAL",
             Map("",
                 {Choice("model",
                         {"diffuse", "metallic_roughness"},
                         "Lambert, or glTF's metallic-roughness (GGX).")
                      .Required()
                      .Refuse({{"conductor", "; metallic_roughness with metallic 1 is near"},
                               {"dielectric", ""}}),
                  base_color,
                  number("roughness", 0.1, "0.5", "Perceptual roughness, alpha = roughness²."),
                  number("metallic", 0.0, "0", "0 = plastic, 1 = metal."),
                  Bool("two_sided", "Seen from behind too (else black there).").Default("true")},
                 "A material.")
                 .Refuse({{"ior", "; it is 1.5"}, {"preset", ""}}),
             "What the meshes are made of.")
      .Required()
      .Items(1, 0);
}

SchemaNode LightsSchema() {
  const std::vector<std::string> environments = {"envmap", "constant"};
  const SchemaNode init = Map("init",
                              {Colour("constant", "Every texel.").Default("[1, 1, 1]")},
                              "What the environment starts from.")
                              .Always()
                              .Needs("size_px")
                              .When("type", {"envmap"});
  return NamedMap(
      "lights",
      "LIGHT",
      Map("",
          {Choice("type",
                  {"envmap", "constant", "point", "directional"},
                  "`envmap`: picture of all directions; `constant`: the same from everywhere.")
               .Required()
               .Refuse({{"area", ""}, {"spot", ""}}),
           Path("file", "Latitude-longitude picture, EXR or HDR.")
               .OneOf("source")
               .When("type", {"envmap"}),
           Size("size_px", "Size of an environment without file.")
               .OneOf("source")
               .When("type", {"envmap"}),
           init,
           Rotation("rotate", "Turns the environment.").When("type", {"envmap"}),
           Colour("radiance", "Radiance.")
               .Unit("W/(sr m²), relative")
               .Default("[1, 1, 1]")
               .When("type", {"constant"}),
           Bool("visible", "Seen behind the objects (else black there, without coverage).")
               .Default("true")
               .When("type", environments),
           Vector("position_m", "Place of the light.")
               .Unit("metres")
               .Required()
               .When("type", {"point"}),
           Colour("intensity", "Factor of an environment; radiant intensity of a point light.")
               .Unit("1, or W/sr")
               .Default("[1, 1, 1]")
               .When("type", {"envmap", "point"}),
           Vector("direction", "Where the light goes; its length does not matter.")
               .Required()
               .When("type", {"directional"}),
           Colour("irradiance", "On a surface facing the light.")
               .Unit("W/m²")
               .Default("[1, 1, 1]")
               .When("type", {"directional"}),
           Choice("frame",
                  {"world", "camera"},
                  "`camera`: the light goes with the camera, as for an object on a turntable.")
               .Default("world")},
          "A light."),
      "What shines. At most one `envmap` or `constant`.");
}

SchemaNode SensorsSchema() {
  const SchemaNode pose =
      Map("pose",
          {Map("look_at",
               {Vector("origin_m", "Place of the camera.").Unit("metres").Required(),
                Vector("target_m", "What is in the middle of the picture.")
                    .Unit("metres")
                    .Required(),
                Vector("up", "What is up in the picture.").Default("[0, 1, 0]")},
               "Pose by what is looked at.")
               .OneOf("pose"),
           List("world_from_camera",
                List("", Number("", ""), "").Items(4, 4),
                "4 rows of a rigid transform; camera: x right, y up, looking along -z.")
               .Items(4, 4)
               .OneOf("pose")},
          "Where the camera is.")
          .Required();
  const auto coefficient = [](const char* key) {
    return Number(key, "Coefficient of OpenCV's model.").Default("0");
  };
  return NamedMap(
      "sensors",
      "SENSOR",
      Map("",
          {Choice("type", {"perspective"}, "Kind of camera.")
               .Default("perspective")
               .Refuse({{"orthographic", ""}}),
           Size("size_px", "Size of the whole picture.").Required(),
           Either("focal_px",
                  {Number("", "").Above(0.0), List("", Number("", "").Above(0.0), "").Items(2, 2)},
                  "Focal length, or one for x and one for y.")
               .Unit("pixels")
               .OneOf("focal"),
           Number("fov_deg", "Angle of view.").Between(0.0, 180.0).Unit("degrees").OneOf("focal"),
           Choice("fov_axis",
                  {"x", "y", "smaller", "larger", "diagonal"},
                  "Along which side of the picture `fov_deg` is measured.")
               .Default("smaller")
               .Needs("fov_deg"),
           List("principal_point_px",
                Number("", ""),
                "From the top-left corner of the picture; the first pixel's centre is 0.5, 0.5.")
               .Items(2, 2)
               .Unit("pixels")
               .DefaultIs("middle of the picture"),
           Map("distortion",
               {coefficient("k1"),
                coefficient("k2"),
                coefficient("k3"),
                coefficient("p1"),
                coefficient("p2")},
               "Brown's lens distortion.")
               .Always(),
           pose,
           List("crop_px", Integer("", "").From(0, 32768), "Part to render: x, y, width, height.")
               .Items(4, 4)
               .Unit("pixels")
               .DefaultIs("the whole picture"),
           Number("exposure_ev", "Brightness factor as a power of two.")
               .From(-20, 20)
               .Unit("EV")
               .Default("0")},
          "A camera."),
      "Cameras of a scene without photos.");
}

}  // namespace

SchemaNode SceneSchema() {
  return Map("scene",
             {GeometrySchema(), MaterialsSchema(), LightsSchema(), SensorsSchema()},
             "The model that the fit starts from. Right-handed, y up, metres.")
      .Required();
}

}  // namespace pathfit::app
