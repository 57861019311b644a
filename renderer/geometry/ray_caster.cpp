#include "renderer/geometry/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "renderer/core/error.h"
#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/embree_compat.h"

namespace pathfit::renderer {
namespace {

void FillRay(const Ray& ray, const Vec3& center, double near, double far, RTCRay& out) {
  out.org_x = static_cast<float>(ray.origin.x - center.x);
  out.org_y = static_cast<float>(ray.origin.y - center.y);
  out.org_z = static_cast<float>(ray.origin.z - center.z);
  out.dir_x = static_cast<float>(ray.direction.x);
  out.dir_y = static_cast<float>(ray.direction.y);
  out.dir_z = static_cast<float>(ray.direction.z);
  out.tnear = static_cast<float>(near);
  out.tfar = static_cast<float>(far);
  out.time = 0.0F;
  out.mask = 0xFFFFFFFFU;
  out.id = 0;
  out.flags = 0;
}

void AddMesh(RTCDevice device, RTCScene scene, const Mesh& mesh, const Vec3& center) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry,
                                                               RTC_BUFFER_TYPE_VERTEX,
                                                               0,
                                                               RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float),
                                                               mesh.positions.size()));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry,
                                                                 RTC_BUFFER_TYPE_INDEX,
                                                                 0,
                                                                 RTC_FORMAT_UINT3,
                                                                 3 * sizeof(unsigned),
                                                                 mesh.triangles.size()));
  if (vertices != nullptr && indices != nullptr) {
    for (const Vec3& p : mesh.positions) {
      *vertices++ = static_cast<float>(p.x - center.x);
      *vertices++ = static_cast<float>(p.y - center.y);
      *vertices++ = static_cast<float>(p.z - center.z);
    }
    for (const Triangle& t : mesh.triangles) {
      for (const std::int32_t index : t) {
        *indices++ = static_cast<unsigned>(index);
      }
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace

struct RayCaster::Handles {
  Handles() : device(rtcNewDevice(nullptr)) {}
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    if (scene != nullptr) {
      rtcReleaseScene(scene);
    }
    rtcReleaseDevice(device);
  }
  RTCDevice device;
  RTCScene scene = nullptr;
};

std::string EmbreeVersion() { return RTC_VERSION_STRING; }

RayCaster::RayCaster() : handles_(std::make_unique<Handles>()) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

void RayCaster::Build(const std::vector<const Mesh*>& meshes) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity};
  Vec3 high = -low;
  first_triangle_.clear();
  triangles_.clear();
  for (const Mesh* mesh : meshes) {
    first_triangle_.push_back(static_cast<std::int64_t>(triangles_.size()));
    for (const Vec3& p : mesh->positions) {
      for (int i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], p[i]);
        high[i] = std::max(high[i], p[i]);
      }
    }
    for (const Triangle& t : mesh->triangles) {
      const auto corner = [&](int i) {
        return mesh->positions[static_cast<std::size_t>(t[static_cast<std::size_t>(i)])];
      };
      triangles_.push_back(TriangleGeometry::Make(corner(0), corner(1), corner(2)));
    }
  }
  const bool empty = triangles_.empty();
  center_ = empty ? Vec3{} : (low + high) * 0.5;
  extent_ = empty ? 1.0 : 0.5 * Norm(high - low);
  offset_ = kRayOffset * extent_;

  if (handles_->scene != nullptr) {
    rtcReleaseScene(handles_->scene);
  }
  handles_->scene = rtcNewScene(handles_->device);
  rtcSetSceneFlags(handles_->scene,
                   static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | kEmbreeFilterFlag));
  for (const Mesh* mesh : meshes) {
    AddMesh(handles_->device, handles_->scene, *mesh, center_);
  }
  rtcCommitScene(handles_->scene);
  if (const RTCError error = rtcGetDeviceError(handles_->device); error != RTC_ERROR_NONE) {
    throw SceneError("Embree could not build the scene (error " + std::to_string(error) + ")");
  }
}

namespace {

struct IgnoringQuery : EmbreeFilteredContext {
  std::span<const TriangleId> ignored;
};

void SkipIgnored(const RTCFilterFunctionNArguments* arguments) {
  // The context is the base of an IgnoringQuery.
  const auto* context = reinterpret_cast<const EmbreeFilteredContext*>(arguments->context);
  const auto& ignored = static_cast<const IgnoringQuery*>(context)->ignored;
  const TriangleId id{static_cast<std::int32_t>(RTCHitN_geomID(arguments->hit, arguments->N, 0)),
                      static_cast<std::int32_t>(RTCHitN_primID(arguments->hit, arguments->N, 0))};
  if (std::find(ignored.begin(), ignored.end(), id) != ignored.end()) {
    arguments->valid[0] = 0;
  }
}

}  // namespace

std::optional<Hit> RayCaster::Intersect(const Ray& ray) const {
  return IntersectIgnoring(ray, 0.0, {});
}

std::optional<Hit> RayCaster::IntersectIgnoring(const Ray& ray,
                                                double min_distance,
                                                std::span<const TriangleId> ignored) const {
  RTCRayHit query;
  FillRay(ray, center_, min_distance, std::numeric_limits<double>::infinity(), query.ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (ignored.empty()) {
    EmbreeIntersect(handles_->scene, query);
  } else {
    IgnoringQuery context;
    context.ignored = ignored;
    EmbreeIntersectFiltered(handles_->scene, SkipIgnored, context, query);
  }
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    return std::nullopt;
  }
  const TriangleId id{static_cast<std::int32_t>(query.hit.geomID),
                      static_cast<std::int32_t>(query.hit.primID)};
  const PlaneHit hit = IntersectPlane(Geometry(id), ray.origin, ray.direction);
  return Hit{id, hit.b1, hit.b2, hit.distance};
}

bool RayCaster::Occluded(const Ray& ray, double max_distance) const {
  RTCRay query;
  FillRay(ray, center_, 0.0, max_distance, query);
  EmbreeOccluded(handles_->scene, query);
  return query.tfar < 0.0F;
}

namespace {

// A triangle that rises less above the plane of a point, as a sine, is in it.
constexpr double kFlat = 1e-3;
// Rounding of points on triangles, relative to the scene's extent.
constexpr double kRounding = 1e-9;

struct NearestQuery {
  const RayCaster* caster;
  const std::vector<bool>* wanted;
  Vec3 x, n;
  double squared_distance;
};

bool VisitTriangle(RTCPointQueryFunctionArguments* arguments) {
  auto& nearest = *static_cast<NearestQuery*>(arguments->userPtr);
  const TriangleId id{static_cast<std::int32_t>(arguments->geomID),
                      static_cast<std::int32_t>(arguments->primID)};
  if (!(*nearest.wanted)[static_cast<std::size_t>(id.mesh)]) {
    return false;
  }
  const TriangleGeometry& t = nearest.caster->Geometry(id);
  const std::array<Vec3, 3> to_corners = {
      t.p0 - nearest.x, t.p0 + t.e1 - nearest.x, t.p0 + t.e2 - nearest.x};
  if (std::all_of(to_corners.begin(), to_corners.end(), [&](const Vec3& to) {
        return !(Dot(nearest.n, to) > 0.0);
      })) {
    return false;
  }
  const Vec3 to_nearest = ClosestPointOfTriangle(nearest.x, t) - nearest.x;
  if (SquaredNorm(to_nearest) >= nearest.squared_distance) {
    return false;
  }
  // A point's own triangle is above or below it by rounding only.
  const double least = kRounding * nearest.caster->Extent();
  double rise = 0.0;
  const auto look_at = [&](const Vec3& to) {
    const double norm = Norm(to);
    rise = norm > least ? std::max(rise, Dot(nearest.n, to) / norm) : rise;
  };
  look_at(to_nearest);
  std::for_each(to_corners.begin(), to_corners.end(), look_at);
  if (!(rise > kFlat)) {
    return false;
  }
  const double squared = SquaredNorm(to_nearest) / (rise * rise);
  if (squared >= nearest.squared_distance) {
    return false;
  }
  nearest.squared_distance = squared;
  arguments->query->radius = static_cast<float>(std::sqrt(squared));
  return true;
}

}  // namespace

double RayCaster::DistanceBefore(const Vec3& x,
                                 const Vec3& n,
                                 const std::vector<bool>& wanted,
                                 double max_distance) const {
  NearestQuery nearest{this, &wanted, x, n, max_distance * max_distance};
  RTCPointQuery query;
  query.x = static_cast<float>(x.x - center_.x);
  query.y = static_cast<float>(x.y - center_.y);
  query.z = static_cast<float>(x.z - center_.z);
  query.time = 0.0F;
  query.radius = static_cast<float>(max_distance);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(handles_->scene, &query, &context, VisitTriangle, &nearest);
  return std::sqrt(nearest.squared_distance);
}

}  // namespace pathfit::renderer
