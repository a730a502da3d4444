// Errors that --set assignments cause, reported at the assignments.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "config/errors.hpp"

namespace gripline {

/// Reports an error that a --set assignment caused at that assignment, not at the line of the file that became wrong:
/// an error that first appears after the k-th assignment belongs to it. `read` is called with the first 0, 1, 2 ...
/// assignments and reads everything; exceptions other than InputError count as no error.
[[nodiscard]] InputError attribute_to_assignments(const InputError& error, std::span<const std::string> assignments,
                                                  const std::function<void(std::span<const std::string>)>& read);

}  // namespace gripline
