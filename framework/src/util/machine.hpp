// This machine and its processes, named so that other processes and other machines can tell them apart.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

namespace gripline {

/// The host's name; empty where it has none.
std::string this_machine();

/// When a process of this machine began, in the kernel's ticks since the machine did: the number of a process that has
/// ended is given to another, which began later. None where there is no such process.
std::optional<std::uint64_t> process_start(pid_t pid);

}  // namespace gripline
