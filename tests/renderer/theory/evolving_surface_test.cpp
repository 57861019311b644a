#include "tests/renderer/theory/evolving_surface.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/renderer/theory/surface_integral.h"
#include "tests/renderer/theory/surfaces.h"
#include "tests/support/finite_difference.h"

// Path_space 6.1: the identities of the paper's supplement, in its order ([S n] is its equation n).
namespace pathfit::tests::evolving_surface_test {
namespace {

using renderer::ReferenceConfiguration;

constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-12;
constexpr LocalBox kWholeSphere{0.0, 2.0 * kPi, -1.0, 1.0};

struct Row {
  std::string quantity;
  double value, expected;
};
void ExpectRows(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    EXPECT_NEAR(row.value, row.expected, kRounding * std::max(1.0, std::abs(row.expected)))
        << row.quantity;
  }
}
void AddRows(std::vector<Row>& rows,
             const std::string& name,
             const Vec3& value,
             const Vec3& expected) {
  for (int i = 0; i < 3; ++i) rows.push_back({name, value[i], expected[i]});
}

/// int phi dA over the translating square.
double SquareIntegral(double pi) {
  return SurfaceIntegral(SquareGlobal(), LocalBox(), pi, [](const auto& at) {
    return SquaredDistance()(SquareGlobal()(at), at.pi);
  });
}
double SphereIntegral(double r) {
  return SurfaceIntegral(ScalingSphere(), kWholeSphere, r, [](const auto& at) {
    return SquaredDistance()(ScalingSphere()(at), at.pi);
  });
}

TEST(EvolvingSurface, SeedSquareMovesAsPrinted) {
  const double pi = 0.3;
  // The spatial point (0.5, 1.0, pi) under both parameterisations.
  const LocalPoint<double> global{0.2, 0.7, pi};
  const LocalPoint<double> local{0.5, 1.0, pi};
  std::vector<Row> rows;
  AddRows(rows, "S 6: same point", MaterialPoint(SquareGlobal(), global), {0.5, 1.0, pi});
  AddRows(rows, "S 8: same point", MaterialPoint(SquareLocal(), local), {0.5, 1.0, pi});
  AddRows(rows,
          "S 2-5: P(chi(p)) = p",
          MaterialPoint(SquareGlobal(), global) - Vec3{pi, pi, pi},
          ReferenceConfiguration(SquareGlobal(), 0.0)(global));
  AddRows(rows, "S 7: local velocity, global", LocalVelocity(SquareGlobal(), global), {1, 1, 1});
  AddRows(rows, "S 9: local velocity, local", LocalVelocity(SquareLocal(), local), {0, 0, 1});
  AddRows(rows, "S 11: tangential velocity", TangentialVelocity(SquareGlobal(), global), {1, 1, 0});
  AddRows(rows, "S 12: tangential velocity", TangentialVelocity(SquareLocal(), local), {0, 0, 0});
  rows.push_back({"S 10: V, global", ScalarNormalVelocity(SquareGlobal(), global), 1.0});
  rows.push_back({"S 10: V, local", ScalarNormalVelocity(SquareLocal(), local), 1.0});
  rows.push_back({"S 13: phi", SquaredDistance()(Vec3{0.5, 1.0, pi}, pi), 0.25 + 1.0 + 0.09});
  const SquaredDistance phi;
  rows.push_back({"S 14: phidot, global", SceneDerivative(SquareGlobal(), phi, global), 3.6});
  rows.push_back({"S 16: phidot, local", SceneDerivative(SquareLocal(), phi, local), 0.6});
  rows.push_back({"S 15: boxphi, global", NormalSceneDerivative(SquareGlobal(), phi, global), 0.6});
  rows.push_back({"S 17: boxphi, local", NormalSceneDerivative(SquareLocal(), phi, local), 0.6});
  rows.push_back({"kappa of a plane", TotalCurvature(SquareGlobal(), global), 0.0});
  ExpectRows(rows);
}

TEST(EvolvingSurface, SeedSquareIntegralsAsPrinted) {
  const SquaredDistance phi;
  ExpectRows({{"S 18", SquareIntegral(0.3), 1.5366666666666667},
              {"S 18", SquareIntegral(-0.4), 0.3466666666666667}});
  for (const double pi : {0.3, -0.4, 1.25}) {
    const double interior = SurfaceIntegral(SquareGlobal(), LocalBox(), pi, [&](const auto& at) {
      return TransportIntegrand(SquareGlobal(), phi, at);
    });
    const double border = BorderTerm(SquareGlobal(), phi, LocalBox(), pi);
    const double material = SurfaceIntegral(
        ReferenceConfiguration(SquareGlobal(), 0.0), LocalBox(), pi, [&](const auto& at) {
          return MaterialIntegrand(SquareGlobal(), phi, 0.0, at);
        });
    ExpectRows({{"S 20, 21: interior 2 pi", interior, 2.0 * pi},
                {"S 22: border 4 pi + 2", border, 4.0 * pi + 2.0},
                {"S 23: sum 6 pi + 2", interior + border, 6.0 * pi + 2.0},
                {"(M): interior 6 pi + 2, alone", material, 6.0 * pi + 2.0},
                {"J = 1", AreaRatio(SquareGlobal(), 0.0, LocalPoint<double>{0.3, 0.9, pi}), 1.0}});
    EXPECT_NEAR(RiddersDerivative(SquareIntegral, pi, 0.1), 6.0 * pi + 2.0, 1e-10) << "S 19";
  }
}

TEST(EvolvingSurface, SeedSquareBorderVelocityIsOfTheBorderNotOfTheLabels) {
  const double expected[] = {-1.0, 1.0, 1.0, -1.0};  // outward normals -y, +x, +y, -x
  for (int side = 0; side < 4; ++side) {
    const BoxSide border{LocalBox(), side};
    // By x and y the labels rest and the border moves over them.
    const auto moving = [&](const auto& s, const auto& pi) {
      auto xi = border(s, pi);
      xi[0] += pi;
      xi[1] += pi;
      return xi;
    };
    EXPECT_NEAR(CurveNormalVelocity(SquareGlobal(), border, 0.4, 0.3), expected[side], kRounding);
    EXPECT_NEAR(CurveNormalVelocity(SquareLocal(), moving, 0.4, 0.3), expected[side], kRounding);
    // In the reference configuration it rests: (M) has no border term.
    EXPECT_EQ(CurveNormalVelocity(ReferenceConfiguration(SquareGlobal(), 0.0), border, 0.4, 0.3),
              0.0);
  }
}

TEST(EvolvingSurface, SeedSphereAsPrinted) {
  const double r = 1.7;
  const SquaredDistance phi;
  const LocalPoint<double> at{0.8, 0.35, r};
  const Vec3 x = MaterialPoint(ScalingSphere(), at);
  std::vector<Row> rows;
  AddRows(rows, "S 24: x = r p", x, ReferenceConfiguration(ScalingSphere(), 1.0)(at) * r);
  AddRows(rows, "S 27: velocity x / r", LocalVelocity(ScalingSphere(), at), x / r);
  rows.push_back({"S 28: V", ScalarNormalVelocity(ScalingSphere(), at), 1.0});
  rows.push_back({"S 29: boxphi 2 r", NormalSceneDerivative(ScalingSphere(), phi, at), 3.4});
  rows.push_back({"S 32: kappa", TotalCurvature(ScalingSphere(), at), -2.0 / r});
  rows.push_back({"S 32: integrand 4 r", TransportIntegrand(ScalingSphere(), phi, at), 6.8});
  rows.push_back({"S 33: J = r^2", AreaRatio(ScalingSphere(), 1.0, at), r * r});
  ExpectRows(rows);
  // Printed to 12 digits.
  EXPECT_NEAR(SphereIntegral(r), 104.955584008, 1e-9) << "S 30";
  EXPECT_NEAR(RiddersDerivative(SphereIntegral, r, 0.2), 246.954315313, 1e-9) << "S 31";
  const double transport = SurfaceIntegral(ScalingSphere(), kWholeSphere, r, [&](const auto& p) {
    return TransportIntegrand(ScalingSphere(), phi, p);
  });
  EXPECT_NEAR(transport, 16.0 * kPi * r * r * r, 1e-10) << "S 32";
  const double material = SurfaceIntegral(
      ReferenceConfiguration(ScalingSphere(), 1.0), kWholeSphere, r, [&](const auto& p) {
        return MaterialIntegrand(ScalingSphere(), phi, 1.0, p);
      });
  EXPECT_NEAR(material, 16.0 * kPi * r * r * r, 1e-10) << "S 33";
}

TEST(EvolvingSurface, OnlyNormalQuantitiesAreFreeOfTheLabels) {
  const LocalPoint<double> slid{0.4, 0.7, 0.35};
  const LocalPoint<double> plain = SlidLabels(slid);
  const WavingField phi;
  ASSERT_NEAR(Norm(RelabelledPatch()(slid) - WavingPatch()(plain)), 0.0, kRounding);
  ExpectRows(
      {{"V",
        ScalarNormalVelocity(RelabelledPatch(), slid),
        ScalarNormalVelocity(WavingPatch(), plain)},
       {"kappa", TotalCurvature(RelabelledPatch(), slid), TotalCurvature(WavingPatch(), plain)},
       {"boxphi",
        NormalSceneDerivative(RelabelledPatch(), phi, slid),
        NormalSceneDerivative(WavingPatch(), phi, plain)}});
  // The rest differs by the sliding of the labels, which is tangential.
  const Vec3 sliding = LocalVelocity(RelabelledPatch(), slid) - LocalVelocity(WavingPatch(), plain);
  EXPECT_GT(Norm(sliding), 0.1);
  EXPECT_NEAR(Dot(sliding, UnitNormal(WavingPatch(), plain)), 0.0, kRounding);
  const double slope = Dot(sliding, SurfaceGradient(WavingPatch(), phi, plain));
  EXPECT_GT(std::abs(slope), 0.01);
  EXPECT_NEAR(
      SceneDerivative(RelabelledPatch(), phi, slid) - SceneDerivative(WavingPatch(), phi, plain),
      slope,
      kRounding);
}

TEST(EvolvingSurface, DivergenceOfVelocityIsTheGrowthOfArea) {
  const LocalPoint<double> at{0.4, 0.7, 0.35};
  const auto log_area = [&](double pi) {
    return std::log(AreaElement(WavingPatch(), LocalPoint<double>{at.xi1, at.xi2, pi}));
  };
  const double divergence = VelocityDivergence(WavingPatch(), at);
  EXPECT_NEAR(divergence, RiddersDerivative(log_area, at.pi, 0.1), 1e-9);
  const auto tangential = [](const auto& p) { return TangentialVelocity(WavingPatch(), p); };
  EXPECT_NEAR(divergence,
              SurfaceDivergence(WavingPatch(), tangential, at) -
                  TotalCurvature(WavingPatch(), at) * ScalarNormalVelocity(WavingPatch(), at),
              kRounding);
}

TEST(EvolvingSurface, DerivativesAgreeWithJetsAndDifferences) {
  using J = ceres::Jet<double, 3>;
  const LocalPoint<double> at{0.4, 0.7, 0.35};
  const LocalPoint<J> jet{J(at.xi1, 0), J(at.xi2, 1), J(at.pi, 2)};
  const Vector3<J> x = WavingPatch()(jet);
  const auto [t1, t2] = SurfaceTangents(WavingPatch(), at);
  const Vec3 v = LocalVelocity(WavingPatch(), at);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(t1[i], x[i].v[0], kRounding);
    EXPECT_NEAR(t2[i], x[i].v[1], kRounding);
    EXPECT_NEAR(v[i], x[i].v[2], kRounding);
  }
  // The functions themselves accept Jets: derivative of the curvature along each variable.
  const J curvature = TotalCurvature(WavingPatch(), jet);
  const auto curvature_at = [&](int variable, double value) {
    LocalPoint<double> moved = at;
    (variable == 0 ? moved.xi1 : (variable == 1 ? moved.xi2 : moved.pi)) = value;
    return TotalCurvature(WavingPatch(), moved);
  };
  const double start[] = {at.xi1, at.xi2, at.pi};
  for (int k = 0; k < 3; ++k) {
    const double difference =
        RiddersDerivative([&](double value) { return curvature_at(k, value); }, start[k], 0.1);
    EXPECT_NEAR(curvature.v[k], difference, 1e-8);
  }
}

}  // namespace
}  // namespace pathfit::tests::evolving_surface_test
