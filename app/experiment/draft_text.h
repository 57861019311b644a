#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>

#include "app/config/near_path.h"
#include "app/config/wrapped_words.h"
#include "optim/observation/load_observations.h"
#include "renderer/core/lower_case.h"

namespace pathfit::app {

/// As YAML, in quotes where it needs them.
inline std::string YamlWord(const std::string& text) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-";
  const std::string low = renderer::LowerCase(text);
  const bool is_name = !text.empty() && text.find_first_not_of(kPlain) == std::string::npos &&
                       text.find_first_not_of("0123456789.-") != std::string::npos;
  const bool is_other = low == "null" || low == "true" || low == "false" || low == "yes" ||
                        low == "no" || low == "on" || low == "off" || low == "y" || low == "n";
  if (is_name && !is_other) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

/// As YAML, relative to the folder of the config if that is near.
inline std::string YamlPath(const std::filesystem::path& path,
                            const std::filesystem::path& folder) {
  return YamlWord(NearPath(path, folder).generic_string());
}

/// Words as comments of a config, in lines that begin with `start`.
inline std::string CommentLines(const std::string& words, const std::string& start) {
  constexpr std::size_t kWidth = 140;
  std::string text;
  for (const std::string& line : WrappedWords(words, kWidth - start.size())) {
    text += start + line + "\n";
  }
  return text;
}

/// What a draft begins with.
inline std::string DraftBeginning(const std::string& name) {
  return "# Written by pathfit init. Every setting that is not here has its default "
         "(configs/README.md lists them).\n"
         "schema: 1\nname: '" +
         name + "'\n\ninput:\n";
}

/// What a draft says of photos that are held out; nothing where it is usual.
inline std::string SplitLine(const optim::ObservationOptions& options) {
  return options.validation_every > 0
             ? ""
             : "  split: {validation: none}  # so few photos are all needed\n";
}

/// The surface of a draft.
enum class DraftSurface {
  kMatt,   ///< sees coarse light only
  kShiny,  ///< paint, plastic, glaze: white highlights of one roughness, which is unknown
  kMetal   ///< highlights in the colour of the surface, which has no other
};

/// "matt", "shiny", "metal".
inline const char* WordOf(DraftSurface surface) {
  constexpr std::array<const char*, 3> kWords = {"matt", "shiny", "metal"};
  return kWords[static_cast<std::size_t>(surface)];
}

/// Of such a word; matt where there is none.
inline DraftSurface SurfaceOf(const std::string& word) {
  for (const DraftSurface surface : {DraftSurface::kShiny, DraftSurface::kMetal}) {
    if (word == WordOf(surface)) return surface;
  }
  return DraftSurface::kMatt;
}

/// Whether it has highlights: then it sees fine light.
inline bool Shines(DraftSurface surface) { return surface != DraftSurface::kMatt; }

/// The material of a draft and what another one would be. `of_light`: what that asks of the light.
inline std::string SurfaceLines(DraftSurface surface, const std::string& of_light) {
  const std::string matt = "{model: diffuse, base_color: {vertex: [0.5, 0.5, 0.5]}}";
  const std::string shiny = std::string(
                                "{model: metallic_roughness, base_color: {vertex: [0.5, 0.5, "
                                "0.5]}, roughness: {constant: "
                                "0.4}, metallic: {constant: ") +
                            (surface == DraftSurface::kMetal ? "1}}" : "0}}");
  const bool shines = Shines(surface);
  return CommentLines((shines ? "One colour per vertex, with highlights; metallic 1: a metal, 0: "
                                "anything else. Without highlights: " +
                                    matt + ", and no surface.roughness"
                              : "One colour per vertex. With highlights: " + shiny +
                                    ", and surface.roughness") +
                          " among the unknowns" + of_light + ".",
                      "    # ") +
         "    surface: " + (shines ? shiny : matt) + "\n";
}

}  // namespace pathfit::app
