#include "config/files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <optional>
#include <system_error>
#include <vector>

#include "config/errors.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    names.push_back(it->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// The name most like `name`: the same one with an ending, else one with other letters.
std::optional<std::string> near_name(const std::string& name, const std::vector<std::string>& names) {
  for (const std::string_view ending : {".json", ".csv"})
    if (std::ranges::find(names, name + std::string(ending)) != names.end()) return name + std::string(ending);
  return nearest(name, names);
}

/// Says which part of the path is missing, and what it may have been meant to be.
std::string why_missing(const fs::path& file) {
  fs::path known;
  for (const fs::path& part : file) {
    std::error_code error;
    if (fs::exists(known / part, error)) {
      known /= part;
      continue;
    }
    const auto near = near_name(part.string(), names_in(known.empty() ? "." : known));
    const std::string hint = near ? "; did you mean \"" + *near + "\"?" : "";
    if (part == file.filename()) return "no such file" + hint;
    return "no such file: there is no \"" + part.string() + "\"" +
           (known.empty() ? "" : " in \"" + known.generic_string() + "\"") + hint;
  }
  return "no such file";
}

std::string last_system_error() { return std::error_code(errno, std::generic_category()).message(); }

}  // namespace

std::string why_unopenable(const fs::path& file) {
  if (file.native().find('\0') != std::string::npos) return "is not a path: it holds a NUL character";
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) return why_missing(without_dots(file));
  if (status.type() == fs::file_type::none) return "cannot be read: " + error.message();
  if (fs::is_directory(status)) return "is a folder, expected a file";
  // Reading a named pipe blocks until somebody writes to it. Pipes of a shell, /dev/fd/N, have a writer and no path.
  if (fs::is_fifo(status) && !fs::canonical(file, error).empty()) return "is a pipe, expected a file";
  if (fs::is_socket(status)) return "is a socket, expected a file";
  errno = 0;
  if (!std::ifstream(file, std::ios::binary)) return "cannot be read: " + last_system_error();
  return "";
}

std::string why_unreadable(const fs::path& file) {
  if (std::string why = why_unopenable(file); !why.empty()) return why;
  std::error_code error;
  if (fs::is_regular_file(file, error) && fs::file_size(file, error) > max_file_size)
    return "is larger than " + std::to_string(max_file_size >> 20U) + " MB";
  return "";
}

void read_chunks(const fs::path& file, const std::function<void(std::string_view)>& use) {
  const auto refuse = [&](std::string reason) {
    throw InputError(std::vector{Diagnostic{.file = shown(file), .message = std::move(reason)}});
  };
  if (std::string reason = why_unreadable(file); !reason.empty()) refuse(std::move(reason));
  std::ifstream in(file, std::ios::binary);
  std::vector<char> chunk(std::size_t{1} << 16U);
  std::size_t size = 0;
  while (in.read(chunk.data(), static_cast<std::streamsize>(chunk.size())) || in.gcount() > 0) {
    const auto count = static_cast<std::size_t>(in.gcount());
    size += count;
    // A device or a pipe has no size to ask for beforehand.
    if (size > max_file_size) refuse("is larger than " + std::to_string(max_file_size >> 20U) + " MB");
    use({chunk.data(), count});
  }
  if (in.bad()) refuse("cannot be read: " + last_system_error());
}

std::string read_bytes(const fs::path& file) {
  std::string bytes;
  std::error_code none;
  if (fs::is_regular_file(file, none))
    bytes.reserve(std::min(fs::file_size(file, none), std::uintmax_t{max_file_size}));
  read_chunks(file, [&](std::string_view chunk) { bytes += chunk; });
  return bytes;
}

fs::path without_dots(const fs::path& file) {
  const fs::path plain = file.lexically_normal();
  const bool is_path = file.native().find('\0') == std::string::npos;  // else the system would see the part before it
  if (!is_path || std::ranges::find(file, "..") == file.end()) return plain;
  std::error_code failed, other;
  const fs::path found = fs::weakly_canonical(file, failed);
  return failed || found == fs::weakly_canonical(plain, other) ? plain : found;
}

std::string shown(const fs::path& file) { return without_dots(file).generic_string(); }

}  // namespace gripline
