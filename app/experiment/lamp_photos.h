#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "optim/observation/lamp_list.h"

namespace pathfit::app {

/// Pictures of a folder by their numbers, 2 before 10, but for masks, normals and the like.
std::vector<std::filesystem::path> NumberedPhotos(const std::filesystem::path& folder);

/// One for each lamp, all in one folder: that of the photos or one in it. `lamp_source`: the file
/// of the lamps, or the folder of a ball that told them. Throws IoError if there are none, or more
/// than one such folder.
std::vector<std::filesystem::path> PhotosOfLamps(const std::filesystem::path& top,
                                                 const optim::LampList& list,
                                                 const std::filesystem::path& lamp_source);

/// What the names begin with and a star, if no other picture begins so; else empty.
std::string PatternOf(const std::vector<std::string>& names,
                      const std::vector<std::filesystem::path>& pictures);

/// A folder with photos: this one, or the only one in it that has some beside `other`.
std::filesystem::path PhotoFolder(const std::filesystem::path& top,
                                  const std::filesystem::path& other);

}  // namespace pathfit::app
