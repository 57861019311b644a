#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "renderer/math/rgb.h"
#include "renderer/math/vector.h"

namespace pathfit::optim {

/// A far lamp that shone in one photo, in the frame of photometric stereo: x right, y up, z from
/// the object to the viewer.
struct PhotoLamp {
  std::string photo;                      ///< as the file names it; empty: by its place in the list
  renderer::Vec3 towards;                 ///< unit, from the object to the lamp
  std::optional<renderer::Rgb> strength;  ///< relative
};

struct LampList {
  std::vector<PhotoLamp> lamps;
  bool reversed = false;       ///< the file has all vectors the other way; `towards` has not
  std::size_t num_unused = 0;  ///< columns of the file that mean nothing here
};

/// Reads the lamps of photometric stereo from text, one of
///   an LP file: their number, then lines "photo x y z";
///   rows "x y z", "x y z strength" or "x y z red green blue", each perhaps after the photo's name
///   or number (0 or 1 onwards); three rows of x, y and z with a column for each lamp.
/// Columns are separated by blanks, commas or semicolons; what follows # is not read. The lengths
/// of vectors do not matter. Vectors that all have z < 0 say where the light goes. Throws IoError
/// with file:line.
LampList ReadLampList(const std::filesystem::path& path);

/// Gives the lamps the strengths of another file, a row "strength" or "red green blue" for each.
/// Throws IoError with file:line, also when their numbers differ.
void ReadLampStrengths(const std::filesystem::path& path, LampList& list);

}  // namespace pathfit::optim
