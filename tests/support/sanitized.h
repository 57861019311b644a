#pragma once

namespace pathfit::tests {

/// Whether a sanitizer watches, under which everything takes ten times as long: what is repeated
/// for its answers alone need not be for its memory.
#if defined(PATHFIT_ADDRESS_SANITIZER) || defined(PATHFIT_THREAD_SANITIZER)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace pathfit::tests
