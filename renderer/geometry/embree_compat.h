#pragma once

#include <cstddef>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace pathfit::renderer {

/// Rays of a packet.
inline constexpr std::size_t kPacket = 8;
/// Which rays of a packet there are: -1, the others 0.
struct alignas(4 * kPacket) EmbreeMask {
  int lanes[kPacket] = {};
};

/// A query of rays, whose hits pass through `filter` if there is one: it finds the query at the
/// address of the context. What differs between Embree 3 and 4 is here; only the branch for 3 can
/// be tested on Debian 12.
struct EmbreeQuery {
#if RTC_VERSION_MAJOR >= 4
  explicit EmbreeQuery(RTCFilterFunctionN filter = nullptr, bool coherent = false) {
    rtcInitRayQueryContext(&context);
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    arguments.filter = filter;
    arguments.flags = static_cast<RTCRayQueryFlags>(
        (filter != nullptr ? RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER : 0) |
        (coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT));
  }
  EmbreeQuery(const EmbreeQuery&) = delete;
  EmbreeQuery& operator=(const EmbreeQuery&) = delete;
  void Intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray, &arguments); }
  void Intersect(RTCScene scene, const EmbreeMask& mask, RTCRayHit8& rays) {
    rtcIntersect8(mask.lanes, scene, &rays, &arguments);
  }
  void Occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, nullptr); }
  void Occluded(RTCScene scene, const EmbreeMask& mask, RTCRay8& rays) {
    rtcOccluded8(mask.lanes, scene, &rays, nullptr);
  }
  static constexpr RTCSceneFlags kSceneFlag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

  RTCRayQueryContext context;
  RTCIntersectArguments arguments;
#else
  explicit EmbreeQuery(RTCFilterFunctionN filter = nullptr, bool coherent = false) {
    rtcInitIntersectContext(&context);
    context.filter = filter;
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  }
  void Intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &context, &ray); }
  void Intersect(RTCScene scene, const EmbreeMask& mask, RTCRayHit8& rays) {
    rtcIntersect8(mask.lanes, scene, &context, &rays);
  }
  void Occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &context, &ray); }
  void Occluded(RTCScene scene, const EmbreeMask& mask, RTCRay8& rays) {
    rtcOccluded8(mask.lanes, scene, &context, &rays);
  }
  static constexpr RTCSceneFlags kSceneFlag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

  RTCIntersectContext context;
#endif
};

}  // namespace pathfit::renderer
