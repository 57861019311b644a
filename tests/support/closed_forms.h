#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "renderer/math/vector.h"
#include "tests/support/closed_forms_camera.h"
#include "tests/support/quadrature.h"

// Known answers for a point receiver: the cases C1-C11b, C18-C23, C26, C33 of path_space 6.3 (those
// seen through a filter are in closed_forms_camera.h, included above). Conventions: emitted
// radiance 1, receiver at the origin facing +z, `value` is the irradiance there (a diffuse receiver
// shows albedo / pi times it), `d_x` the derivative by the argument x. All lengths in one unit.
namespace pathfit::tests {

using renderer::Vec3;

/// C1: disk of this radius, parallel and coaxial, at this height.
struct C1Answer {
  double value, d_radius, d_height;
};
inline C1Answer C1CoaxialDisk(double radius, double height) {
  const double s = radius * radius + height * height;
  const double k = 2.0 * std::numbers::pi * radius * height / (s * s);
  return {std::numbers::pi * radius * radius / s, k * height, -k * radius};
}

/// C2: as C1, the disk's centre moved sideways by `offset`.
struct C2Answer {
  double value, d_offset, d_height, d_radius;
};
inline C2Answer C2OffsetDisk(double radius, double height, double offset) {
  const double r2 = radius * radius;
  const double h2 = height * height;
  const double a2 = offset * offset;
  const double s = h2 + a2 + r2;
  const double q = s * s - 4.0 * a2 * r2;
  const double k = 2.0 * std::numbers::pi / (q * std::sqrt(q));
  return {0.5 * std::numbers::pi * (1.0 - (h2 + a2 - r2) / std::sqrt(q)),
          -2.0 * k * offset * r2 * h2,
          -k * height * r2 * (h2 - a2 + r2),
          k * radius * h2 * s};
}

/// Irradiance per unit of x from the line [y0, y1] at this x of a parallel plane at this height:
/// what a border of the emitter brings per unit of its normal motion.
inline double BorderFlux(double x, double y0, double y1, double height) {
  const double a2 = x * x + height * height;
  const double a = std::sqrt(a2);
  const auto primitive = [&](double y) {
    return y / (2.0 * a2 * (a2 + y * y)) + std::atan(y / a) / (2.0 * a2 * a);
  };
  return height * height * (primitive(y1) - primitive(y0));
}

/// C3: parallel rectangle [x0, x1] x [y0, y1]. `d_scale`: growth about its own centre.
struct C3Answer {
  double value, d_x, d_y, d_height, d_scale;
};
inline C3Answer C3Rectangle(double x0, double x1, double y0, double y1, double height) {
  const auto corner = [&](double x, double y) {
    const double dx = std::hypot(x, height);
    const double dy = std::hypot(y, height);
    return 0.5 * (x / dx * std::atan(y / dx) + y / dy * std::atan(x / dy));
  };
  const double left = BorderFlux(x0, y0, y1, height);
  const double right = BorderFlux(x1, y0, y1, height);
  const double front = BorderFlux(y0, x0, x1, height);
  const double back = BorderFlux(y1, x0, x1, height);
  return {corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0),
          right - left,
          back - front,
          -(x1 * right - x0 * left + y1 * back - y0 * front) / height,
          0.5 * (x1 - x0) * (right + left) + 0.5 * (y1 - y0) * (back + front)};
}

/// Irradiance of a plane polygon wholly above the horizon.  [Lambert's contour]
inline double PolygonIrradiance(std::span<const Vec3> corners) {
  double sum = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3& b = corners[(i + 1) % corners.size()];
    const Vec3 normal = Cross(a, b);
    sum += std::atan2(Norm(normal), Dot(a, b)) * normal.z / Norm(normal);
  }
  return 0.5 * std::abs(sum);
}

/// Its derivative when the corners move, as an integral over the outline.  [path_space 1.7, B0]
inline double PolygonIrradianceDerivative(std::span<const Vec3> corners,
                                          std::span<const Vec3> velocities) {
  Vec3 centre;
  for (const Vec3& corner : corners) centre += corner / static_cast<double>(corners.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t j = (i + 1) % corners.size();
    const Vec3 edge = corners[j] - corners[i];
    Vec3 outward = Normalized(Cross(edge, corners[i]));  // of the plane through eye and edge
    if (Dot(outward, centre) > 0.0) outward = -outward;
    sum += Integrate(
        [&](double t) {
          const Vec3 x = corners[i] + edge * t;
          const Vec3 v = velocities[i] * (1.0 - t) + velocities[j] * t;
          const double r = Norm(x);
          // cos sin(phi) / r^2 dl, with sin(phi) dl = |edge x w| dt
          return x.z / r * Norm(Cross(edge, x / r)) / (r * r) * Dot(outward, v);
        },
        0.0,
        1.0);
  }
  return sum;
}

/// C4: rectangle of two sides around `centre`, turned by `theta` about its own y axis.
/// Derivatives by theta, the centre, a turn about the receiver's z, growth about its centre and
/// about the receiver (the two about the receiver are zero).
struct C4Answer {
  double value, d_theta, d_x, d_y, d_z, d_turn_about_receiver, d_scale, d_scale_about_receiver;
};
inline C4Answer C4RotatedRectangle(double size_x, double size_y, const Vec3& centre, double theta) {
  const Vec3 u{std::cos(theta), 0.0, -std::sin(theta)};
  const Vec3 v{0.0, 1.0, 0.0};
  std::array<Vec3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const double su = i == 0 || i == 3 ? -0.5 : 0.5;
    const double sv = i < 2 ? -0.5 : 0.5;
    corners[i] = centre + u * (su * size_x) + v * (sv * size_y);
  }
  const auto derivative = [&](auto velocity_at) {
    std::array<Vec3, 4> velocities;
    for (std::size_t i = 0; i < 4; ++i) velocities[i] = velocity_at(corners[i]);
    return PolygonIrradianceDerivative(corners, velocities);
  };
  return {PolygonIrradiance(corners),
          derivative([&](const Vec3& p) { return Cross(v, p - centre); }),
          derivative([](const Vec3&) {
            return Vec3{1, 0, 0};
          }),
          derivative([](const Vec3&) {
            return Vec3{0, 1, 0};
          }),
          derivative([](const Vec3&) {
            return Vec3{0, 0, 1};
          }),
          derivative([](const Vec3& p) {
            return Cross(Vec3{0, 0, 1}, p);
          }),
          derivative([&](const Vec3& p) { return p - centre; }),
          derivative([](const Vec3& p) { return p; })};
}

/// C6: wall x = distance, y in [y0, y1], z in [0, height].
struct C6Answer {
  double value, d_distance, d_height;
};
inline C6Answer C6Wall(double distance, double y0, double y1, double height) {
  const double d2 = distance * distance;
  const double top2 = d2 + height * height;
  const double top = std::sqrt(top2);
  const auto at = [&](double y) -> C6Answer {
    const double angle = std::atan(y / top);
    const double slant2 = top2 + y * y;
    return {
        0.5 * (std::atan(y / distance) - distance / top * angle),
        0.5 * (-y / (d2 + y * y) - height * height / (top2 * top) * angle + d2 / top2 * y / slant2),
        distance * height * (y / (2.0 * top2 * slant2) + angle / (2.0 * top2 * top))};
  };
  const C6Answer upper = at(y1);
  const C6Answer lower = at(y0);
  return {upper.value - lower.value,
          upper.d_distance - lower.d_distance,
          upper.d_height - lower.d_height};
}

/// C7: bright sphere wholly above the horizon.
struct SphereAnswer {
  double value, d_radius;
  Vec3 d_centre;
};
inline SphereAnswer C7Sphere(double radius, const Vec3& centre) {
  const double distance = Norm(centre);
  const double k = std::numbers::pi * radius * radius / (distance * distance * distance);
  const Vec3 up{0, 0, 1};
  return {k * centre.z,
          2.0 * k * centre.z / radius,
          (up - centre * (3.0 * centre.z / (distance * distance))) * k};
}

/// C8: rectangle |x| < half_x, |y| < half_y at `height`, seen from (receiver_x, receiver_y, 0) past
/// the black half plane x < edge_x at `edge_height`. `d_edge_x` and `d_edge_height` are direct
/// boundary only; `d_emitter_x` and `d_receiver_x` move one of the three, the others stay.
struct C8Answer {
  double value, d_edge_x, d_edge_height, d_receiver_x, d_emitter_x;
};
inline C8Answer C8HalfPlane(double half_x,
                            double half_y,
                            double height,
                            double edge_x,
                            double edge_height,
                            double receiver_x = 0.0,
                            double receiver_y = 0.0) {
  const double magnified = height / edge_height;
  const double right = half_x - receiver_x;
  const double left = -half_x - receiver_x;
  const double shadow = (edge_x - receiver_x) * magnified;
  const double x0 = std::clamp(shadow, left, right);
  const double y0 = -half_y - receiver_y;
  const double y1 = half_y - receiver_y;
  const bool cut = shadow > left && shadow < right;
  const double at_x0 = BorderFlux(x0, y0, y1, height);
  const double at_right = shadow < right ? BorderFlux(right, y0, y1, height) : 0.0;
  const double at_shadow = cut ? at_x0 : 0.0;
  const double at_left = shadow <= left ? at_x0 : 0.0;
  return {C3Rectangle(x0, right, y0, y1, height).value,
          -magnified * at_shadow,
          shadow / edge_height * at_shadow,
          magnified * at_shadow + at_left - at_right,
          at_right - at_left};
}

/// C10: black sphere before the rectangle |x|, |y| < half at `height`, its outline inside it.
inline SphereAnswer C10SphereOccluder(double half,
                                      double height,
                                      double radius,
                                      const Vec3& centre) {
  const SphereAnswer sphere = C7Sphere(radius, centre);
  return {C3Rectangle(-half, half, -half, half, height).value - sphere.value,
          -sphere.d_radius,
          -sphere.d_centre};
}

/// C11: the half plane x < strip_end at `height` shines past the black half plane x < edge_x at
/// `edge_height`, on the receiver (x, 0, 0) in its penumbra.
struct C11Answer {
  double value, d_edge_x, d_edge_height;
};
inline C11Answer C11Strip(
    double strip_end, double height, double edge_x, double edge_height, double x) {
  const double p = std::hypot(edge_x - x, edge_height);
  const double k = 0.5 * std::numbers::pi / (p * p * p) * edge_height;
  return {0.5 * std::numbers::pi *
              ((strip_end - x) / std::hypot(strip_end - x, height) - (edge_x - x) / p),
          -k * edge_height,
          k * (edge_x - x)};
}
/// C11 averaged over the floor with a filter of this kind around `centre`.
inline C11Answer C11StripFiltered(double strip_end,
                                  double height,
                                  double edge_x,
                                  double edge_height,
                                  const Filter1D& filter,
                                  double centre) {
  const auto average = [&](double C11Answer::*field) {
    const auto weighted = [&](double u) {
      return filter.Value(u) *
             (C11Strip(strip_end, height, edge_x, edge_height, centre + u).*field);
    };
    return Integrate(weighted, -filter.radius, 0.0) + Integrate(weighted, 0.0, filter.radius);
  };
  return {average(&C11Answer::value),
          average(&C11Answer::d_edge_x),
          average(&C11Answer::d_edge_height)};
}

/// C11b: C8 averaged over the floor [x0, x1] x [y0, y1], wholly in the penumbra.
struct C11bAnswer {
  double value, d_edge_x;
};
inline C11bAnswer C11bFootprint(double half_x,
                                double half_y,
                                double height,
                                double edge_x,
                                double edge_height,
                                double x0,
                                double x1,
                                double y0,
                                double y1) {
  const auto average = [&](double C8Answer::*field) {
    const auto at = [&](double x, double y) {
      return C8HalfPlane(half_x, half_y, height, edge_x, edge_height, x, y).*field;
    };
    return Integrate2D(at, x0, x1, y0, y1) / ((x1 - x0) * (y1 - y0));
  };
  return {average(&C8Answer::value), average(&C8Answer::d_edge_x)};
}

/// C18: inside of a sphere; a share `cap` of it emits 1 and is black, the rest has this albedo.
struct C18Answer {
  double value, d_cap, d_albedo, d_radius;
};
inline C18Answer C18IntegratingSphere(double cap, double albedo) {
  const double gain = 1.0 / (1.0 - albedo * (1.0 - cap));
  const double k = std::numbers::pi * gain * gain;
  return {std::numbers::pi * cap * gain, k * (1.0 - albedo), k * cap * (1.0 - cap), 0.0};
}

/// C19: light of an emitter reflected once by a wall, past an occluder. Emitter [x0, x1] x
/// |y| < half_y at `height`, facing down; wall x = distance, |y| < wall_half_y, z in [0, wall_top],
/// diffuse; black occluder x = occluder_x, z < edge_z. `d_edge_z` is indirect boundary only.
struct C19Scene {
  double x0 = 0.5, x1 = 0.9, half_y = 0.3, height = 1.5;
  double distance = 1.0, wall_half_y = 0.4, wall_top = 1.0, albedo = 0.6;
  double occluder_x = 0.4, edge_z = 0.2;
  double receiver_y = 0.0;
};
struct C19Answer {
  double value, d_edge_z, direct;
};
inline C19Answer C19Indirect(const C19Scene& s) {
  const auto wall_radiance = [&](double y, double z) {
    // The emitter in the frame of the wall point: normal -x becomes +z.
    const auto seen = [&](double x, double ey) {
      return Vec3{ey - y, s.height - z, s.distance - x};
    };
    const std::array<Vec3, 4> corners{
        seen(s.x0, -s.half_y), seen(s.x1, -s.half_y), seen(s.x1, s.half_y), seen(s.x0, s.half_y)};
    return s.albedo / std::numbers::pi * PolygonIrradiance(corners);
  };
  const auto kernel = [&](double y, double z) {
    const double across = y - s.receiver_y;
    const double r2 = s.distance * s.distance + across * across + z * z;
    return wall_radiance(y, z) * z * s.distance / (r2 * r2);
  };
  const double lowest = s.edge_z * s.distance / s.occluder_x;
  const double border =
      Integrate([&](double y) { return kernel(y, lowest); }, -s.wall_half_y, s.wall_half_y);
  return {
      Integrate2D(kernel, -s.wall_half_y, s.wall_half_y, lowest, s.wall_top),
      -s.distance / s.occluder_x * border,
      C3Rectangle(s.x0, s.x1, -s.half_y - s.receiver_y, s.half_y - s.receiver_y, s.height).value};
}

/// C21: sky of radiance base + gradient . w, turned by t about x, at t = 0.
struct C21Answer {
  double value, d_turn;
};
inline C21Answer C21LinearSky(double base, const Vec3& gradient) {
  return {std::numbers::pi * base + 2.0 * std::numbers::pi / 3.0 * gradient.z,
          2.0 * std::numbers::pi / 3.0 * gradient.y};
}

/// C22: sky that is 1 on the half around a direction tilted by theta from the normal, else 0.
struct C22Answer {
  double value, d_theta;
};
inline C22Answer C22HalfBrightSky(double theta) {
  return {0.5 * std::numbers::pi * (1.0 + std::cos(theta)),
          -0.5 * std::numbers::pi * std::sin(theta)};
}

/// C23: black sphere under a sky of radiance 1.
inline SphereAnswer C23SphereUnderSky(double radius, const Vec3& centre) {
  const SphereAnswer sphere = C7Sphere(radius, centre);
  return {std::numbers::pi - sphere.value, -sphere.d_radius, -sphere.d_centre};
}

/// C26: rectangle |x - s| < half_x, |y| < half_y at `height` that carries its radiance 1 + (x -
/// s)/2 along when it moves by s.
struct C26Answer {
  double value, d_s;
};
inline C26Answer C26TexturedEmitter(double half_x, double half_y, double height, double s) {
  const double x0 = s - half_x;
  const double x1 = s + half_x;
  const auto flux = [&](double x) { return BorderFlux(x, -half_y, half_y, height); };
  const double plain = C3Rectangle(x0, x1, -half_y, half_y, height).value;
  const double moment = Integrate([&](double x) { return x * flux(x); }, x0, x1);
  return {plain + 0.5 * (moment - s * plain),
          (1.0 + 0.5 * half_x) * flux(x1) - (1.0 - 0.5 * half_x) * flux(x0) - 0.5 * plain};
}

/// C33: regular polygon inscribed in the disk of C1: the answer for a mesh of it.
struct C33Answer {
  double value, d_radius;
};
inline C33Answer C33RegularPolygon(int sides, double radius, double height) {
  const double cosine = std::cos(std::numbers::pi / sides);
  const double sine = std::sin(std::numbers::pi / sides);
  const double in = radius * cosine;  // to the middle of a side
  const double half = radius * sine;  // half a side
  const double d = std::hypot(in, height);
  const double d_in = in * cosine / d;  // of d by the radius
  const double angle = std::atan(half / d);
  const double d_angle = (sine * d - half * d_in) / (d * d + half * half);
  return {sides * angle * in / d,
          sides * (d_angle * in / d + angle * (cosine * d - in * d_in) / (d * d))};
}

}  // namespace pathfit::tests
