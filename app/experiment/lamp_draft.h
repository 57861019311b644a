#pragma once

#include <filesystem>
#include <string>

#include "app/experiment/draft_text.h"
#include "app/experiment/lamp_input.h"
#include "renderer/geometry/mesh.h"

namespace pathfit::app {

/// Where a draft for photos under a lamp each puts and finds its files.
struct LampDraftFiles {
  std::filesystem::path config;
  std::filesystem::path mesh;  ///< the start
  std::filesystem::path mask;
};

/// The start for a draft: what fills the mask, in the draft's frame.
renderer::Mesh LampStart(const FoundLamps& found);

/// A short commented config that fits shape and colours to photos under a known lamp each, with
/// every setting at its default. Paths in it are relative to the config's folder.
std::string DraftLampConfig(const FoundLamps& found,
                            const LampDraftFiles& files,
                            const std::string& name,
                            DraftSurface surface = DraftSurface::kMatt);

}  // namespace pathfit::app
