#include "renderer/emitter/emitter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pathfit::renderer {
namespace {

template <class E>
auto& Intensity(E& emitter) {
  return *std::visit(
      [](auto& light) {
        if constexpr (requires { light.intensity; }) {
          return &light.intensity;
        } else {
          return &light.irradiance;
        }
      },
      emitter.light);
}

}  // namespace

Rgb& LightIntensity(Emitter& emitter) { return Intensity(emitter); }
const Rgb& LightIntensity(const Emitter& emitter) { return Intensity(emitter); }

Vec2 EnvironmentUv(const Vec3& d) {
  const double u = std::atan2(d.x, -d.z) * (0.5 * std::numbers::inv_pi);
  return {u < 0.0 ? u + 1.0 : u, std::acos(std::clamp(d.y, -1.0, 1.0)) * std::numbers::inv_pi};
}

Vec3 EnvironmentDirection(const Vec2& uv) {
  const double theta = uv.y * std::numbers::pi;
  const double phi = uv.x * 2.0 * std::numbers::pi;
  const double s = std::sin(theta);
  return {s * std::sin(phi), std::cos(theta), -s * std::cos(phi)};
}

TexelWeights EnvironmentTexelWeights(const EnvironmentEmitter& environment, const Vec2& uv) {
  const int w = environment.width;
  const int h = environment.height;
  if (w == 1 && h == 1) {
    return {{0, 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}};
  }
  const double x = uv.x * w - 0.5;
  const double y = std::clamp(uv.y * h - 0.5, 0.0, static_cast<double>(h - 1));
  const double floor_x = std::floor(x);
  const int x0 = (static_cast<int>(floor_x) + w) % w;
  const int x1 = (x0 + 1) % w;
  const int y0 = std::min(static_cast<int>(y), h - 1);
  const int y1 = std::min(y0 + 1, h - 1);
  const double fx = x - floor_x;
  const double fy = y - y0;
  return {{y0 * w + x0, y0 * w + x1, y1 * w + x0, y1 * w + x1},
          {(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy}};
}

Rgb EnvironmentRadianceAt(const EnvironmentEmitter& environment, const Vec2& uv) {
  if (environment.texels.size() == 1) {
    return environment.intensity * environment.texels[0];
  }
  const TexelWeights lookup = EnvironmentTexelWeights(environment, uv);
  Rgb sum;
  for (std::size_t i = 0; i < 4; ++i) {
    sum += environment.texels[static_cast<std::size_t>(lookup.texel[i])] * lookup.weight[i];
  }
  return environment.intensity * sum;
}

}  // namespace pathfit::renderer
