#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace gripline {

/// Larger input files are refused [bytes], where they are read as a whole.
inline constexpr std::size_t max_file_size = std::size_t{256} << 20U;

/// Why `file` cannot be read, as the second half of a sentence about it: `no such file; did you mean "ethz.json"?`,
/// `is a folder, expected a file`. Empty if it can.
[[nodiscard]] std::string why_unreadable(const std::filesystem::path& file);

/// The same of a file that is never in memory as a whole: it may be of any size.
[[nodiscard]] std::string why_unopenable(const std::filesystem::path& file);

/// Gives all bytes of a file to `use`, in order, a piece at a time: for files that need not be in memory at once.
/// Throws InputError: `name: reason`.
void read_chunks(const std::filesystem::path& file, const std::function<void(std::string_view)>& use);

/// All bytes of a file. Throws InputError: `name: reason`.
[[nodiscard]] std::string read_bytes(const std::filesystem::path& file);

/// The same file without `.` and needless `..`: as the names stand, or, where a `..` follows a linked folder, as the
/// system finds it: in the folder that the link names.
[[nodiscard]] std::filesystem::path without_dots(const std::filesystem::path& file);

/// A path as messages show it: `/` between names, without_dots().
[[nodiscard]] std::string shown(const std::filesystem::path& file);

}  // namespace gripline
