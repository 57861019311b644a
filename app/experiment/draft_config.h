#pragma once

#include <filesystem>
#include <string>

#include "app/experiment/input_search.h"
#include "app/experiment/light_choice.h"

namespace pathfit::app {

/// The surface of a draft.
enum class DraftSurface {
  kMatt,  ///< sees coarse light only
  kShiny  ///< highlights of one roughness, which is unknown, in finer light
};

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
