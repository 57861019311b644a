#include "renderer/emitter/emitter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/math/warp.h"

namespace pathfit::renderer {
namespace {

// Distance from the poles' axis, of a unit direction, below which slopes along u fade out.
constexpr double kPoleDistance = 1e-6;

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

// The square of texel centres around a point of the map, and where the point lies in it.
struct TexelSquare {
  std::array<int, 4> texel{};  // (x0, y0), (x1, y0), (x0, y1), (x1, y1)
  double fx = 0.0, fy = 0.0;
  bool beyond_rows = false;  // between a pole and the outermost texel centres: constant along v
};
TexelSquare SquareAround(const EnvironmentEmitter& environment, const Vec2& uv) {
  const int w = environment.width;
  const int h = environment.height;
  const double x = uv.x * w - 0.5;
  const double row = uv.y * h - 0.5;
  const double y = std::clamp(row, 0.0, static_cast<double>(h - 1));
  const double floor_x = std::floor(x);
  // The map's own coordinates are at most half a texel outside: no division is needed.
  const int column = static_cast<int>(floor_x);
  const int x0 = column < 0 ? column + w : (column < w ? column : column - w);
  const int x1 = x0 + 1 < w ? x0 + 1 : 0;
  const int y0 = std::min(static_cast<int>(y), h - 1);
  const int y1 = std::min(y0 + 1, h - 1);
  return {{y0 * w + x0, y0 * w + x1, y1 * w + x0, y1 * w + x1}, x - floor_x, y - y0, row != y};
}

}  // namespace

std::optional<Vec3> AxisOfSymmetry(const Emitter& emitter) {
  if (const auto* directional = std::get_if<DirectionalEmitter>(&emitter.light)) {
    return directional->direction;
  }
  if (const auto* spot = std::get_if<SpotEmitter>(&emitter.light)) {
    return spot->frame_from_light * Vec3{0.0, 0.0, -1.0};
  }
  return std::nullopt;
}

Rgb& LightIntensity(Emitter& emitter) { return Intensity(emitter); }
const Rgb& LightIntensity(const Emitter& emitter) { return Intensity(emitter); }

const char* LightWord(const Emitter& emitter) {
  constexpr std::array kWords = {
      "environment", "point", "directional", "spot", "projector", "area"};
  return kWords.at(emitter.light.index());
}

int LightTexture(const Emitter& emitter) {
  return std::visit(
      [](const auto& light) {
        if constexpr (requires { light.texture; }) {
          return light.texture;
        } else {
          return -1;
        }
      },
      emitter.light);
}

Vec2 EnvironmentUv(const Vec3& d) {
  return {TurnOf(d.x, -d.z), PolarShare(std::clamp(d.y, -1.0, 1.0))};
}

Vec3 EnvironmentDirection(const Vec2& uv) {
  const double theta = uv.y * std::numbers::pi;
  const double phi = uv.x * 2.0 * std::numbers::pi;
  const double s = std::sin(theta);
  return {s * std::sin(phi), std::cos(theta), -s * std::cos(phi)};
}

TexelWeights EnvironmentTexelWeights(const EnvironmentEmitter& environment, const Vec2& uv) {
  if (environment.width == 1 && environment.height == 1) {
    return {{0, 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}};
  }
  const auto [texel, fx, fy, beyond_rows] = SquareAround(environment, uv);
  return {texel, {(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy}};
}

Rgb EnvironmentRadianceAt(const EnvironmentEmitter& environment, const Vec2& uv) {
  if (environment.texels.size() == 1) return environment.intensity * environment.texels[0];
  const auto [texel, fx, fy, beyond_rows] = SquareAround(environment, uv);
  const Rgb* const texels = environment.texels.data();
  const Rgb sum = texels[texel[0]] * ((1.0 - fx) * (1.0 - fy)) +
                  texels[texel[1]] * (fx * (1.0 - fy)) + texels[texel[2]] * ((1.0 - fx) * fy) +
                  texels[texel[3]] * (fx * fy);
  return environment.intensity * sum;
}

std::array<Vec3, 3> EnvironmentGradient(const EnvironmentEmitter& environment, const Vec3& d) {
  if (environment.width == 1 && environment.height == 1) return {};
  const TexelSquare square = SquareAround(environment, EnvironmentUv(d));
  const auto texel = [&](std::size_t i) {
    return environment.texels[static_cast<std::size_t>(square.texel[i])];
  };
  const Rgb by_x = (texel(1) - texel(0)) * (1.0 - square.fy) + (texel(3) - texel(2)) * square.fy;
  const Rgb by_y = (texel(2) - texel(0)) * (1.0 - square.fx) + (texel(3) - texel(1)) * square.fx;
  const Rgb by_phi =
      environment.intensity * by_x * (0.5 * environment.width * std::numbers::inv_pi);
  const Rgb by_theta = square.beyond_rows ? Rgb{}
                                          : environment.intensity * by_y *
                                                (environment.height * std::numbers::inv_pi);
  // phi = atan2(x, -z) and theta = acos(y) by the direction; both slopes are tangential.
  const double rho = std::max(std::hypot(d.x, d.z), kPoleDistance);
  const Vec3 phi_by_d = Vec3{-d.z, 0.0, d.x} / (rho * rho);
  const Vec3 theta_by_d{d.x * d.y / rho, -rho, d.z * d.y / rho};
  std::array<Vec3, 3> gradient;
  for (int c = 0; c < 3; ++c) {
    gradient[static_cast<std::size_t>(c)] = phi_by_d * by_phi[c] + theta_by_d * by_theta[c];
  }
  return gradient;
}

}  // namespace pathfit::renderer
