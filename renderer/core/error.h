#pragma once

#include <stdexcept>
#include <string>

namespace pathfit::renderer {

/// The user's input is wrong: a scene that cannot be rendered.
class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file is missing, unreadable or malformed. The message names the file and, for text, the line.
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A number that should be finite is not; the message names view, pixel and parameter.
class NumericalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller asked to stop (signal, time limit).
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace pathfit::renderer
