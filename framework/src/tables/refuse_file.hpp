// How a reader of logs refuses a file.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "config/errors.hpp"

namespace gripline {

/// Throws InputError at a line of the file, from 1; 0: at none.
[[noreturn]] inline void refuse_file(const std::filesystem::path& file, std::string message, int line = 0) {
  Diagnostic d;
  d.file = file.string();
  d.line = line;
  d.message = std::move(message);
  throw InputError({d});
}

}  // namespace gripline
