#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/renderer/theory/evolving_surface.h"
#include "tests/renderer/theory/geometry_term.h"
#include "tests/renderer/theory/surface_integral.h"
#include "tests/support/closed_forms.h"

// The closed forms of path_space 6.3 that the interior term alone must give: int (G' / G + J' / J)
// G dA over the emitter for a point receiver, int (W' / W + J' / J + H' / H) W H dA for a pixel.
// Each surface is a motion with parameter pi, taken at pi = 0; no border, no boundary
// (path_space 1.3, 1.4).
namespace pathfit::tests::interior_answers_test {
namespace {

using renderer::LocalPoint;
using renderer::LocalVariable;
using renderer::OrientedPoint;
using renderer::PartialOf;
using renderer::Pinhole;
using renderer::PinholeImage;
using renderer::PinholeMotion;
using renderer::Vector3;

constexpr double kPi = std::numbers::pi;
constexpr double kQuadrature = 1e-10;

template <class Surface>
OrientedPoint<double> PointOn(const Surface& surface, const LocalPoint<double>& at) {
  return {surface(at), UnitNormal(surface, at)};
}
/// Rate of change at fixed label.
template <class Surface>
OrientedPoint<double> RateOn(const Surface& surface, const LocalPoint<double>& at) {
  const auto normal = [&](const auto& here) { return UnitNormal(surface, here); };
  return {LocalVelocity(surface, at), PartialOf(normal, at, LocalVariable::kPi)};
}

struct Measured {
  double value, derivative;
};
/// Irradiance at the origin facing +z and its derivative by pi, at pi = 0.
template <class Surface>
Measured Irradiance(const Surface& surface, const LocalBox& box) {
  const OrientedPoint<double> receiver{{0, 0, 0}, {0, 0, 1}};
  const auto g = [&](const LocalPoint<double>& at) {
    return GeometryTerm(receiver, PointOn(surface, at));
  };
  const auto log_rate = [&](const LocalPoint<double>& at) {
    return LogGeometryTermDerivative(
               receiver, PointOn(surface, at), OrientedPoint<double>(), RateOn(surface, at)) +
           VelocityDivergence(surface, at);
  };
  return {SurfaceIntegral(surface, box, 0.0, g),
          SurfaceIntegral(surface, box, 0.0, [&](const LocalPoint<double>& at) {
            return g(at) * log_rate(at);
          })};
}
void ExpectMeasured(const Measured& measured, double value, double derivative, const char* what) {
  EXPECT_NEAR(measured.value, value, kQuadrature * std::max(1.0, std::abs(value))) << what;
  EXPECT_NEAR(measured.derivative, derivative, kQuadrature * std::max(1.0, std::abs(derivative)))
      << what;
}

/// Moves every point of a surface at rest with a velocity linear in place: v = drift + spin x (x -
/// centre) + scale (x - centre).
struct LinearMotion {
  Vec3 drift, spin;
  double scale = 0.0;
  Vec3 centre;
  template <class T>
  Vector3<T> operator()(const Vector3<T>& x, const T& pi) const {
    const auto lifted = [](const Vec3& a) { return Vector3<T>{T(a.x), T(a.y), T(a.z)}; };
    const Vector3<T> arm = x - lifted(centre);
    return x + (lifted(drift) + Cross(lifted(spin), arm) + arm * T(scale)) * pi;
  }
};

TEST(InteriorAnswers, C1AndC2Disks) {
  const double radius = 0.5;
  const double height = 2.0;
  const LocalBox box{0.0, radius, 0.0, 2.0 * kPi};
  for (const double offset : {0.0, 0.7}) {
    const auto moving = [&](const LinearMotion& motion) {
      return Irradiance(
          [&, motion](const auto& at) {
            using std::cos;
            using std::sin;
            using T = std::decay_t<decltype(at.pi)>;
            const Vector3<T> x{at.xi1 * cos(at.xi2) + offset, at.xi1 * sin(at.xi2), T(height)};
            return motion(x, at.pi);
          },
          box);
    };
    const C2Answer c2 = C2OffsetDisk(radius, height, offset);
    ExpectMeasured(moving({{1, 0, 0}, {}, 0.0, {}}), c2.value, c2.d_offset, "da");
    ExpectMeasured(moving({{0, 0, 1}, {}, 0.0, {}}), c2.value, c2.d_height, "dh");
    const LinearMotion growth{{}, {}, 1.0 / radius, {offset, 0, height}};
    ExpectMeasured(moving(growth), c2.value, c2.d_radius, "dR");
  }
  const C1Answer c1 = C1CoaxialDisk(radius, height);
  const C2Answer c2 = C2OffsetDisk(radius, height, 0.0);
  EXPECT_NEAR(c1.value, c2.value, 1e-15);
  EXPECT_NEAR(c1.d_radius, c2.d_radius, 1e-15);
  EXPECT_NEAR(c1.d_height, c2.d_height, 1e-15);
}

TEST(InteriorAnswers, C3Rectangle) {
  const C3Answer c3 = C3Rectangle(-0.3, 0.7, -0.4, 0.6, 1.5);
  const auto moving = [](const LinearMotion& motion) {
    return Irradiance(
        [motion](const auto& at) {
          using T = std::decay_t<decltype(at.pi)>;
          return motion(Vector3<T>{at.xi1, at.xi2, T(1.5)}, at.pi);
        },
        {-0.3, 0.7, -0.4, 0.6});
  };
  ExpectMeasured(moving({{1, 0, 0}, {}, 0.0, {}}), c3.value, c3.d_x, "dx");
  ExpectMeasured(moving({{0, 1, 0}, {}, 0.0, {}}), c3.value, c3.d_y, "dy");
  ExpectMeasured(moving({{0, 0, 1}, {}, 0.0, {}}), c3.value, c3.d_height, "dh");
  ExpectMeasured(moving({{}, {}, 1.0, {0.2, 0.1, 1.5}}), c3.value, c3.d_scale, "dscale");
}

TEST(InteriorAnswers, C4RotatedRectangle) {
  const double theta = 0.3;
  const Vec3 centre{0.2, 0.1, 1.5};
  const C4Answer c4 = C4RotatedRectangle(1.0, 0.6, centre, theta);
  const auto moving = [&](const LinearMotion& motion) {
    return Irradiance(
        [&, motion](const auto& at) {
          using T = std::decay_t<decltype(at.pi)>;
          const Vector3<T> x{centre.x + at.xi1 * std::cos(theta),
                             centre.y + at.xi2,
                             centre.z - at.xi1 * std::sin(theta)};
          return motion(x, at.pi);
        },
        {-0.5, 0.5, -0.3, 0.3});
  };
  ExpectMeasured(moving({{}, {0, 1, 0}, 0.0, centre}), c4.value, c4.d_theta, "dtheta");
  ExpectMeasured(moving({{1, 0, 0}, {}, 0.0, {}}), c4.value, c4.d_x, "dx");
  ExpectMeasured(moving({{0, 1, 0}, {}, 0.0, {}}), c4.value, c4.d_y, "dy");
  ExpectMeasured(moving({{0, 0, 1}, {}, 0.0, {}}), c4.value, c4.d_z, "dz");
  ExpectMeasured(moving({{}, {0, 0, 1}, 0.0, {}}), c4.value, 0.0, "turn about receiver");
  ExpectMeasured(moving({{}, {}, 1.0, centre}), c4.value, c4.d_scale, "scale about centre");
  ExpectMeasured(moving({{}, {}, 1.0, {}}), c4.value, 0.0, "scale about receiver");
}

TEST(InteriorAnswers, C6Wall) {
  const double height = 1.1;
  const C6Answer c6 = C6Wall(0.8, -0.5, 0.9, height);
  const auto moving = [&](double away, double growth) {
    return Irradiance(
        [=](const auto& at) {
          using T = std::decay_t<decltype(at.pi)>;
          return Vector3<T>{0.8 + away * at.pi, at.xi1, at.xi2 * (1.0 + growth / height * at.pi)};
        },
        {-0.5, 0.9, 0.0, height});
  };
  ExpectMeasured(moving(1.0, 0.0), c6.value, c6.d_distance, "dd");
  ExpectMeasured(moving(0.0, 1.0), c6.value, c6.d_height, "dH");
}

TEST(InteriorAnswers, C7SphereNeedsNoBoundaryAtItsOutline) {
  const double radius = 0.3;
  const Vec3 centre{0.4, -0.3, 1.5};
  const SphereAnswer c7 = C7Sphere(radius, centre);
  // Longitude and cosine about the direction to the receiver: the visible cap ends at R / |c|.
  const Vec3 pole = -Normalized(centre);
  const Vec3 side = Normalized(Cross(pole, Vec3{1, 0, 0}));
  const Vec3 other = Cross(pole, side);
  const LocalBox cap{0.0, 2.0 * kPi, radius / Norm(centre), 1.0};
  const auto moving = [&](const LinearMotion& motion) {
    return Irradiance(
        [&, motion](const auto& at) {
          using std::cos;
          using std::sin;
          using std::sqrt;
          using T = std::decay_t<decltype(at.pi)>;
          const auto lifted = [](const Vec3& a) { return Vector3<T>{T(a.x), T(a.y), T(a.z)}; };
          const T ring = radius * sqrt(1.0 - at.xi2 * at.xi2);
          const Vector3<T> x = lifted(centre) + lifted(side) * (ring * cos(at.xi1)) +
                               lifted(other) * (ring * sin(at.xi1)) +
                               lifted(pole) * (radius * at.xi2);
          return motion(x, at.pi);
        },
        cap);
  };
  ExpectMeasured(moving({{}, {}, 1.0 / radius, centre}), c7.value, c7.d_radius, "dR");
  ExpectMeasured(moving({{1, 0, 0}, {}, 0.0, {}}), c7.value, c7.d_centre.x, "dx");
  ExpectMeasured(moving({{0, 1, 0}, {}, 0.0, {}}), c7.value, c7.d_centre.y, "dy");
  ExpectMeasured(moving({{0, 0, 1}, {}, 0.0, {}}), c7.value, c7.d_centre.z, "dz");
}

constexpr PinholeMotion<double> kStill{};
Pinhole<double> CameraAtOrigin(double focal) {
  return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, focal};
}
/// The two interior parts of a pixel with filter H(u) H(v) over the material in `box`: that of W
/// and J, and that of the filter. H is null for a box filter that no border of the surface meets.
template <class Surface>
MaterialSplit PixelInterior(const Surface& surface,
                            const LocalBox& box,
                            double focal,
                            const Filter1D* filter) {
  const Pinhole<double> camera = CameraAtOrigin(focal);
  const auto weighted = [&](const LocalPoint<double>& at, bool of_filter) {
    const OrientedPoint<double> x = PointOn(surface, at);
    const OrientedPoint<double> rate = RateOn(surface, at);
    const double w = PinholeWeight(camera, x);
    const PinholeImage<double> u = ImageOf(camera, x.x);
    const double h = filter ? filter->Value(u.u) * filter->Value(u.v) : 1.0;
    if (!of_filter) {
      return w * h *
             (LogPinholeWeightDerivative(camera, kStill, x, rate) +
              VelocityDivergence(surface, at));
    }
    const PinholeImage<double> gradient{filter->Derivative(u.u) * filter->Value(u.v),
                                        filter->Value(u.u) * filter->Derivative(u.v)};
    return w * h * FilterLogDerivative(h, gradient, ImageVelocity(camera, kStill, x.x, rate.x));
  };
  const auto part = [&](bool of_filter) {
    return SurfaceIntegral(
        surface, box, 0.0, [&](const auto& at) { return weighted(at, of_filter); });
  };
  return {part(false), filter ? part(true) : 0.0};
}

TEST(InteriorAnswers, C13TiltedQuadInsideABoxPixel) {
  const double tilt = 0.4;
  const C13Answer c13 = C13TiltedQuad(5.0, 0.2, 0.3, 3.0, tilt);
  const auto moving = [&](const LinearMotion& motion) {
    const auto surface = [&, motion](const auto& at) {
      using T = std::decay_t<decltype(at.pi)>;
      const Vector3<T> x{at.xi1, at.xi2 * std::cos(tilt), 3.0 + at.xi2 * std::sin(tilt)};
      return motion(x, at.pi);
    };
    return PixelInterior(surface, {-0.1, 0.1, -0.15, 0.15}, 5.0, nullptr).interior;
  };
  EXPECT_NEAR(moving({{0, 0, 1}, {}, 0.0, {}}), c13.d_z, kQuadrature);
  EXPECT_NEAR(moving({{}, {1, 0, 0}, 0.0, {0, 0, 3}}), c13.d_tilt, kQuadrature);
}

TEST(InteriorAnswers, C13bQuadUnderAGaussian) {
  const Filter1D gauss{Filter1D::Kind::kGauss, 1.5, 0.5};
  const C13bAnswer c13b = C13bFilteredQuad(gauss, 5.0, 0.2, 0.3, 0.12, -0.07, 3.0);
  const auto moving = [&](const Vec3& drift) {
    const auto surface = [drift](const auto& at) {
      using T = std::decay_t<decltype(at.pi)>;
      const Vector3<T> x{at.xi1 + 0.12, at.xi2 - 0.07, T(3.0)};
      return LinearMotion{drift, {}, 0.0, {}}(x, at.pi);
    };
    const MaterialSplit split = PixelInterior(surface, {-0.1, 0.1, -0.15, 0.15}, 5.0, &gauss);
    return split.interior + split.filter;
  };
  EXPECT_NEAR(moving({1, 0, 0}), c13b.d_cx, kQuadrature);
  EXPECT_NEAR(moving({0, 1, 0}), c13b.d_cy, kQuadrature);
  EXPECT_NEAR(moving({0, 0, 1}), c13b.d_z, kQuadrature);
}

TEST(InteriorAnswers, C14UniformPlaneUnderATent) {
  const double z = 3.0;
  const double focal = 5.0;
  const Filter1D tent{Filter1D::Kind::kTent, 1.0, 0.0};
  const auto plane = [&](const auto& at) {
    using T = std::decay_t<decltype(at.pi)>;
    return Vector3<T>{at.xi1, at.xi2, z + at.pi};
  };
  // One quarter at a time: the tent has kinks on the axes.
  const double reach = z / focal;
  MaterialSplit sum{0.0, 0.0};
  for (const double x : {-reach, 0.0}) {
    for (const double y : {-reach, 0.0}) {
      const MaterialSplit part = PixelInterior(plane, {x, x + reach, y, y + reach}, focal, &tent);
      sum.interior += part.interior;
      sum.filter += part.filter;
    }
  }
  const MaterialSplit c14 = C14MovingPlane(z);
  EXPECT_NEAR(sum.interior, c14.interior, kQuadrature);
  EXPECT_NEAR(sum.filter, c14.filter, kQuadrature);
}

/// (P): - int over the pixel's outline |u| = |v| = 0.5 of n . u', for a plane given by its depth at
/// pixel (u, v) and its velocity.
template <class Depth>
double PixelBoundary(double focal, const Depth& depth, const Vec3& velocity) {
  const Pinhole<double> camera = CameraAtOrigin(focal);
  const auto image_velocity = [&](double u, double v) {
    const double z = depth(u, v);
    return ImageVelocity(camera, kStill, Vec3{u * z / focal, v * z / focal, z}, velocity);
  };
  const auto outward = [&](double s) {
    return image_velocity(0.5, s).u - image_velocity(-0.5, s).u + image_velocity(s, 0.5).v -
           image_velocity(s, -0.5).v;
  };
  return -Integrate(outward, -0.5, 0.5);
}

TEST(InteriorAnswers, C14AndC15UnderABox) {
  const double focal = 5.0;
  const double z0 = 3.0;
  const double slope = 0.4;
  const MaterialSplit c14 = C14MovingPlane(z0);
  const MaterialSplit c15 = C15TiltedPlane(z0, slope);
  EXPECT_NEAR(
      PixelBoundary(focal, [&](double, double) { return z0; }, {0, 0, 1}), c14.filter, kQuadrature);
  const auto depth = [&](double u, double) { return z0 / (1.0 - slope * u / focal); };
  EXPECT_NEAR(PixelBoundary(focal, depth, {1, 0, 0}), c15.filter, kQuadrature);
  // Interior: labels are the pixel coordinates at pi = 0, so that the box holds the whole pixel.
  const auto interior = [&](double k, const Vec3& drift) {
    const auto surface = [=](const auto& at) {
      using T = std::decay_t<decltype(at.pi)>;
      const T z = z0 / (1.0 - k * at.xi1 / focal);
      const Vector3<T> x{at.xi1 * z / focal, at.xi2 * z / focal, z};
      return LinearMotion{drift, {}, 0.0, {}}(x, at.pi);
    };
    return PixelInterior(surface, {-0.5, 0.5, -0.5, 0.5}, focal, nullptr).interior;
  };
  EXPECT_NEAR(interior(0.0, {0, 0, 1}), c14.interior, kQuadrature);
  EXPECT_NEAR(interior(slope, {1, 0, 0}), c15.interior, kQuadrature);
}

}  // namespace
}  // namespace pathfit::tests::interior_answers_test
