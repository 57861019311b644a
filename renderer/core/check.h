#pragma once

#include <cstdio>
#include <cstdlib>

namespace pathfit::renderer {

[[noreturn]] inline void CheckFailed(const char* file, int line, const char* condition) {
  std::fprintf(stderr, "%s:%d: internal error: check failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace pathfit::renderer

/// Our own mistake, always checked. User input is reported by exceptions (error.h) instead.
#define PATHFIT_CHECK(condition)                                        \
  do {                                                                  \
    if (!(condition)) {                                                 \
      ::pathfit::renderer::CheckFailed(__FILE__, __LINE__, #condition); \
    }                                                                   \
  } while (false)

#if PATHFIT_CHECKS
#define PATHFIT_DCHECK(condition) PATHFIT_CHECK(condition)
#else
#define PATHFIT_DCHECK(condition) \
  do {                            \
  } while (false)
#endif
