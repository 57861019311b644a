#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/renderer/theory/boundary_segment.h"
#include "tests/renderer/theory/geometry_term.h"
#include "tests/support/closed_forms.h"

// The closed forms of path_space 6.3 that need a boundary term, by quadrature over the occluder's
// edge with the functions of boundary_segment.h: (B0) for a point receiver, (B) for two extended
// surfaces, (B1) for a pixel.
namespace pathfit::tests::boundary_answers_test {
namespace {

using renderer::GrazingMotion;
using renderer::GrazingSegment;

constexpr double kQuadrature = 1e-10;

/// Emitter |x| < half_x, |y| < half_y at `height`; black half plane x < edge_x at `edge_height`,
/// its edge along y. Parameters of C8 and C11b in path_space 6.3.
struct HalfPlaneScene {
  double half_x = 0.6, half_y = 0.5, height = 2.0, edge_x = 0.05, edge_height = 0.8;

  /// The line from a floor point over the edge point of this y.
  [[nodiscard]] GrazingSegment<double> Segment(const Vec3& x_d, double y) const {
    const Vec3 x_b{edge_x, y, edge_height};
    return {x_d, x_b, x_d + (x_b - x_d) * (height / edge_height), {0, 1, 0}, {-1, 0, 0}};
  }
  /// (B0): int dl over the part of the edge whose shadow lies on the emitter.
  [[nodiscard]] double Boundary(const Vec3& x_d, const GrazingMotion<double>& motion) const {
    const double lambda = edge_height / height;
    const auto edge_y = [&](double y_s) { return x_d.y + lambda * (y_s - x_d.y); };
    return Integrate(
        [&](double y) {
          return PointReceiverWeight(Segment(x_d, y), motion, {0, 0, 1});
        },
        edge_y(-half_y),
        edge_y(half_y));
  }
};
constexpr GrazingMotion<double> kEdgeAlongX{{}, {1, 0, 0}, {}};

TEST(BoundaryAnswers, C8EdgeMotionIsBoundaryOnly) {
  const HalfPlaneScene s;
  const C8Answer c8 = C8HalfPlane(s.half_x, s.half_y, s.height, s.edge_x, s.edge_height);
  EXPECT_NEAR(s.Boundary({}, kEdgeAlongX), c8.d_edge_x, kQuadrature);
  EXPECT_NEAR(s.Boundary({}, {{}, {0, 0, 1}, {}}), c8.d_edge_height, kQuadrature);
}

TEST(BoundaryAnswers, C8EmitterAndReceiverMotionAreInteriorPlusBoundary) {
  const HalfPlaneScene s;
  const C8Answer c8 = C8HalfPlane(s.half_x, s.half_y, s.height, s.edge_x, s.edge_height);
  // Interior at fixed labels over the lit part; the plane emitter translates in itself: J' = 0.
  const double shadow = s.edge_x * s.height / s.edge_height;
  const auto interior = [&](const Vec3& v_d, const Vec3& v_s) {
    const renderer::OrientedPoint<double> receiver{{}, {0, 0, 1}};
    const auto integrand = [&](double x, double y) {
      const renderer::OrientedPoint<double> source{{x, y, s.height}, {0, 0, -1}};
      return GeometryTerm(receiver, source) *
             renderer::LogGeometryTermDerivative<double>(receiver, source, {v_d, {}}, {v_s, {}});
    };
    return Integrate2D(integrand, shadow, s.half_x, -s.half_y, s.half_y);
  };
  const Vec3 along_x{1, 0, 0};
  EXPECT_NEAR(
      interior({}, along_x) + s.Boundary({}, {{}, {}, along_x}), c8.d_emitter_x, kQuadrature);
  EXPECT_NEAR(
      interior(along_x, {}) + s.Boundary({}, {along_x, {}, {}}), c8.d_receiver_x, kQuadrature);
  // All three together: nothing changes.
  EXPECT_NEAR(c8.d_edge_x + c8.d_emitter_x + c8.d_receiver_x, 0.0, 1e-15);
}

TEST(BoundaryAnswers, C8IsRightOutsideThePenumbraToo) {
  const C8Answer lit = C8HalfPlane(0.6, 0.5, 2.0, -0.5, 0.8, 0.1);
  const C3Answer rectangle = C3Rectangle(-0.7, 0.5, -0.5, 0.5, 2.0);  // seen from x = 0.1
  EXPECT_EQ(lit.value, rectangle.value);
  EXPECT_EQ(lit.d_edge_x, 0.0);
  EXPECT_GT(std::abs(rectangle.d_x), 0.01);
  EXPECT_EQ(lit.d_emitter_x, rectangle.d_x);
  EXPECT_EQ(lit.d_receiver_x, -rectangle.d_x);
  const C8Answer dark = C8HalfPlane(0.6, 0.5, 2.0, 0.5, 0.8);
  EXPECT_EQ(dark.value, 0.0);
  EXPECT_EQ(dark.d_edge_x, 0.0);
  EXPECT_EQ(dark.d_emitter_x, 0.0);
  EXPECT_EQ(dark.d_receiver_x, 0.0);
}

TEST(BoundaryAnswers, C11bByDirectionsAtTheEdge) {  // (K) and (B) with a real occluder
  const HalfPlaneScene s;
  const double x0 = 0.0, x1 = 0.2, y0 = -0.05, y1 = 0.15;
  const C11bAnswer c11b =
      C11bFootprint(s.half_x, s.half_y, s.height, s.edge_x, s.edge_height, x0, x1, y0, y1);
  // Average over floor points x_D of int dl dsigma(w) sin(phi) V_rel, directions by their floor
  // point: dsigma = dA(x_D) / DetectorArea; the edge points are those whose shadow meets the
  // emitter.
  const double lambda = s.edge_height / s.height;
  const auto over_edge = [&](double x, double y) {
    const Vec3 x_d{x, y, 0.0};
    return Integrate(
        [&](double y_s) {
          const auto segment = s.Segment(x_d, y + lambda * (y_s - y));
          return lambda * BoundaryWeight(segment, kEdgeAlongX) /
                 DetectorArea(segment, Vec3{0, 0, 1});
        },
        -s.half_y,
        s.half_y,
        2);
  };
  const double area = (x1 - x0) * (y1 - y0);
  EXPECT_NEAR(Integrate2D(over_edge, x0, x1, y0, y1, 2, 2) / area, c11b.d_edge_x, kQuadrature);
  // The primal side: the same average of the lit area's G.
  const auto irradiance = [&](double x, double y) {
    const renderer::OrientedPoint<double> receiver{{x, y, 0}, {0, 0, 1}};
    const auto g = [&](double xs, double ys) {
      return renderer::GeometryTerm<double>(receiver, {{xs, ys, s.height}, {0, 0, -1}});
    };
    return Integrate2D(g, x + (s.edge_x - x) / lambda, s.half_x, -s.half_y, s.half_y, 2, 2);
  };
  EXPECT_NEAR(Integrate2D(irradiance, x0, x1, y0, y1, 1, 1) / area, c11b.value, kQuadrature);
}

TEST(BoundaryAnswers, C11StripByItsInfiniteEdge) {
  const double edge_x = 0.1, edge_height = 0.7, height = 2.0, x = 0.12;
  const C11Answer c11 = C11Strip(0.4, height, edge_x, edge_height, x);
  const HalfPlaneScene s{1.0, 1.0, height, edge_x, edge_height};
  // y = tan(t) covers the whole edge; the receiver sits at x.
  const auto boundary = [&](const Vec3& v_b) {
    return Integrate(
        [&](double t) {
          const double c = std::cos(t);
          const GrazingSegment<double> segment = s.Segment({x, 0, 0}, std::tan(t));
          return PointReceiverWeight(segment, {{}, v_b, {}}, Vec3{0, 0, 1}) / (c * c);
        },
        -0.5 * std::numbers::pi,
        0.5 * std::numbers::pi,
        16);
  };
  EXPECT_NEAR(boundary({1, 0, 0}), c11.d_edge_x, kQuadrature);
  EXPECT_NEAR(boundary({0, 0, 1}), c11.d_edge_height, kQuadrature);
}

TEST(BoundaryAnswers, C19IndirectLightPastAVerticalHalfPlane) {
  const C19Scene s;
  const C19Answer c19 = C19Indirect(s);
  // (B0) on the horizontal edge z = edge_z of the plane x = occluder_x, the wall as source.
  const double lambda = s.occluder_x / s.distance;
  const auto wall_radiance = [&](const Vec3& x) {
    const renderer::OrientedPoint<double> wall{x, {-1, 0, 0}};
    const auto g = [&](double ex, double ey) {
      return renderer::GeometryTerm<double>(wall, {{ex, ey, s.height}, {0, 0, -1}});
    };
    return s.albedo / std::numbers::pi * Integrate2D(g, s.x0, s.x1, -s.half_y, s.half_y, 2, 2);
  };
  const auto at = [&](double y) {
    const Vec3 x_b{s.occluder_x, y, s.edge_z};
    const GrazingSegment<double> segment{{}, x_b, x_b / lambda, {0, 1, 0}, {0, 0, -1}};
    return wall_radiance(segment.x_s) *
           PointReceiverWeight(segment, {{}, {0, 0, 1}, {}}, Vec3{0, 0, 1});
  };
  EXPECT_NEAR(
      Integrate(at, -lambda * s.wall_half_y, lambda * s.wall_half_y, 4), c19.d_edge_z, kQuadrature);
}

/// (B1): the edge x = edge_x, z of a bright half plane x < edge_x before black, in image form. The
/// background's label is the pixel: x_S turns and travels with the camera.
double PrimaryBoundary(const Filter1D& filter,
                       double focal,
                       double edge_x,
                       double z,
                       const Vec3& v_b,
                       const Vec3& spin) {
  const renderer::Pinhole<double> camera{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, focal};
  const Filter1D rows{Filter1D::Kind::kBox, 0.5, 0.0};
  const auto at = [&](double y) {
    const Vec3 x_b{edge_x, y, z};
    const GrazingSegment<double> segment{{}, x_b, x_b * 2.0, {0, 1, 0}, {-1, 0, 0}};
    const auto u = ImageOf(camera, x_b);
    const double cosine = Direction(segment).z;
    const double weight =
        filter.Value(u.u) * rows.Value(u.v) * focal * focal / (cosine * cosine * cosine);
    const GrazingMotion<double> motion{{}, v_b, Cross(spin, segment.x_s)};
    const double jump = 0.0 - 1.0;  // background minus foreground
    return BoundaryWeight(segment, motion) / SquaredNorm(x_b) * weight * jump;
  };
  return Integrate(at, -0.5 * z / focal, 0.5 * z / focal);
}

TEST(BoundaryAnswers, C12EdgeUnderThreeFilters) {
  const double focal = 4.0, z = 2.0, x = 0.08;
  using Kind = Filter1D::Kind;
  const Filter1D filters[] = {
      {Kind::kBox, 0.5, 0.0}, {Kind::kTent, 1.0, 0.0}, {Kind::kGauss, 1.5, 0.5}};
  for (const Filter1D& filter : filters) {
    const C12Answer c12 = C12FilterEdge(filter, focal, z, x);
    EXPECT_NEAR(PrimaryBoundary(filter, focal, x, z, {1, 0, 0}, {}), c12.d_x, kQuadrature);
    EXPECT_NEAR(PrimaryBoundary(filter, focal, x, z, {0, 0, 1}, {}), c12.d_z, kQuadrature);
    // The yaw of the table turns the edge towards smaller u at the centre.
    EXPECT_NEAR(PrimaryBoundary(filter, focal, x, z, {}, {0, 1, 0}), c12.d_yaw, kQuadrature);
  }
}

TEST(BoundaryAnswers, FiltersAreNormalisedAndTheirPartsFitTogether) {
  using Kind = Filter1D::Kind;
  const Filter1D filters[] = {
      {Kind::kBox, 0.5, 0.0}, {Kind::kTent, 0.8, 0.0}, {Kind::kGauss, 1.5, 0.5}};
  for (const Filter1D& filter : filters) {
    const auto value = [&](double u) { return filter.Value(u); };
    const auto slope = [&](double u) { return filter.Derivative(u); };
    EXPECT_NEAR(Integrate(value, -filter.radius, 0.0), 0.5, 1e-13);
    for (const double u : {-0.4, 0.1, 0.45}) {
      EXPECT_NEAR(filter.Cumulative(u), 0.5 + Integrate(value, 0.0, u), 1e-13);
      EXPECT_NEAR(filter.Value(u), filter.Value(0.0) + Integrate(slope, 0.0, u), 1e-12);
    }
    EXPECT_EQ(filter.Value(filter.radius + 1e-9), 0.0);
    EXPECT_NEAR(filter.Cumulative(2.0), 1.0, 1e-15);
    EXPECT_NEAR(filter.Cumulative(-2.0), 0.0, 1e-15);
  }
}

}  // namespace
}  // namespace pathfit::tests::boundary_answers_test
