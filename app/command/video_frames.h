#pragma once

#include <filesystem>

#include "app/command/command_line.h"
#include "app/command/stop_signals.h"

namespace pathfit::app {

/// By the name's ending.
bool HasVideoExtension(const std::filesystem::path& path);

struct VideoInput {
  std::filesystem::path video;   ///< absolute
  std::filesystem::path frames;  ///< folder to make; earlier frames in it are replaced
  int count = 0;                 ///< of frames; fewer if the video has no more
};

/// Takes pictures out of a video with the program ffmpeg, upright, as frame_0001.png and so on: of
/// each of so many equal times the one that is blurred least. Returns false if a signal came; then
/// the folder is as it was. Throws IoError saying what to do: ffmpeg is not there or cannot read
/// the file.
bool TakeFrames(const VideoInput& input, const StopSignals& signals, CommandContext& context);

}  // namespace pathfit::app
