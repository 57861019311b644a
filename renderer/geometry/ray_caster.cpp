#include "renderer/geometry/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "renderer/core/error.h"
#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/embree_compat.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/near_corner.h"
#include "renderer/math/median.h"

namespace pathfit::renderer {
namespace {

/// One lane of a ray (RTCRay: one lane) or of a packet.
template <unsigned kLanes = 1, class Packet>
void FillRay(const Ray& ray,
             const Vec3& center,
             double near,
             double far,
             Packet& packet,
             unsigned lane = 0) {
  RTCRayN* const out = reinterpret_cast<RTCRayN*>(&packet);
  RTCRayN_org_x(out, kLanes, lane) = static_cast<float>(ray.origin.x - center.x);
  RTCRayN_org_y(out, kLanes, lane) = static_cast<float>(ray.origin.y - center.y);
  RTCRayN_org_z(out, kLanes, lane) = static_cast<float>(ray.origin.z - center.z);
  RTCRayN_dir_x(out, kLanes, lane) = static_cast<float>(ray.direction.x);
  RTCRayN_dir_y(out, kLanes, lane) = static_cast<float>(ray.direction.y);
  RTCRayN_dir_z(out, kLanes, lane) = static_cast<float>(ray.direction.z);
  RTCRayN_tnear(out, kLanes, lane) = static_cast<float>(near);
  RTCRayN_tfar(out, kLanes, lane) = static_cast<float>(far);
  RTCRayN_time(out, kLanes, lane) = 0.0F;
  RTCRayN_mask(out, kLanes, lane) = 0xFFFFFFFFU;
  RTCRayN_id(out, kLanes, lane) = lane;
  RTCRayN_flags(out, kLanes, lane) = 0;
}

// A side of a piece of a triangle is at most so many times longer than its distance from the
// centre. Below 2 sqrt(3) a triangle that passes by the centre has a side to cut.
constexpr double kPieceLength = 3.0;
// Distances from the centre below this share of the size of the mesh there do not count.
constexpr double kLeastDistance = 0.125;
// Vertices of a mesh that are looked at for its middle.
constexpr std::size_t kMiddleSamples = 1024;
// Where the steps of the centre begin, in steps.
constexpr double kOddStep = 0.3183;
// Cuts of cuts, against endless ones of what is thinner than rounding.
constexpr int kMaxCuts = 64;

/// Where most of a mesh is, and how far it reaches from there: few far corners do not matter.
struct Middle {
  Vec3 at;
  double size = 0.0;
};
Middle MiddleOf(const Mesh& mesh) {
  const std::size_t step = (mesh.positions.size() + kMiddleSamples - 1) / kMiddleSamples;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < mesh.positions.size(); i += step) {
    points.push_back(mesh.positions[i]);
  }
  std::vector<double> values(points.size());
  const auto median_of = [&](const auto& value) {
    std::transform(points.begin(), points.end(), values.begin(), value);
    return Median(values);
  };
  Middle middle;
  for (int i = 0; i < 3; ++i) {
    middle.at[i] = median_of([&](const Vec3& p) { return p[i]; });
  }
  middle.size = median_of([&](const Vec3& p) { return Norm(p - middle.at); });
  return middle;
}

/// The same in coarse steps: while a mesh moves a little, what rays can tell apart elsewhere stays
/// the same to the bit.
Middle Stepped(Middle middle) {
  if (middle.size > 0.0) {
    middle.size = std::exp2(std::round(std::log2(middle.size)));
    for (int i = 0; i < 3; ++i) {
      // Aside from halves and quarters of round numbers, where things often stand.
      middle.at[i] =
          (std::floor(middle.at[i] / middle.size + kOddStep) + 0.5 - kOddStep) * middle.size;
    }
  }
  return middle;
}

/// The middle, in steps, from which the worst ratio of a mesh's distance, as it counts there, to
/// its size is least. Meshes without a size are asked only if there are no others.
Middle ChooseMiddle(const std::vector<const Mesh*>& meshes, const std::vector<bool>& aside) {
  std::vector<Middle> middles;
  for (const bool with_aside : {false, true}) {
    for (std::size_t m = 0; m < meshes.size() && (!with_aside || middles.empty()); ++m) {
      if (!meshes[m]->positions.empty() && (with_aside || aside.empty() || !aside[m])) {
        middles.push_back(MiddleOf(*meshes[m]));
      }
    }
  }
  Middle best = middles.empty() ? Middle{} : middles.front();
  std::erase_if(middles, [](const Middle& middle) { return !(middle.size > 0.0); });
  double least = std::numeric_limits<double>::infinity();
  for (const Middle& middle : middles) {
    const Middle center = Stepped(middle);
    double worst = 0.0;
    for (const Middle& other : middles) {
      const double distance = std::max(Norm(other.at - center.at), kLeastDistance * center.size);
      worst = std::max(worst, distance / other.size);
      if (worst >= least) {
        break;
      }
    }
    if (worst < least) {
      least = worst;
      best = center;
    }
  }
  return best;
}

using Corners = std::array<Vec3, 3>;

/// Cuts a triangle, its corners relative to the centre, until no side is long for its distance.
/// Where a side is cut depends on its ends alone, so that neighbours stay joined. Triangles are cut
/// across their longest such side only: cuts elsewhere leave thin pieces.
void CutTriangle(const Corners& c, double least, int cuts, std::vector<Corners>& pieces) {
  std::size_t longest = 3;
  double length = kPieceLength * least;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& a = c[i];
    const Vec3& b = c[(i + 1) % 3];
    const double side = Norm(b - a);
    if (side > length && side > kPieceLength * Norm(ClosestPointOfSegment({}, a, b))) {
      longest = i;
      length = side;
    }
  }
  if (cuts == kMaxCuts || longest == 3) {
    pieces.push_back(c);
    return;
  }
  const Vec3& a = c[longest];
  const Vec3& b = c[(longest + 1) % 3];
  const Vec3& apex = c[(longest + 2) % 3];
  const Vec3 middle = (a + b) * 0.5;
  CutTriangle({a, middle, apex}, least, cuts + 1, pieces);
  CutTriangle({middle, b, apex}, least, cuts + 1, pieces);
}

/// Adds a mesh; returns whose piece each primitive is, nothing if all are whole.
std::vector<std::int32_t> AddMesh(
    RTCDevice device, RTCScene scene, const Mesh& mesh, const Vec3& center, double least) {
  std::vector<Vec3> positions(mesh.positions.size());
  std::transform(
      mesh.positions.begin(), mesh.positions.end(), positions.begin(), [&](const Vec3& p) {
        return p - center;
      });
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> origin;
  bool cut = false;
  std::vector<Corners> pieces;
  triangles.reserve(mesh.triangles.size());
  origin.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const auto p = [&](std::size_t k) { return positions[static_cast<std::size_t>(t[k])]; };
    // A bound of what may be cut: most triangles are small.
    const double reach = Norm(p(1) - p(0)) + Norm(p(2) - p(0));
    pieces.clear();
    if (reach > kPieceLength * std::max(Norm(p(0)) - reach, least)) {
      CutTriangle({p(0), p(1), p(2)}, least, 0, pieces);
    }
    if (pieces.size() <= 1) {
      triangles.push_back(t);
      origin.push_back(static_cast<std::int32_t>(i));
      continue;
    }
    cut = true;
    for (const Corners& corners : pieces) {
      const auto first = static_cast<std::int32_t>(positions.size());
      positions.insert(positions.end(), corners.begin(), corners.end());
      triangles.push_back({first, first + 1, first + 2});
      origin.push_back(static_cast<std::int32_t>(i));
    }
  }
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), positions.size()));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry,
                                                                 RTC_BUFFER_TYPE_INDEX,
                                                                 0,
                                                                 RTC_FORMAT_UINT3,
                                                                 3 * sizeof(unsigned),
                                                                 triangles.size()));
  if (vertices != nullptr && indices != nullptr) {
    for (const Vec3& p : positions) {
      *vertices++ = static_cast<float>(p.x);
      *vertices++ = static_cast<float>(p.y);
      *vertices++ = static_cast<float>(p.z);
    }
    for (const Triangle& t : triangles) {
      for (const std::int32_t index : t) {
        *indices++ = static_cast<unsigned>(index);
      }
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return cut ? origin : std::vector<std::int32_t>{};
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

void RayCaster::Build(const std::vector<const Mesh*>& meshes,
                      const std::vector<bool>& aside,
                      const std::optional<RayFrame>& frame) {
  Box all;
  first_triangle_.clear();
  triangles_.clear();
  bounds_.clear();
  for (const Mesh* mesh : meshes) {
    first_triangle_.push_back(static_cast<std::int64_t>(triangles_.size()));
    bounds_.push_back(BoxAround(mesh->positions));
    all.Include(bounds_.back());
    const std::vector<TriangleGeometry> triangles = GeometryOf(*mesh);
    triangles_.insert(triangles_.end(), triangles.begin(), triangles.end());
  }
  extent_ = triangles_.empty() ? 1.0 : all.HalfDiagonal();
  if (frame.has_value()) {
    frame_ = *frame;
  } else {
    const Middle middle = ChooseMiddle(meshes, aside);
    frame_ = RayFrame{middle.at, middle.size > 0.0 ? kLeastDistance * middle.size : extent_};
  }

  if (handles_->scene != nullptr) {
    rtcReleaseScene(handles_->scene);
  }
  handles_->scene = rtcNewScene(handles_->device);
  rtcSetSceneFlags(handles_->scene,
                   static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | EmbreeQuery::kSceneFlag));
  pieces_.clear();
  for (const Mesh* mesh : meshes) {
    pieces_.push_back(
        AddMesh(handles_->device, handles_->scene, *mesh, frame_.center, frame_.least_distance));
  }
  rtcCommitScene(handles_->scene);
  const RTCError error = rtcGetDeviceError(handles_->device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE) {
    throw SceneError("Embree could not build the scene (error " + std::to_string(error) + ")");
  }
}

namespace {

// Barycentric weights this far outside are on a triangle's border.
constexpr double kBorder = 1e-9;

void SkipIgnored(const RTCFilterFunctionNArguments* arguments);
struct IgnoringQuery : EmbreeQuery {
  IgnoringQuery(const RayCaster& of, const Ray& along, std::span<const TriangleId> left_out)
      : EmbreeQuery(SkipIgnored), caster(of), ray(along), ignored(left_out) {}
  const RayCaster& caster;
  const Ray& ray;
  std::span<const TriangleId> ignored;
};

/// Leaves out what is to be ignored and what only rounding hits: a ray along a silhouette of a fine
/// mesh passes the neighbours of the edge's triangles closer than Embree can tell.
void SkipIgnored(const RTCFilterFunctionNArguments* arguments) {
  // The context is the base of an IgnoringQuery.
  const auto& query =
      *static_cast<const IgnoringQuery*>(reinterpret_cast<const EmbreeQuery*>(arguments->context));
  const TriangleId id = query.caster.TriangleOf(RTCHitN_geomID(arguments->hit, arguments->N, 0),
                                                RTCHitN_primID(arguments->hit, arguments->N, 0));
  if (std::find(query.ignored.begin(), query.ignored.end(), id) != query.ignored.end()) {
    arguments->valid[0] = 0;
    return;
  }
  const PlaneHit hit =
      IntersectPlane(query.caster.Geometry(id), query.ray.origin, query.ray.direction);
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
  RTCRayHit hit;
  FillRay(ray, frame_.center, min_distance, std::numeric_limits<double>::infinity(), hit.ray);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (ignored.empty()) {
    EmbreeQuery().Intersect(handles_->scene, hit);
  } else {
    IgnoringQuery(*this, ray, ignored).Intersect(handles_->scene, hit);
  }
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    return std::nullopt;
  }
  return Refined(hit.hit.geomID, hit.hit.primID, ray);
}

bool RayCaster::Occluded(const Ray& ray, double max_distance) const {
  RTCRay segment;
  FillRay(ray, frame_.center, 0.0, max_distance, segment);
  EmbreeQuery().Occluded(handles_->scene, segment);
  return segment.tfar < 0.0F;
}

namespace {

// Triangles whose distances differ by a smaller share may change places when rounded.
constexpr float kRivalry = 1e-5F;

/// A packet and which of its rays have rivals: triangles almost as far as the nearest.
void NoteRivals(const RTCFilterFunctionNArguments* arguments);
struct RivalQuery : EmbreeQuery {
  explicit RivalQuery(bool coherent) : EmbreeQuery(NoteRivals, coherent) {
    nearest.fill(std::numeric_limits<float>::infinity());
  }
  std::array<float, kPacket> nearest;
  std::array<bool, kPacket> rivals{};
};

/// Notes rivals, and lets Embree look as far as they may be.
void NoteRivals(const RTCFilterFunctionNArguments* arguments) {
  // The context is the base of a RivalQuery.
  auto& query = *static_cast<RivalQuery*>(reinterpret_cast<EmbreeQuery*>(arguments->context));
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] == 0) {
      continue;
    }
    const unsigned lane = RTCRayN_id(arguments->ray, arguments->N, i);
    float& nearest = query.nearest[lane];
    float& far = RTCRayN_tfar(arguments->ray, arguments->N, i);
    query.rivals[lane] = far * (1.0F + kRivalry) >= nearest;
    nearest = std::min(nearest, far);
    far = nearest * (1.0F + kRivalry);
  }
}

}  // namespace

void RayCaster::IntersectTogether(std::span<const Ray> rays,
                                  bool coherent,
                                  std::span<std::optional<Hit>> hits) const {
  const std::size_t count = std::min(kPacket, rays.size());
  EmbreeMask mask;
  RTCRayHit8 packet;  // lanes without a ray are not read
  for (std::size_t i = 0; i < count; ++i) {
    mask.lanes[i] = -1;
    FillRay<kPacket>(rays[i],
                     frame_.center,
                     0.0,
                     std::numeric_limits<double>::infinity(),
                     packet.ray,
                     static_cast<unsigned>(i));
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RivalQuery query(coherent);
  query.Intersect(handles_->scene, mask, packet);
  for (std::size_t i = 0; i < count; ++i) {
    if (query.rivals[i]) {
      hits[i] = Intersect(rays[i]);  // which one is found depends on the order of the search
    } else if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
      hits[i].reset();
    } else {
      hits[i] = Refined(packet.hit.geomID[i], packet.hit.primID[i], rays[i]);
    }
  }
  Intersect(rays.subspan(count), coherent, hits.subspan(count));
}

void RayCaster::OccludedTogether(std::span<const Segment> segments,
                                 std::span<bool> occluded) const {
  const std::size_t count = std::min(kPacket, segments.size());
  EmbreeMask mask;
  RTCRay8 packet;  // lanes without a ray are not read
  for (std::size_t i = 0; i < count; ++i) {
    mask.lanes[i] = -1;
    FillRay<kPacket>(
        segments[i].ray, frame_.center, 0.0, segments[i].length, packet, static_cast<unsigned>(i));
  }
  EmbreeQuery().Occluded(handles_->scene, mask, packet);
  for (std::size_t i = 0; i < count; ++i) {
    occluded[i] = packet.tfar[i] < 0.0F;
  }
  Occluded(segments.subspan(count), occluded.subspan(count));
}

namespace {

// Bounds of so many meshes are looked at faster than one tree of triangles.
constexpr std::size_t kFewMeshes = 32;

struct NearQuery {
  const RayCaster& caster;
  const RayCaster::Reach& reach;
  CornerView view;
  double most;  // what is not nearer, over its rise and the reach, does not count
  NearFacts* facts;
};

bool VisitForNearness(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<NearQuery*>(arguments->userPtr);
  const TriangleId id = query.caster.TriangleOf(arguments->geomID, arguments->primID);
  const double reach = query.reach.Of(id.mesh);
  if (!(reach > 0.0)) {
    return false;
  }
  const NearCorner corner = CornerSeen(query.view, query.caster.Geometry(id), query.most * reach);
  if (!(corner.rise > 0.0)) {
    return false;
  }
  query.most = NearnessOf(query.view, corner) / reach;
  if (query.facts != nullptr) *query.facts = {reach, corner.meets};
  const double radius = query.most * query.reach.most;
  if (radius >= static_cast<double>(arguments->query->radius)) {
    return false;
  }
  arguments->query->radius = static_cast<float>(radius);
  return true;
}

/// False if the bounds of the meshes alone tell that Nearness is `most`.
bool MayBeNear(const RayCaster& caster, const Vec3& x, const RayCaster::Reach& reach, double most) {
  const std::size_t count = reach.of_mesh.size();
  if (count > kFewMeshes) {
    return true;
  }
  for (int mesh = 0; mesh < static_cast<int>(count); ++mesh) {
    const double of_mesh = reach.Of(mesh);
    if (of_mesh > 0.0 && caster.Bounds(mesh).Distance(x) < kAlmost * most * of_mesh) {
      return true;
    }
  }
  return false;
}

/// `x` relative to the caster's centre.
void VisitTriangles(
    RTCScene scene, const Vec3& x, double radius, RTCPointQueryFunction visit, void* user) {
  RTCPointQuery query;
  query.x = static_cast<float>(x.x);
  query.y = static_cast<float>(x.y);
  query.z = static_cast<float>(x.z);
  query.time = 0.0F;
  query.radius = static_cast<float>(radius);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &query, &context, visit, user);
}

}  // namespace

double RayCaster::Nearness(
    const Vec3& x, const Vec3& n, const Reach& reach, double most, NearFacts* facts) const {
  if (!MayBeNear(*this, x, reach, most)) {
    return most;
  }
  NearQuery query{*this, reach, {x, n, Offset(x)}, most, facts};
  VisitTriangles(handles_->scene, x - frame_.center, most * reach.most, VisitForNearness, &query);
  return query.most;
}

}  // namespace pathfit::renderer
