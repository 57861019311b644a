#include "renderer/io/texture_file.h"

#include <string>

#include "renderer/core/error.h"
#include "renderer/image/color.h"
#include "renderer/io/image_file.h"

namespace pathfit::renderer {

Texture ReadTexture(const std::filesystem::path& path, TextureRole role) {
  const DecodedImage decoded = ReadImageFile(path, false);
  Texture texture;
  texture.name = path.filename().string();
  texture.width = decoded.image.width;
  texture.height = decoded.image.height;
  texture.scalar = role == TextureRole::kData;
  texture.texels.clear();
  texture.texels.reserve(decoded.image.data.size() / 3);
  for (int y = 0; y < texture.height; ++y) {
    for (int x = 0; x < texture.width; ++x) {
      Rgb texel = decoded.image.ColorAt(x, y);
      if (texture.scalar) texel = Rgb::Constant(texel.r);
      for (int c = 0; c < 3; ++c) {
        if (texel[c] < 0.0) {
          throw IoError(path.string() + ": pixel (" + std::to_string(x) + ", " + std::to_string(y) +
                        ") is negative, which a texture cannot be");
        }
        if (role == TextureRole::kColor && !decoded.linear) texel[c] = LinearFromSrgb(texel[c]);
      }
      texture.texels.push_back(texel);
    }
  }
  return texture;
}

}  // namespace pathfit::renderer
