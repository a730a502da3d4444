#include "util/temporary_folder.hpp"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace gripline {

TemporaryFolder::TemporaryFolder(const std::string& purpose) {
  std::string name = std::filesystem::temp_directory_path() / ("gripline_" + purpose + "_XXXXXX");
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name + ": " + std::strerror(errno));
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace gripline
