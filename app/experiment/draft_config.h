#pragma once

#include <filesystem>
#include <string>

#include "app/experiment/input_search.h"

namespace pathfit::app {

/// A short commented config that fits shape, light and colours to what was found, with every
/// setting at its default. `path` is where it will be written: its folder is what paths are
/// relative to. `mesh` is the start mesh; empty: carved from the masks, or without masks a sphere
/// where the cameras look. Throws SceneError when there is neither and the cameras look at no
/// common point.
std::string DraftConfig(const FoundInput& input,
                        const std::filesystem::path& path,
                        const std::string& name,
                        const std::filesystem::path& mesh);

/// Whether something tells how the light moves; else it is taken to stand still.
bool IsLightKnown(const FoundInput& input);

/// What stands in the draft as a guess, in words.
std::string LightGuess(const FoundInput& input);

}  // namespace pathfit::app
