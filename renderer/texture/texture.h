#pragma once

#include <array>
#include <string>

#include "renderer/core/shared_vector.h"
#include "renderer/math/rgb.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// What a UV outside the unit square sees.
enum class TextureWrap {
  kRepeat,  ///< the picture again and again; at its border, opposite texels are neighbours
  kClamp    ///< the nearest point of the border
};

/// Picture on the unit square, looked up by UV and interpolated bilinearly. u runs right, v up:
/// (0, 0) is the bottom-left corner of the picture, (1, 1) the top-right, as in OBJ files. Texel x
/// of row y, counted from the top, has its centre at ((x + 0.5) / width, 1 - (y + 0.5) / height).
///
/// Values are linear Rec.709 or plain numbers: whoever loads a file decodes sRGB for colours and
/// takes data (roughness, metallic) as they are. Their range is that of what the texture is used
/// for, which ValidateScene checks. The default is one white texel.
///
/// Copies share the texels until one of them is changed.
struct Texture {
  std::string name;                                 ///< for messages, and its parameters' names
  int width = 1;                                    ///< texels, > 0
  int height = 1;                                   ///< texels, > 0
  SharedVector<Rgb> texels = {Rgb{1.0, 1.0, 1.0}};  ///< texels[y * width + x], row 0 on top
  TextureWrap wrap = TextureWrap::kRepeat;
  /// All three channels of a texel are equal, and one parameter: roughness, metallic.
  bool scalar = false;
};

/// A lookup and its derivatives: value = sum_k weight[k] * texels[texel[k]].
struct TextureLookup {
  std::array<int, 4> texel{};      ///< into Texture::texels; the same one may be there repeatedly
  std::array<double, 4> weight{};  ///< derivative of the value by the texel, >= 0; their sum is 1
  Rgb value;
  /// Derivatives of the value by u and v, per unit square (not per texel). They jump where u or v
  /// pass a texel's centre; there they are those towards larger UVs. Zero beyond the outermost
  /// centres of a clamped texture.
  Rgb du, dv;
};
/// `uv` may be any; a coordinate that is not finite counts as that of the bottom-left texel's
/// centre, with slope zero. The number of texels must be width * height.
TextureLookup LookUpTexture(const Texture& texture, const Vec2& uv);
/// LookUpTexture's value.
Rgb TextureValue(const Texture& texture, const Vec2& uv);

}  // namespace pathfit::renderer
