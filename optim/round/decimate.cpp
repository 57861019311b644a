#include "optim/round/decimate.h"

#include <cstddef>
#include <vector>

#include <OpenMesh/Core/Geometry/VectorT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModAspectRatioT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

constexpr double kMostTurnDeg = 60.0;  // of a triangle's normal by one collapse
// Longest side over height: in a flat part corners may come to lie in a row, which no normal shows.
constexpr float kMostAspect = 50.0F;

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
  HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};
using Kernel = OpenMesh::TriMesh_ArrayKernelT<Traits>;

}  // namespace

renderer::Mesh Decimate(const renderer::Mesh& mesh, int num_triangles) {
  Kernel kernel;
  const std::vector<renderer::Vec3>& positions = mesh.positions;
  for (const renderer::Vec3& p : positions) kernel.add_vertex({p.x, p.y, p.z});
  const std::vector<renderer::Triangle>& triangles = mesh.triangles;
  for (const renderer::Triangle& t : triangles) {
    const auto face = kernel.add_face(
        OpenMesh::VertexHandle(t[0]), OpenMesh::VertexHandle(t[1]), OpenMesh::VertexHandle(t[2]));
    if (!face.is_valid()) {
      throw renderer::SceneError("a vertex joins parts of the surface that share no edge there");
    }
  }
  // Quadrics know nothing of borders: in a flat sheet all collapses are free.
  for (const auto v : kernel.vertices()) kernel.status(v).set_locked(kernel.is_boundary(v));
  kernel.update_face_normals();
  OpenMesh::Decimater::DecimaterT<Kernel> decimater(kernel);
  OpenMesh::Decimater::ModQuadricT<Kernel>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<Kernel>::Handle flipping;
  OpenMesh::Decimater::ModAspectRatioT<Kernel>::Handle aspect;
  decimater.add(quadric);
  decimater.add(flipping);
  decimater.add(aspect);
  decimater.module(quadric).unset_max_err();
  decimater.module(flipping).set_max_normal_deviation(kMostTurnDeg);
  decimater.module(aspect).set_aspect_ratio(kMostAspect);
  if (!decimater.initialize()) throw renderer::SceneError("the surface cannot be decimated");
  decimater.decimate_to_faces(0, static_cast<std::size_t>(num_triangles));
  kernel.garbage_collection();

  renderer::Mesh coarse;
  std::vector<renderer::Vec3> kept;
  for (const auto v : kernel.vertices()) {
    const OpenMesh::Vec3d& p = kernel.point(v);
    kept.push_back({p[0], p[1], p[2]});
  }
  std::vector<renderer::Triangle> faces;
  for (const auto f : kernel.faces()) {
    renderer::Triangle t{};
    std::size_t k = 0;
    for (const auto v : kernel.fv_range(f)) t[k++] = v.idx();
    faces.push_back(t);
  }
  coarse.positions = std::move(kept);
  coarse.triangles = std::move(faces);
  return coarse;
}

}  // namespace pathfit::optim
