#pragma once

#include <string>
#include <vector>

#include "app/command/command_line.h"

namespace pathfit::app {

/// The words of a command line sorted to their options, still as text: conversions with messages of
/// our own follow in command_line. This is the door to CLI11.
struct RawOptions {
  CommandName command = CommandName::kHelp;
  std::string command_name;  ///< for messages; empty if none was given
  std::string help_text;     ///< set if help was asked for
  int verbose = 0;
  int quiet = 0;
  bool version = false;
  bool json = false;
  std::string log_level, log_file, threads, seed, color, progress;
  std::string target, output, time_limit, max_memory, stop_after, views, terms, form;
  std::string step, spp, replicates, sigma;
  std::vector<std::string> set, sensors, derivatives, params;
};

/// Throws UsageError for unknown commands and options (with the nearest one) and for missing
/// values.
RawOptions ParseRawOptions(const std::vector<std::string>& arguments);

/// Throws UsageError: the text, how to get help, the status.
[[noreturn]] void ThrowUsage(const std::string& command, const std::string& text);

}  // namespace pathfit::app
