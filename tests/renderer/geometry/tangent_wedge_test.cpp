#include "renderer/geometry/tangent_wedge.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/math/warp.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::tangent_wedge_test {
namespace {

constexpr double kPi = std::numbers::pi;

/// Faces along x whose normals differ by `angle`; the frame is turned so that nothing is exact.
BoundaryEdge EdgeOfAngle(double angle) {
  const Vec3 along = Normalized(Vec3{0.3, -0.5, 0.8});
  const Vec3 up = Normalized(Cross(along, Vec3{0.9, 0.2, 0.1}));
  const Vec3 side = Cross(along, up);
  BoundaryEdge edge;
  edge.a = {1.0, 2.0, 3.0};
  edge.b = edge.a + along * 0.7;
  edge.n0 = Normalized(up * std::cos(0.5 * angle) - side * std::sin(0.5 * angle));
  edge.n1 = Normalized(up * std::cos(0.5 * angle) + side * std::sin(0.5 * angle));
  return edge;
}

BoundaryEdge Border() {
  BoundaryEdge edge = EdgeOfAngle(0.4);
  edge.border = true;
  edge.n1 = -edge.n0;
  return edge;
}

TEST(TangentWedge, AngleIsAccurateFromNarrowToBorder) {
  for (const double angle : {1e-6, 1e-3, 0.5, 0.5 * kPi, 2.5, 3.1}) {
    // Unit normals hold 1e-16, which bounds the angle between them.
    EXPECT_NEAR(WedgeAngle(EdgeOfAngle(angle)), angle, 1e-15 + 1e-14 * angle);
  }
  EXPECT_DOUBLE_EQ(WedgeAngle(Border()), kPi);
}

TEST(TangentWedge, SamplesAreSilhouettesAndUnit) {
  std::vector<BoundaryEdge> edges = {Border()};
  for (const double angle : {1e-6, 1e-4, 0.01, 0.5, 0.5 * kPi, 2.5, 3.141}) {
    edges.push_back(EdgeOfAngle(angle));
  }
  edges.push_back(EdgeOfAngle(1e-6));
  edges.back().n1 *= 1.0 + 1e-15;  // rounding of its length must not tilt the wedge
  CounterRng rng(1);
  for (const BoundaryEdge& edge : edges) {
    int misses = 0;
    for (int i = 0; i < 20000; ++i) {
      const double u0 = rng.Next();
      const Vec3 w = SampleWedge(edge, u0, rng.Next());
      misses += edge.IsSilhouette(w) ? 0 : 1;
      ASSERT_NEAR(Norm(w), 1.0, 1e-14);
    }
    EXPECT_EQ(misses, 0) << "angle " << WedgeAngle(edge);
  }
}

/// Azimuth within the wedge in its own width, side and height along the edge: uniform in all.
void ExpectUniform(const BoundaryEdge& edge) {
  const Vec3 along = Normalized(edge.b - edge.a);
  const Vec3 h = Normalized(edge.n1 - edge.n0);
  const Vec3 s = Cross(h, along);
  const double angle = WedgeAngle(edge);
  constexpr int kBins = 8;
  std::vector<double> observed(kBins * kBins * 2);
  const int n = 100000;
  CounterRng rng(2);
  for (int i = 0; i < n; ++i) {
    const double u0 = rng.Next();
    const Vec3 w = SampleWedge(edge, u0, rng.Next());
    const int side = Dot(w, h) > 0.0 ? 1 : 0;
    const double azimuth = std::atan(Dot(w, s) / Dot(w, h));
    const auto bin = [](double x) { return std::min(kBins - 1, static_cast<int>(x * kBins)); };
    const int i0 = bin(std::max(0.0, azimuth / angle + 0.5));
    const int i1 = bin(0.5 * (Dot(w, along) + 1.0));
    observed[static_cast<std::size_t>((i0 * kBins + i1) * 2 + side)] += 1.0;
  }
  const std::vector<double> expected(observed.size(), n / static_cast<double>(observed.size()));
  EXPECT_TRUE(tests::ChiSquareAccepts(observed, expected, 5)) << "angle " << angle;
}

TEST(TangentWedge, UniformOverTheWedge) {
  for (const double angle : {1e-6, 0.02, 1.0, 2.8}) {
    ExpectUniform(EdgeOfAngle(angle));
  }
  ExpectUniform(Border());
}

TEST(TangentWedge, MeasureIsFourTimesTheAngle) {
  for (const BoundaryEdge& edge : {EdgeOfAngle(0.3), EdgeOfAngle(2.0), Border()}) {
    const int n = 200000;
    CounterRng rng(3);
    double inside = 0.0;
    for (int i = 0; i < n; ++i) {
      const double u0 = rng.Next();
      inside += edge.IsSilhouette(SampleUniformSphere(u0, rng.Next())) ? 1.0 : 0.0;
    }
    const double share = inside / n;
    const double sigma = std::sqrt(std::max(share * (1.0 - share), 1e-9) / n);
    EXPECT_NEAR(share * 4.0 * kPi, 4.0 * WedgeAngle(edge), 4.0 * 4.0 * kPi * sigma + 1e-9);
  }
}

TEST(TangentWedge, CloseNumbersAreCloseDirections) {
  const BoundaryEdge edge = EdgeOfAngle(1.0);
  for (int i = 0; i < 1000; ++i) {
    const double u = i / 1000.0;
    const double next = i == 999 ? 0.0 : u + 1e-3;
    EXPECT_LT(Norm(SampleWedge(edge, 0.3, u) - SampleWedge(edge, 0.3, next)), 0.1) << u;
  }
}

}  // namespace
}  // namespace pathfit::renderer::tangent_wedge_test
