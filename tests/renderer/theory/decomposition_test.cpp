#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/renderer/theory/evolving_surface.h"
#include "tests/renderer/theory/surface_integral.h"
#include "tests/renderer/theory/surfaces.h"
#include "tests/support/finite_difference.h"

// Path_space 6.2: the derivative of int phi dA by the transport relation (T) on the moving surface
// and by the material form (M) on the reference configuration. Both must give the exact derivative,
// with different shares of interior and boundary. A step of phi is the border of the region where
// phi is 1, run counter-clockwise, so that its jump is +1.
namespace pathfit::tests::decomposition_test {
namespace {

using renderer::ReferenceConfiguration;

constexpr double kPi = std::numbers::pi;
constexpr double kQuadrature = 1e-11;

/// The smooth part inside `box`: under (T), and under (M).
template <class Surface, class Field>
double TransportInterior(const Surface& surface,
                         const Field& field,
                         const LocalBox& box,
                         double pi) {
  return SurfaceIntegral(
      surface, box, pi, [&](const auto& at) { return TransportIntegrand(surface, field, at); });
}
template <class Surface, class Field>
double MaterialInterior(
    const Surface& surface, const Field& field, const LocalBox& box, double pi, double reference) {
  return SurfaceIntegral(ReferenceConfiguration(surface, reference), box, pi, [&](const auto& at) {
    return MaterialIntegrand(surface, field, reference, at);
  });
}
/// The step's share under (M): the jump of phi J times V_DeltaB.
template <class Surface, class Curve>
double MaterialStep(
    const Surface& surface, const Curve& curve, double pi, double reference, double s1 = 1.0) {
  const auto on_reference = ReferenceConfiguration(surface, reference);
  return CurveIntegral(
      on_reference,
      curve,
      pi,
      [&](double s) {
        const auto xi = curve(s, pi);
        return AreaRatio(surface, reference, LocalPoint<double>{xi[0], xi[1], pi}) *
               CurveNormalVelocity(on_reference, curve, s, pi);
      },
      0.0,
      s1);
}

TEST(Decomposition, E1StepOnATranslatingSquare) {
  const double pi = 0.3;
  const double a = 0.5;
  const LocalBox lit{a - pi, 1.0, 0.0, 1.0};  // phi = 1[x > a]
  // The step rests in space: over the labels it runs to the left. Downwards: the lit side is left.
  const auto step = [&](const auto& s, const auto& p) { return std::array{a - p, 1.0 - s}; };
  double transport = FluxThrough(SquareGlobal(), UnitField(), step, pi);
  for (const int side : {0, 1, 2}) {
    transport += FluxThrough(SquareGlobal(), UnitField(), BoxSide{lit, side}, pi);
  }
  EXPECT_NEAR(TransportInterior(SquareGlobal(), UnitField(), lit, pi), 0.0, kQuadrature);
  EXPECT_NEAR(transport, 1.0, kQuadrature);
  EXPECT_NEAR(MaterialInterior(SquareGlobal(), UnitField(), lit, pi, 0.0), 0.0, kQuadrature);
  EXPECT_NEAR(MaterialStep(SquareGlobal(), step, pi, 0.0), 1.0, kQuadrature);
}

TEST(Decomposition, E2StepOnAScalingSphere) {
  const double r = 1.3;
  const double a = 0.4;
  const LocalBox lit{0.0, 2.0 * kPi, a / r, 1.0};  // phi = 1[z > a]
  const auto step = [&](const auto& s, const auto& p) { return std::array{s, a / p}; };
  const double interior = 4.0 * kPi * (r - a);
  const double boundary = 2.0 * kPi * a;
  EXPECT_NEAR(interior, 11.3097336, 1e-7);
  EXPECT_NEAR(interior + boundary, 13.8230076758, 1e-10);
  EXPECT_NEAR(TransportInterior(ScalingSphere(), UnitField(), lit, r), interior, 1e-10);
  EXPECT_NEAR(FluxThrough(ScalingSphere(), UnitField(), step, r, 0.0, 2.0 * kPi), boundary, 1e-10);
  EXPECT_NEAR(CurveNormalVelocity(ScalingSphere(), step, 0.9, r),
              a / std::sqrt(r * r - a * a),
              kQuadrature);
  for (const double reference : {1.0, r}) {
    EXPECT_NEAR(MaterialInterior(ScalingSphere(), UnitField(), lit, r, reference), interior, 1e-10);
    EXPECT_NEAR(MaterialStep(ScalingSphere(), step, r, reference, 2.0 * kPi), boundary, 1e-10);
  }
}

/// The deforming triangle of path_space 1.3 over the square: (xi1, xi2) -> (s, t) = (xi1 (1 - xi2),
/// xi2), so that its third corner is the whole side xi2 = 1.
struct DeformingTriangle {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    const T s = at.xi1 * (1.0 - at.xi2);
    const T& t = at.xi2;
    const auto corner = [&](const Vec3& p, const Vec3& v) {
      return Vector3<T>{p.x + at.pi * v.x, p.y + at.pi * v.y, p.z + at.pi * v.z};
    };
    return corner({0.1, -0.2, 0.3}, {0.2, -0.1, 0.4}) * (1.0 - s - t) +
           corner({1.2, 0.1, -0.4}, {-0.3, 0.5, 0.1}) * s +
           corner({0.3, 0.9, 0.5}, {0.6, 0.2, -0.7}) * t;
  }
};

TEST(Decomposition, E3AreaOfADeformingTriangle) {
  const double derivative = -0.206497246465;
  double border = 0.0;
  for (const int side : {0, 1, 3}) {
    border += FluxThrough(DeformingTriangle(), UnitField(), BoxSide{LocalBox(), side}, 0.0);
  }
  EXPECT_NEAR(
      TransportInterior(DeformingTriangle(), UnitField(), LocalBox(), 0.0), 0.0, kQuadrature);
  EXPECT_NEAR(border, derivative, 1e-12);
  EXPECT_NEAR(
      MaterialInterior(DeformingTriangle(), UnitField(), LocalBox(), 0.0, 0.0), derivative, 1e-12);
}

TEST(Decomposition, E4RotatingSheet) {
  const auto height = [](const auto& x, const auto& /*pi*/) { return x.z; };
  const double derivative = 0.5 * std::cos(0.7);
  EXPECT_NEAR(derivative, 0.382421093642, 1e-12);
  EXPECT_NEAR(TransportInterior(RotatingSheet(), height, LocalBox(), 0.7), derivative, kQuadrature);
  EXPECT_NEAR(BorderTerm(RotatingSheet(), height, LocalBox(), 0.7), 0.0, kQuadrature);
  EXPECT_NEAR(
      MaterialInterior(RotatingSheet(), height, LocalBox(), 0.7, 0.0), derivative, kQuadrature);
}

TEST(Decomposition, E5ExpandingCylinder) {
  const double r = 0.8;
  const LocalBox box{0.0, 2.0 * kPi, 0.0, 2.0};
  const auto field = [](const auto& x, const auto& pi) { return x.z * x.z + pi; };
  const double derivative = 36.8613538021;
  EXPECT_NEAR(TransportInterior(ExpandingCylinder(), field, box, r), derivative, 1e-10);
  EXPECT_NEAR(BorderTerm(ExpandingCylinder(), field, box, r), 0.0, kQuadrature);
  EXPECT_NEAR(MaterialInterior(ExpandingCylinder(), field, box, r, 1.0), derivative, 1e-10);
  EXPECT_NEAR(
      TotalCurvature(ExpandingCylinder(), LocalPoint<double>{0.3, 1.1, r}), -1.0 / r, 1e-12);
}

TEST(Decomposition, E6StaticDiscOnATranslatingSquare) {
  const double pi = 0.3;
  const auto outline = [](const auto& s, const auto& p) {
    using std::cos;
    using std::sin;
    return std::array{0.8 + 0.25 * cos(s) - p, 0.9 + 0.25 * sin(s) - p};
  };
  EXPECT_NEAR(
      FluxThrough(SquareGlobal(), UnitField(), outline, pi, 0.0, 2.0 * kPi), 0.0, kQuadrature);
  EXPECT_NEAR(MaterialStep(SquareGlobal(), outline, pi, 0.0, 2.0 * kPi), 0.0, 1e-14);
  // Point by point the outline does move over the material.
  const auto reference = ReferenceConfiguration(SquareGlobal(), 0.0);
  EXPECT_NEAR(CurveNormalVelocity(reference, outline, 0.0, pi), -1.0, kQuadrature);
}

TEST(Decomposition, BothHoldOnACurvedPatchWithAFieldOfTheParameter) {
  const LocalBox box{0.1, 0.9, -0.2, 0.7};
  const double pi = 0.35;
  const auto integral = [&](double p) {
    return SurfaceIntegral(WavingPatch(), box, p, [](const auto& at) {
      return WavingField()(WavingPatch()(at), at.pi);
    });
  };
  const double exact = RiddersDerivative(integral, pi, 0.1);
  const double interior = TransportInterior(WavingPatch(), WavingField(), box, pi);
  const double border = BorderTerm(WavingPatch(), WavingField(), box, pi);
  EXPECT_NEAR(interior + border, exact, 1e-9);
  EXPECT_GT(std::abs(border), 0.01);
  for (const double reference : {0.0, 0.35, 0.8}) {
    EXPECT_NEAR(MaterialInterior(WavingPatch(), WavingField(), box, pi, reference), exact, 1e-9);
  }
}

}  // namespace
}  // namespace pathfit::tests::decomposition_test
