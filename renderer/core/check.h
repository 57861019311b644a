#pragma once

#include <stdexcept>
#include <string>

namespace pathfit::renderer {

/// A mistake of this program, never the user's: file, line, the condition that failed and, of an
/// equality, both operands. Programs end with status 1 and ask for a report.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] inline void CheckFailed(const char* file, int line, const std::string& condition) {
  throw InternalError(std::string(file) + ":" + std::to_string(line) +
                      ": check failed: " + condition);
}

template <class A, class B>
[[noreturn]] void CheckEqualFailed(
    const char* file, int line, const char* condition, const A& a, const B& b) {
  CheckFailed(
      file,
      line,
      std::string(condition) + " (" + std::to_string(a) + " against " + std::to_string(b) + ")");
}

}  // namespace pathfit::renderer

/// Our own mistake, always checked; throws InternalError. User input is reported by the other
/// exceptions (error.h).
#define PATHFIT_CHECK(condition)                                        \
  do {                                                                  \
    if (!(condition)) {                                                 \
      ::pathfit::renderer::CheckFailed(__FILE__, __LINE__, #condition); \
    }                                                                   \
  } while (false)

/// PATHFIT_CHECK(a == b) of numbers, which may be evaluated twice.
#define PATHFIT_CHECK_EQ(a, b)                                                           \
  do {                                                                                   \
    if (!((a) == (b))) {                                                                 \
      ::pathfit::renderer::CheckEqualFailed(__FILE__, __LINE__, #a " == " #b, (a), (b)); \
    }                                                                                    \
  } while (false)

#if PATHFIT_CHECKS
#define PATHFIT_DCHECK(condition) PATHFIT_CHECK(condition)
#else
#define PATHFIT_DCHECK(condition) \
  do {                            \
  } while (false)
#endif
