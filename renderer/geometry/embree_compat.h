#pragma once

#include <cstddef>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace pathfit::renderer {

// The calls that differ between Embree 3 and 4. Only the branch for 3 can be tested on Debian 12.
inline void EmbreeIntersect(RTCScene scene, RTCRayHit& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
#endif
}

/// Ray query whose hits pass through `filter`, which finds the query at the address of the context.
struct EmbreeFilteredContext {
#if RTC_VERSION_MAJOR >= 4
  RTCRayQueryContext base;
#else
  RTCIntersectContext base;
#endif
};
inline void EmbreeIntersectFiltered(RTCScene scene,
                                    RTCFilterFunctionN filter,
                                    EmbreeFilteredContext& context,
                                    RTCRayHit& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&context.base);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.base;
  arguments.filter = filter;
  arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  rtcIntersect1(scene, &ray, &arguments);
#else
  rtcInitIntersectContext(&context.base);
  context.base.filter = filter;
  rtcIntersect1(scene, &context.base, &ray);
#endif
}
#if RTC_VERSION_MAJOR >= 4
inline constexpr RTCSceneFlags kEmbreeFilterFlag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
inline constexpr RTCSceneFlags kEmbreeFilterFlag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif

/// Rays of a packet.
inline constexpr std::size_t kPacket = 8;
/// Which rays of a packet there are: -1, the others 0.
struct alignas(4 * kPacket) EmbreeMask {
  int lanes[kPacket] = {};
};

inline void EmbreeIntersectFiltered(RTCScene scene,
                                    RTCFilterFunctionN filter,
                                    EmbreeFilteredContext& context,
                                    const EmbreeMask& mask,
                                    bool coherent,
                                    RTCRayHit8& rays) {
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&context.base);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.base;
  arguments.filter = filter;
  arguments.flags = static_cast<RTCRayQueryFlags>(
      RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER |
      (coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT));
  rtcIntersect8(mask.lanes, scene, &rays, &arguments);
#else
  rtcInitIntersectContext(&context.base);
  context.base.filter = filter;
  context.base.flags =
      coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect8(mask.lanes, scene, &context.base, &rays);
#endif
}

inline void EmbreeOccluded(RTCScene scene, const EmbreeMask& mask, RTCRay8& rays) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded8(mask.lanes, scene, &rays, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded8(mask.lanes, scene, &context, &rays);
#endif
}

inline void EmbreeOccluded(RTCScene scene, RTCRay& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
}

}  // namespace pathfit::renderer
