#pragma once

namespace pathfit::app {

/// What the process returns; README.md lists the same table.
enum class ExitStatus {
  kFinished = 0,       ///< also --help
  kInternalError = 1,  ///< a bug; the message asks for log.txt
  kUsage = 2,          ///< command line wrong
  kConfig = 3,         ///< config wrong, all problems listed
  kInput = 4,          ///< input data missing, unreadable or inconsistent
  kNumerical = 5,      ///< NaN, no usable step; the last accepted state is saved
  kCheckFailed = 7,    ///< gradcheck outside its limits
  kMemory = 8,         ///< would exceed the memory limit, or allocation failed
  kStopped = 75,       ///< by --time-limit or SIGTERM, with a checkpoint: `pathfit resume`
  kInterrupted = 130,  ///< Ctrl-C, with a checkpoint
};

}  // namespace pathfit::app
