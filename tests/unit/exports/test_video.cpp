// A browser and an encoder that are scripts: what becomes of the file when the encoder fails.
#include "exports/video.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "exports/browser.hpp"
#include "support/host_support.hpp"

namespace gripline::exports {
namespace test_video {

using namespace testing_support;
namespace fs = std::filesystem;

/// Answers every command; a replay is there, it lasts half a second, and the pictures of it are three bytes.
constexpr const char* browser = R"(import json, os
text = b""
while chunk := os.read(3, 65536):
    text += chunk
    while b"\0" in text:
        command, text = text.split(b"\0", 1)
        command = json.loads(command)
        value = 0.5 if "clock.end" in command["params"].get("expression", "") else True
        result = {"targetId": "1", "sessionId": "1", "data": "AAAA", "result": {"value": value}}
        os.write(4, json.dumps({"id": command["id"], "result": result}).encode() + b"\0")
)";

/// By default, and as `env --ignore-signal=CHLD` leaves it.
class Video : public testing::TestWithParam<void (*)(int)> {
 protected:
  void SetUp() override {
    if (const char* const path = std::getenv("PATH"); path != nullptr) path_ = path;
    const std::string python = find_program("python3");
    ASSERT_FALSE(python.empty()) << "the browser here is a script for python3, a package that tests need";
    install("browser", "#!" + python + "\n" + browser);
    setenv("GRIPLINE_CHROMIUM", (folder_ / "browser").c_str(), 1);
    setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
    before_ = std::signal(SIGCHLD, GetParam());
  }
  void TearDown() override {
    if (HasFatalFailure()) return;
    EXPECT_EQ(std::signal(SIGCHLD, before_), GetParam());
    setenv("PATH", path_.c_str(), 1);
    unsetenv("GRIPLINE_CHROMIUM");
  }

  void install(const std::string& name, const std::string& text) const {
    write_text(folder_ / name, text);
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  /// An encoder that writes what it gets into the file that is its last argument, and then does `end`.
  void install_encoder(const std::string& end) const {
    install("ffmpeg", "#!/bin/sh\nfor file; do :; done\ncat > \"$file\"\n" + end + "\n");
  }
  void write() const { write_video(folder_ / "page.html", file(), {.fps = 10}, nullptr); }
  fs::path file() const { return folder_ / "race.mp4"; }
  fs::path aside() const { return folder_ / "race.mp4.partial"; }

 private:
  Folder folder_;
  std::string path_;
  void (*before_)(int) = SIG_DFL;
};

TEST_P(Video, IsRenamedWhenItIsComplete) {
  install_encoder("exit 0");
  write();
  EXPECT_EQ(fs::file_size(file()), 6 * 3u) << "pictures at 0 to 0.5 s";
  EXPECT_FALSE(fs::exists(aside()));
}

TEST_P(Video, OfAnEncoderThatFailsNothingIsLeft) {
  for (const char* end : {"exit 1", "kill -KILL $$"}) {
    install_encoder(end);
    try {
      write();
      ADD_FAILURE() << end;
    } catch (const std::runtime_error& e) {
      EXPECT_STREQ(e.what(), "ffmpeg could not write the video");
    }
    EXPECT_FALSE(fs::exists(file()));
    EXPECT_FALSE(fs::exists(aside()));
  }
}

INSTANTIATE_TEST_SUITE_P(EndOfChildren, Video, testing::Values(SIG_DFL, SIG_IGN),
                         [](const auto& info) { return std::string(info.param == SIG_IGN ? "ignored" : "usual"); });

}  // namespace test_video
}  // namespace gripline::exports
