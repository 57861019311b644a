#pragma once

#include <filesystem>
#include <string>

namespace pathfit::renderer {

/// Of this process in bytes, by a key of Linux' /proc/self/status ("VmRSS:" resident now, "VmHWM:"
/// at most so far); 0 where the system does not tell.
double ProcessMemory(const std::string& key);

/// What this process can have resident, in bytes: the machine's memory, its control groups' limits
/// (both versions; containers and batch systems set them) or what `ulimit -v` leaves beside what
/// is mapped but not used, whichever is least; 0 where the system does not tell.
double MemoryLimit();

/// The least limit of the groups that a file such as /proc/self/cgroup names, and of those they are
/// in, below `mount` (/sys/fs/cgroup); infinite if there is none.
double ControlGroupLimit(const std::filesystem::path& groups, const std::filesystem::path& mount);

/// Gives the system back what was freed: between phases that take their memory in pieces of
/// different sizes, it stands in the way of the next one's.
void ReturnFreedMemory();

}  // namespace pathfit::renderer
