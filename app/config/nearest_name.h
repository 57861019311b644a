#pragma once

#include <string>
#include <vector>

namespace pathfit::app {

/// The candidate with the fewest edits (insert, delete, replace, swap of neighbours) from `name`,
/// or empty if none is near enough to be what was meant. A candidate of which `name` is a prefix (3
/// letters or more) also counts.
std::string NearestName(const std::string& name, const std::vector<std::string>& candidates);

/// " (did you mean 'x'?)", or " (known: a, b, c)" with at most 12 names, or "" if there are none.
std::string NameHint(const std::string& name, const std::vector<std::string>& candidates);

/// Whether a name fits a glob pattern.
bool MatchesGlob(const std::string& pattern, const std::string& name);

bool Contains(const std::vector<std::string>& list, const std::string& text);

/// "a, b, c", cut after `limit` names.
std::string JoinNames(const std::vector<std::string>& names, std::size_t limit = std::string::npos);

}  // namespace pathfit::app
