#include "tests/support/closed_forms.h"

#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

// Every printed number of path_space 6.3, then the same formulas against differences of themselves
// at other arguments, so that the helpers other tests rely on are right away from the table too.
namespace pathfit::tests::closed_forms_test {
namespace {

using Kind = Filter1D::Kind;
constexpr Filter1D kBox{Kind::kBox, 0.5, 0.0};
constexpr Filter1D kTent{Kind::kTent, 1.0, 0.0};
constexpr Filter1D kGauss{Kind::kGauss, 1.5, 0.5};

/// The table prints 13 digits; zeros are those of its own rounding.
void ExpectPrinted(double value, double printed, const std::string& what) {
  EXPECT_NEAR(value, printed, 1e-12 * std::abs(printed) + 1e-15) << what;
}
void ExpectPrinted(const Vec3& value, const Vec3& printed, const std::string& what) {
  for (int i = 0; i < 3; ++i) ExpectPrinted(value[i], printed[i], what);
}

TEST(ClosedForms, DisksMatchTheTable) {
  const C1Answer c1 = C1CoaxialDisk(0.5, 2.0);
  ExpectPrinted(c1.value, 1.847995678582e-01, "C1 E");
  ExpectPrinted(c1.d_radius, 6.957160201721e-01, "C1 dR");
  ExpectPrinted(c1.d_height, -1.739290050430e-01, "C1 dh");
  const C2Answer c2 = C2OffsetDisk(0.5, 2.0, 0.7);
  ExpectPrinted(c2.value, 1.501185034406e-01, "C2 E");
  ExpectPrinted(c2.d_offset, -8.537633483664e-02, "C2 da");
  ExpectPrinted(c2.d_height, -1.146482210663e-01, "C2 dh");
  ExpectPrinted(c2.d_radius, 5.781197530367e-01, "C2 dR");
  const double values[3][2] = {{1.673402101046e-01, 6.336340232248e-01},
                               {1.836836304362e-01, 6.917755160774e-01},
                               {1.847297252345e-01, 6.954695093416e-01}};
  for (int i = 0; i < 3; ++i) {
    const C33Answer c33 = C33RegularPolygon(8 << (2 * i), 0.5, 2.0);
    ExpectPrinted(c33.value, values[i][0], "C33 E");
    ExpectPrinted(c33.d_radius, values[i][1], "C33 dR");
  }
}

TEST(ClosedForms, RectanglesMatchTheTable) {
  const C3Answer c3 = C3Rectangle(-0.3, 0.7, -0.4, 0.6, 1.5);
  ExpectPrinted(c3.value, 3.745815647112e-01, "C3 E");
  ExpectPrinted(c3.d_x, -1.004550977969e-01, "C3 dx");
  ExpectPrinted(c3.d_y, -5.017480138979e-02, "C3 dy");
  ExpectPrinted(c3.d_height, -4.231140697066e-01, "C3 dh");
  ExpectPrinted(c3.d_scale, 6.597796042583e-01, "C3 dscale");
  const C4Answer c4 = C4RotatedRectangle(1.0, 0.6, {0.2, 0.1, 1.5}, 0.3);
  ExpectPrinted(c4.value, 2.322605239587e-01, "C4 E");
  ExpectPrinted(c4.d_theta, -2.552660729420e-02, "C4 dtheta");
  ExpectPrinted(c4.d_x, -4.364519192477e-02, "C4 dx");
  ExpectPrinted(c4.d_y, -3.606716317770e-02, "C4 dy");
  ExpectPrinted(c4.d_z, -2.751454395375e-01, "C4 dz");
  ExpectPrinted(c4.d_turn_about_receiver, 0.0, "C4 turn about receiver");
  ExpectPrinted(c4.d_scale, 4.250539140090e-01, "C4 dscale");
  ExpectPrinted(c4.d_scale_about_receiver, 0.0, "C4 scale about receiver");
  const C6Answer c6 = C6Wall(0.8, -0.5, 0.9, 1.1);
  ExpectPrinted(c6.value, 4.258696143535e-01, "C6 E");
  ExpectPrinted(c6.d_distance, -7.167805902798e-01, "C6 dd");
  ExpectPrinted(c6.d_height, 3.009145001218e-01, "C6 dH");
  const C26Answer c26 = C26TexturedEmitter(0.5, 0.4, 1.2, 0.1);
  ExpectPrinted(c26.value, 4.590201169266e-01, "C26 E");
  ExpectPrinted(c26.d_s, -1.284736609891e-01, "C26 ds");
}

TEST(ClosedForms, SpheresMatchTheTable) {
  const SphereAnswer c7 = C7Sphere(0.3, {0.4, -0.3, 1.5});
  ExpectPrinted(c7.value, 1.072935532706e-01, "C7 E");
  ExpectPrinted(c7.d_radius, 7.152903551373e-01, "C7 dR");
  ExpectPrinted(
      c7.d_centre, {-5.150090556989e-02, 3.862567917742e-02, -1.215993603733e-01}, "C7 dc");
  const SphereAnswer c10 = C10SphereOccluder(0.8, 2.0, 0.15, {0.05, -0.04, 0.9});
  ExpectPrinted(c10.value, 4.416618836981e-01, "C10 E");
  ExpectPrinted(c10.d_radius, -1.154774020367e+00, "C10 dR");
  ExpectPrinted(
      c10.d_centre, {1.595775424288e-02, -1.276620339430e-02, 1.910084080079e-01}, "C10 dc");
  const SphereAnswer c23 = C23SphereUnderSky(0.3, {0.2, -0.1, 0.8});
  ExpectPrinted(c23.value, 2.746945719694e+00, "C23 E");
  ExpectPrinted(c23.d_radius, -2.630979559307e+00, "C23 dR");
  ExpectPrinted(
      c23.d_centre, {3.431712468661e-01, -1.715856234331e-01, 8.793763200945e-01}, "C23 dc");
}

TEST(ClosedForms, OccludersMatchTheTable) {
  const C8Answer c8 = C8HalfPlane(0.6, 0.5, 2.0, 0.05, 0.8);
  ExpectPrinted(c8.value, 1.062857221707e-01, "C8 E");
  ExpectPrinted(c8.d_edge_x, -5.957683349300e-01, "C8 ds");
  ExpectPrinted(c8.d_edge_height, 3.723552093312e-02, "C8 dz_o");
  ExpectPrinted(c8.d_receiver_x, 3.929982931156e-01, "C8 receiver");
  ExpectPrinted(c8.d_emitter_x, 2.027700418144e-01, "C8 emitter");
  const C11Answer c11 = C11Strip(0.4, 2.0, 0.1, 0.7, 0.12);
  ExpectPrinted(c11.value, 2.626491128471e-01, "C11 E");
  ExpectPrinted(c11.d_edge_x, -2.241249805045e+00, "C11 ds");
  ExpectPrinted(c11.d_edge_height, -6.403570871557e-02, "C11 dz_o");
  const auto filtered = [](const Filter1D& filter) {
    return C11StripFiltered(0.4, 2.0, 0.1, 0.7, filter, 0.1);
  };
  const C11Answer box = filtered({Kind::kBox, 0.1, 0.0});
  ExpectPrinted(box.value, 2.327345340118e-01, "C11 box");
  ExpectPrinted(box.d_edge_x, -2.221441469079e+00, "C11 box ds");
  ExpectPrinted(box.d_edge_height, 0.0, "C11 box dz_o");
  const C11Answer tent = filtered({Kind::kTent, 0.1, 0.0});
  ExpectPrinted(tent.value, 2.328735057496e-01, "C11 tent");
  ExpectPrinted(tent.d_edge_x, -2.232661156633e+00, "C11 tent ds");
  const C11Answer gauss = filtered({Kind::kGauss, 0.1, 0.04});
  ExpectPrinted(gauss.value, 2.329061478273e-01, "C11 Gauss");
  ExpectPrinted(gauss.d_edge_x, -2.235306038160e+00, "C11 Gauss ds");
  const C11bAnswer c11b = C11bFootprint(0.6, 0.5, 2.0, 0.05, 0.8, 0.0, 0.2, -0.05, 0.15);
  ExpectPrinted(c11b.value, 1.445362362111e-01, "C11b E");
  ExpectPrinted(c11b.d_edge_x, -5.884459617591e-01, "C11b ds");
  const C19Answer c19 = C19Indirect({});
  ExpectPrinted(c19.value, 2.213654950580e-03, "C19 E");
  ExpectPrinted(c19.d_edge_z, -5.697802856714e-03, "C19 ds");
  ExpectPrinted(c19.direct, 7.043044761367e-02, "C19 direct");
}

TEST(ClosedForms, FilteredEdgesMatchTheTable) {
  struct Row {
    Filter1D filter;
    double value, d_x, d_z, d_yaw, both, primary, foreground;
  };
  const Row rows[] = {{kBox, 0.66, 2.0, -0.08, -4.0064, -1.6, -2.2, 0.6},
                      {kTent, 0.6472, 1.68, -0.0672, -3.365376, -1.344, -1.848, 0.504},
                      {kGauss,
                       6.278422562538e-01,
                       1.543608368540e+00,
                       -6.174433474161e-02,
                       -3.092156283860e+00,
                       -1.234886694832e+00,
                       -1.697969205394e+00,
                       4.630825105621e-01}};
  for (const Row& row : rows) {
    const C12Answer c12 = C12FilterEdge(row.filter, 4.0, 2.0, 0.08);
    ExpectPrinted(c12.value, row.value, "C12 I");
    ExpectPrinted(c12.d_x, row.d_x, "C12 dx");
    ExpectPrinted(c12.d_z, row.d_z, "C12 dz");
    ExpectPrinted(c12.d_yaw, row.d_yaw, "C12 dyaw");
    const C30Answer c30 = C30ForegroundEdge(row.filter, 0.3, 1.1, 4.0, 2.0, 0.08);
    ExpectPrinted(c30.d_x, row.both, "C30 dx");
    ExpectPrinted(c30.primary, row.primary, "C30 primary");
    ExpectPrinted(c30.foreground, row.foreground, "C30 foreground");
  }
}

TEST(ClosedForms, QuadsUnderFiltersMatchTheTable) {
  const C13Answer c13 = C13TiltedQuad(5.0, 0.2, 0.3, 3.0, 0.4);
  ExpectPrinted(c13.value, 1.536266284006e-01, "C13 I");
  ExpectPrinted(c13.d_z, -1.024954382619e-01, "C13 dz");
  ExpectPrinted(c13.d_tilt, -6.440106273540e-02, "C13 dtilt");
  ExpectPrinted(c13.d_f, 6.145065136025e-02, "C13 df");
  const C13Answer flat = C13TiltedQuad(5.0, 0.2, 0.3, 3.0, 0.0);
  ExpectPrinted(flat.value, 1.666666666667e-01, "C13 flat I");
  ExpectPrinted(flat.d_z, -1.111111111111e-01, "C13 flat dz");
  const C13bAnswer tent = C13bFilteredQuad(kTent, 5.0, 0.2, 0.3, 0.12, -0.07, 3.0);
  ExpectPrinted(tent.value, 1.130370370370e-01, "C13b tent I");
  ExpectPrinted(tent.d_cx, -2.354938271605e-01, "C13b tent dcx");
  ExpectPrinted(tent.d_cy, 1.037037037037e-01, "C13b tent dcy");
  ExpectPrinted(tent.d_z, -5.917283950617e-02, "C13b tent dz");
  const C13bAnswer gauss = C13bFilteredQuad(kGauss, 5.0, 0.2, 0.3, 0.12, -0.07, 3.0);
  ExpectPrinted(gauss.value, 9.351889927426e-02, "C13b Gauss I");
  ExpectPrinted(gauss.d_cx, -1.216335167083e-01, "C13b Gauss dcx");
  ExpectPrinted(gauss.d_cy, 6.768330280550e-02, "C13b Gauss dcy");
  ExpectPrinted(gauss.d_z, -5.252228725810e-02, "C13b Gauss dz");
}

TEST(ClosedForms, MovingPlanesMatchTheTable) {
  const MaterialSplit c14 = C14MovingPlane(3.0);
  ExpectPrinted(c14.interior, -6.666666666667e-01, "C14 interior");
  ExpectPrinted(c14.filter, 6.666666666667e-01, "C14 filter");
  const MaterialSplit c15 = C15TiltedPlane(3.0, 0.4);
  ExpectPrinted(c15.interior, -1.333333333333e-01, "C15 interior");
  ExpectPrinted(c15.filter, 1.333333333333e-01, "C15 pixel boundary");
  EXPECT_EQ(c14.interior + c14.filter, 0.0);
  EXPECT_EQ(c15.interior + c15.filter, 0.0);
  const C15bAnswer c15b = C15bTexturedPlane(1.0, 0.7, 5.0, 3.0, 0.2, 0.3);
  ExpectPrinted(c15b.value, 0.986, "C15b I");
  ExpectPrinted(c15b.d_s, -0.7, "C15b ds");
}

TEST(ClosedForms, FurnacesMatchTheTable) {
  struct Row {
    int bounces;
    double value, d_albedo;
  };
  const Row rows[] = {{0, 0.5, 0.0},
                      {1, 0.85, 0.5},
                      {2, 1.095, 1.2},
                      {5, 1.470585, 3.22125},
                      {-1, 5.0 / 3.0, 5.555555555556}};
  for (const Row& row : rows) {
    const C16Answer c16 = C16Furnace(0.5, 0.7, row.bounces);
    EXPECT_NEAR(c16.value, row.value, 1e-12) << row.bounces;
    EXPECT_NEAR(c16.d_albedo, row.d_albedo, 1e-12) << row.bounces;
  }
  const C17Answer c17 = C17SphereInSky(2.0, 0.7, 0.6, 3.0);
  ExpectPrinted(c17.area, 5.235987755983e-01, "C17 area");
  ExpectPrinted(c17.d_radius, -5.454153912482e-01, "C17 dR");
  ExpectPrinted(c17.d_distance, 1.090830782496e-01, "C17 dd");
  ExpectPrinted(C17CubeInSky(2.0, 0.7, 0.5, 3.0), -9.216e-01, "C17 cube");
  ExpectPrinted(C17OrthographicSphere(0.7, 0.6), -1.130973355292e+00, "C17 orthographic");
  const C18Answer c18 = C18IntegratingSphere(0.1, 0.8);
  ExpectPrinted(c18.value, 1.121997376282e+00, "C18 E");
  ExpectPrinted(c18.d_cap, 8.014266973443e+00, "C18 dc");
  ExpectPrinted(c18.d_albedo, 3.606420138050e+00, "C18 drho");
  EXPECT_EQ(c18.d_radius, 0.0);
}

TEST(ClosedForms, SkiesAndMaterialsMatchTheTable) {
  const C21Answer c21 = C21LinearSky(1.0, {0.3, -0.2, 0.5});
  ExpectPrinted(c21.value, 4.188790204786e+00, "C21 E");
  ExpectPrinted(c21.d_turn, -4.188790204786e-01, "C21 dt");
  const C22Answer c22 = C22HalfBrightSky(0.6);
  ExpectPrinted(c22.value, 2.867230479068e+00, "C22 E");
  ExpectPrinted(c22.d_theta, -8.869383231613e-01, "C22 dtheta");
  const C25Answer c25 = C25CollocatedLight(3.0, 0.6, 2.0, 0.5);
  ExpectPrinted(c25.value, 1.257044424265e-01, "C25 L");
  ExpectPrinted(c25.d_r, -1.257044424265e-01, "C25 dr");
  ExpectPrinted(c25.d_theta, -6.867264988202e-02, "C25 dtheta");
  ExpectPrinted(c25.d_h, -9.385431554711e-02, "C25 dh");
  const C20bAnswer c20b = C20bDielectric(1.5);
  ExpectPrinted(c20b.reflectance, 0.04, "C20b R");
  ExpectPrinted(c20b.d_reflectance, 0.128, "C20b dR");
  ExpectPrinted(c20b.slab, 9.230769230769e-01, "C20b slab");
  ExpectPrinted(c20b.d_slab, -2.366863905325e-01, "C20b dslab");
}

TEST(ClosedForms, WhiteGgxMatchesTheTable) {
  struct Row {
    double theta;
    bool correlated;
    double value, d_alpha;
  };
  const double quarter = 0.25 * std::numbers::pi;
  const Row rows[] = {{0.0, true, 8.773584157886e-01, -8.261023256234e-01},
                      {quarter, false, 8.444323394463e-01, -8.406584562563e-01},
                      {quarter, true, 8.453962137678e-01, -8.300498981922e-01}};
  for (const Row& row : rows) {
    const auto by_alpha = [&](double alpha) {
      return C20WhiteGgx(alpha, row.theta, row.correlated);
    };
    EXPECT_NEAR(by_alpha(0.3), row.value, 1e-11);
    // The table states 7e-6 for its derivatives, which are differences.
    EXPECT_NEAR(RiddersDerivative(by_alpha, 0.3, 0.05), row.d_alpha, 1e-6);
  }
}

}  // namespace
}  // namespace pathfit::tests::closed_forms_test
