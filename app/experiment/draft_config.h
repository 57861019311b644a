#pragma once

#include <filesystem>
#include <string>

#include "app/experiment/draft_text.h"
#include "app/experiment/input_search.h"
#include "app/experiment/light_choice.h"

namespace pathfit::app {

/// A short commented config that fits shape, light and colours to what was found, with every
/// setting at its default. `path` is where it will be written: its folder is what paths are
/// relative to. `mesh` is the start mesh; empty: carved from the masks, or without masks a sphere
/// where the cameras look. Throws SceneError when there is neither, or a flash, and the
/// cameras look at no common point.
std::string DraftConfig(const FoundInput& input,
                        const LightChoice& light,
                        const std::filesystem::path& path,
                        const std::string& name,
                        const std::filesystem::path& mesh,
                        DraftSurface surface = DraftSurface::kMatt);

}  // namespace pathfit::app
