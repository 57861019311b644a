#include "app/command/video_frames.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "app/command/child_process.h"
#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;
using Words = std::vector<std::string>;

// Of a part of the video that are compared.
constexpr double kCandidates = 5.0;
// Lines of the pictures on which blur is measured, at most.
constexpr int kLinesForBlur = 540;
// From so many lines on, colours of a video that does not say how they are coded are Rec.709's.
constexpr int kLinesOfHd = 720;

std::optional<double> ParseNumber(std::string_view text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || last != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// "30000/1001"; 0 if it is none.
double ParseRatio(const std::string& text) {
  const std::size_t slash = text.find('/');
  const std::optional<double> above = ParseNumber(text.substr(0, slash));
  const std::optional<double> below =
      slash == std::string::npos ? 1.0 : ParseNumber(text.substr(slash + 1));
  return above && below && *below > 0.0 ? *above / *below : 0.0;
}

/// What ffprobe says of a video.
struct VideoFacts {
  double seconds = 0.0, frames_per_second = 0.0;
  int width = 0, height = 0;  ///< as it is stored
  std::string color_space, color_transfer;
};

/// An expression of ffmpeg's that holds for these frames. Nested, as it cannot read long sums.
std::string Any(std::span<const std::size_t> frames) {
  if (frames.size() == 1) return fmt::format("eq(n\\,{})", frames.front());
  const std::size_t half = frames.size() / 2;
  return "(" + Any(frames.first(half)) + "+" + Any(frames.subspan(half)) + ")";
}

class FrameTaker {
 public:
  FrameTaker(const VideoInput& input, const StopSignals& signals, CommandContext& context)
      : input_(input), signals_(signals), context_(context), work_(input.frames) {
    work_ += ".part";
  }
  ~FrameTaker() {
    std::error_code ignored;
    fs::remove_all(work_, ignored);
  }
  FrameTaker(const FrameTaker&) = delete;
  FrameTaker& operator=(const FrameTaker&) = delete;

  bool Run() {
    fs::remove_all(work_);
    renderer::CreateFolders(work_);
    const VideoFacts facts = Probe();
    if (signals_.Received()) return false;
    const double rate =
        std::min(facts.frames_per_second, kCandidates * input_.count / facts.seconds);
    const std::vector<double> blur = MeasureBlur(rate);
    if (signals_.Received()) return false;
    const std::vector<std::size_t> chosen = Sharpest(blur);
    Write(facts, rate, chosen);
    if (signals_.Received()) return false;
    MoveFrames();
    context_.log.Info(fmt::format("{} frames of {} ({:.1f} s), those blurred least among {}: {}",
                                  chosen.size(),
                                  input_.video.string(),
                                  facts.seconds,
                                  blur.size(),
                                  input_.frames.string()));
    return true;
  }

 private:
  [[nodiscard]] static fs::path Find(const std::string& program) {
    if (const std::optional<fs::path> found = FindProgram(program)) return *found;
    throw IoError(
        "frames of a video are taken with the program " + program +
        ", which is not on PATH (Debian: apt install ffmpeg); or give a folder of photos");
  }

  /// What a program of ffmpeg's says, with its complaints.
  std::string Say(const std::string& program, Words words) {
    const fs::path answer = work_ / "answer.txt";
    fs::remove(answer);
    words.insert(words.begin(), {program, "-v", "error"});
    const std::optional<int> status = RunChild({Find(program), words, answer, true}, signals_);
    if (signals_.Received()) return "";
    const std::string text = fs::exists(answer) ? renderer::ReadWholeFile(answer) : "";
    if (!status || *status != 0) {
      throw IoError(
          fmt::format("{}: {} {}; it says:\n{}",
                      input_.video.string(),
                      program,
                      status ? fmt::format("failed (status {})", *status) : "was ended by a signal",
                      EndOf(text)));
    }
    return text;
  }

  VideoFacts Probe() {
    std::istringstream lines(
        Say("ffprobe",
            {"-select_streams",
             "v:0",
             "-show_entries",
             "stream=width,height,avg_frame_rate,duration,color_space,color_transfer:"
             "format=duration",
             "-of",
             "default=noprint_wrappers=1",
             input_.video.string()}));
    VideoFacts facts;
    for (std::string line; std::getline(lines, line);) {
      const std::size_t equals = std::min(line.find('='), line.size());
      const std::string key = line.substr(0, equals);
      const std::string value = line.substr(std::min(equals + 1, line.size()));
      const double number = ParseNumber(value).value_or(0.0);
      if (key == "width") facts.width = static_cast<int>(number);
      if (key == "height") facts.height = static_cast<int>(number);
      if (key == "avg_frame_rate") facts.frames_per_second = ParseRatio(value);
      if (key == "duration" && number > 0.0) facts.seconds = number;
      if (key == "color_space") facts.color_space = value;
      if (key == "color_transfer") facts.color_transfer = value;
    }
    if (signals_.Received()) return facts;
    if (facts.width <= 0 || facts.height <= 0 || facts.frames_per_second <= 0.0 ||
        facts.seconds <= 0.0) {
      throw IoError(input_.video.string() +
                    ": holds no moving pictures of known length; turn it into an MP4 file, or give "
                    "a folder of photos");
    }
    constexpr std::array<std::string_view, 2> kHdr = {"arib-std-b67", "smpte2084"};
    if (std::ranges::find(kHdr, facts.color_transfer) != kHdr.end()) {
      context_.log.Warn(input_.video.string() + ": is HDR (" + facts.color_transfer +
                        "), whose brightness is taken for that of usual video: colours and light "
                        "of the fit are off; film without HDR");
    }
    return facts;
  }

  /// Of the frames at `rate`, in their order.
  std::vector<double> MeasureBlur(double rate) {
    const std::string filters = fmt::format(
        "fps={:.9f},scale=w=-2:h='min({},ih)',blurdetect,metadata=print:"
        "key=lavfi.blur:file=-",
        rate,
        kLinesForBlur);
    std::istringstream lines(Say("ffmpeg", Convert({"-vf", filters, "-f", "null", "-"})));
    constexpr std::string_view kFrame = "frame:", kBlur = "lavfi.blur=";
    std::vector<double> blur;
    for (std::string line; std::getline(lines, line);) {
      // A picture without edges has none.
      if (line.starts_with(kFrame)) blur.push_back(std::numeric_limits<double>::max());
      if (!blur.empty() && line.starts_with(kBlur)) {
        const std::optional<double> value =
            ParseNumber(std::string_view(line).substr(kBlur.size()));
        if (value && *value >= 0.0) blur.back() = *value;
      }
    }
    if (blur.empty() && !signals_.Received()) {
      throw IoError(input_.video.string() + ": ffmpeg finds no frames in it");
    }
    return blur;
  }

  /// One of each of as many equal parts as frames are wanted.
  [[nodiscard]] std::vector<std::size_t> Sharpest(const std::vector<double>& blur) const {
    const std::size_t count = std::min(static_cast<std::size_t>(input_.count), blur.size());
    std::vector<std::size_t> chosen;
    for (std::size_t part = 0; part < count; ++part) {
      const auto begin = blur.begin() + static_cast<std::ptrdiff_t>(part * blur.size() / count);
      const auto end = blur.begin() + static_cast<std::ptrdiff_t>((part + 1) * blur.size() / count);
      chosen.push_back(static_cast<std::size_t>(std::min_element(begin, end) - blur.begin()));
    }
    return chosen;
  }

  void Write(const VideoFacts& facts, double rate, const std::vector<std::size_t>& chosen) {
    const bool is_hd = facts.height >= kLinesOfHd || facts.width >= kLinesOfHd;
    const bool is_known = !facts.color_space.empty() && facts.color_space != "unknown";
    const std::string filters = fmt::format(
        "fps={:.9f},select={},scale=in_color_matrix={}:flags=bicubic+accurate_rnd+full_chroma_int,"
        "format=rgb24",
        rate,
        Any(chosen),
        is_known ? "auto"
        : is_hd  ? "bt709"
                 : "bt601");
    std::string pattern = (work_ / "frame_").string();
    for (std::size_t at = 0; (at = pattern.find('%', at)) != std::string::npos; at += 2) {
      pattern.insert(at, "%");
    }
    static_cast<void>(
        Say("ffmpeg", Convert({"-vf", filters, "-fps_mode", "passthrough", pattern + "%04d.png"})));
  }

  /// Of the video's pictures alone.
  [[nodiscard]] Words Convert(const Words& to) const {
    Words words = {"-nostdin", "-y", "-i", input_.video.string(), "-map", "0:v:0"};
    if (context_.line.threads) {
      words.insert(words.begin(), {"-threads", std::to_string(*context_.line.threads)});
    }
    words.insert(words.end(), to.begin(), to.end());
    return words;
  }

  [[nodiscard]] static std::vector<fs::path> FramesIn(const fs::path& folder) {
    std::vector<fs::path> frames;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("frame_") && name.ends_with(".png")) frames.push_back(entry.path());
    }
    return frames;
  }
  void MoveFrames() const {
    renderer::CreateFolders(input_.frames);
    for (const fs::path& old : FramesIn(input_.frames)) fs::remove(old);
    for (const fs::path& made : FramesIn(work_)) {
      fs::rename(made, input_.frames / made.filename());
    }
  }

  const VideoInput& input_;
  const StopSignals& signals_;
  CommandContext& context_;
  fs::path work_;
};

}  // namespace

bool HasVideoExtension(const fs::path& path) {
  constexpr std::array<std::string_view, 10> kExtensions = {
      ".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".mts", ".mpg", ".mpeg", ".3gp"};
  const std::string extension = renderer::LowerCase(path.extension().string());
  return std::ranges::find(kExtensions, extension) != kExtensions.end();
}

bool TakeFrames(const VideoInput& input, const StopSignals& signals, CommandContext& context) {
  return FrameTaker(input, signals, context).Run();
}

}  // namespace pathfit::app
