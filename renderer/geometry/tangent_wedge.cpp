#include "renderer/geometry/tangent_wedge.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {

double WedgeAngle(const BoundaryEdge& edge) {
  // Unlike the arc cosine and the arc sine, accurate at both ends. [Kahan2006]
  return 2.0 * std::atan2(Norm(edge.n1 - edge.n0), Norm(edge.n0 + edge.n1));
}

Vec3 SampleWedge(const BoundaryEdge& edge, double u0, double u1) {
  // With s = (n0 + n1) / 2 and h = (n1 - n0) / 2 the wedge is |s.w| < |h.w|. The longer of the two
  // gives the first axis; the other one is made orthogonal to it, for in a narrow wedge the
  // rounding of the normals' lengths would tilt it.
  const auto across = [](const Vec3& v, const Vec3& unit) { return v - unit * Dot(v, unit); };
  const Vec3 sum = edge.n0 + edge.n1;
  const Vec3 difference = edge.n1 - edge.n0;
  Vec3 h;
  Vec3 s;
  if (SquaredNorm(sum) > SquaredNorm(difference)) {
    s = Normalized(sum);
    h = Normalized(across(difference, s));
  } else {
    h = Normalized(difference);
    const Vec3 rest = across(sum, h);
    // Folded onto itself, or a border: every direction is tangent, the edge is the pole.
    s = SquaredNorm(rest) > 0.0 ? Normalized(rest)
                                : Normalized(Cross(h, across(edge.b - edge.a, h)));
  }
  const double azimuth = (u0 - 0.5) * WedgeAngle(edge);
  // u1 goes up on one side and down on the other, so that close numbers are close directions.
  const bool first = u1 < 0.5;
  const double along = first ? 4.0 * u1 - 1.0 : 3.0 - 4.0 * u1;
  const double across_edge = (first ? 1.0 : -1.0) * std::sqrt(std::max(0.0, 1.0 - along * along));
  return Cross(s, h) * along + (h * std::cos(azimuth) + s * std::sin(azimuth)) * across_edge;
}

}  // namespace pathfit::renderer
