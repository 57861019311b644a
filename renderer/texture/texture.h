#pragma once

#include <array>
#include <string>

#include "renderer/core/shared_vector.h"
#include "renderer/math/rgb.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

enum class TextureWrap { kRepeat, kClamp };

/// Picture looked up by UV, bilinear; texel centres at half-integers. u runs right, v up: (0, 0) is
/// the bottom-left corner, as in OBJ files. Values are linear: whoever loads a file decodes sRGB
/// for colours and takes data (roughness, metallic) as they are. A `scalar` texture has equal
/// channels.
struct Texture {
  std::string name;
  int width = 1;
  int height = 1;
  SharedVector<Rgb> texels = {Rgb{1.0, 1.0, 1.0}};  ///< row 0 on top
  TextureWrap wrap = TextureWrap::kRepeat;
  bool scalar = false;
};

/// A lookup and its derivatives: the value is sum weight * texel; du and dv are its slopes by the
/// UV. Slopes jump where u or v pass a texel's centre; there they are those towards larger UVs.
/// Clamped UVs beyond the outermost centres have slope zero. A UV that is not finite has the value
/// of the corner texel and no slope.
struct TextureLookup {
  std::array<int, 4> texel{};
  std::array<double, 4> weight{};
  Rgb value, du, dv;
};
TextureLookup LookUpTexture(const Texture& texture, const Vec2& uv);
/// The value alone.
Rgb TextureValue(const Texture& texture, const Vec2& uv);

}  // namespace pathfit::renderer
