#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "app/experiment/input_search.h"

namespace pathfit::app {

/// The light of a draft.
enum class DraftLight {
  kWorld,   ///< from all around, stands still around the object
  kCamera,  ///< from all around, goes with the camera: what turns before both is the object
  kFlash    ///< a point beside the lens; what else there is stands still with the background
};
inline constexpr std::array kDraftLights = {
    DraftLight::kWorld, DraftLight::kCamera, DraftLight::kFlash};
/// "world", "camera", "flash".
const char* WordOf(DraftLight light);

struct LightChoice {
  DraftLight light = DraftLight::kWorld;
  std::string reason;  ///< in words
};

/// What a person says.
LightChoice LightAsSaid(DraftLight light);
/// What EXIF's flash tells, or a background with something in it that stands still.
std::optional<LightChoice> LightBySigns(const FoundInput& input);
/// The light by which a few photos, reduced to small ones, are explained best, with a colour for
/// each vertex of the start: the one carved from the masks, or `mesh` if that is not empty. A light
/// that stands still explains hardly anything that one which goes with the camera does not, since
/// colours hold what shading does not change; so it is chosen unless the other is clearly better.
/// Where the background changes, the camera moved, and of lights that go with it only a flash is
/// tried: highlights go with the camera under any light, so that one from all around seems to.
/// Empty without masks, or if the start cannot be fitted: then `problem` says why. `config`: where
/// the draft will be written, for its places.
std::optional<LightChoice> LightByTrial(const FoundInput& input,
                                        const std::filesystem::path& mesh,
                                        const std::filesystem::path& config,
                                        std::string& problem);
/// Where nothing else tells.
LightChoice UsualLight(const FoundInput& input);

}  // namespace pathfit::app
