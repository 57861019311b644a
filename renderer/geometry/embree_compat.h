#pragma once

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
