// Chromium without a window, driven over two pipes by its DevTools protocol (--remote-debugging-pipe): JSON texts, each
// followed by a zero byte (https://chromedevtools.github.io/devtools-protocol/).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "util/pipe.hpp"
#include "util/started_program.hpp"
#include "util/temporary_folder.hpp"

namespace gripline::exports {

/// The program on the PATH, or the file named by GRIPLINE_CHROMIUM; empty if there is none.
std::string find_chromium();

/// A file of one of these names on the PATH; empty if there is none.
std::string find_program(const char* name);

class Browser {
 public:
  /// Starts it with an empty page of this size in pixels. Throws std::runtime_error if it does not come up.
  Browser(const std::string& chromium, int width, int height);
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Opens a file and waits until the JavaScript expression `ready` is true. Throws std::runtime_error after 60 s.
  void open(const std::filesystem::path& page, const std::string& ready);
  /// The value of a JavaScript expression, promises awaited. Throws std::runtime_error if it throws.
  nlohmann::json evaluate(const std::string& expression);
  /// A screenshot of the page, as the bytes of a JPEG.
  std::string screenshot();

 private:
  nlohmann::json call(const std::string& method, const nlohmann::json& parameters);
  std::string read_message();
  TemporaryFolder profile_{"browser"};
  Pipe commands_, answers_;
  std::optional<StartedProgram> program_;
  std::string buffer_, session_;
  int id_ = 0;
};

}  // namespace gripline::exports
