#include "renderer/geometry/near_pairs.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/box.h"

namespace pathfit::renderer {
namespace {

// Items of a node that is not divided.
constexpr std::size_t kFew = 8;

Box BoxOf(const NearItem& item) {
  const Box box = BoxAround(item.triangle->Corners());
  const Vec3 slack{item.slack, item.slack, item.slack};
  return {box.low - slack, box.high + slack};
}

/// Whether the box, which holds its own slack, lies beside the triangle's plane.
bool IsBesidePlane(const Box& box, const NearItem& item) {
  const TriangleGeometry& t = *item.triangle;
  const Vec3 half = box.Size() * 0.5;
  const double reach =
      std::abs(t.n.x) * half.x + std::abs(t.n.y) * half.y + std::abs(t.n.z) * half.z;
  return std::abs(Dot(t.n, box.low + half - t.p0)) > reach + item.slack;
}

/// A tree over the items that grows where it is looked at.
class PairSearch {
 public:
  PairSearch(const std::vector<NearItem>& items,
             const std::function<void(std::size_t, std::size_t)>& visit)
      : items_(items), visit_(visit) {
    entries_.reserve(items.size());
    for (const NearItem& item : items) {
      entries_.push_back({BoxOf(item), entries_.size()});
    }
    nodes_.push_back(Cover(0, items.size()));
  }

  void Within(std::size_t n) {
    if (nodes_[n].label >= 0) {
      return;
    }
    if (nodes_[n].Count() > kFew) {
      const std::size_t child = Divide(n);
      Within(child);
      Within(child + 1);
      Between(child, child + 1);
      return;
    }
    for (std::size_t i = nodes_[n].begin; i < nodes_[n].end; ++i) {
      for (std::size_t k = i + 1; k < nodes_[n].end; ++k) {
        Offer(entries_[i], entries_[k]);
      }
    }
  }

 private:
  struct Entry {
    Box box;
    std::size_t item;
  };
  struct Node {
    Box box;
    std::size_t begin = 0, end = 0;  ///< into entries_
    std::int32_t label = -1;         ///< of all its items, -1 if they differ
    std::size_t child = 0;           ///< the first of two; 0: not divided yet
    [[nodiscard]] std::size_t Count() const { return end - begin; }
    [[nodiscard]] double Size() const { return SquaredNorm(box.Size()); }
  };

  [[nodiscard]] Node Cover(std::size_t begin, std::size_t end) const {
    Node node{entries_[begin].box, begin, end, LabelOf(entries_[begin])};
    for (std::size_t i = begin + 1; i < end; ++i) {
      node.box.Include(entries_[i].box);
      node.label = LabelOf(entries_[i]) == node.label ? node.label : -1;
    }
    return node;
  }

  std::size_t Divide(std::size_t n) {
    if (nodes_[n].child == 0) {
      const std::size_t begin = nodes_[n].begin;
      const std::size_t end = nodes_[n].end;
      const int axis = nodes_[n].box.LongestAxis();
      const auto at = [&](std::size_t i) {
        return entries_.begin() + static_cast<std::ptrdiff_t>(i);
      };
      // In the middle of the space, which is quick, unless that leaves almost all on one side.
      const double cut = nodes_[n].box.low[axis] + nodes_[n].box.high[axis];
      std::size_t middle = static_cast<std::size_t>(
          std::partition(at(begin), at(end), [=](const Entry& e) { return Twice(e, axis) < cut; }) -
          entries_.begin());
      if (std::min(middle - begin, end - middle) < (end - begin) / 8 + 1) {
        middle = (begin + end) / 2;
        std::nth_element(at(begin), at(middle), at(end), [=](const Entry& a, const Entry& b) {
          return Twice(a, axis) < Twice(b, axis);
        });
      }
      const std::size_t child = nodes_.size();
      nodes_.push_back(Cover(begin, middle));
      nodes_.push_back(Cover(middle, end));
      nodes_[n].child = child;
    }
    return nodes_[n].child;
  }

  /// Where the middle of an entry is along an axis.
  static double Twice(const Entry& e, int axis) { return e.box.low[axis] + e.box.high[axis]; }

  void Between(std::size_t a, std::size_t b) {
    if (!MayCount(nodes_[a].label, nodes_[b].label) || !nodes_[a].box.Meets(nodes_[b].box)) {
      return;
    }
    if (nodes_[a].Count() <= kFew || nodes_[b].Count() <= kFew) {
      if (nodes_[a].Count() > nodes_[b].Count()) {
        std::swap(a, b);
      }
      for (std::size_t i = nodes_[a].begin; i < nodes_[a].end; ++i) {
        With(entries_[i], b);
      }
      return;
    }
    if (nodes_[a].Size() < nodes_[b].Size()) {
      std::swap(a, b);
    }
    const std::size_t child = Divide(a);
    Between(child, b);
    Between(child + 1, b);
  }

  void With(const Entry& entry, std::size_t n) {
    if (!MayCount(LabelOf(entry), nodes_[n].label) || !entry.box.Meets(nodes_[n].box) ||
        IsBesidePlane(nodes_[n].box, items_[entry.item])) {
      return;
    }
    if (nodes_[n].Count() <= kFew) {
      for (std::size_t i = nodes_[n].begin; i < nodes_[n].end; ++i) {
        Offer(entry, entries_[i]);
      }
      return;
    }
    const std::size_t child = Divide(n);
    With(entry, child);
    With(entry, child + 1);
  }

  void Offer(const Entry& a, const Entry& b) {
    if (MayCount(LabelOf(a), LabelOf(b)) && a.box.Meets(b.box)) {
      visit_(a.item, b.item);
    }
  }
  [[nodiscard]] std::int32_t LabelOf(const Entry& entry) const { return items_[entry.item].label; }
  static bool MayCount(std::int32_t a, std::int32_t b) { return a != b || a < 0; }

  const std::vector<NearItem>& items_;
  const std::function<void(std::size_t, std::size_t)>& visit_;
  std::vector<Entry> entries_;
  std::vector<Node> nodes_;
};

}  // namespace

void ForEachNearPair(const std::vector<NearItem>& items,
                     const std::function<void(std::size_t, std::size_t)>& visit) {
  if (!items.empty()) {
    PairSearch(items, visit).Within(0);
  }
}

void SegmentPart::Keep(double at_start, double at_finish) {
  const double slope = at_finish - at_start;
  if (slope > 0.0) {
    begin = std::max(begin, -at_start / slope);
  } else if (slope < 0.0) {
    end = std::min(end, -at_start / slope);
  } else if (at_start < 0.0) {
    end = -1.0;
  }
}

void SegmentPart::KeepNear(const TriangleGeometry& triangle,
                           const Vec3& a,
                           const Vec3& b,
                           double slack) {
  const auto keep_below = [&](const Vec3& n, const Vec3& p, double most) {
    Keep(most + slack - Dot(n, a - p), most + slack - Dot(n, b - p));
  };
  keep_below(triangle.n, triangle.p0, 0.0);
  keep_below(-triangle.n, triangle.p0, 0.0);
  const std::array<Vec3, 3> corners = triangle.Corners();
  Vec3 longest, from;
  double length = 0.0;
  for (std::size_t i = 0; i < 3 && !IsEmpty(); ++i) {
    const Vec3 side = corners[(i + 1) % 3] - corners[i];
    const double norm = Norm(side);
    keep_below(Cross(side, triangle.n) * (1.0 / norm), corners[i], 0.0);
    if (norm > length) {
      longest = side * (1.0 / norm);
      from = corners[i];
      length = norm;
    }
  }
  // Beside the tip of a thin triangle its sides alone would let much pass.
  keep_below(longest, from, length);
  keep_below(-longest, from, 0.0);
}

}  // namespace pathfit::renderer
