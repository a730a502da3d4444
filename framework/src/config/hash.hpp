#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace gripline {

/// SHA-256 (FIPS 180-4) as 64 lower-case hexadecimal digits: what `sha256sum` prints.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);

/// sha256_hex() of a file's bytes. Throws InputError if it cannot be read.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace gripline
