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

// Barycentric weights this far outside are on a triangle's border.
constexpr double kBorder = 1e-9;

struct IgnoringQuery : EmbreeFilteredContext {
  const RayCaster* caster = nullptr;
  const Ray* ray = nullptr;
  std::span<const TriangleId> ignored;
};

/// Leaves out what is to be ignored and what only rounding hits: a ray along a silhouette of a fine
/// mesh passes the neighbours of the edge's triangles closer than Embree can tell.
void SkipIgnored(const RTCFilterFunctionNArguments* arguments) {
  // The context is the base of an IgnoringQuery.
  const auto* context = reinterpret_cast<const EmbreeFilteredContext*>(arguments->context);
  const auto& query = *static_cast<const IgnoringQuery*>(context);
  const TriangleId id{static_cast<std::int32_t>(RTCHitN_geomID(arguments->hit, arguments->N, 0)),
                      static_cast<std::int32_t>(RTCHitN_primID(arguments->hit, arguments->N, 0))};
  if (std::find(query.ignored.begin(), query.ignored.end(), id) != query.ignored.end()) {
    arguments->valid[0] = 0;
    return;
  }
  const PlaneHit hit =
      IntersectPlane(query.caster->Geometry(id), query.ray->origin, query.ray->direction);
  if (!(std::min({hit.b1, hit.b2, 1.0 - hit.b1 - hit.b2}) > -kBorder)) {
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
    context.caster = this;
    context.ray = &ray;
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
  const RayCaster& caster;
  const std::vector<bool>& wanted;
  Vec3 x, n;
  double limit;  // what is not nearer, over its rise, does not count
  double slack;
  double radius = 0.0;
};

/// How near a triangle is to the query's point, and how steeply it rises above its plane, seen from
/// up to `slack` nearer. No rise: in or below the plane, or beyond the limit.
struct Corner {
  double distance = 0.0, rise = 0.0;
};
Corner CornerWith(const NearestQuery& query, const TriangleGeometry& t) {
  const std::array<Vec3, 3> to_corners = {
      t.p0 - query.x, t.p0 + t.e1 - query.x, t.p0 + t.e2 - query.x};
  if (std::all_of(to_corners.begin(), to_corners.end(), [&](const Vec3& to) {
        return !(Dot(query.n, to) > 0.0);
      })) {
    return {};
  }
  const Vec3 to_nearest = ClosestPointOfTriangle(query.x, t) - query.x;
  Corner corner{Norm(to_nearest), 0.0};
  if (corner.distance - query.slack >= query.limit) {
    return {};  // a rise is at most 1
  }
  // A point's own triangle is above or below it by rounding only.
  const double least = kRounding * query.caster.Extent();
  const auto look_at = [&](const Vec3& to) {
    const double norm = Norm(to);
    const double height = Dot(query.n, to);
    if (norm > least && height > 0.0) {
      corner.rise = std::max(corner.rise, height / std::max(norm - query.slack, height));
    }
  };
  look_at(to_nearest);
  std::for_each(to_corners.begin(), to_corners.end(), look_at);
  return corner.rise > kFlat && corner.distance - query.slack < query.limit * corner.rise
             ? corner
             : Corner{};
}

/// The corner with the triangle that a point query visits.
Corner VisitedCorner(const RTCPointQueryFunctionArguments* arguments, const NearestQuery& query) {
  const TriangleId id{static_cast<std::int32_t>(arguments->geomID),
                      static_cast<std::int32_t>(arguments->primID)};
  return query.wanted[static_cast<std::size_t>(id.mesh)]
             ? CornerWith(query, query.caster.Geometry(id))
             : Corner{};
}

bool VisitForDistance(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<NearestQuery*>(arguments->userPtr);
  const Corner corner = VisitedCorner(arguments, query);
  if (!(corner.rise > 0.0)) {
    return false;
  }
  query.limit = corner.distance / corner.rise;
  if (query.limit >= static_cast<double>(arguments->query->radius)) {
    return false;
  }
  arguments->query->radius = static_cast<float>(query.limit);
  return true;
}

bool VisitForRadius(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<NearestQuery*>(arguments->userPtr);
  const Corner corner = VisitedCorner(arguments, query);
  if (corner.rise > 0.0) {
    query.radius = std::max(query.radius, corner.distance + query.slack);
  }
  return false;
}

/// `x` relative to the caster's centre.
void VisitTriangles(
    RTCScene scene, const Vec3& x, double radius, RTCPointQueryFunction visit, NearestQuery& user) {
  RTCPointQuery query;
  query.x = static_cast<float>(x.x);
  query.y = static_cast<float>(x.y);
  query.z = static_cast<float>(x.z);
  query.time = 0.0F;
  query.radius = static_cast<float>(radius);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &query, &context, visit, &user);
}

}  // namespace

double RayCaster::DistanceBefore(const Vec3& x,
                                 const Vec3& n,
                                 const std::vector<bool>& wanted,
                                 double max_distance,
                                 double radius) const {
  NearestQuery query{*this, wanted, x, n, max_distance, 0.0};
  VisitTriangles(
      handles_->scene, x - center_, std::min(radius, max_distance), VisitForDistance, query);
  return query.limit;
}

double RayCaster::SearchRadius(const Vec3& x,
                               const Vec3& n,
                               const std::vector<bool>& wanted,
                               double max_distance,
                               double slack) const {
  NearestQuery query{*this, wanted, x, n, max_distance, slack};
  VisitTriangles(handles_->scene, x - center_, max_distance + slack, VisitForRadius, query);
  return query.radius;
}

}  // namespace pathfit::renderer
