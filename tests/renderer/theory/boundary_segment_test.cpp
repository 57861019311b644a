#include "tests/renderer/theory/boundary_segment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/geometry/triangle_kernel.h"
#include "tests/renderer/theory/geometry_term.h"
#include "tests/support/closed_forms.h"
#include "tests/support/finite_difference.h"

namespace pathfit::tests::boundary_segment_test {
namespace {

using renderer::GrazingMotion;
using renderer::GrazingSegment;
using renderer::Vector3;

constexpr int kSegments = 200;

/// A segment in general position, the triangle its source end lies on, and velocities for all.
struct Case {
  GrazingSegment<double> segment;
  Vec3 n_d, n_s;
  GrazingMotion<double> motion;
  Vec3 edge_spin;                         ///< the edge also turns about x_B
  Vec3 corners[3], corner_velocities[3];  ///< of the triangle around x_S
  double b1 = 0.0, b2 = 0.0;              ///< barycentrics of x_S
};

class CaseSource {
 public:
  Case Next() {
    for (;;) {
      const Case c = Draw();
      const Vec3 w = Direction(c.segment);
      // Formula A divides by these; the functions under test need no limit but rounding grows.
      if (SinPhi(c.segment) < 0.2 || std::abs(Dot(c.n_s, w)) < 0.2 ||
          std::abs(Dot(c.n_d, w)) < 0.2 || std::abs(Dot(c.segment.into_occluder, w)) > 0.9 ||
          std::abs(Dot(OccluderNormal(c.segment), c.segment.into_occluder)) < 0.1 ||
          Norm(Cross(w, ShadowCurveOn(c.segment, c.n_s).q)) < 0.2) {
        continue;
      }
      return c;
    }
  }

 private:
  double Number() { return uniform_(engine_); }
  Vec3 Vector() { return {Number(), Number(), Number()}; }
  Case Draw() {
    Case c;
    c.segment.x_b = Vector();
    const Vec3 w = Normalized(Vector());
    c.segment.x_d = c.segment.x_b - w * (1.2 + Number());
    c.segment.x_s = c.segment.x_b + w * (1.2 + Number());
    c.segment.edge = Normalized(Vector());
    c.segment.into_occluder = Normalized(Vector());
    c.n_d = Normalized(Vector());
    c.motion = {Vector(), Vector(), {}};
    c.edge_spin = Vector();
    c.b1 = 0.3 + 0.2 * Number();
    c.b2 = 0.3 + 0.2 * Number();
    c.corners[1] = c.segment.x_s + Vector();
    c.corners[2] = c.segment.x_s + Vector();
    c.corners[0] =
        (c.segment.x_s - c.corners[1] * c.b1 - c.corners[2] * c.b2) / (1.0 - c.b1 - c.b2);
    for (Vec3& velocity : c.corner_velocities) velocity = Vector();
    c.motion.v_s = c.corner_velocities[0] * (1.0 - c.b1 - c.b2) + c.corner_velocities[1] * c.b1 +
                   c.corner_velocities[2] * c.b2;
    c.n_s = renderer::TriangleGeometry::Make(c.corners[0], c.corners[1], c.corners[2]).n;
    return c;
  }

  std::mt19937 engine_{20200801};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

template <class T>
Vector3<T> Moved(const Vec3& a, const Vec3& b, const T& t) {
  return {a.x + t * b.x, a.y + t * b.y, a.z + t * b.z};
}
/// The two lines after time t. The segment no longer meets the edge: MissDistance tells by how
/// much.
template <class T>
GrazingSegment<T> At(const Case& c, const T& t) {
  return {Moved(c.segment.x_d, c.motion.v_d, t),
          Moved(c.segment.x_b, c.motion.v_b, t),
          Moved(c.segment.x_s, c.motion.v_s, t),
          Normalized(Moved(c.segment.edge, Cross(c.edge_spin, c.segment.edge), t)),
          Moved(c.segment.into_occluder, {}, t)};
}

TEST(BoundarySegment, OccluderNormalIsAcrossLineAndEdge) {
  CaseSource cases;
  for (int i = 0; i < kSegments; ++i) {
    const Case c = cases.Next();
    const Vec3 n = OccluderNormal(c.segment);
    EXPECT_NEAR(Norm(n), 1.0, 1e-14);
    EXPECT_NEAR(Dot(n, c.segment.edge), 0.0, 1e-14);
    EXPECT_NEAR(Dot(n, Direction(c.segment)), 0.0, 1e-14);
    EXPECT_GT(Dot(n, c.segment.into_occluder), 0.0);
    EXPECT_NEAR(MissDistance(c.segment), 0.0, 1e-13);
    const Vec3 x_b = c.segment.x_d * (1.0 - Lambda(c.segment)) + c.segment.x_s * Lambda(c.segment);
    EXPECT_NEAR(Norm(x_b - c.segment.x_b), 0.0, 1e-13);
  }
}

TEST(BoundarySegment, RelativeVelocityIsMinusTheRateOfTheMissDistance) {  // (V)
  using J = ceres::Jet<double, 1>;
  CaseSource cases;
  for (int i = 0; i < kSegments; ++i) {
    const Case c = cases.Next();
    const double hand = RelativeVelocity(c.segment, c.motion);
    // The turning of the edge about x_B does not enter: the envelope theorem.
    EXPECT_NEAR(hand, -MissDistance(At(c, J(0.0, 0))).v[0], 1e-12);
    const auto miss = [&](double t) { return MissDistance(At(c, t)); };
    EXPECT_NEAR(hand, -RiddersDerivative(miss, 0.0, 1e-2), 1e-8);
  }
}

TEST(BoundarySegment, RigidMotionAndScalingOfEverythingMoveNothing) {  // C28
  CaseSource cases;
  for (int i = 0; i < kSegments; ++i) {
    const Case c = cases.Next();
    const Vec3 drift = c.motion.v_b;
    const auto rigid = [&](const Vec3& x) { return drift + Cross(c.edge_spin, x); };
    const auto scaled = [&](const Vec3& x) { return (x - drift) * 0.7; };
    const auto at = [&](auto velocity) -> GrazingMotion<double> {
      return {velocity(c.segment.x_d), velocity(c.segment.x_b), velocity(c.segment.x_s)};
    };
    EXPECT_NEAR(RelativeVelocity(c.segment, at(rigid)), 0.0, 1e-13);
    EXPECT_NEAR(RelativeVelocity(c.segment, at(scaled)), 0.0, 1e-13);
    EXPECT_GT(std::abs(RelativeVelocity(c.segment, {drift, rigid(c.segment.x_b), drift})) +
                  std::abs(RelativeVelocity(c.segment, c.motion)),
              1e-6);
  }
}

/// Where the line from x_B along w meets the plane through `point`.
template <class T>
Vector3<T> OnPlane(const Vector3<T>& x_b, const Vector3<T>& w, const Vec3& point, const Vec3& n) {
  const Vector3<T> normal{T(n.x), T(n.y), T(n.z)};
  const Vector3<T> to{point.x - x_b.x, point.y - x_b.y, point.z - x_b.z};
  return x_b + w * (Dot(to, normal) / Dot(w, normal));
}

TEST(BoundarySegment, ChangeOfVariablesIsTheJacobianOfTheGrazingLines) {  // (K), steps 1 to 4
  using J = ceres::Jet<double, 3>;
  CaseSource cases;
  for (int i = 0; i < kSegments; ++i) {
    const Case c = cases.Next();
    const auto& s = c.segment;
    // Grazing lines by (length along the edge, direction): Jets give the volume form
    // dA(x_D) dl(x_S) per dl(x_B) dsigma(w).
    const Vec3 w0 = Direction(s);
    const Vec3 side = Normalized(Cross(w0, std::abs(w0.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    const Vec3 other = Cross(w0, side);
    const Vector3<J> x_b = Moved(s.x_b, s.edge, J(0.0, 0));
    Vector3<J> w = Moved(w0, side, J(0.0, 1));
    w += Moved(Vec3(), other, J(0.0, 2));
    const Vector3<J> x_d = OnPlane(x_b, w, s.x_d, c.n_d);
    const Vector3<J> x_s = OnPlane(x_b, w, s.x_s, c.n_s);
    const Vec3 u = Normalized(Cross(c.n_d, w0));
    const Vec3 v = Cross(c.n_d, u);
    const auto gradient = [](const Vector3<J>& x, const Vec3& along) -> Vec3 {
      const auto part = [&](int k) {
        return x.x.v[k] * along.x + x.y.v[k] * along.y + x.z.v[k] * along.z;
      };
      return {part(0), part(1), part(2)};
    };
    const double volume = std::abs(
        Dot(gradient(x_d, u), Cross(gradient(x_d, v), gradient(x_s, ShadowCurveOn(s, c.n_s).q))));
    EXPECT_NEAR(ShadowLength(s, c.n_s) * DetectorArea(s, c.n_d) / volume, 1.0, 1e-10);
    const double g = renderer::GeometryTerm<double>({s.x_d, c.n_d}, {s.x_s, c.n_s});
    EXPECT_NEAR(g * CurveDensity(s, c.n_s) * volume, SinPhi(s), 1e-10);
    EXPECT_NEAR(g * CurveDensity(s, c.n_s) * ShadowLength(s, c.n_s) * DetectorArea(s, c.n_d),
                SinPhi(s),
                1e-13);
    // Step 4 on its own.
    const auto [q, m] = ShadowCurveOn(s, c.n_s);
    EXPECT_NEAR(
        std::abs(Dot(c.n_s, w0)), Norm(Cross(w0, q)) * std::abs(Dot(OccluderNormal(s), m)), 1e-14);
  }
}

TEST(BoundarySegment, RayFootVelocityIsThatOfTheMovingIntersection) {
  CaseSource cases;
  for (int i = 0; i < kSegments / 4; ++i) {
    const Case c = cases.Next();
    const auto foot = [&](double t) {
      Vec3 p[3];
      for (int k = 0; k < 3; ++k) p[k] = c.corners[k] + c.corner_velocities[k] * t;
      const GrazingSegment<double> s = At(c, t);
      const auto hit =
          IntersectPlane(renderer::TriangleGeometry::Make(p[0], p[1], p[2]), s.x_d, s.x_b - s.x_d);
      return c.corners[0] * (1.0 - hit.b1 - hit.b2) + c.corners[1] * hit.b1 + c.corners[2] * hit.b2;
    };
    const Vec3 hand = RayFootVelocity(c.segment, c.motion, c.n_s);
    for (int k = 0; k < 3; ++k) {
      const double difference = RiddersDerivative([&](double t) { return foot(t)[k]; }, 0.0, 1e-3);
      EXPECT_NEAR(hand[k], difference, 1e-7 * std::max(1.0, Norm(hand)));
    }
  }
}

TEST(BoundarySegment, FormulaAIsSinPhiTimesRelativeVelocity) {
  CaseSource cases;
  double worst = 0.0;
  for (int i = 0; i < 10 * kSegments; ++i) {
    const Case c = cases.Next();
    const double b = BoundaryWeight(c.segment, c.motion);
    EXPECT_EQ(b, SinPhi(c.segment) * RelativeVelocity(c.segment, c.motion));
    const double size = std::max({Norm(c.motion.v_d), Norm(c.motion.v_b), Norm(c.motion.v_s)});
    worst = std::max(
        worst, std::abs(FormulaA(c.segment, c.motion, c.n_s) - b) / (SinPhi(c.segment) * size));
    // u' along m is V_DeltaB, up to the sign that formula A carries separately.
    const auto [q, m] = ShadowCurveOn(c.segment, c.n_s);
    const double along = Dot(m, RayFootVelocity(c.segment, c.motion, c.n_s)) *
                         (Dot(OccluderNormal(c.segment), m) < 0.0 ? -1.0 : 1.0);
    EXPECT_NEAR(along, ShadowCurveVelocity(c.segment, c.motion, c.n_s), 1e-11);
  }
  EXPECT_LT(worst, 1e-12);
}

TEST(BoundarySegment,
     WeightIsTheSameFromBothEnds) {  // C37: both orders are wanted, with one weight
  CaseSource cases;
  for (int i = 0; i < kSegments; ++i) {
    const Case c = cases.Next();
    const auto& s = c.segment;
    const GrazingSegment<double> swapped{s.x_s, s.x_b, s.x_d, s.edge, s.into_occluder};
    EXPECT_NEAR(BoundaryWeight(s, c.motion),
                BoundaryWeight(swapped, {c.motion.v_s, c.motion.v_b, c.motion.v_d}),
                1e-13);
  }
}

}  // namespace
}  // namespace pathfit::tests::boundary_segment_test
