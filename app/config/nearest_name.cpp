#include "app/config/nearest_name.h"

#include <algorithm>

#include <fnmatch.h>

namespace pathfit::app {
namespace {

constexpr std::size_t kMostNames = 16;  // in a message, where none is near

// Optimal string alignment distance.
std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string NearestName(const std::string& name, const std::vector<std::string>& candidates) {
  constexpr std::size_t kMaxLength = 100;
  if (name.size() > kMaxLength) return {};
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(1, (name.size() + 1) / 3) + 1;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > kMaxLength) continue;
    const std::size_t distance = EditDistance(name, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best_distance = distance;
      best = candidate;
    }
  }
  constexpr std::size_t kMinPrefix = 3;
  if (best.empty() && name.size() >= kMinPrefix) {
    for (const std::string& candidate : candidates) {
      if (candidate.compare(0, name.size(), name) == 0) return candidate;
    }
  }
  return best;
}

std::string NameHint(const std::string& name, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return {};
  const std::string nearest = NearestName(name, candidates);
  return nearest.empty() ? " (known: " + JoinNames(candidates, kMostNames) + ")"
                         : " (did you mean '" + nearest + "'?)";
}

bool MatchesGlob(const std::string& pattern, const std::string& name) {
  return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

bool Contains(const std::vector<std::string>& list, const std::string& text) {
  return std::ranges::find(list, text) != list.end();
}

std::string JoinNames(const std::vector<std::string>& names, std::size_t limit) {
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), limit); ++i) {
    out += (i > 0 ? ", " : "") + names[i];
  }
  return names.size() > limit ? out + ", …" : out;
}

}  // namespace pathfit::app
