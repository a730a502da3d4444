// CPU time, which does not count what other processes take of the machine.
#pragma once

namespace gripline {

/// Spent by the calling thread since it began [s].
double thread_cpu_s();
/// Spent by all threads of this process since it began [s].
double process_cpu_s();

/// Spent by all children of this process that have ended and been collected [s].
double children_cpu_s();

}  // namespace gripline
