#pragma once
#include <functional>
#include <span>
#include <string>

#include "config/errors.hpp"

namespace gripline {

/// What --set assignments did wrong is told at the assignment, not at the line of the file it happened to spoil: an
/// error that appears once the k-th assignment is carried out is that assignment's. `read` reads everything with the
/// first so many assignments; what it throws besides InputError counts as no error.
[[nodiscard]] InputError blame_assignments(const InputError& error, std::span<const std::string> assignments,
                                           const std::function<void(std::span<const std::string>)>& read);

}  // namespace gripline
