#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "renderer/boundary/primary_guide.h"

namespace pathfit::renderer {

/// Guides that outlive a pass: the next pass of the same view draws by them and spends nothing on
/// pilots, until they are kRefreshAfter passes old. A guide that no longer fits the scene costs
/// variance, never the mean. Not safe for passes that run at once.
class GuideStore {
 public:
  /// Guides of all ways of one estimator, or null if they must be learned.
  const std::vector<PrimaryGuide>* Find(std::uint64_t view, std::uint64_t estimator) {
    const auto found = entries_.find({view, estimator});
    if (found == entries_.end() || found->second.passes >= kRefreshAfter) {
      return nullptr;
    }
    ++found->second.passes;
    return &found->second.guides;
  }
  void Keep(std::uint64_t view, std::uint64_t estimator, std::vector<PrimaryGuide> guides) {
    entries_[{view, estimator}] = {std::move(guides), 1};
  }
  void Clear() { entries_.clear(); }

  static constexpr int kRefreshAfter = 8;

 private:
  struct Entry {
    std::vector<PrimaryGuide> guides;
    int passes = 0;
  };
  std::map<std::pair<std::uint64_t, std::uint64_t>, Entry> entries_;
};

}  // namespace pathfit::renderer
