// Chunks of ROS 1 bags: as they are, or packed with bzip2 or LZ4 where gripline was built with those libraries.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace gripline::tools {

/// The package without which gripline was built and that this compression needs; "" where it can be unpacked.
std::string missing_for(const std::string& compression);

/// The `size` bytes of a chunk. Throws InputError: a compression that is unknown or was not built in, bytes that do not
/// make that many.
std::vector<std::byte> unpack_chunk(const std::string& compression, std::vector<std::byte> packed, std::size_t size);

}  // namespace gripline::tools
